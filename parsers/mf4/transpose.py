"""Turn transposed blocks back into records: squares of eight by eight bytes at a time, in registers."""

from __future__ import annotations

import numpy as np

from parsers.channels import ByteArray
from parsers.jit import kernel, load_u64

SQUARE = 8


@kernel
def _swapped(a: int, b: int, mask: int, bits: int) -> tuple[int, int]:
    """Exchange the upper parts of each lane of `a` with the lower parts of `b` (both uint64)."""
    keep, shift = np.uint64(mask), np.uint64(bits)
    moved = ((a >> shift) ^ b) & keep
    return int(a ^ (moved << shift)), int(b ^ moved)


@kernel
def put_u64(out: ByteArray, at: int, value: int) -> None:
    """Write eight bytes, unchecked. The compiler makes one store of these, as the places are unsigned."""
    p = np.uint64(at)
    out[p] = np.uint8(value)
    out[p + np.uint64(1)] = np.uint8(value >> np.uint64(8))
    out[p + np.uint64(2)] = np.uint8(value >> np.uint64(16))
    out[p + np.uint64(3)] = np.uint8(value >> np.uint64(24))
    out[p + np.uint64(4)] = np.uint8(value >> np.uint64(32))
    out[p + np.uint64(5)] = np.uint8(value >> np.uint64(40))
    out[p + np.uint64(6)] = np.uint8(value >> np.uint64(48))
    out[p + np.uint64(7)] = np.uint8(value >> np.uint64(56))


@kernel
def _square(data: ByteArray, at: int, lines: int, out: ByteArray, to: int, columns: int) -> None:
    """Eight bytes of each of eight columns, to eight bytes of each of eight lines."""
    keep, shift = 0x00000000FFFFFFFF, 32
    a, e = _swapped(load_u64(data, at), load_u64(data, at + 4 * lines), keep, shift)
    b, f = _swapped(load_u64(data, at + lines), load_u64(data, at + 5 * lines), keep, shift)
    c, g = _swapped(load_u64(data, at + 2 * lines), load_u64(data, at + 6 * lines), keep, shift)
    d, h = _swapped(load_u64(data, at + 3 * lines), load_u64(data, at + 7 * lines), keep, shift)
    keep, shift = 0x0000FFFF0000FFFF, 16
    a, c = _swapped(a, c, keep, shift)
    b, d = _swapped(b, d, keep, shift)
    e, g = _swapped(e, g, keep, shift)
    f, h = _swapped(f, h, keep, shift)
    keep, shift = 0x00FF00FF00FF00FF, 8
    a, b = _swapped(a, b, keep, shift)
    c, d = _swapped(c, d, keep, shift)
    e, f = _swapped(e, f, keep, shift)
    g, h = _swapped(g, h, keep, shift)
    put_u64(out, to, a)
    put_u64(out, to + columns, b)
    put_u64(out, to + 2 * columns, c)
    put_u64(out, to + 3 * columns, d)
    put_u64(out, to + 4 * columns, e)
    put_u64(out, to + 5 * columns, f)
    put_u64(out, to + 6 * columns, g)
    put_u64(out, to + 7 * columns, h)


@kernel
def _squares(data: ByteArray, columns: int, lines: int, out: ByteArray) -> None:
    """All lines by squares; where a side is no multiple of eight, the last square overlaps the one before.

    columns and lines are at least eight, data and out hold columns * lines bytes: nothing else is checked.
    """
    for some in range(0, lines, SQUARE):
        line = min(some, lines - SQUARE)
        for few in range(0, columns, SQUARE):
            column = min(few, columns - SQUARE)
            _square(data, column * lines + line, lines, out, line * columns + column, columns)


def records_of(data: ByteArray, columns: int, out: ByteArray | None = None) -> ByteArray:
    """The bytes of a block in the records' order. data: all first bytes of the records, all second ones, and so on.

    columns: bytes of a record. What is left behind the last whole record stands at the end as it is. out: as long as data, where
    they are to go; without it they may be `data` itself.
    """
    lines = data.size // columns if columns > 0 else 0
    if columns < 2 or lines < 2:
        if out is None:
            return data
        out[:] = data
        return out
    if out is None:
        out = np.empty(data.size, np.uint8)
    whole = columns * lines
    if columns < SQUARE or lines < SQUARE:
        out[:whole] = data[:whole].reshape(columns, lines).T.reshape(-1)
    else:
        _squares(data, columns, lines, out)
    out[whole:] = data[whole:]
    return out
