"""An inertial unit that is mounted backwards: half a turn about the vertical axis inverts all that it says of x and y.

Judged one by one, what the drive tells clearly would be turned and what it does not (often pitch) left, so that the unit's signals
contradict each other. So the whole unit is turned for a trial: where nothing of it is wrong then, one mistake explains what several would.
"""

from __future__ import annotations

from dataclasses import replace

from parsers.checks.all_signs import AllSigns, all_signs
from parsers.checks.grid import Grid
from parsers.checks.sideways import sideways
from parsers.drive import Decision

_FORCES = ("accel_x", "accel_y")
_TURNS = ("roll", "pitch", "roll_rate", "pitch_rate")


def judge_signs(grid: Grid) -> AllSigns:
    """All signs; those of a unit that is mounted backwards in one decision, without what a unit mounted sideways says."""
    aside = sideways(grid)
    if aside is not None:
        rest = all_signs(grid.without(aside.names))
        return replace(
            rest, exchanged=rest.exchanged | aside.names, decisions=(aside.decision, *rest.decisions)
        )
    alone = all_signs(grid)
    if not _perhaps_backwards(grid, alone.inverted):
        return alone
    unit = _unit(grid, alone.inverted)
    turned = all_signs(grid.scaled(dict.fromkeys(unit, -1.0)))
    against = turned.inverted & {*unit, "yaw_rate", "accel_z"}
    if not against:
        decision = _backwards(unit, alone)
        return replace(turned, inverted=turned.inverted ^ set(unit), decisions=(decision, *turned.decisions))
    if not set(_FORCES) <= alone.inverted:
        return alone
    return replace(alone, decisions=(*alone.decisions, _contradicted(sorted(against))))


def _perhaps_backwards(grid: Grid, inverted: frozenset[str]) -> bool:
    """Whether both horizontal accelerations seem opposite (the lateral one, or yaw rate that is held against it), gravity not.

    What the unit says of turning must seem opposite as well, where it says anything: else two accelerations have their signs wrong, and no more.
    Without gravity, accelerations that are all logged as their reactions look alike: then some rate or angle must.
    """
    lateral = bool(inverted & {"accel_y", "yaw_rate"}) and "accel_y" in grid.columns
    told = bool(inverted & set(_TURNS)) or ("accel_z" in grid.columns and not _own_turns(grid))
    return "accel_x" in inverted and lateral and told and "accel_z" not in inverted


def _unit(grid: Grid, inverted: frozenset[str]) -> tuple[str, ...]:
    """What is logged of the unit: both accelerations, and what comes with them, or seems opposite as they do."""
    own = _own_turns(grid)
    return _FORCES + tuple(
        name for name in _TURNS if name in grid.columns and (name in inverted or name in own)
    )


def _own_turns(grid: Grid) -> frozenset[str]:
    """What the table of the accelerations holds of rolling and pitching."""
    group = {name: signal.group for name, signal in grid.made_of.items()}
    return frozenset(n for n in _TURNS if n in grid.columns and group.get(n) == group.get("accel_x"))


def _backwards(unit: tuple[str, ...], alone: AllSigns) -> Decision:
    seen = {each.signal: each.evidence for each in alone.decisions if each.signal in (*unit, "yaw_rate")}
    untold = [name for name in unit if any(text.startswith(f"sign of {name}:") for text in alone.unchecked)]
    evidence = "; ".join(f"{name}: {text}" for name, text in seen.items())
    if untold:
        evidence += f"; the drive does not tell {' and '.join(untold)} alone"
    return Decision(
        signal="accel_x",
        kind="sign",
        found="the inertial unit is mounted backwards, turned by 180° about the vertical axis",
        action=f"{', '.join(unit[:-1])} and {unit[-1]} inverted together",
        evidence=evidence,
        applied=True,
    )


def _contradicted(against: list[str]) -> Decision:
    return Decision(
        signal="accel_x",
        kind="sign",
        found=f"accel_x and accel_y are opposite as in a unit that is mounted backwards, but {' and '.join(against)} "
        f"{'contradicts' if len(against) == 1 else 'contradict'} that",
        action="each sign is judged by itself; where the drive does not tell one, say it in a mapping file",
        evidence="turned all together, they would not agree with the rest",
        applied=False,
    )
