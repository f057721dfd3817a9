"""Trends: parts of a vehicle that wear, a straight line in time each, told at a stated false-alarm rate."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from pipelines.hierarchy.drift import AXLES, Line, Slopes, line_of, slopes_of
from pipelines.hierarchy.posterior import VehiclePosterior
from pipelines.hierarchy.records import DriveTold, Trend
from pipelines.results import FloatArray

CHANCE = 0.01
"""False-alarm rate of a part: a trend as large by chance is less likely than this."""

FEWEST = 5
"""Drives from which on a trend is looked for: two make any line, and the scatter is to be seen as well."""

SHORTEST_DAYS = 30.0
"""Time from the first drive to the last from which on a trend is looked for."""

LARGEST = 0.15
"""Standard deviation of a slope, of the part's value a year, beyond which it cannot be told."""

HARDLY = 1.0
"""Standard deviation from which on more drives are no help: nothing in them sees the part."""

YEAR_S = 365.25 * 86400.0


@dataclass(frozen=True)
class _Part:
    """What is reported: a sum of unknowns. kind: whose scatter is found. sums: unknown -> factor in the part's unit."""

    parameter: str
    title: str
    unit: str
    kind: str
    sums: Callable[[Mapping[str, float]], dict[str, float]]


def _rate(axle: str) -> Callable[[Mapping[str, float]], dict[str, float]]:
    return lambda _: {f"spring_{axle}": 1.0}


def _damper(axle: str) -> Callable[[Mapping[str, float]], dict[str, float]]:
    return lambda _: {f"bump_{axle}": 0.5, f"rebound_{axle}": 0.5}


def _stiffness(values: Mapping[str, float]) -> dict[str, float]:
    found = {
        f"spring_{a}": 0.5 * (values.get(f"spring_base_{a}", 1.0) * values[f"track_{a}"]) ** 2 for a in AXLES
    }
    return found | {f"bar_{a}": 1.0 for a in AXLES}


def _damping(values: Mapping[str, float]) -> dict[str, float]:
    ways = ("bump", "rebound")
    return {
        f"{way}_{a}": 0.25 * (values.get(f"spring_base_{a}", 1.0) * values[f"track_{a}"]) ** 2
        for way in ways
        for a in AXLES
    }


PARTS = (
    _Part("damper_rate_front_nspm", "Dampers, front (a wheel)", "N·s/m", "dampers", _damper("front")),
    _Part("damper_rate_rear_nspm", "Dampers, rear (a wheel)", "N·s/m", "dampers", _damper("rear")),
    _Part("roll_damping_nmsprad", "Roll damping", "N·m·s/rad", "dampers", _damping),
    _Part("roll_stiffness_nmprad", "Roll stiffness", "N·m/rad", "springs", _stiffness),
    _Part("spring_rate_front_npm", "Springs, front (a wheel)", "N/m", "springs", _rate("front")),
    _Part("spring_rate_rear_npm", "Springs, rear (a wheel)", "N/m", "springs", _rate("rear")),
)
"""By parameter, as in the vehicle file."""


@dataclass(frozen=True)
class _Times:
    """The drives that count: rows of the posterior, years from their middle; first and last as written."""

    rows: tuple[int, ...]
    years: FloatArray
    first: str
    last: str


def _when(text: str | None) -> float | None:
    """Seconds since 1970, None where there is no time."""
    try:
        at = datetime.fromisoformat(text or "")
    except ValueError:
        return None
    return (at if at.tzinfo is not None else at.replace(tzinfo=UTC)).timestamp()


def _times(posterior: VehiclePosterior, drives: Sequence[DriveTold]) -> _Times:
    written = {drive.drive_id: drive.start_utc for drive in drives}
    found = []
    for row, drive_id in enumerate(posterior.drives):
        text = written.get(drive_id)
        seconds = _when(text)
        if seconds is not None and text is not None:
            found.append((seconds, row, text))
    found.sort()
    seconds_all = np.array([s for s, _, _ in found])
    years = (seconds_all - seconds_all.mean()) / YEAR_S if found else np.zeros(0)
    return _Times(
        tuple(row for _, row, _ in found), years, found[0][2] if found else "", found[-1][2] if found else ""
    )


