"""Signals of one drive that share no time: logs, buses or topics whose clocks count from different moments."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

from parsers.pieces import Span
from parsers.timebase import NS

_MOST_SETS = 4
_MOST_NAMES = 6


def apart_notes(spans: Mapping[str, Span]) -> list[str]:
    """A note where the signals fall into sets that share no time; none where their times hang together.

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
        return []
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


def _named(names: list[str]) -> str:
    return ", ".join(sorted(names)[:_MOST_NAMES]) + (", …" if len(names) > _MOST_NAMES else "")
