"""Columns that have a number in few of a table's rows: kept as those rows and numbers until somebody asks for the column.

A table that several recorders write into has a row for each of their samples, and in most rows nothing for most channels:
kept as it is read it would take several times the memory of what was measured.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parsers.adjacent import joined
from parsers.channels import FloatArray

_PROBES = 64
"""So many rows of a piece are looked at to see whether it is worth a closer look."""

_FEW = 0.4
"""Share of rows with a number up to which a piece is packed: packed a number takes 12 bytes, a row 8."""

_LEAST = 1024


@dataclass(frozen=True)
class Packed:
    """A piece of a column. at: rows with a number, (k,). values: the numbers, (k,). rows: of the piece."""

    at: NDArray[np.int32]
    values: FloatArray
    rows: int

    def put(self, into: FloatArray) -> None:
        """Write the piece over `into`, (rows,): NaN where it has no number."""
        into.fill(np.nan)
        into[self.at] = self.values

    def whole(self) -> FloatArray:
        """The piece as it was read, (rows,)."""
        values = np.empty(self.rows)
        self.put(values)
        return values


Kept = FloatArray | Packed
"""A piece of a column as it is kept."""


def packed(columns: Mapping[str, FloatArray]) -> dict[str, Kept]:
    """A chunk's columns, (n,) each, as they are to be kept: packed where few rows have a number.

    Readers give columns that lie in one block of memory: once one of them is packed the others are copied, since a view
    would keep the whole block.
    """
    kept: dict[str, Kept] = {name: _packed(values) for name, values in columns.items()}
    if any(isinstance(piece, Packed) for piece in kept.values()):
        for name, piece in kept.items():
            if not isinstance(piece, Packed) and piece.base is not None:
                kept[name] = piece.copy()
    return kept


def _packed(values: FloatArray) -> Kept:
    n = len(values)
    # an odd step: channels that take turns have their rows at even ones
    if n < _LEAST or np.count_nonzero(np.isnan(values[:: (n // _PROBES) | 1])) < (1 - _FEW) * _PROBES - 1:
        return values
    at = np.flatnonzero(~np.isnan(values))
    if len(at) > _FEW * n or n > np.iinfo(np.int32).max:
        return values
    return Packed(at.astype(np.int32), values[at], n)


def whole(piece: Kept) -> FloatArray:
    """A piece as it was read, (n,)."""
    return piece.whole() if isinstance(piece, Packed) else piece


def joined_pieces(pieces: Sequence[Kept]) -> FloatArray:
    """Pieces end to end, (n,): a view where they are neighbours in one block of memory, else a copy."""
    dense = [piece for piece in pieces if not isinstance(piece, Packed)]
    if len(dense) == len(pieces):
        return joined(dense)
    sizes = [piece.rows if isinstance(piece, Packed) else len(piece) for piece in pieces]
    values, at = np.empty(sum(sizes)), 0
    for piece, size in zip(pieces, sizes, strict=True):
        part = values[at : at + size]
        if isinstance(piece, Packed):
            piece.put(part)
        else:
            part[:] = piece
        at += size
    return values


class SparseColumns(Mapping[str, FloatArray]):
    """Columns (n,) by name, of which some are packed: those are made anew whenever they are asked for, the last one kept."""

    def __init__(
        self, dense: dict[str, FloatArray], sparse: dict[str, list[Kept]], rows: NDArray[np.intp] | None
    ) -> None:
        """rows: in which order the rows of packed columns are told; None as they come."""
        self._dense, self._sparse, self._rows = dense, sparse, rows
        self._last: tuple[str, FloatArray] | None = None

    def __getitem__(self, name: str) -> FloatArray:
        if name in self._dense:
            return self._dense[name]
        if self._last is None or self._last[0] != name:
            self._last = None
            values = joined_pieces(self._sparse[name])
            self._last = name, values if self._rows is None else values[self._rows]
        return self._last[1]

    def __contains__(self, name: object) -> bool:
        return name in self._dense or name in self._sparse

    def __iter__(self) -> Iterator[str]:
        yield from self._dense
        yield from self._sparse

    def __len__(self) -> int:
        return len(self._dense) + len(self._sparse)
