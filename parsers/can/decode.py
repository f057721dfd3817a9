"""Raw values of a signal out of many payloads at once, and their conversion to physical values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parsers.can.definitions import BitField, SignalDef
from parsers.can.frames import CanFrames
from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel

RawArray = NDArray[np.uint64]
Mask = NDArray[np.bool_]


@kernel
def _gather_little(
    data: ByteArray,
    offset: IntArray,
    length: ByteArray,
    rows: IntArray,
    start: int,
    bits: int,
    raw: RawArray,
    short: Mask,
) -> None:
    first = start >> 3
    last = (start + bits - 1) >> 3
    shift = np.uint64(start & 7)
    mask = np.uint64(0xFFFFFFFFFFFFFFFF) >> np.uint64(64 - bits)
    for i in range(rows.size):
        row = rows[i]
        at = offset[row]
        if last >= length[row] or at < 0 or at >= data.size - last:
            raw[i] = np.uint64(0)
            short[i] = True
            continue
        value = np.uint64(data[at + first]) >> shift
        for k in range(first + 1, last + 1):
            value |= np.uint64(data[at + k]) << (np.uint64(8 * (k - first)) - shift)
        raw[i] = value & mask
        short[i] = False


@kernel
def _gather_big(
    data: ByteArray,
    offset: IntArray,
    length: ByteArray,
    rows: IntArray,
    start: int,
    bits: int,
    raw: RawArray,
    short: Mask,
) -> None:
    first = start >> 3
    # bits of the first byte below and at the most significant one, and what lies beyond the last bit
    head = (start & 7) + 1
    last = first + (max(bits - head, 0) + 7) // 8
    spare = head + 8 * (last - first) - bits
    head_mask = np.uint64((1 << head) - 1)
    for i in range(rows.size):
        row = rows[i]
        at = offset[row]
        if last >= length[row] or at < 0 or at >= data.size - last:
            raw[i] = np.uint64(0)
            short[i] = True
            continue
        value = np.uint64(data[at + first]) & head_mask
        if last == first:
            value >>= np.uint64(spare)
        else:
            for k in range(first + 1, last):
                value = (value << np.uint64(8)) | np.uint64(data[at + k])
            kept = np.uint64(8 - spare)
            value = (value << kept) | (np.uint64(data[at + last]) >> np.uint64(spare))
        raw[i] = value
        short[i] = False


def raw_values(frames: CanFrames, rows: IntArray, field: BitField) -> tuple[RawArray, Mask]:
    """A field's raw value in the given frames.

    rows: (n,) indices into `frames`. Returns (n,) uint64 unsigned raw values, and (n,) bool: the payload is too short
    for the field (the raw value is 0 there).
    """
    raw = np.empty(rows.size, dtype=np.uint64)
    short = np.empty(rows.size, dtype=np.bool_)
    gather = _gather_little if field.little else _gather_big
    gather(frames.data, frames.offset, frames.length, rows, field.start, field.length, raw, short)
    return raw, short


@dataclass(frozen=True)
class Decoded:
    """One signal in n frames: physical values, NaN where there is none, and how often for which reason.

    short: (n,) bool, frames too short for the signal. not_available, errors, reserved: counts of J1939 codes.
    invalid: count of codes that the database's value table calls invalid.
    """

    values: FloatArray
    short: Mask
    not_available: int = 0
    errors: int = 0
    reserved: int = 0
    invalid: int = 0


def decode_signal(
    frames: CanFrames, rows: IntArray, signal: SignalDef, *, j1939: bool = False, proprietary: bool = False
) -> Decoded:
    """A signal's physical values in the given frames.

    j1939: look for the codes "not available", "error" and "reserved"; proprietary: only for "not available", since
    the maker of such a message may use the other codes as values.
    """
    raw, short = raw_values(frames, rows, signal.field)
    values = _physical(raw, signal)
    missing = short.copy()
    counts = [0, 0, 0]
    if j1939 and not signal.signed and not signal.is_float:
        for index, (low, high) in enumerate(j1939_codes(signal.field.length, proprietary)):
            hit = (raw >= np.uint64(low)) & (raw <= np.uint64(high)) & ~missing
            counts[index] = int(np.count_nonzero(hit))
            if counts[index]:
                missing |= hit
    invalid = 0
    if signal.invalid:
        hit = np.isin(raw, np.array(signal.invalid, dtype=np.uint64)) & ~missing
        invalid = int(np.count_nonzero(hit))
        missing |= hit
    values[missing] = np.nan
    return Decoded(values, short, counts[0], counts[1], counts[2], invalid)


def j1939_codes(bits: int, proprietary: bool = False) -> list[tuple[int, int]]:
    """Raw ranges (inclusive) that stand for "not available", "error" and "reserved", in this order.

    SAE J1939-71: the most significant byte is FF, FE, FB-FD for values of 8, 12, 16, 20, 24, 28 and 32 bits; a
    10-bit value has single codes at its top, 2 and 4 bits end with error and not available. Other lengths: all ones.
    """
    top = (1 << bits) - 1
    if bits == 1:
        return []
    if proprietary:
        return [(top, top)] if bits >= 8 else []
    if 8 <= bits <= 32 and bits % 4 == 0:
        step = 1 << (bits - 8)
        return [(0xFF * step, top), (0xFE * step, 0xFF * step - 1), (0xFB * step, 0xFE * step - 1)]
    if bits == 10:
        return [(top, top), (top - 1, top - 1), (top - 4, top - 2)]
    if bits in (2, 4):
        return [(top, top), (top - 1, top - 1)]
    return [(top, top)]


def _physical(raw: RawArray, signal: SignalDef) -> FloatArray:
    bits = signal.field.length
    if signal.is_float:
        kinds = {16: (np.uint16, np.float16), 32: (np.uint32, np.float32), 64: (np.uint64, np.float64)}
        whole, fraction = kinds[bits]
        values = raw.astype(whole).view(fraction).astype(np.float64)
    elif signal.signed:
        unused = 64 - bits
        values = ((raw << np.uint64(unused)).view(np.int64) >> np.int64(unused)).astype(np.float64)
    else:
        values = raw.astype(np.float64)
    if signal.scale != 1.0:
        with np.errstate(over="ignore", invalid="ignore"):
            values *= signal.scale
    if signal.offset != 0.0:
        values += signal.offset
    return values


@kernel
def _split(slot: IntArray, slots: int, order: IntArray, bounds: IntArray) -> None:
    for i in range(slot.size):
        if 0 <= slot[i] < slots:
            bounds[slot[i] + 1] += 1
    for k in range(slots):
        bounds[k + 1] += bounds[k]
    at = bounds[:slots].copy()
    for i in range(slot.size):
        which = slot[i]
        if 0 <= which < slots:
            order[at[which]] = i
            at[which] += 1


def rows_by_slot(slot: IntArray, slots: int) -> list[IntArray]:
    """The row numbers of each slot, in order. slot: (n,) int64, -1 for rows that belong to none."""
    order = np.empty(slot.size, dtype=np.int64)
    bounds = np.zeros(slots + 1, dtype=np.int64)
    _split(slot, slots, order, bounds)
    return [order[bounds[k] : bounds[k + 1]] for k in range(slots)]


def frame_keys(frames: CanFrames) -> IntArray:
    """One number for bus and id of each frame: (n,) int64, bus * 2**32 + id."""
    return (frames.bus.astype(np.int64) << np.int64(32)) | frames.can_id.astype(np.int64)
