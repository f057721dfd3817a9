"""Columns of a Parquet file as its pages hold them: whole numbers as differences, numbers as they are, all zstd.

Source: the Parquet format, https://parquet.apache.org/docs/file-format/data-pages/encodings/ (DELTA_BINARY_PACKED, PLAIN,
and the levels that tell empty cells).
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
import zstandard
from numpy.typing import NDArray

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel
from parsers.parquet_thrift import I32, Thrift, varint

INT64, DOUBLE = 2, 5
PLAIN, RLE, DELTA = 0, 3, 5
_LEVEL = 1
"""Of zstd: a third of the work of its usual level 3, for files a third larger."""

_BLOCK, _MINI = 128, 32
_MOST_BLOCK = 10 + _BLOCK // _MINI + 8 * _BLOCK


@dataclass(frozen=True)
class PackedColumn:
    """A column of a group of rows. data: its page with the page's head; size: of the same before compression, bytes.

    kind: INT64 or DOUBLE; encoding: PLAIN or DELTA. low, high: the least and the largest value, None where there is none.
    """

    name: str
    data: bytes
    size: int
    rows: int
    empty: int
    kind: int
    encoding: int
    low: bytes | None
    high: bytes | None


@kernel
def _put_varint(value: np.uint64, out: ByteArray, at: int) -> int:
    while value >= np.uint64(128):
        out[at] = np.uint8((value & np.uint64(127)) | np.uint64(128))
        value >>= np.uint64(7)
        at += 1
    out[at] = np.uint8(value)
    return at + 1


@kernel
def _put_bits(steps: NDArray[np.uint64], width: int, out: ByteArray, at: int) -> int:
    """Numbers of `width` bits each, the first in the lowest bits; returns the place behind them."""
    held, bits = np.uint64(0), 0
    for step in steps:
        held |= step << np.uint64(bits)
        bits += width
        while bits >= 64:
            for k in range(8):
                out[at + k] = np.uint8((held >> np.uint64(8 * k)) & np.uint64(255))
            at += 8
            bits -= 64
            held = step >> np.uint64(width - bits) if bits else np.uint64(0)
    while bits > 0:
        out[at] = np.uint8(held & np.uint64(255))
        held >>= np.uint64(8)
        at += 1
        bits -= 8
    return at


@kernel
def _put_differences(values: IntArray, steps: NDArray[np.uint64], out: ByteArray) -> int:
    """The blocks of DELTA_BINARY_PACKED; returns their size. values: (n,). steps: (_BLOCK,) for use in between.

    out: at least _MOST_BLOCK bytes a block. Differences wrap around as those of int64 do.
    """
    at, n = 0, values.size
    for start in range(1, n, _BLOCK):
        stop = min(start + _BLOCK, n)
        least = values[start] - values[start - 1]
        for k in range(start, stop):
            least = min(least, values[k] - values[k - 1])
        at = _put_varint(np.uint64((least << 1) ^ (least >> 63)), out, at)
        # what is beyond the last value is of no account
        steps[:] = 0
        for k in range(start, stop):
            steps[k - start] = np.uint64(values[k] - values[k - 1] - least)
        widths = at
        at += _BLOCK // _MINI
        for mini in range(_BLOCK // _MINI):
            part = steps[mini * _MINI : (mini + 1) * _MINI]
            every = np.uint64(0)
            for step in part:
                every |= step
            width = 0
            while every > np.uint64(0):
                width += 1
                every >>= np.uint64(1)
            out[widths + mini] = width
            if width > 0:
                at = _put_bits(part, width, out, at)
    return at


def differences(values: IntArray) -> bytes:
    """Whole numbers (n,) as DELTA_BINARY_PACKED."""
    first = int(values[0]) if len(values) else 0
    head = (
        varint(_BLOCK) + varint(_BLOCK // _MINI) + varint(len(values)) + varint((first << 1) ^ (first >> 63))
    )
    blocks = -(-max(len(values) - 1, 0) // _BLOCK)
    out = np.empty(blocks * _MOST_BLOCK, np.uint8)
    size = int(_put_differences(np.ascontiguousarray(values), np.empty(_BLOCK, np.uint64), out))
    return head + out[:size].tobytes()


def _levels(rows: int, valid: NDArray[np.bool_] | None) -> bytes:
    """Which cells hold a value: all of them, or a bit each."""
    if valid is None:
        runs = varint(rows << 1) + b"\1"
    else:
        runs = varint((-(-rows // 8) << 1) | 1) + np.packbits(valid, bitorder="little").tobytes()
    return len(runs).to_bytes(4, "little") + runs


def pack_column(name: str, values: IntArray | FloatArray) -> PackedColumn:
    """A column (n,) of int64, or of float64 with NaN where a cell is empty, ready to be written."""
    whole = values.dtype.kind == "i"
    missing = None if whole else np.isnan(values)
    valid = ~missing if missing is not None and missing.any() else None
    held: Any = values if valid is None else values[valid]
    # bytes of an array need no copy
    content = differences(held) if whole else np.ascontiguousarray(held).view(np.uint8).data
    page = b"".join((_levels(len(values), valid), content))
    packed = zstandard.ZstdCompressor(level=_LEVEL, write_content_size=True).compress(page)
    kind, encoding = (INT64, DELTA) if whole else (DOUBLE, PLAIN)
    about = Thrift([(1, I32, len(values)), (2, I32, encoding), (3, I32, RLE), (4, I32, RLE)])
    checksum = zlib.crc32(packed)
    head = Thrift(
        [
            (1, I32, 0),
            (2, I32, len(page)),
            (3, I32, len(packed)),
            # the format has it as a signed number
            (4, I32, checksum - (checksum >> 31 << 32)),
            (5, Thrift, about),
        ]
    ).pack()
    extent = (held.min().tobytes(), held.max().tobytes()) if len(held) else (None, None)
    return PackedColumn(
        name,
        head + packed,
        len(head) + len(page),
        len(values),
        len(values) - len(held),
        kind,
        encoding,
        *extent,
    )
