"""Values of measured channels out of records: all wanted ones of some hundred records at a time, so that those stay near."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel, load_u64

AT, SHIFT, MASK, KIND, SPARE, LINEAR, RULES = range(7)
"""Columns of `rules`. AT, SHIFT, MASK: see `parsers.mf4.words`. SPARE: bits of a word that are not the value's. LINEAR: 1
where `linear` (factor, offset) is to be used."""
UNSIGNED, SIGNED, FLOAT_32, FLOAT_64 = range(4)
BLOCK = 512
"""Records at a time."""


@kernel
def _raw(data: ByteArray, at: int, stride: int, rule: IntArray, words: IntArray, count: int) -> None:
    """The bits of one channel of some records."""
    shift, mask = np.uint64(rule[SHIFT]), np.uint64(rule[MASK])
    for i in range(count):
        words[i] = np.int64((load_u64(data, at + i * stride) >> shift) & mask)


@kernel
def _numbers(
    words: IntArray, rule: IntArray, doubles: FloatArray, singles: NDArray[np.float32], out: FloatArray
) -> None:
    """The bits as numbers. doubles, singles: the memory of `words`, looked at as floats of 8 and of 4 bytes."""
    if rule[KIND] == FLOAT_64:
        for i in range(out.shape[0]):
            out[i] = doubles[i]
    elif rule[KIND] == FLOAT_32:
        step = singles.shape[0] // words.shape[0]
        for i in range(out.shape[0]):
            out[i] = singles[step * i]
    elif rule[KIND] == SIGNED:
        spare = rule[SPARE]
        for i in range(out.shape[0]):
            out[i] = float((words[i] << spare) >> spare)
    elif rule[SPARE] > 0:
        for i in range(out.shape[0]):
            out[i] = float(words[i])
    else:
        for i in range(out.shape[0]):
            out[i] = float(np.uint64(words[i]))


@kernel
def read_columns(
    data: ByteArray,
    stride: int,
    begin: int,
    rules: IntArray,
    linear: FloatArray,
    words: IntArray,
    singles: NDArray[np.float32],
    out: FloatArray,
) -> None:
    """Fill out (channels, records). rules: (channels, RULES). linear: (channels, 2).

    words: room for BLOCK; singles: the same memory as float32, from the place of each word's lower half on.
    data: contiguous, one record every `stride` bytes from `begin` on. No load is checked: each channel's word lies within
    its record.
    """
    doubles = words.view(np.float64)
    for row in range(0, out.shape[1], BLOCK):
        count = min(BLOCK, out.shape[1] - row)
        for channel in range(out.shape[0]):
            rule = rules[channel]
            some = out[channel, row : row + count]
            _raw(data, row * stride + begin + rule[AT], stride, rule, words, count)
            _numbers(words, rule, doubles, singles, some)
            if rule[LINEAR] != 0:
                factor, offset = linear[channel, 0], linear[channel, 1]
                for i in range(count):
                    some[i] = some[i] * factor + offset
