"""Many columns of plain signals in one call of a kernel.

A column of a piece is a few hundredths of a millisecond of work: called one by one, two cores wait for the interpreter's lock longer
than they decode.
"""

from __future__ import annotations

import numpy as np

from parsers.allocator import Slab
from parsers.can.decode import Payloads, Place, WordArray, is_plain, turned
from parsers.can.definitions import SignalDef
from parsers.channels import FloatArray, IntArray
from parsers.jit import kernel

FIRST, STEP, ROWS, INTO, LEFT, BITS, SWAP, SIGNED, JOB = range(9)
"""Of a job: the first word and how many lie between two payloads', how many rows, the first cell of the column; how the field lies
in the word, as `Place` has it."""


@kernel
def _columns(words: WordArray, cells: FloatArray, jobs: IntArray, factors: FloatArray) -> None:
    """Fields in one word into their columns: each case its own short loop. factors: (jobs, 2) scale and offset."""
    for k in range(len(jobs)):
        job = jobs[k]
        first, step, into = job[FIRST], job[STEP], job[INTO]
        up, down = np.uint64(job[LEFT]), np.uint64(64 - job[BITS])
        scale, offset = factors[k, 0], factors[k, 1]
        if job[SIGNED] and job[SWAP]:
            for i in range(job[ROWS]):
                raw = np.int64(turned(words[first + i * step]) << up) >> np.int64(down)
                cells[into + i] = np.float64(raw) * scale + offset
        elif job[SIGNED]:
            for i in range(job[ROWS]):
                raw = np.int64(words[first + i * step] << up) >> np.int64(down)
                cells[into + i] = np.float64(raw) * scale + offset
        elif job[SWAP]:
            for i in range(job[ROWS]):
                raw = np.int64((turned(words[first + i * step]) << up) >> down)
                cells[into + i] = np.float64(raw) * scale + offset
        else:
            for i in range(job[ROWS]):
                raw = np.int64((words[first + i * step] << up) >> down)
                cells[into + i] = np.float64(raw) * scale + offset


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
            payloads.first + place.first, payloads.words.shape[1], values.size, into, place.left, place.bits,
            place.swap, signal.signed,
        ))  # fmt: skip
        self._factors.append((signal.scale, signal.offset))
        return True

    def decode(self) -> None:
        """Fill all columns that were taken."""
        if self._jobs:
            _columns(self._words, self._slab.cells, np.array(self._jobs, np.int64), np.array(self._factors))
