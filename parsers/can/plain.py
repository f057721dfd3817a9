"""Many columns of plain signals in one call of a kernel.

A column of a piece is a few hundredths of a millisecond of work: called one by one, two cores wait for the interpreter's lock longer
than they decode.
"""

from __future__ import annotations

import numpy as np

from parsers.allocator import Slab
from parsers.can.decode import Payloads, Place, WordArray, is_plain, plain
from parsers.can.definitions import SignalDef
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
