"""Time stamps of a batch of records: by a compiled kernel where the time is one word and a straight line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel, load_u64
from parsers.mf4.batch import Batch
from parsers.mf4.clock import LATEST_NS, NO_TIME, find_rule, times_ns
from parsers.mf4.model import MASTER, Channel, Group
from parsers.mf4.values import FLOAT_LE, INT_LE
from parsers.mf4.words import NUMBERS, word_of

AT, SHIFT, MASK, KIND, FACTOR, OFFSET, SIGNED, SPARE, START, RULES = range(10)
"""AT, SHIFT, MASK: see `parsers.mf4.words`. KIND: one of the three below. FACTOR, OFFSET: in ns, of COUNTS. SIGNED, SPARE:
whole numbers have a sign, and so many bits of a word are not theirs. START: ns added to each stamp."""
FLOAT_SECONDS, COUNTS, WHOLE_SECONDS = range(3)
EPOCH_NS = 631_152_000_000_000_000
"""1990 in ns since 1970: a master from there on is no time since the file's start but a date already."""


@kernel
def seconds_ns(seconds: float) -> int:
    """Whole nanoseconds of seconds (the nearest, of two the even one), NO_TIME where they are beyond reach or NaN."""
    if not abs(seconds) * 1e9 < LATEST_NS:
        return NO_TIME
    # whole seconds first: an absolute stamp does not keep its ns in one product
    whole = np.int64(seconds)
    if seconds < whole:
        whole -= 1
    # numbers of this size have no place for fractions: the sum is rounded, half to even
    part = ((seconds - whole) * 1e9 + 4503599627370496.0) - 4503599627370496.0
    return int(whole * 1_000_000_000 + np.int64(part))


@kernel
def read_stamps(
    data: ByteArray, stride: int, begin: int, rules: IntArray, linear: FloatArray, time_ns: IntArray
) -> int:
    """Fill in the stamps; returns how many are NO_TIME. rules: see above. linear: factor and offset in s.

    data: contiguous, one record every `stride` bytes from `begin` on, as many as time_ns is long. No load is checked: the
    word lies within its record.
    """
    at, kind, factor, offset = begin + rules[AT], rules[KIND], rules[FACTOR], rules[OFFSET]
    shift, mask = np.uint64(rules[SHIFT]), np.uint64(rules[MASK])
    signed, spare, start = rules[SIGNED] != 0, rules[SPARE], rules[START]
    seconds = time_ns.view(np.float64)
    bad = 0
    # the bits first, so that they can be looked at as floats
    for i in range(time_ns.shape[0]):
        time_ns[i] = np.int64((load_u64(data, i * stride + at) >> shift) & mask)
    for i in range(time_ns.shape[0]):
        if kind == FLOAT_SECONDS:
            stamp = seconds_ns(seconds[i] * linear[0] + linear[1])
        else:
            value = time_ns[i]
            size = float(np.uint64(value))
            if signed:
                value = (value << spare) >> spare
                size = float(value)
            if kind == WHOLE_SECONDS:
                stamp = seconds_ns(size * linear[0] + linear[1])
            elif abs(size) * factor < LATEST_NS:
                stamp = value * factor + offset
            else:
                stamp = NO_TIME
        known = stamp != NO_TIME
        bad += not known
        time_ns[i] = stamp + (start if known and stamp < EPOCH_NS else 0)
    return bad


@dataclass(frozen=True)
class StampReader:
    """Reads the stamps of a group's records. rules, linear: None where the kernel cannot. zero_ns: the stamp of a record of zeros, None
    where the stamps are not in the records. number: of the group. dates: see `Measurement`; None where nobody asks."""

    master: Channel
    start_ns: int
    rules: IntArray | None
    linear: FloatArray
    zero_ns: int | None = None
    number: int = 0
    dates: dict[int, bool] | None = None

    def read(self, batch: Batch, room: IntArray | None = None) -> tuple[IntArray, int]:
        """Stamps with the start added where they are no dates, NO_TIME where there is none, and how many those are.

        room: for as many stamps at least, where they may be put; the caller's memory.
        """
        if self.dates is not None and batch.count and not self.dates.get(self.number):
            # one stamp a batch tells: a group's first record may be blank
            first = times_ns(batch.rows[:1], self.master, batch.first)
            self.dates[self.number] = bool(first[0] >= EPOCH_NS)
        if self.rules is not None:
            out = np.empty(batch.count, np.int64) if room is None else room[: batch.count]
            bad = read_stamps(batch.data, batch.stride, batch.skip, self.rules, self.linear, out)
            return out, int(bad)
        time_ns = times_ns(batch.rows, self.master, batch.first)
        known = time_ns != NO_TIME
        start_ns = np.where(known & (time_ns < EPOCH_NS), self.start_ns, 0)
        return np.where(known, time_ns + start_ns, NO_TIME), int(np.sum(~known))


def stamp_reader(
    master: Channel,
    group: Group,
    start_ns: int,
    dates: dict[int, bool] | None = None,
    *,
    compiled: bool = True,
) -> StampReader:
    """The reader of a group's stamps. dates: see `StampReader`. compiled: False to take the slower way anyway."""
    word, rule = word_of(master, group, *NUMBERS), find_rule(master)
    linear = np.array([1.0, 0.0])
    single = word is not None and word.kind == FLOAT_LE and word.bits != 64
    zero_ns = _zero_ns(master, start_ns)
    if word is None or rule is None or single or not compiled:
        return StampReader(master, start_ns, None, linear, zero_ns, group.number, dates)
    linear[:] = rule.factor, rule.offset
    rules = np.zeros(RULES, np.int64)
    rules[AT], rules[SHIFT], rules[MASK], rules[START] = word.at, word.shift, word.mask, start_ns
    rules[SIGNED], rules[SPARE] = word.kind == INT_LE, 64 - word.bits
    rules[KIND] = FLOAT_SECONDS if word.kind == FLOAT_LE else WHOLE_SECONDS
    if rule.exact is not None and word.kind != FLOAT_LE:
        rules[KIND], rules[FACTOR], rules[OFFSET] = COUNTS, *rule.exact
    return StampReader(master, start_ns, rules, linear, zero_ns, group.number, dates)


def _zero_ns(master: Channel, start_ns: int) -> int | None:
    if master.kind != MASTER:
        return None
    record = np.zeros((1, master.byte_offset + master.byte_count + 8), np.uint8)
    stamp = int(times_ns(record, master, 0)[0])
    return None if stamp == NO_TIME else stamp + start_ns
