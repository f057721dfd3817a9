"""Copies: a file manager's, and one recording in several formats. They are named and left out, lest a drive counts twice."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from pipelines.fleet.clocks import NS
from pipelines.fleet.likeness import Likeness, likeness
from pipelines.fleet.logs import Log
from pipelines.fleet.names import copied_from
from pipelines.fleet.together import (
    Facts,
    Grouped,
    Moments,
)

_BEST_FIRST = ("mf4", "blf", "mcap", "rosbag1", "rosbag2", "parquet", "vbo", "candump", "trc", "asc", "csv")


def without_copies(logs: Sequence[Log], out: Grouped) -> list[Log]:
    """Leave out what a file manager's name calls a copy and whose bytes are those of the original."""
    by_name = {(log.stem.casefold(), log.size, log.digest): log for log in logs if log.size and log.digest}
    kept = []
    for log in logs:
        of = copied_from(log.stem)
        original = by_name.get((of.casefold(), log.size, log.digest)) if of else None
        found = Likeness.NONE if original is None or original is log else likeness(original, log)
        if original is not None and found in (Likeness.SAME, Likeness.ENDS):
            out.left_out.append((log.place, f"a copy of {original.name}: {found.value.removesuffix(' as')}"))
        else:
            kept.append(log)
    return kept


def without_formats(logs: Sequence[Log], facts: Facts, out: Grouped) -> list[Log]:
    """Leave out recordings that another of the same name is in another format; the one that is kept gets a note of each."""
    rows: dict[str, list[Log]] = defaultdict(list)
    for log in logs:
        rows[log.stem.casefold()].append(log)
    kept: list[Log] = []
    for row in rows.values():
        if len({log.format for log in row}) < 2:
            kept += row
            continue
        found: list[Log] = []
        for log in sorted(row, key=lambda each: _rank(each, facts)):
            other = next((each for each in found if _is_copy(log, each, facts)), None)
            if other is None:
                found.append(log)
                continue
            why = f"the same recording as {other.name} in another format: same length, same content"
            out.left_out.append((log.place, why))
            note = f"{log.name} is the same recording in another format: not counted again"
            out.notes[other.place] = (*out.notes.get(other.place, ()), note)
        kept += found
    return kept


def _rank(log: Log, facts: Facts) -> tuple[bool, int, int, str]:
    """The best first: a clock since 1970, the most signals, the format that keeps most."""
    clock, content = facts.clock(log), facts.content(log)
    order = _BEST_FIRST.index(log.format) if log.format in _BEST_FIRST else len(_BEST_FIRST)
    return clock is None or not clock.absolute, -len(content or ()), order, log.name


def _is_copy(log: Log, other: Log, facts: Facts) -> bool:
    """Whether one recording is the other in another format: equally long, and its signals (all in the other) alike."""
    first, second = facts.clock(log), facts.clock(other)
    if first is None or second is None or log.format == other.format:
        return False
    longest = max(first.duration_ns, second.duration_ns)
    if abs(first.duration_ns - second.duration_ns) > max(longest // 500, NS // 20):
        return False
    if first.absolute and second.absolute and abs(first.first_ns - second.first_ns) > 2 * NS:
        return False
    one, two = facts.content(log), facts.content(other)
    if not one or not two or not (one.keys() <= two.keys()):
        return False
    return all(_alike(one[name], two[name]) for name in one)


def _alike(a: Moments, b: Moments) -> bool:
    """Whether two sets of samples are of one signal: rounding of a format moves them by less than this."""
    spread = max(a.std, b.std)
    size = max(abs(a.mean), abs(b.mean), spread)
    return (
        abs(a.mean - b.mean) <= 0.02 * spread + 1e-3 * size
        and abs(a.std - b.std) <= 0.05 * spread + 1e-3 * size
    )
