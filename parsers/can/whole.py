"""Columns that are whole from the beginning: all batches are counted first, so that each decodes to where its rows belong.

The pieces of a column then need not be brought together afterwards, which would touch as much memory again.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from parsers.allocator import Slab, room_of
from parsers.can.groups import Group
from parsers.can.spread import Piece
from parsers.channels import FloatArray, IntArray

WHOLE_BYTES = 64 << 20
"""Columns of more than this are decoded batch by batch: whoever takes them may bring them to the disk."""


Columns = Mapping[str, FloatArray]
"""Channel name -> (rows,)."""


@dataclass(frozen=True)
class Places:
    """Where the rows of one piece go. stamps: those of all parts, each part's from stamps_at (parts,) on.

    columns: of each group, None where they get memory of their own: where the group has not all of its message's frames. slab: what
    they lie in, None where they do not. rows_at: (parts,) rows of each part in the pieces before.
    """

    stamps: IntArray | None
    stamps_at: IntArray | None
    columns: Sequence[Columns | None]
    slab: Slab | None = None
    rows_at: IntArray | None = None

    @classmethod
    def loose(cls, groups: Sequence[Group]) -> Places:
        """Everything gets memory of its own."""
        return cls(None, None, [None] * len(groups))


@dataclass(frozen=True)
class Whole:
    """Whole columns of each group, in one slab, and stamps of all parts, each part's from first (parts,) on. columns: None for a
    group that has not all of its message's frames."""

    slab: Slab
    stamps: IntArray
    first: IntArray
    columns: Sequence[Columns | None]
    parts: Sequence[int]

    def places(self, pieces: deque[Piece]) -> Iterator[tuple[Piece, Places]]:
        """The pieces of a log in order, each with the places of its rows. Takes the pieces out of the queue."""
        begin = np.zeros_like(self.first)
        while pieces:
            piece = pieces.popleft()
            end = begin + piece.counts
            rows = [
                None
                if whole is None
                else {name: column[begin[part] : end[part]] for name, column in whole.items()}
                for part, whole in zip(self.parts, self.columns, strict=True)
            ]
            yield piece, Places(self.stamps, self.first + begin, rows, self.slab, begin)
            begin = end


def whole_columns(
    pieces: Iterable[Piece], groups: Sequence[Group], parts: Sequence[int], wanted: frozenset[str]
) -> Whole | None:
    """Room for all that the pieces of a log hold; None where that is more than WHOLE_BYTES.

    parts: of each group the part of a piece that it is made of.
    """
    totals = sum((piece.counts for piece in pieces), np.zeros(max(parts) + 1, np.int64))
    names = [
        () if group.gates else tuple(name for name in group.signals if name in wanted) for group in groups
    ]
    sizes = [room_of(8 * int(totals[part])) * len(each) for part, each in zip(parts, names, strict=True)]
    size = sum(sizes) + room_of(8 * int(totals.sum()))
    if size > WHOLE_BYTES:
        return None
    slab = Slab(size)
    slab.touch()
    stamps, first = slab.empty(int(totals.sum()), np.int64), np.cumsum(totals) - totals
    columns = [
        None if group.gates else {name: slab.empty(int(totals[part]), np.float64) for name in each}
        for group, part, each in zip(groups, parts, names, strict=True)
    ]
    return Whole(slab, stamps, first, columns, tuple(parts))
