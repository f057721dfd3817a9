"""Physical values of a signal out of many payloads at once.

Payloads come as words of eight bytes (`parsers.can.keep`): most fields are two shifts of one word.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from parsers.can.definitions import BitField, SignalDef
from parsers.can.slots import LengthArray
from parsers.channels import FloatArray, IntArray
from parsers.jit import kernel

WordArray = NDArray[np.uint64]
LONGEST = (1 << 16) - 1
"""More than any payload has."""
# places in the kernel's tally
NOT_AVAILABLE, ERROR, RESERVED, INVALID = range(4)


@dataclass(frozen=True)
class Payloads:
    """n payloads of one message. time_ns: (n,) int64. length: (n,) uint16, bytes in the log. words: (n, w) uint64, first byte
    lowest; bytes beyond a payload's length are of no meaning. shortest: least of length. flat: words of which these are some
    that lie together, from the `first` on; first is -1 where they lie elsewhere."""

    time_ns: IntArray
    length: LengthArray
    words: WordArray
    shortest: int
    flat: WordArray = field(default_factory=lambda: np.empty(0, np.uint64))
    first: int = -1

    def rows(self, which: IntArray | slice) -> Payloads:
        """Some of the payloads, in this order."""
        length = self.length[which]
        return Payloads(self.time_ns[which], length, self.words[which], int(length.min(initial=LONGEST)))


@dataclass(frozen=True)
class Place:
    """Where a field lies in the words of a payload. last: its last byte. swap: words are turned round first.

    A field in one word: word << left, then >> 64 - bits. In two words: first << left | second >> right where swapped, else
    second << left | first >> right, then >> 64 - bits. second: -1 where there is none.
    """

    first: int
    second: int
    left: int
    right: int
    bits: int
    swap: bool
    last: int

    @classmethod
    def of(cls, field: BitField) -> Place:
        """The place of a database's field."""
        # big endian: counted from the highest bit of the first byte
        begin = field.start if field.little else 8 * (field.start >> 3) + 7 - (field.start & 7)
        word, within, last = begin >> 6, begin & 63, (begin + field.length - 1) >> 3
        if within + field.length <= 64:
            left = 64 - within - field.length if field.little else within
            return cls(word, -1, left, 0, field.length, not field.little, last)
        if field.little:
            over = within + field.length - 64
            return cls(word, word + 1, 64 - over, over, field.length, False, last)
        return cls(word, word + 1, within, 64 - within, field.length, True, last)


@kernel
def _turned(word: np.uint64) -> np.uint64:
    """The bytes of a word the other way round."""
    low = np.uint64(0x00FF00FF00FF00FF)
    word = ((word >> np.uint64(8)) & low) | ((word & low) << np.uint64(8))
    low = np.uint64(0x0000FFFF0000FFFF)
    word = ((word >> np.uint64(16)) & low) | ((word & low) << np.uint64(16))
    return (word >> np.uint64(32)) | (word << np.uint64(32))


@kernel
def _top(words: WordArray, i: int, first: int, second: int, left: int, right: int, swap: bool) -> np.uint64:
    """A field of payload i, moved to the top of a word; what is below it belongs to others."""
    word = np.uint64(words[i, first])
    if swap:
        word = _turned(word)
    if second < 0:
        return np.uint64(word << np.uint64(left))
    other = np.uint64(words[i, second])
    if swap:
        return np.uint64((word << np.uint64(left)) | (_turned(other) >> np.uint64(right)))
    return np.uint64((other << np.uint64(left)) | (word >> np.uint64(right)))


@kernel
def plain(
    words: WordArray,
    first: int,
    step: int,
    left: int,
    bits: int,
    swap: bool,
    signed: bool,
    scale: float,
    offset: float,
    out: FloatArray,
    into: int,
    rows: int,
) -> None:
    """Fields in one word, without anything to look out for: each case its own short loop. Unsigned: below 64 bits.

    words: (m,), the first payload's at `first`, the next one's `step` further on. out: (k,), filled from `into` on. Unchecked.
    """
    up, down = np.uint64(left), np.uint64(64 - bits)
    if signed and swap:
        for i in range(rows):
            raw = np.int64(_turned(words[first + i * step]) << up) >> np.int64(down)
            out[into + i] = np.float64(raw) * scale + offset
    elif signed:
        for i in range(rows):
            raw = np.int64(words[first + i * step] << up) >> np.int64(down)
            out[into + i] = np.float64(raw) * scale + offset
    elif swap:
        for i in range(rows):
            raw = np.int64((_turned(words[first + i * step]) << up) >> down)
            out[into + i] = np.float64(raw) * scale + offset
    else:
        for i in range(rows):
            raw = np.int64((words[first + i * step] << up) >> down)
            out[into + i] = np.float64(raw) * scale + offset


def codes_of(signal: SignalDef, *, j1939: bool, proprietary: bool) -> list[tuple[int, int]]:
    """The codes of J1939 that are looked for in a signal; see `decode_signal`."""
    told = j1939 and not signal.signed and not signal.is_float
    return j1939_codes(signal.field.length, proprietary) if told else []


def plain_at_best(signal: SignalDef, place: Place, *, codes: bool = False) -> bool:
    """Whether a signal is a field in one word, without anything to look out for but the payloads' length. codes: of J1939."""
    odd = codes or signal.invalid or signal.is_float or place.second >= 0 or place.bits == 64
    return not odd


