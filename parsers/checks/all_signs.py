"""All signs, step by step: the speed's and the springs' own, then lateral ones (which look at it and at accel_z's), then those that build on them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from parsers.checks.along_signs import DOUBTED, along_signs
from parsers.checks.grid import Grid
from parsers.checks.rate_signs import rate_signs
from parsers.checks.signs import SignResult, lateral_signs, springs_signs, turned_along
from parsers.checks.speed_signs import speed_signs
from parsers.checks.springs import exchanged_decision
from parsers.drive import Decision


@dataclass(frozen=True)
class AllSigns:
    """inverted: signals whose sign is wrong; exchanged: with each other, so that none of them can be used; grid: as it then is, without
    the exchanged ones; unchecked: checks that had too little to go by, as sentences."""

    inverted: frozenset[str]
    exchanged: frozenset[str]
    grid: Grid
    decisions: tuple[Decision, ...]
    unchecked: tuple[str, ...]


def all_signs(grid: Grid) -> AllSigns:
    """Judge every signal's sign by itself."""
    inverted: frozenset[str] = frozenset()
    exchanged: frozenset[str] = frozenset()
    decisions: list[Decision] = []
    unchecked: list[str] = []
    axes_turned = False
    steps: tuple[Callable[[Grid], SignResult], ...] = (
        speed_signs,
        springs_signs,
        lateral_signs,
        along_signs,
        rate_signs,
    )
    for step in steps:
        result = rate_signs(grid, _untold(grid, unchecked)) if step is rate_signs else step(grid)
        if result.exchanged:
            exchanged = result.exchanged & set(grid.columns)
            decisions = [exchanged_decision(bool(exchanged & inverted))]
            inverted -= exchanged
            grid = grid.without(exchanged)
        axes_turned |= result.axes_turned
        along = turned_along(grid.columns, result.unchecked) if axes_turned else ()
        with_it = {each.signal for each in along}
        turned = (result.inverted & set(grid.columns)) | with_it
        inverted ^= turned
        grid = grid.scaled(dict.fromkeys(turned, -1.0))
        decisions += [*result.decisions, *along]
        unchecked = [
            text for text in unchecked if text.split(":")[0].removeprefix("sign of ") not in result.told
        ]
        unchecked += [
            text for text in result.unchecked if text.split(":")[0].removeprefix("sign of ") not in with_it
        ]
    return AllSigns(inverted, exchanged, grid, tuple(decisions), tuple(unchecked))


def _untold(grid: Grid, unchecked: Sequence[str]) -> frozenset[str]:
    """The angles of a drive whose sign nothing told, and accel_x where it looks wrong. unchecked: what was said of that."""
    untold = {
        name for name in ("roll", "pitch") if any(text.startswith(f"sign of {name}:") for text in unchecked)
    }
    if any(text.startswith("lateral signs:") for text in unchecked):
        untold.add("roll")
    if any(text.startswith(DOUBTED) for text in unchecked):
        untold.add("accel_x")
    return frozenset(untold & set(grid.columns))
