"""Time stamps of a group's records in whole nanoseconds, and the channel that they come from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.mf4.conversions import IDENTITY, LINEAR, convert
from parsers.mf4.conversions import fault as rule_fault
from parsers.mf4.model import MASTER, VIRTUAL_MASTER, Channel, Group
from parsers.mf4.values import FLOAT_LE, UINT_LE, fault, raw_values

_NS = 1e9
LATEST_NS = 1 << 61
NO_TIME = -(1 << 62)
"""Stamp of a record whose time is no number, or beyond 73 years from the start."""


def find_master(group: Group) -> Channel | None:
    """The channel with a group's time, None where it has none that can be read."""
    for channel in group.channels:
        timed = channel.sync == 1 or (channel.sync == 0 and channel.unit in ("", "s"))
        if channel.kind in (MASTER, VIRTUAL_MASTER) and timed:
            usable = fault(channel, group) is None and rule_fault(channel.conversion) is None
            return channel if usable else None
    return None


def _exact(channel: Channel) -> tuple[int, int] | None:
    """(factor, offset) in ns where both are whole: then no float rounds the stamp."""
    rule = channel.conversion
    if rule is None or rule.kind != LINEAR:
        return None
    offset, factor = rule.values[:2].tolist()
    # a comparison with NaN is false: damaged numbers go the slow way and make no stamp
    if not (abs(factor * _NS) < LATEST_NS and abs(offset * _NS) < LATEST_NS):
        return None
    ns, shift = round(factor * _NS), round(offset * _NS)
    whole = ns >= 1 and abs(factor * _NS - ns) <= 1e-9 * ns and abs(offset * _NS - shift) <= 1e-6
    return (ns, shift) if whole else None


@dataclass(frozen=True)
class TimeRule:
    """Seconds are factor * raw + offset. exact: the same in whole ns, for raw stamps that are whole numbers."""

    factor: float
    offset: float
    exact: tuple[int, int] | None


def find_rule(channel: Channel) -> TimeRule | None:
    """How a time channel's raw values become seconds, None where they do so in no straight line."""
    rule = channel.conversion
    if rule is None or rule.kind == IDENTITY:
        return TimeRule(1.0, 0.0, None)
    if rule.kind != LINEAR:
        return None
    return TimeRule(float(rule.values[1]), float(rule.values[0]), _exact(channel))


def ns_per_count(channel: Channel) -> int | None:
    """Nanoseconds of one count where the stamp is a plain little-endian counter from byte to byte, else None."""
    plain = channel.kind == MASTER and channel.data_type == UINT_LE and channel.bit_offset == 0
    exact = _exact(channel) if plain and channel.bit_count % 8 == 0 else None
    return exact[0] if exact is not None else None


def is_double(channel: Channel) -> bool:
    """Whether the stamp is a float of eight bytes that grows with the time: then its bits, as a whole number, do too."""
    rule = find_rule(channel)
    plain = channel.kind == MASTER and channel.data_type == FLOAT_LE and channel.bit_count == 64
    return plain and rule is not None and rule.factor > 0


def times_ns(rows: ByteArray, channel: Channel, first: int) -> IntArray:
    """Stamps relative to the file's start, shape (n,). NO_TIME where there is none."""
    raw = raw_values(rows, channel, first)
    exact = _exact(channel)
    if exact is not None and raw.dtype.kind in "ui":
        factor, shift = exact
        fits = np.abs(raw.astype(np.float64)) * factor < LATEST_NS
        return np.where(fits, np.where(fits, raw, 0).astype(np.int64) * factor + shift, NO_TIME)
    rule = channel.conversion
    seconds: FloatArray = raw.astype(np.float64)
    with np.errstate(over="ignore", invalid="ignore"):
        if rule is not None and rule.kind != IDENTITY:
            seconds = convert(rule, seconds, whole_numbers=raw.dtype.kind != "f")
        fits = np.abs(seconds) * _NS < LATEST_NS
    # whole seconds first: an absolute stamp in s does not keep its ns in one product
    whole = np.floor(np.where(fits, seconds, 0.0))
    part = np.rint((np.where(fits, seconds, 0.0) - whole) * _NS)
    return np.where(fits, whole.astype(np.int64) * 1_000_000_000 + part.astype(np.int64), NO_TIME)