def is_plain(payloads: Payloads, signal: SignalDef, place: Place, *, codes: bool = False) -> bool:
    """Whether it is so in every one of these payloads."""
    return plain_at_best(signal, place, codes=codes) and payloads.shortest > place.last


@kernel
def _raw(
    words: WordArray, length: LengthArray, first: int, second: int, left: int, right: int, bits: int, swap: bool, last: int,
    raw: WordArray,
) -> None:  # fmt: skip
    """Raw values, unsigned; 0 where the payload is too short."""
    down = np.uint64(64 - bits)
    for i in range(raw.size):
        raw[i] = np.uint64(0)
        if np.int64(length[i]) > last:
            raw[i] = _top(words, i, first, second, left, right, swap) >> down


@kernel
def _special(raw: np.uint64, codes: WordArray, invalid: WordArray, tally: IntArray) -> bool:
    """Whether a raw value stands for something else than a quantity; counts for what."""
    for k in range(codes.size):
        # ranges that follow each other downwards from the highest value
        if raw >= codes[k]:
            tally[k] += 1
            return True
    if invalid.size:
        at = np.searchsorted(invalid, raw)
        if at < invalid.size and invalid[at] == raw:
            tally[3] += 1
            return True
    return False


@kernel
def _careful(
    raw: WordArray, length: LengthArray, last: int, bits: int, signed: bool, scale: float, offset: float, codes: WordArray,
    invalid: WordArray, tally: IntArray, out: FloatArray,
) -> None:  # fmt: skip
    """Physical values of raw ones, NaN where there is none."""
    up = np.uint64(64 - bits)
    for i in range(raw.size):
        if np.int64(length[i]) <= last or _special(raw[i], codes, invalid, tally):
            out[i] = np.nan
        elif signed:
            out[i] = np.float64(np.int64(raw[i] << up) >> np.int64(up)) * scale + offset
        else:
            out[i] = np.float64(raw[i]) * scale + offset


def raw_values(payloads: Payloads, field: BitField) -> WordArray:
    """A field's raw value in each payload: (n,) uint64, unsigned; 0 where the payload is too short."""
    place = Place.of(field)
    raw = np.zeros(payloads.length.size, np.uint64)
    if place.last < 8 * payloads.words.shape[1]:
        _raw(
            payloads.words, payloads.length, place.first, place.second, place.left, place.right, place.bits, place.swap,
            place.last, raw,
        )  # fmt: skip
    return raw


def short(payloads: Payloads, fields: list[BitField]) -> NDArray[np.bool_]:
    """(n,) bool: which payloads are too short for one of the fields."""
    return payloads.length <= last_byte(fields)


def last_byte(fields: list[BitField]) -> int:
    """The last byte that any of the fields reaches; -1 without fields."""
    return max((Place.of(field).last for field in fields), default=-1)


@dataclass(frozen=True)
class Decoded:
    """One signal in n payloads: physical values, NaN where there is none, and how often for which reason.

    not_available, errors, reserved: counts of J1939 codes. invalid: count of codes that the database's value table calls
    invalid. Payloads that are too short are not counted: see `short`.
    """

    values: FloatArray
    not_available: int = 0
    errors: int = 0
    reserved: int = 0
    invalid: int = 0


def decode_signal(
    payloads: Payloads,
    signal: SignalDef,
    into: FloatArray | None = None,
    *,
    j1939: bool = False,
    proprietary: bool = False,
) -> Decoded:
    """A signal's physical values in the given payloads, written into `into`, (n,), where given.

    j1939: look for the codes "not available", "error" and "reserved"; proprietary: only for "not available", since
    the maker of such a message may use the other codes as values.
    """
    place = Place.of(signal.field)
    values = np.empty(payloads.length.size) if into is None else into
    if place.last >= 8 * payloads.words.shape[1]:
        # beyond the longest payload
        values.fill(np.nan)
        return Decoded(values)
    codes = codes_of(signal, j1939=j1939, proprietary=proprietary)
    if is_plain(payloads, signal, place, codes=bool(codes)):
        words = np.ascontiguousarray(payloads.words)
        plain(
            words.reshape(-1), place.first, words.shape[1], place.left, place.bits, place.swap, signal.signed,
            signal.scale, signal.offset, values, 0, values.size,
        )  # fmt: skip
        return Decoded(values)
    raw = raw_values(payloads, signal.field)
    if signal.is_float:
        _floats(raw, signal, values)
        values[payloads.length <= place.last] = np.nan
        return Decoded(values)
    tally = np.zeros(4, np.int64)
    _careful(
        raw, payloads.length, place.last, place.bits, signal.signed, signal.scale, signal.offset,
        np.array([low for low, _ in codes], np.uint64), np.array(signal.invalid, np.uint64), tally, values,
    )  # fmt: skip
    counts = tally.tolist()
    return Decoded(values, counts[NOT_AVAILABLE], counts[ERROR], counts[RESERVED], counts[INVALID])


def _floats(raw: WordArray, signal: SignalDef, values: FloatArray) -> None:
    """Physical values of a float signal, into `values`."""
    kinds = {16: (np.uint16, np.float16), 32: (np.uint32, np.float32), 64: (np.uint64, np.float64)}
    whole, fraction = kinds[signal.field.length]
    with np.errstate(over="ignore", invalid="ignore"):
        values[:] = raw.astype(whole).view(fraction)
        values *= signal.scale
        values += signal.offset


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
