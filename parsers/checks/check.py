"""All checks of signals against physics, in the order in which they build on each other."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from parsers.checks.grid import Grid, make_grid
from parsers.checks.offsets import offsets, stuck
from parsers.checks.signs import SignResult, lateral_signs, other_signs, rate_signs
from parsers.checks.spikes import calm, clean
from parsers.checks.unit_faults import unit_faults
from parsers.drive import Decision, Signal


@dataclass(frozen=True)
class Checked:
    """signals: as they are used from here on. unchecked: checks that had too little to go by, as sentences."""

    signals: dict[str, Signal]
    decisions: tuple[Decision, ...]
    unchecked: tuple[str, ...]


def check_signals(
    signals: Mapping[str, Signal], *, fix: bool, units_stated: Mapping[str, bool]
) -> tuple[dict[str, Signal], tuple[Decision, ...]]:
    """The signals and decisions of `check_all`."""
    checked = check_all(signals, fix=fix, units_stated=units_stated)
    return checked.signals, checked.decisions


def check_all(signals: Mapping[str, Signal], *, fix: bool, units_stated: Mapping[str, bool]) -> Checked:
    """Find wrong units, signs, impossible samples, offsets and stuck channels; repair what is beyond doubt.

    units_stated: signal -> whether the log, a profile or a map says its unit (absent: yes). With fix=False the
    signals come back untouched, and every decision has applied=False. Signals that lose all samples are left out.
    """
    work, decisions, missing = _run(signals, units_stated)
    if fix:
        return Checked(work, decisions, missing)
    left = tuple(replace(each, action=_undone(each), applied=False) for each in decisions)
    return Checked(dict(signals), left, missing)


def unchecked(signals: Mapping[str, Signal], units_stated: Mapping[str, bool]) -> tuple[str, ...]:
    """Which checks had too little motion to go by, as sentences."""
    return _run(signals, units_stated)[2]


def _undone(decision: Decision) -> str:
    return f"left as it is (--no-fix); would be: {decision.action}" if decision.applied else decision.action


def _run(
    signals: Mapping[str, Signal], stated: Mapping[str, bool]
) -> tuple[dict[str, Signal], tuple[Decision, ...], tuple[str, ...]]:
    work = {name: signal for name, signal in signals.items() if len(signal.values)}
    quiet = {name: calm(signal) for name, signal in work.items()}
    factors, decisions = unit_faults(work, make_grid(quiet), stated)
    work = _scaled(work, factors)
    for name, signal in list(work.items()):
        cleaned = clean(signal)
        decisions += cleaned.decisions
        if cleaned.signal is None:
            del work[name]
        else:
            work[name] = cleaned.signal
    work, grid, found, missing = _signs(work, make_grid(work))
    decisions += found
    idle = stuck(work, grid)
    decisions += idle
    for decision in idle:
        if decision.applied:
            del work[decision.signal]
    decisions += offsets(_without(grid, [each.signal for each in idle if each.applied]))
    guessed = [f"unit of {name}: the log does not say it" for name in work if not stated.get(name, True)]
    return work, tuple(decisions), (*missing, *guessed)


def _signs(work: dict[str, Signal], grid: Grid) -> tuple[dict[str, Signal], Grid, list[Decision], list[str]]:
    """Lateral signs first (they want to see which way accel_z points), then those that build on them."""
    decisions: list[Decision] = []
    missing: list[str] = []
    for step in (lateral_signs, other_signs, rate_signs):
        result: SignResult = step(grid)
        turned = result.inverted & set(work)
        work = _scaled(work, dict.fromkeys(turned, -1.0))
        columns = {name: -column if name in turned else column for name, column in grid.columns.items()}
        grid = Grid(grid.time_s, columns)
        decisions += result.decisions
        missing += result.unchecked
    return work, grid, decisions, missing


def _scaled(signals: Mapping[str, Signal], factors: Mapping[str, float]) -> dict[str, Signal]:
    return {
        name: replace(signal, values=signal.values * factors[name]) if name in factors else signal
        for name, signal in signals.items()
    }


def _without(grid: Grid, names: Iterable[str]) -> Grid:
    gone = set(names)
    return Grid(grid.time_s, {name: column for name, column in grid.columns.items() if name not in gone})
