"""Small compiled helpers that read numbers out of the bytes of a text line. All stay within [at, end)."""

from __future__ import annotations

from parsers.channels import ByteArray
from parsers.jit import lean_kernel

BAD = -(1 << 62)
"""What the helpers return where there is no number."""


@lean_kernel
def skip_space(text: ByteArray, at: int, end: int) -> int:
    """The first place at or after `at` that is neither space nor tab."""
    while at < end and (text[at] == 32 or text[at] == 9):
        at += 1
    return at


@lean_kernel
def token_end(text: ByteArray, at: int, end: int) -> int:
    """Where the word that begins at `at` ends."""
    while at < end and text[at] != 32 and text[at] != 9:
        at += 1
    return at


@lean_kernel
def line_end(text: ByteArray, at: int, stop: int) -> int:
    """Where the line that begins at `at` ends: its line feed, or the end of the text."""
    while at < stop and text[at] != 10:
        at += 1
    return at


LONG_LINE = 400
"""Characters beyond which no line of these formats is: a frame of 64 bytes with all that Vector writes behind it takes 320."""


@lean_kernel
def holds_zeros(text: ByteArray, at: int, feed: int) -> bool:
    """Whether a line holds zero bytes: what is left of a lost block of the file, and of the lines that stood there."""
    while at < feed and text[at] != 0:
        at += 1
    return at < feed


@lean_kernel
def swallowed(text: ByteArray, at: int, feed: int) -> bool:
    """Whether a comment or header stands before a lost block: a shorter one may be filled up with zeros by its writer."""
    return feed - at > LONG_LINE and holds_zeros(text, at, feed)


@lean_kernel
def torn(text: ByteArray, at: int, feed: int) -> bool:
    """Whether a line that is none of the format's is what a damaged block left, and may stand for several.

    It is longer than any frame, or holds bytes that no text has. A short line of text is one that some tool wrote.
    """
    if feed - at > LONG_LINE:
        return True
    found = False
    for i in range(at, feed):
        # tab to carriage return are text, and so are the end mark of DOS and the escapes of a console's colours
        found |= (text[i] < 9) | ((text[i] > 13) & (text[i] < 26))
    return found


@lean_kernel
def trimmed_end(text: ByteArray, at: int, end: int) -> int:
    """Where a line ends without the spaces and carriage returns at its end."""
    while end > at and (text[end - 1] == 13 or text[end - 1] == 32):
        end -= 1
    return end


@lean_kernel
def nibble(byte: int) -> int:
    """A hexadecimal digit's value, -1 for anything else."""
    if 48 <= byte <= 57:
        return byte - 48
    if 65 <= byte <= 70:
        return byte - 55
    if 97 <= byte <= 102:
        return byte - 87
    return -1


@lean_kernel
def whole_number(text: ByteArray, at: int, end: int, base: int) -> int:
    """The number in [at, end) in base 10 or 16, BAD where it is none or has more than 15 digits."""
    if at >= end or end - at > 15:
        return BAD
    value = 0
    for i in range(at, end):
        digit = nibble(text[i])
        if digit < 0 or digit >= base:
            return BAD
        value = value * base + digit
    return value


@lean_kernel
def decimal_ns(text: ByteArray, at: int, end: int, unit_ns: int) -> int:
    """A decimal number of units (10**9 for seconds, 10**6 for milliseconds) in ns; BAD where it is none.

    Digits finer than 1 ns are cut off; point and comma both separate.
    """
    negative = at < end and text[at] == 45
    if negative:
        at += 1
    whole = 0
    digits = 0
    while at < end and 48 <= text[at] <= 57:
        whole = whole * 10 + (text[at] - 48)
        digits += 1
        at += 1
        if whole > 9_000_000_000_000_000_000 // unit_ns or digits > 19:
            return BAD
    value = whole * unit_ns
    if at < end and (text[at] == 46 or text[at] == 44):
        at += 1
        part = unit_ns
        while at < end and 48 <= text[at] <= 57:
            part //= 10
            value += (text[at] - 48) * part
            digits += 1
            at += 1
    if at != end or digits == 0:
        return BAD
    return -value if negative else value


@lean_kernel
def same_word(text: ByteArray, at: int, end: int, word: ByteArray) -> bool:
    """Whether [at, end) is `word` (given in lower case), whatever the case."""
    if end - at != word.size:
        return False
    for i in range(word.size):
        byte = text[at + i]
        if 65 <= byte <= 90:
            byte += 32
        if byte != word[i]:
            return False
    return True


@lean_kernel
def read_bytes(text: ByteArray, at: int, end: int, base: int, count: int, data: ByteArray, into: int) -> int:
    """Read `count` bytes written as words into data[into:]; where the last word ends, or BAD.

    In base 16 each word has two digits, in base 10 one to three.
    """
    if count < 0 or into + count > data.size:
        return BAD
    for k in range(count):
        at = skip_space(text, at, end)
        stop = token_end(text, at, end)
        if base == 16 and stop - at != 2:
            return BAD
        value = whole_number(text, at, stop, base)
        if value < 0 or value > 255:
            return BAD
        data[into + k] = value
        at = stop
    return at


@lean_kernel
def days_from_civil(year: int, month: int, day: int) -> int:
    """Days from 1970-01-01 to a date of the Gregorian calendar."""
    if month <= 2:
        year -= 1
        month += 12
    era_days = 365 * year + year // 4 - year // 100 + year // 400
    return era_days + (153 * (month - 3) + 2) // 5 + day - 1 - 719468
