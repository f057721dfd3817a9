"""Signals of one drive that share no time (their clocks count from different moments), or are there for a part of it only."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

from parsers.pieces import Span
from parsers.timebase import NS

_MOST_SETS = 4
_MOST_NAMES = 6
_MUCH_S, _MUCH = 10.0, 0.1
"""A signal that lacks so many seconds, and that share of the drive, at one of its ends is said to."""


def apart_notes(spans: Mapping[str, Span]) -> list[str]:
    """A note where the signals fall into sets that share no time, else where some are there for a part of the drive.

    spans: signal -> first and last stamp. Whatever two signals tell together (a sign, a unit, every parameter) cannot be
    told across such sets, and nothing else in a record shows it.
    """
    sets: list[tuple[int, int, list[str]]] = []
    for name, (first, last) in sorted(spans.items(), key=lambda item: (item[1], item[0])):
        if sets and first <= sets[-1][1]:
            begin, end, names = sets[-1]
            sets[-1] = begin, max(end, last), [*names, name]
        else:
            sets.append((first, last, [name]))
    if len(sets) < 2:
        return _in_part(spans)
    zero = sets[0][0]
    said = [_named(sets[0][2]) + f" end at {(sets[0][1] - zero) / NS:.1f} s"]
    for (_, end, _), (begin, _, names) in pairwise(sets[:_MOST_SETS]):
        said.append(
            f"{_named(names)} begin at {(begin - zero) / NS:.1f} s, {(begin - end) / NS:.1f} s after that"
        )
    more = f" (and {len(sets) - _MOST_SETS} sets more)" if len(sets) > _MOST_SETS else ""
    return [
        f"signals that share no time: {'; '.join(said)}{more}; do their clocks count from different moments? "
        "Nothing that needs both can be told"
    ]


def _in_part(spans: Mapping[str, Span]) -> list[str]:
    """A note on signals that begin long after the drive, or end long before it: sensors that fell out, recorders started late."""
    zero, end = min((a for a, _ in spans.values()), default=0), max((b for _, b in spans.values()), default=0)
    much = max(_MUCH_S * NS, _MUCH * (end - zero))
    # messages of one sensor stop within a few of their steps
    missing: dict[tuple[str, int], list[str]] = {}
    for name, (first, last) in spans.items():
        if first - zero > much:
            missing.setdefault((f"begin at {(first - zero) / NS:.0f} s", 0), []).append(name)
        if end - last > much:
            missing.setdefault((f"end at {(last - zero) / NS:.0f} s", 1), []).append(name)
    if not missing:
        return []
    each = sorted(missing.items(), key=lambda item: (item[0][1], item[0][0]))
    said = [f"{_named(names)} {what}" for (what, _), names in each[:_MOST_SETS]]
    more = f" (and {len(each) - _MOST_SETS} more)" if len(each) > _MOST_SETS else ""
    return [
        f"signals that are there for a part of the {(end - zero) / NS:.0f} s only: {'; '.join(said)}{more}"
    ]


def _named(names: list[str]) -> str:
    return ", ".join(sorted(names)[:_MOST_NAMES]) + (", …" if len(names) > _MOST_NAMES else "")
