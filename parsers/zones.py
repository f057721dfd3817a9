"""Logs side by side of which one does not say its time zone: whole quarters of an hour that bring them together, where a signal of both proves it.

A CAN logger writes the local time, a satellite receiver beside it UTC. Taken for UTC, the first lies hours beside the second.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.checks.far_lags import at_far_lags
from parsers.opened_log import OpenedLog
from parsers.pieces import OVERLAP_NS, Piece, Span, overlap_ns
from parsers.timebase import NS

STEP_NS, MOST_STEPS = 900 * NS, 56
"""Time zones differ from UTC by quarters of an hour, up to 14 hours."""

TELLING = ("speed", "gps_speed_2d", "wheel_speed_rl", "wheel_speed_fl", "yaw_rate", "accel_y", "accel_x")
"""Signals of which one drive is told from another: a receiver's speed is that of the wheels."""
_SPEEDS = TELLING[:4]

ALIKE, ELSEWHERE = 0.9, 0.15
"""Least correlation at the right shift, and by how much it must be above that at any other."""

WINDOW_NS, CELL_NS = 1200 * NS, NS // 10
FEWEST = 300
"""Cells of the window: half a minute."""


def zone_shifts(
    logs: Sequence[OpenedLog], held: Sequence[Mapping[str, Piece]], used: Sequence[int]
) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """What is added to each log's stamps, and sentences. held: signal -> piece of each log; used: those that have any, all of which count from 1970."""
    shifts, notes = [0] * len(logs), list[str]()
    sure = [number for number in used if logs[number].log.zone_known]
    beside = [held[number] for number in sure]
    for number in used:
        if number in sure or not sure:
            continue
        found = _shift(held[number], beside)
        if found is None:
            continue
        by, likeness, names = found
        shifts[number] = by
        hours = -by / (4 * STEP_NS)
        notes.append(
            f"the stamps of {logs[number].path.name} are local time, {abs(hours):g} h {'ahead of' if hours > 0 else 'behind'} UTC: laid by as much beside "
            f"{' and '.join(logs[each].path.name for each in sure)}, as its {names[0]} and their {names[1]} are one motion there (correlation {likeness:.2f})"
        )
    return tuple(shifts), tuple(notes)


def _span(pieces: Sequence[Mapping[str, Piece]]) -> Span:
    spans = [piece.span for each in pieces for piece in each.values()]
    return min(first for first, _ in spans), max(last for _, last in spans)


def _shift(
    own: Mapping[str, Piece], beside: Sequence[Mapping[str, Piece]]
) -> tuple[int, float, tuple[str, str]] | None:
    """Nanoseconds to add, the likeness there, and of which two signals; None where the logs overlap as they are, or nothing proves a shift."""
    mine, others = _span([own]), _span(beside)
    if overlap_ns(mine, others) > OVERLAP_NS:
        return None
    shorter = min(mine[1] - mine[0], others[1] - others[0])
    found: list[tuple[float, int, tuple[str, str]]] = []
    for step in range(-MOST_STEPS, MOST_STEPS + 1):
        by = step * STEP_NS
        moved = mine[0] + by, mine[1] + by
        if min(moved[1], others[1]) - max(moved[0], others[0]) > shorter // 2:
            best = max((_likeness(own, each, by) for each in beside), default=(0.0, ("", "")))
            found.append((best[0], by, best[1]))
    if not found:
        return None
    found.sort(reverse=True)
    likeness, by, names = found[0]
    if likeness < ALIKE or (len(found) > 1 and found[1][0] > likeness - ELSEWHERE):
        return None
    return by, likeness, names


def _likeness(own: Mapping[str, Piece], other: Mapping[str, Piece], by: int) -> tuple[float, tuple[str, str]]:
    """The best correlation of a signal of one log, so many nanoseconds later, with one of the other; the names of both."""
    best: tuple[float, tuple[str, str]] = (0.0, ("", ""))
    for name in (each for each in TELLING if each in own):
        alike = _SPEEDS if name in _SPEEDS else (name,)
        partner = next((each for each in alike if each in other), None)
        if partner is None:
            continue
        first, second = own[name], other[partner]
        start = max(first.span[0] + by, second.span[0])
        stop = min(first.span[1] + by, second.span[1], start + WINDOW_NS)
        cells = np.arange(start, stop, CELL_NS)
        if len(cells) < FEWEST:
            continue
        columns = _on(first, cells - by), _on(second, cells)
        found = at_far_lags(*columns)
        if found is not None and float(found.max()) > best[0]:
            best = float(found.max()), (name, partner)
    return best


def _on(piece: Piece, cells: IntArray) -> FloatArray:
    """A piece's values at stamps (n,)."""
    time_ns, values = piece.load(int(cells[0]), int(cells[-1]) + 1)
    if len(time_ns) < 2:
        return np.zeros(len(cells))
    return np.asarray(
        np.interp((cells - cells[0]).astype(np.float64), (time_ns - cells[0]).astype(np.float64), values)
    )
