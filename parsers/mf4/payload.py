"""Where the payload bytes of CAN frames are: in the record, or in records of variable length elsewhere."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, IntArray
from parsers.errors import LogError
from parsers.jit import kernel, load_u32
from parsers.mf4.batch import Batch, Window
from parsers.mf4.model import FIXED, Channel, Group
from parsers.mf4.streams import DataStream
from parsers.mf4.values import UINT_LE, fault, raw_values

MAX_LENGTH = 64
MAX_SPAN = 16 << 20
"""Bytes of variable-length data read for one batch of records at a time."""
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True)
class Payload:
    """data, and for each frame offset and length in it. good: the payload is whole. late: it is not there yet."""

    data: ByteArray
    offset: IntArray
    length: IntArray
    good: BoolArray
    late: BoolArray

    def rows(self, choice: slice | BoolArray) -> Payload:
        """Those of some of the frames."""
        columns = (self.offset[choice], self.length[choice], self.good[choice], self.late[choice])
        return Payload(self.data, *columns)


def reference_fault(channel: Channel, group: Group) -> str | None:
    """Why the place of a payload cannot be read from a record, or None."""
    return fault(replace(channel, kind=FIXED, data_type=UINT_LE), group)


def references(rows: ByteArray, channel: Channel) -> IntArray:
    """Places of the payloads, as the records say (in 4 or 8 bytes); -1 where the number is impossible."""
    raw = raw_values(rows, replace(channel, kind=FIXED, data_type=UINT_LE), 0).astype(np.uint64)
    possible = raw < np.uint64(1 << 62)
    return np.where(possible, np.where(possible, raw, 0).astype(np.int64), -1)


@kernel
def _find_payloads(
    data: ByteArray, at: IntArray, length: IntArray, offset: IntArray, taken: IntArray, good: BoolArray
) -> None:
    """Look at the u32 length at each place: offset, bytes and whether all of it is in `data`. Places may be anywhere."""
    end = data.shape[0]
    for i in range(at.shape[0]):
        offset[i], taken[i], good[i] = 0, 0, False
        start = at[i]
        if 0 <= start <= end - 4:
            stored = load_u32(data, start)
            if stored <= end - 4 - start:
                offset[i], taken[i], good[i] = start + 4, min(stored, length[i], MAX_LENGTH), True


def _resolve(data: ByteArray, at: IntArray, length: IntArray, late: BoolArray) -> Payload:
    """Payloads at places in `data`, each behind its u32 length."""
    offset, taken, good = np.empty_like(at), np.empty_like(at), np.empty(at.size, np.bool_)
    _find_payloads(data, at, length, offset, taken, good)
    return Payload(data, offset, taken, good | late, late)


def window_payload(
    batch: Batch, channel: Channel, length: IntArray, window: Window, *, by_order: bool
) -> Payload:
    """Payloads in a VLSD group of the same stream. by_order: an unfinished file, whose records' places were never
    written: the n-th record belongs to the n-th payload."""
    if by_order:
        number = batch.first + np.arange(batch.count, dtype=np.int64) - window.first
        known = (number >= 0) & (number < window.starts.size)
        late = number >= window.starts.size
        place = np.full(number.size, -1, np.int64)
        place[known] = window.starts[number[known]] - window.base
    else:
        reference = references(batch.rows, channel)
        late = (reference >= window.end) & (reference < window.end + MAX_SPAN)
        place = np.where(reference >= 0, reference - window.base, -1)
    if window.lost:
        place, late = np.full_like(place, -1), np.zeros_like(late)
    return _resolve(window.data, place, length, late)


def stream_payload(batch: Batch, channel: Channel, length: IntArray, stream: DataStream) -> Payload:
    """Payloads in a data stream of their own (SD blocks). Records are read in pieces where they are far apart."""
    reference = references(batch.rows, channel)
    count = reference.size
    inside = (reference >= 0) & (reference + 4 <= stream.size)
    parts: list[ByteArray] = []
    place, base = np.full(count, -1, np.int64), 0
    begin = 0
    while begin < count:
        low, stop = _span(reference, inside, begin)
        if stop > begin and inside[begin:stop].any():
            part = reference[begin:stop][inside[begin:stop]]
            high = min(int(part.max()) + 4 + MAX_LENGTH, stream.size)
            try:
                data = stream.read(low, high)
            except LogError:
                data = np.zeros(0, np.uint8)
                inside[begin:stop] = False
            parts.append(data)
            rows = np.flatnonzero(inside[begin:stop]) + begin
            place[rows] = reference[rows] - low + base
            base += data.size
        begin = stop
    joined = np.concatenate(parts) if parts else np.zeros(0, np.uint8)
    return _resolve(joined, place, length, np.zeros(count, np.bool_))


def _span(reference: IntArray, inside: BoolArray, begin: int) -> tuple[int, int]:
    """The longest run of records from `begin` whose payloads lie within MAX_SPAN, and its lowest place."""
    some = reference[begin:]
    neutral = np.where(inside[begin:], some, some[inside[begin:]][0] if inside[begin:].any() else 0)
    spread = np.maximum.accumulate(neutral) - np.minimum.accumulate(neutral)
    run = max(int(np.searchsorted(spread, MAX_SPAN, side="right")), 1)
    return int(neutral[:run].min()), begin + run
