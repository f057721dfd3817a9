"""Vertical forces of an axle's two wheels whose gains differ: what bends put on one wheel they take off the other, and braking loads both alike.

The sum of an axle's forces has next to no part that is linear in the lateral acceleration (links lift in proportion to its square), whatever
the springs, bars and roll centres are; nor has their difference one in braking. Loads to one side, links that stand askew and tyres
that braking loads unlike make some per cent of either, opposite at front and rear. A strut that reads a fifth too much shows that fifth
in both, and at rest puts the mass 4 % up, a corner's by the fifth, at five to eight standard deviations. Which of the two wheels
is right, the log does not say.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import Grid
from parsers.checks.motion import smooth
from parsers.checks.pedals import change_of_speed
from parsers.checks.wheel_forces import FORCES
from parsers.drive import Decision
from parsers.quantiles import quantile
from parsers.signals import WHEELS

BOTH, ALONE = 0.08, 0.12
"""ln of the left wheel's gain over the right one's that right drives stay below where bends and braking agree, and where one of them tells.
Struts, axles and loads of 40 right drives come to 0.037 in bends and 0.085 in braking."""
EACH = 0.05
"""What each of the two must show where both tell."""
TELLS = 0.04
"""Standard deviation up to which one of them tells anything."""
SURE = 3.0
LEAST_MPS2, LEAST_CELLS, BLOCKS = 0.3, 300, 10
TWO_WAYS = 0.2
"""Bends to the one side over those to the other, by size: in bends to one side a bank and the square of the acceleration look linear."""
LARGEST = 1e7


@dataclass(frozen=True)
class _Gain:
    """ln of left over right, and its spread; NaN where nothing tells."""

    log: float
    std: float

    @property
    def tells(self) -> bool:
        return math.isfinite(self.log) and self.std <= TELLS


def unlike_gains(grid: Grid, known: Collection[str] = ()) -> list[Decision]:
    """Both forces of an axle left out, where one of them surely reads far more than the other. known: signals that something else is wrong with."""
    found: list[Decision] = []
    lateral, along = grid.get("accel_y"), grid.get("accel_x")
    along = change_of_speed(grid) if along is None else along
    if lateral is None or along is None:
        return found
    for kind in FORCES:
        names = [f"{kind}_{wheel}" for wheel in WHEELS]
        columns = [column for name in names if (column := grid.get(name)) is not None]
        if len(columns) == len(names) and set(known).isdisjoint(names):
            table = np.column_stack([smooth(column) for column in columns])
            found += _axles(kind, table, smooth(lateral), smooth(along))
    return found


def _axles(kind: str, forces: FloatArray, lateral: FloatArray, along: FloatArray) -> list[Decision]:
    """What is decided of the axles. forces: (n, 4) in the order of WHEELS; lateral, along: (n,)."""
    gains = _gains(forces, lateral, along)
    found: list[Decision] = []
    for axle, end, (bends, braking) in zip(("front", "rear"), "fr", gains, strict=False):
        off = _off(bends, braking)
        if off is None:
            continue
        words = [
            f"{math.exp(g.log):.2f} times (± {100 * g.std:.1f} %) in {where}"
            for g, where in ((bends, "bends"), (braking, "braking"))
            if g.tells
        ]
        text = f"{kind} of the {axle} axle's wheels differ in gain: the left one reads {math.exp(off):.2f} times what the right one does"
        evidence = f"changes of the left wheel's force are {' and '.join(words)} those of the right one's, which both make alike"
        action = "left out: which of both is right, the log does not say"
        names = [f"{kind}_{end}{side}" for side in "lr"]
        found += [Decision(name, "range", text, action, evidence, applied=True) for name in names]
    return found


def _off(bends: _Gain, braking: _Gain) -> float | None:
    """ln of left over right, where that is beyond doubt; None where it is not."""
    told = [gain for gain in (bends, braking) if gain.tells]
    if not told:
        return None
    if len(told) == 1:
        (gain,) = told
        return gain.log if abs(gain.log) > ALONE + SURE * gain.std else None
    if bends.log * braking.log < 0 or min(abs(gain.log) for gain in told) < EACH:
        return None
    # neither is better known than what loads and links make
    weights = np.array([1 / (gain.std**2 + (EACH / 2) ** 2) for gain in told])
    off = float(weights @ [gain.log for gain in told] / weights.sum())
    std = max(gain.std for gain in told)
    return off if abs(off) > BOTH + SURE * std else None


def _gains(forces: FloatArray, lateral: FloatArray, along: FloatArray) -> list[tuple[_Gain, _Gain]]:
    """By bends and by braking, of the front and of the rear axle; empty where the drive does not tell."""
    table = np.column_stack([np.ones(len(lateral)), lateral, along, lateral**2])
    rows = np.isfinite(table).all(axis=1) & np.isfinite(forces).all(axis=1)
    table, forces = table[rows], forces[rows]
    if len(table) < LEAST_CELLS or max(float(np.abs(table).max()), float(np.abs(forces).max())) > LARGEST:
        return []
    parts = np.array_split(np.arange(len(table)), BLOCKS)
    left = np.array([table[part].T @ table[part] for part in parts])
    right = np.array([table[part].T @ forces[part] for part in parts])
    whole = left.sum(axis=0)
    rest = whole - left
    if not np.linalg.cond(np.concatenate([whole[None], rest])).max() < 1e10:
        return []
    found = _logs(np.linalg.solve(whole, right.sum(axis=0)))
    without = np.array([_logs(each) for each in np.linalg.solve(rest, right.sum(axis=0) - right)])
    std = np.sqrt((BLOCKS - 1) / BLOCKS * np.sum((without - without.mean(axis=0)) ** 2, axis=0))
    moves = 1 / np.sqrt(np.diagonal(np.linalg.inv(whole))[1:3] * len(table)) >= LEAST_MPS2
    ways = sorted((-quantile(table[:, 1], 0.03), quantile(table[:, 1], 0.97)))
    moves[0] &= ways[0] >= TWO_WAYS * ways[1]
    told = [
        _Gain(float(value), float(spread)) if moves[number // 2] else _Gain(math.nan, math.nan)
        for number, (value, spread) in enumerate(zip(found, std, strict=True))
    ]
    return [(told[0], told[2]), (told[1], told[3])]


def _logs(slopes: FloatArray) -> FloatArray:
    """ln of left over right: by bends front and rear, by braking front and rear. slopes: (4, 4); NaN where signs are not those."""
    _, side, along, _ = slopes
    ratios = np.array([-side[0] / side[1], -side[2] / side[3], along[0] / along[1], along[2] / along[3]])
    return np.log(np.where(ratios > 0, ratios, np.nan))
