"""Many columns of plain signals in one call of a kernel.

A column of a piece is a few hundredths of a millisecond of work: called one by one, two cores wait for the interpreter's lock longer
than they decode.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from parsers.allocator import Slab
from parsers.can.decode import Payloads, Place, WordArray, codes_of, is_plain, plain, plain_at_best
from parsers.can.definitions import SignalDef
from parsers.can.groups import Group
from parsers.can.whole import Whole
from parsers.channels import FloatArray, IntArray
from parsers.jit import kernel

FIRST, STEP, LEFT, BITS, SWAP, SIGNED, INTO, ROWS, JOB = range(9)
"""Of a job: the first payload's word with the field, how many words a payload has, how the field lies in its word, as `Place` has
it; the first cell of the column, and how many rows."""


@kernel
def _columns(words: WordArray, cells: FloatArray, jobs: IntArray, factors: FloatArray) -> None:
    """Fields in one word into their columns. factors: (jobs, 2) scale and offset."""
    for k in range(len(jobs)):
        job = jobs[k]
        swap, signed = job[SWAP] == 1, job[SIGNED] == 1
        plain(
            words, job[FIRST], job[STEP], job[LEFT], job[BITS], swap, signed, factors[k, 0], factors[k, 1],
            cells, job[INTO], job[ROWS],
        )  # fmt: skip


class PlainColumns:
    """Columns in a slab that are to be decoded out of one piece's payloads."""

    def __init__(self, slab: Slab) -> None:
        self._slab = slab
        self._words = np.empty(0, np.uint64)
        self._jobs: list[tuple[int, ...]] = []
        self._factors: list[tuple[float, float]] = []

    def take(self, payloads: Payloads, signal: SignalDef, values: FloatArray, *, codes: bool) -> bool:
        """Note a signal's column, (n,), to be filled by `decode`; False where it is not for this way. codes: as `is_plain`."""
        place = Place.of(signal.field)
        into = self._slab.cell_of(values)
        if payloads.first < 0 or into < 0 or not is_plain(payloads, signal, place, codes=codes):
            return False
        if place.last >= 8 * payloads.words.shape[1]:
            return False
        self._words = payloads.flat
        self._jobs.append((
            payloads.first + place.first, payloads.words.shape[1], place.left, place.bits, place.swap, signal.signed,
            into, values.size,
        ))  # fmt: skip
        self._factors.append((signal.scale, signal.offset))
        return True

    def decode(self) -> None:
        """Fill all columns that were taken."""
        if self._jobs:
            _columns(self._words, self._slab.cells, np.array(self._jobs, np.int64), np.array(self._factors))


class PlainGroups:
    """Groups of which all that is wanted is plain, in whole columns: what is to be done for them is made out once for all pieces."""

    def __init__(self, groups: Sequence[Group], whole: Whole) -> None:
        """groups: those that the columns are of, in the same order."""
        self._cells = whole.slab.cells
        jobs: list[tuple[int, ...]] = []
        owners: list[tuple[int, int, int]] = []
        factors: list[tuple[float, float]] = []
        for number, (group, part, columns) in enumerate(zip(groups, whole.parts, whole.columns, strict=True)):
            own = (
                []
                if columns is None
                else [_job(group, name, column, whole.slab) for name, column in columns.items()]
            )
            if all(each is not None for each in own):
                for job, scale, last in filter(None, own):
                    jobs.append(job)
                    factors.append(scale)
                    owners.append((number, part, last))
        self._jobs = np.array(jobs, np.int64).reshape(-1, JOB)
        self._factors = np.array(factors).reshape(-1, 2)
        self._group, self._part, self._last = np.array(owners, np.int64).reshape(-1, 3).T

    def decode(self, payloads: Sequence[Payloads], rows_at: IntArray) -> frozenset[int]:
        """Fill the rows of one piece; the groups for which that is all. rows_at: (parts,) where each part's begin in its columns.

        The others have a payload that is too short for a signal, or signals with more to look out for.
        """
        first, width, rows, shortest = np.array(
            [(of.first, of.words.shape[1], of.length.size, of.shortest) for of in payloads], np.int64
        ).T
        part = self._part
        fits = (shortest[part] > self._last) & (self._last < 8 * width[part]) & (first[part] >= 0)
        short = frozenset(self._group[~fits].tolist())
        done = frozenset(self._group.tolist()) - short
        if not done:
            return done
        jobs = self._jobs.copy()
        jobs[:, FIRST] += first[part]
        jobs[:, STEP] = width[part]
        jobs[:, INTO] += rows_at[part]
        jobs[:, ROWS] = rows[part]
        factors = self._factors
        if short:
            chosen = np.isin(self._group, list(done))
            jobs, factors = jobs[chosen], factors[chosen]
        _columns(payloads[0].flat, self._cells, jobs, factors)
        return done


def _job(
    group: Group, name: str, column: FloatArray, slab: Slab
) -> tuple[tuple[int, ...], tuple[float, float], int] | None:
    """Of a signal that is plain in every payload that is long enough: its job but for what differs between pieces, scale and
    offset, and the last byte that it needs; else None."""
    signal, stream = group.signals[name], group.stream
    place, into = Place.of(signal.field), slab.cell_of(column)
    codes = codes_of(signal, j1939=stream.special_codes, proprietary=stream.proprietary)
    if into < 0 or not plain_at_best(signal, place, codes=bool(codes)):
        return None
    job = (place.first, 0, place.left, place.bits, place.swap, signal.signed, into, 0)
    return job, (signal.scale, signal.offset), place.last
