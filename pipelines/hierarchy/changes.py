"""Changes of the load from one drive of a vehicle to the next: told at a stated false-alarm rate, with their sizes.

Whether there is a change is asked of the drives alone (`contrast`): what is usual for loads draws two loads towards each
other. How large it is, is the difference of the two drives' joint answers, with all that is known.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.hierarchy.contrast import Contrast, Share, compared, half_seen, moments, share_of
from pipelines.hierarchy.posterior import VehiclePosterior
from pipelines.hierarchy.records import DriveTold, LoadChange
from pipelines.results import FloatArray

Shared = tuple[FloatArray, FloatArray]
"""Precision (K, K) and right hand side (K,) of the shared unknowns, by all drives."""

CHANCE = 0.01
"""False-alarm rate of a comparison of two drives."""

CHANGED = ("mass_kg", "cg_height_m", "cg_to_front_axle_m", "cg_lateral_offset_m")

THIRDS = (0.35, 0.65)
"""Of the wheelbase: a load before the first is at the front, behind the second at the rear."""

ASIDE = 0.15
"""Of the track: a load farther from the middle is said to be on that side."""

BACK = 6
"""Drives that are gone back at most for one that sees the load: vehicles are driven with different recorders."""

PLACED = 0.2
"""Of the wheelbase, and of the track: largest spread of a place that is put into words."""

NOT_SEEN = (
    "whether the load changed cannot be told: what these drives measured does not see the load apart from what loads usually "
    "are (it needs suspension deflections with spring rates, forces, axle loads, or drive torque)"
)


OR_SPRINGS = (
    "or springs, or the sensors of their travel, changed: these drives do not tell one from the other"
)


@dataclass(frozen=True)
class _Change:
    """A comparison with its sizes. load: (4,) and covariance of the change of the load's moments, all that is known in."""

    contrast: Contrast
    sizes: dict[str, tuple[float, float]]
    moved: FloatArray
    covariance: FloatArray
    length: float
    track: float
    least_kg: float


def _load_slopes(posterior: VehiclePosterior, i: int) -> tuple[FloatArray, FloatArray]:
    """(4,) moments of a drive's load at its joint mean, (4, k) their derivatives by the drive's unknowns."""
    part, at = posterior.parts[i], posterior.mean(i)
    rows = [part.names.index(name) for name in ("load", "load_x", "load_y", "load_h")]
    load = at[rows]
    slopes = np.zeros((4, len(part.names)))
    slopes[0, rows[0]] = 1.0
    for k in (1, 2, 3):
        slopes[k, rows[0]], slopes[k, rows[k]] = load[k], load[0]
    return moments(load), slopes


def _sizes(posterior: VehiclePosterior, a: int, b: int) -> dict[str, tuple[float, float]]:
    """Differences of the parameters, b less a, with their standard deviations: what is shared cancels. Where the vehicle's drives scatter more
    than the model of their errors has it, so do differences of theirs, as the answers themselves."""
    (before, by_a), (after, by_b) = posterior.outputs(a), posterior.outputs(b)
    found = {}
    for name in CHANGED:
        _, variance = posterior.functional({a: -by_a[name], b: by_b[name]})
        std = posterior.inflation * math.sqrt(max(float(variance[0, 0]), 0.0))
        found[name] = (after[name] - before[name], std)
    return found


def _changed(posterior: VehiclePosterior, a: int, b: int, contrast: Contrast) -> _Change:
    (was, by_a), (now, by_b) = _load_slopes(posterior, a), _load_slopes(posterior, b)
    _, covariance = posterior.functional({a: -by_a, b: by_b})
    part, at = posterior.parts[b], posterior.mean(b)
    value = dict(zip(part.names, at.tolist(), strict=True))
    # a load in the middle of the vehicle, at the height where loads usually lie
    usual = part.mean[part.names.index("load_h")]
    middle = (1.0, 0.5 * value["wheelbase"], 0.0, float(usual))
    return _Change(
        contrast, _sizes(posterior, a, b), now - was, posterior.inflation**2 * covariance, value["wheelbase"],
        value["track_front"], half_seen(contrast, middle, CHANCE),
    )  # fmt: skip


def _placed(change: _Change, row: int) -> tuple[float, float]:
    """Where the mass was added or taken away, along one axis, and its spread (that of a ratio, to first order)."""
    mass, moment = float(change.moved[0]), float(change.moved[row])
    slope = np.zeros(4)
    slope[0], slope[row] = -moment / mass**2, 1 / mass
    return moment / mass, math.sqrt(max(float(slope @ change.covariance @ slope), 0.0))


def _where(change: _Change) -> str:
    """At the front, on the left …, as far as that is known."""
    words = []
    x, spread = _placed(change, 1)
    if spread < PLACED * change.length:
        share = x / change.length
        words.append(
            "at the front" if share < THIRDS[0] else "at the rear" if share > THIRDS[1] else "in the middle"
        )
    y, spread = _placed(change, 2)
    if spread < PLACED * change.track and abs(y) > ASIDE * change.track:
        words.append("on the left" if y > 0 else "on the right")
    return ", " + ", ".join(words) if words else ""


