"""Compiled helpers that read a text log's digits eight characters, or two hexadecimal digits, at once.

Eight characters are loaded as one uint64: the first is the lowest byte, so that a number's last digit is the highest.
The loads are unchecked: a text must have FRONT bytes in front of the first line and BEHIND bytes behind the last.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.can.bytescan import LONG_LINE
from parsers.channels import ByteArray
from parsers.jit import lean_kernel, load_u16, load_u32, load_u64

FRONT = 64
BEHIND = 512

NO_PAIR = 1 << 8
"""In the table of pairs: not two hexadecimal digits."""

_HIGH = np.uint64(0x8080808080808080)
_LOW = np.uint64(0x0101010101010101)
_FEEDS = np.uint64(0x0A0A0A0A0A0A0A0A)
_NIBBLES = np.uint64(0x0F0F0F0F0F0F0F0F)
_PLACES = np.uint64(0x0001020304050607)
_NONE = np.uint64(0)


def hex_pairs() -> NDArray[np.int16]:
    """(65536,) the byte that two characters, loaded as a little-endian number, mean; NO_PAIR where none."""
    digits = np.full(256, NO_PAIR, dtype=np.int16)
    for value, character in enumerate("0123456789abcdef"):
        digits[ord(character)] = digits[ord(character.upper())] = value
    second, first = np.meshgrid(digits, digits, indexing="ij")
    pairs: NDArray[np.int16] = np.where(
        (first < 16) & (second < 16), first * np.int16(16) + second, np.int16(NO_PAIR)
    ).ravel()
    return pairs


@lean_kernel
def signed(value: np.uint64) -> int:
    """The same number, to go on with as kernels do with numbers."""
    return np.int64(value)  # type: ignore[return-value]


@lean_kernel
def not_decimal(values: np.uint64) -> np.uint64:
    """Zero if all eight bytes are 0 to 9."""
    return (values | (values + np.uint64(0x7676767676767676))) & _HIGH


@lean_kernel
def decimal(values: np.uint64) -> int:
    """The number whose eight digits are the bytes."""
    pairs = (values * np.uint64(2561)) >> np.uint64(8)
    fours = ((pairs & np.uint64(0x00FF00FF00FF00FF)) * np.uint64(6553601)) >> np.uint64(16)
    return signed(((fours & np.uint64(0x0000FFFF0000FFFF)) * np.uint64(42949672960001)) >> np.uint64(32))


@lean_kernel
def not_hexadecimal(text: np.uint64) -> np.uint64:
    """Zero if all eight characters are hexadecimal digits."""
    small = text | np.uint64(0x2020202020202020)
    number = (text + np.uint64(0x5050505050505050)) & ~(text + np.uint64(0x4646464646464646))
    letter = (small + np.uint64(0x1F1F1F1F1F1F1F1F)) & ~(small + np.uint64(0x1919191919191919))
    # sums carry into the next character only from one that is beyond ASCII
    return (~(number | letter) | text) & _HIGH


@lean_kernel
def hexadecimal(text: np.uint64) -> int:
    """The number whose eight hexadecimal digits are the characters."""
    ones = (text & _NIBBLES) + np.uint64(9) * ((text >> np.uint64(6)) & _LOW)
    twos = ((ones << np.uint64(4)) | (ones >> np.uint64(8))) & np.uint64(0x00FF00FF00FF00FF)
    fours = ((twos << np.uint64(8)) | (twos >> np.uint64(16))) & np.uint64(0x0000FFFF0000FFFF)
    return signed(((fours << np.uint64(16)) | (fours >> np.uint64(32))) & np.uint64(0xFFFFFFFF))


@lean_kernel
def find_feed(text: ByteArray, at: int, stop: int) -> int:
    """The first line feed or zero byte in [at, stop), or stop."""
    while at < stop:
        zeros = load_u64(text, at)
        feeds = zeros ^ _FEEDS
        hits = (((feeds - _LOW) & ~feeds) | ((zeros - _LOW) & ~zeros)) & _HIGH
        if hits != _NONE:
            lowest = (hits & (~hits + np.uint64(1))) >> np.uint64(7)
            return min(at + signed((lowest * _PLACES) >> np.uint64(56)), stop)
        at += 8
    return stop


@lean_kernel
def feed_after(text: ByteArray, at: int, stop: int) -> int:
    """The line feed of a line whose payload ends at `at`, -1 where a payload may not end so."""
    byte = text[at]
    feed = at
    if byte == 13:
        feed = at + 1
    elif byte == 32:
        feed = at + 1 if text[at + 1] == 10 else find_feed(text, at + 1, stop)
    elif byte != 10:
        return -1
    if feed - at > LONG_LINE:
        # the format's kernel looks at what that is, and at lines with zeros
        return -1
    return feed if feed < stop and text[feed] == 10 else -1


@lean_kernel
def spaced_bytes(
    text: ByteArray, at: int, count: int, pairs: NDArray[np.int16], data: ByteArray, into: int
) -> bool:
    """Write `count` bytes that stand at `at` with one space between them to data[into:]; False where they do not."""
    wrong = int(pairs[load_u16(text, at)])
    data[into] = wrong
    if count == 8:
        # the usual number once more, so that its loop is unrolled
        for k in range(1, 8):
            wrong |= spaced_byte(text, at + 3 * k, pairs, data, into + k)
    else:
        for k in range(1, count):
            wrong |= spaced_byte(text, at + 3 * k, pairs, data, into + k)
    return bool(wrong < NO_PAIR)


@lean_kernel
def spaced_byte(text: ByteArray, at: int, pairs: NDArray[np.int16], data: ByteArray, into: int) -> int:
    """Write the byte at `at` to data[into]; below NO_PAIR if there is one, and a space before it."""
    word = load_u32(text, at - 1)
    value = int(pairs[(word >> 8) & 0xFFFF])
    data[into] = value
    return value | ((word & 0xFF) ^ 32) << 8


@lean_kernel
def compact_bytes(
    text: ByteArray, at: int, most: int, pairs: NDArray[np.int16], data: ByteArray, into: int
) -> int:
    """Write the bytes that stand at `at` without separators, `most` at most, to data[into:]; their number."""
    count = 0
    wrong = 0
    for k in range(8):
        value = int(pairs[load_u16(text, at + 2 * k)])
        data[into + k] = value
        wrong |= value
    if wrong < NO_PAIR:
        count = 8
    while count < most:
        value = int(pairs[load_u16(text, at + 2 * count)])
        if value == NO_PAIR:
            break
        data[into + count] = value
        count += 1
    return count
