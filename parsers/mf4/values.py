"""Raw values of channels out of a block of records: whole columns, any byte order, any bits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.mf4.model import VIRTUAL, VIRTUAL_MASTER, Channel, Group

UINT_LE, UINT_BE, INT_LE, INT_BE, FLOAT_LE, FLOAT_BE = range(6)
Raw = NDArray[np.uint64] | IntArray | FloatArray


def is_virtual(channel: Channel) -> bool:
    """Whether the value is the record's number, and no bits of the record."""
    return channel.kind in (VIRTUAL, VIRTUAL_MASTER)


def fault(channel: Channel, group: Group) -> str | None:
    """Why a channel's numbers cannot be read, or None."""
    if is_virtual(channel):
        return None
    if not 0 <= channel.data_type <= FLOAT_BE:
        return f"data type {channel.data_type} is no number"
    if channel.data_type in (FLOAT_LE, FLOAT_BE):
        if channel.bit_count not in (16, 32, 64) or channel.bit_offset:
            return f"a float of {channel.bit_count} bits at bit {channel.bit_offset}"
    elif not 1 <= channel.bit_count <= 64 or channel.bit_offset > 7:
        return f"an integer of {channel.bit_count} bits at bit {channel.bit_offset}"
    if channel.byte_offset + channel.byte_count > group.invalid_at:
        return f"bytes {channel.byte_offset} to {channel.byte_offset + channel.byte_count} of records of {group.invalid_at}"
    return None


def _whole(rows: ByteArray, channel: Channel) -> Raw | None:
    """Values that are a machine type: one strided look, no bit work."""
    size = channel.bit_count // 8
    letter = {UINT_LE: "u", UINT_BE: "u", INT_LE: "i", INT_BE: "i", FLOAT_LE: "f", FLOAT_BE: "f"}[
        channel.data_type
    ]
    if channel.bit_offset or channel.bit_count not in (8, 16, 32, 64):
        return None
    dtype = np.dtype(f"{'>' if channel.data_type % 2 else '<'}{letter}{size}")
    at = channel.byte_offset
    column = np.ascontiguousarray(rows[:, at : at + size]).view(dtype)[:, 0]
    if letter == "f":
        # bytes that are no float may be the kind of NaN that numpy warns of
        with np.errstate(invalid="ignore"):
            return column.astype(np.float64)
    return column.astype(np.uint64) if letter == "u" else column.astype(np.int64)


def _bits(rows: ByteArray, channel: Channel) -> Raw:
    """Integers of any number of bits at any bit; up to 9 bytes are touched."""
    size, at = channel.byte_count, channel.byte_offset
    part = rows[:, at : at + size]
    if channel.data_type in (UINT_BE, INT_BE):
        part = part[:, ::-1]
    padded = np.zeros((rows.shape[0], 16), np.uint8)
    padded[:, :size] = part
    words = padded.view("<u8")
    value = (words[:, 0] >> np.uint64(channel.bit_offset)).astype(np.uint64)
    if size > 8:
        value |= words[:, 1] << np.uint64(64 - channel.bit_offset)
    if channel.bit_count < 64:
        value &= np.uint64((1 << channel.bit_count) - 1)
    if channel.data_type in (UINT_LE, UINT_BE):
        return value
    spare = np.int64(64 - channel.bit_count)
    return (value.view(np.int64) << spare) >> spare


def raw_values(rows: ByteArray, channel: Channel, first: int) -> Raw:
    """Raw values, shape (n,), of a channel without `fault`. rows: (n, record bytes). first: number of the first record."""
    if is_virtual(channel):
        return np.arange(first, first + rows.shape[0], dtype=np.int64)
    whole = _whole(rows, channel)
    return _bits(rows, channel) if whole is None else whole


def has_invalid_bit(channel: Channel) -> bool:
    """Whether a bit of each record says if the channel's value is valid."""
    return channel.flags & 3 == 2


def invalid(rows: ByteArray, channel: Channel) -> NDArray[np.bool_] | None:
    """Where the channel has no valid value; None where nothing is said. rows: invalidation bytes, shape (n, bytes)."""
    if channel.flags & 1:
        return np.ones(rows.shape[0], np.bool_)
    at = channel.invalid_bit // 8
    if not channel.flags & 2 or at >= rows.shape[1]:
        return None
    return np.asarray((rows[:, at] >> np.uint8(channel.invalid_bit % 8)) & np.uint8(1), np.bool_)
