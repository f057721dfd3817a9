"""Compiled pieces that read protobuf's wire format: varints, fixed numbers, fields of no interest.

Source: the protobuf encoding, https://protobuf.dev/programming-guides/encoding. Every read is checked against the
end of the message it is in.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray
from parsers.jit import lean_kernel, load_u32, load_u64

VARINT, FIXED64, BYTES, GROUP, GROUP_END, FIXED32 = 0, 1, 2, 3, 4, 5
DOUBLE, FLOAT, UINT64, INT32, FIXED64_KIND, FIXED32_KIND, BOOL = 1, 2, 4, 5, 6, 7, 8
MESSAGE, UINT32, ENUM, SFIXED32, SINT32, SINT64 = 11, 13, 14, 15, 17, 18


@lean_kernel
def signed(value: np.uint64) -> int:
    """The same bits as int64 (numba's int() would keep it unsigned, and unsigned + signed would be a float)."""
    return np.int64(value)  # type: ignore[return-value]


@lean_kernel
def varint(data: ByteArray, at: int, end: int) -> tuple[np.uint64, int]:
    """A varint and the place behind it; place -1 where it is cut off or longer than 10 bytes."""
    value = np.uint64(0)
    for k in range(10):
        if at + k >= end:
            return value, -1
        byte = np.uint64(data[at + k])
        value |= (byte & np.uint64(0x7F)) << np.uint64(7 * k)
        if byte < np.uint64(0x80):
            return value, at + k + 1
    return value, -1


@lean_kernel
def raw(data: ByteArray, at: int, end: int, wire: int) -> tuple[np.uint64, int]:
    """A number of the given wire type and the place behind it, -1 where it is cut off."""
    if wire == VARINT:
        return varint(data, at, end)
    size = 8 if wire == FIXED64 else 4
    if size > end - at:
        return np.uint64(0), -1
    bits = np.uint64(load_u64(data, at)) if size == 8 else np.uint64(load_u32(data, at))
    return bits, at + size


@lean_kernel
def whole(kind: int, bits: np.uint64) -> int:
    """The integer that the bits mean for an integer kind (uint64 above 2^63 wraps)."""
    if kind in (SINT32, SINT64):
        if kind == SINT32:
            bits &= np.uint64(0xFFFFFFFF)
        return signed(bits >> np.uint64(1)) ^ -signed(bits & np.uint64(1))
    if kind in (INT32, ENUM, SFIXED32):
        low = signed(bits & np.uint64(0xFFFFFFFF))
        return low - (1 << 32) if low >= (1 << 31) else low
    if kind in (UINT32, FIXED32_KIND):
        return signed(bits & np.uint64(0xFFFFFFFF))
    if kind == BOOL:
        return 1 if bits != np.uint64(0) else 0
    return signed(bits)


@lean_kernel
def number(kind: int, bits: np.uint64, word: NDArray[np.uint64], half: NDArray[np.uint32]) -> float:
    """The number that the bits mean. word, half: one element of scratch each, to look at bits as floats."""
    if kind == DOUBLE:
        word[0] = bits
        return word.view(np.float64)[0]  # type: ignore[no-any-return]
    if kind == FLOAT:
        half[0] = np.uint32(bits & np.uint64(0xFFFFFFFF))
        return np.float64(half.view(np.float32)[0])
    if kind in (UINT64, FIXED64_KIND):
        return np.float64(bits)
    return np.float64(whole(kind, bits))


@lean_kernel
def skip(data: ByteArray, at: int, end: int, wire: int) -> int:
    """The place behind a field of no interest, -1 where the payload is malformed. Groups are skipped whole."""
    depth = 0
    while True:
        if wire == VARINT:
            _, at = varint(data, at, end)
        elif wire in (FIXED64, FIXED32):
            at += 8 if wire == FIXED64 else 4
        elif wire == BYTES:
            size, at = varint(data, at, end)
            if at < 0 or size > np.uint64(end - at):
                return -1
            at += signed(size)
        elif wire == GROUP:
            depth += 1
        elif wire == GROUP_END and depth > 0:
            depth -= 1
        else:
            return -1
        if at < 0 or at > end:
            return -1
        if depth == 0:
            return at
        tag, at = varint(data, at, end)
        if at < 0 or tag < np.uint64(8):
            return -1
        wire = signed(tag & np.uint64(7))