def _sure(size: tuple[float, float]) -> bool:
    return abs(size[0]) > 1.96 * size[1]


def _moved(change: _Change) -> list[str]:
    """How the CG moved, where that is known for sure."""
    words = (
        ("cg_height_m", "higher", "lower"),
        ("cg_to_front_axle_m", "farther back", "farther forward"),
        ("cg_lateral_offset_m", "to the left", "to the right"),
    )
    found = []
    for name, more, less in words:
        value, std = change.sizes[name]
        if _sure((value, std)):
            side = more if value > 0 else less
            found.append(f"CG {100 * abs(value):.1f} ± {100 * std:.1f} cm {side}")
    return found


def _rounded(value: float, std: float) -> str:
    """In kg, no finer than it is known."""
    step = 10.0 if std >= 20 else 5.0 if std >= 8 else 1.0
    return f"{step * round(abs(value) / step):.0f} ± {max(std, 0.5):.0f} kg"


def _least(change: _Change) -> str:
    if not math.isfinite(change.least_kg):
        return ""
    step = 10.0 if change.least_kg >= 100 else 5.0 if change.least_kg >= 20 else 1.0
    size = step * max(round(change.least_kg / step), 1)
    return f"a change of {size:.0f} kg in the middle of the vehicle would be noticed in half the cases"


def _text(change: _Change, detected: bool) -> str:
    mass = change.sizes["mass_kg"]
    if change.contrast.figures == 0:
        return NOT_SEEN
    least = _least(change)
    if not detected:
        return "no change of the load is seen" + (f"; {least}" if least else "")
    if _sure(mass):
        first = f"about {_rounded(*mass)} {'more' if mass[0] > 0 else 'less'}{_where(change)}"
    else:
        first = f"the load lies otherwise (mass {'+' if mass[0] > 0 else '-'}{_rounded(*mass)})"
    return ", ".join([first, *_moved(change)])


def _may_be_springs(posterior: VehiclePosterior, a: int, b: int, shared: Shared) -> bool:
    """Whether no change of the load is left where one of the two drives may have had other springs or deflection sensors."""
    usual, other = (
        [share_of(posterior.parts[i], posterior.mean(i), replaced=replaced) for i in (a, b)]
        for replaced in (False, True)
    )
    pairs = ((usual[0], other[1]), (other[0], usual[1]))
    return any(
        before is not None and after is not None
        and compared(before, after, *shared).probability >= CHANCE
        for before, after in pairs
    )  # fmt: skip


def _shared(posterior: VehiclePosterior) -> Shared:
    precision = np.linalg.inv(posterior.s_covariance)
    precision = 0.5 * (precision + precision.T)
    return precision, precision @ posterior.s


def _record(
    posterior: VehiclePosterior, shared: Shared, a: int, b: int, contrast: Contrast, between: int
) -> LoadChange:
    """between: drives that lie between the two and do not see the load."""
    change = _changed(posterior, a, b, contrast)
    detected = contrast.figures > 0 and contrast.probability < CHANCE
    names, text = posterior.drives, _text(change, detected)
    if detected and _may_be_springs(posterior, a, b, shared):
        text = f"{text}; {OR_SPRINGS}"
    if between:
        drives = "the drive between does" if between == 1 else f"the {between} drives between do"
        text = f"{text} (against {names[a]}: {drives} not see the load)"
    return LoadChange(names[b], names[a], contrast.probability, detected, change.sizes, text)


def load_changes(posterior: VehiclePosterior, drives: Sequence[DriveTold]) -> tuple[LoadChange, ...]:
    """Every drive against the one before it that told anything. drives: of one vehicle, in the order of time.

    Where two drives do not see the difference of their loads, the drives before them are asked, the nearest first.
    probability: of relations as unlike by chance had the load been the same; detected below `CHANCE`. A drive that is not
    in the posterior, or has no load among its unknowns, is passed over.
    """
    told = {drive.drive_id for drive in drives if drive.kept is not None}
    shared = _shared(posterior)
    before: deque[tuple[int, Share]] = deque(maxlen=BACK)
    found = []
    for row, part in enumerate(posterior.parts):
        # joined drives are made linear where they ended
        share = share_of(part, posterior.mean(row)) if part.drive_id in told else None
        if share is None:
            continue
        first: tuple[int, Contrast, int] | None = None
        for between, (other, load) in enumerate(reversed(before)):
            contrast = compared(load, share, *shared)
            if first is None or contrast.figures:
                first = (other, contrast, between)
            if contrast.figures:
                break
        if first is not None:
            found.append(_record(posterior, shared, first[0], row, *first[1:]))
        before.append((row, share))
    return tuple(found)