def _short(times: _Times, drives: int) -> str:
    """Why no trend can be looked for; empty where it can."""
    dated = len(times.rows)
    if dated < FEWEST:
        undated = f", {drives - dated} more have no date" if drives > dated else ""
        count = "1 drive" if dated == 1 else f"{dated} drives"
        return f"cannot be told: {count} with a date{undated}; a trend needs {FEWEST}"
    days = float(np.ptp(times.years)) * YEAR_S / 86400.0
    if days < SHORTEST_DAYS:
        return f"cannot be told: the drives lie within {days:.0f} days; a trend needs {SHORTEST_DAYS:.0f}"
    return ""


def _untold(part: _Part, times: _Times, why: str) -> Trend:
    nothing = math.nan
    return Trend(
        part.parameter, part.title, part.unit, nothing, nothing, nothing, nothing, 1.0, False, times.first,
        times.last, len(times.rows), why,
    )  # fmt: skip


def _text(part: _Part, line: Line, whole: float, detected: bool, scatter: float) -> str:
    """The line in the part's unit, and roughly as a share: what the part has in all may be known less well than its change."""
    low, high = whole * line.low, whole * line.high
    slope = f"{whole * line.slope:+.0f} {part.unit} a year ({low:+.0f} to {high:+.0f})"
    share = f"about {100 * line.slope:+.0f} % of the {whole:.0f} that it seems to have"
    way = ("falls" if line.slope < 0 else "rises") if detected else "no trend is seen"
    # springs are known by what their deflections read: the two are one thing to most relations
    sensors = "; deflection sensors that drift or were replaced look the same" * (
        detected and part.kind == "springs"
    )
    return f"{way}: {slope}, {share}; a drive scatters by {100 * scatter:.1f} %{sensors}"


def _blind(line: Line | None) -> str:
    """Why the drives do not tell a slope."""
    if line is None or line.std > HARDLY:
        return "cannot be told: these drives' relations do not see this part change"
    return (
        f"cannot be told: these drives see a slope to ± {100 * line.std:.0f} % a year (standard deviation), and it is told "
        f"up to {100 * LARGEST:.0f} %; more drives, or drives over a longer time, tell it"
    )


def _trend(part: _Part, slopes: Slopes | None, values: Mapping[str, float], times: _Times) -> Trend:
    """One part's trend, its line in the part's unit."""
    sums = part.sums(values) if slopes is not None else {}
    if slopes is None or not set(sums) <= set(slopes.parts):
        return _untold(part, times, "cannot be told: the drives' relations do not have this part")
    sizes = np.array([sums.get(name, 0.0) for name in slopes.parts]) * slopes.base
    whole = float(sizes.sum())
    line = line_of(slopes, sizes / whole)
    if line is None or line.std > LARGEST:
        return _untold(part, times, _blind(line))
    detected = line.probability < CHANCE
    scatter = float(slopes.weight @ slopes.scatter)
    return Trend(
        part.parameter, part.title, part.unit, whole * line.slope, whole * line.std, whole * line.low,
        whole * line.high, line.probability, detected, times.first, times.last, len(times.rows),
        _text(part, line, whole, detected, scatter),
    )  # fmt: skip


def trends(posterior: VehiclePosterior, drives: Sequence[DriveTold]) -> tuple[Trend, ...]:
    """Every part of `PARTS`, told or not and why not. drives: of one vehicle; those without a date do not count.

    Figures of what cannot be told are NaN, its probability 1. The order of the drives does not matter.
    """
    times = _times(posterior, drives)
    why = _short(times, len(posterior.drives))
    if why:
        return tuple(_untold(part, times, why) for part in PARTS)
    first = times.rows[0]
    values = dict(zip(posterior.parts[first].names, posterior.mean(first).tolist(), strict=True))
    found = slopes_of(posterior, times.rows, times.years)
    return tuple(_trend(part, found.get(part.kind), values, times) for part in PARTS)
