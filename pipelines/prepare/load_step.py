"""Does what is carried change in mid-drive? A step between two stands, beyond what friction, slopes and drift explain.

What the wheels carry at stand i is, wheel by wheel and for their sum,

    F_i = c + b_x f_x + b_y f_y + d_1 t + d_2 t² + s [i >= k] + e_i

with f_x, f_y what the accelerometers read (a slope, against held brakes and by links that lift), t over the drive in -1 to 1 (a sensor
that drifts), and e_i what dry friction holds at that rest. b and d are known beforehand within the spreads below, so that two stands tell a
step as well as twenty, if less well. s is estimated for every k at once by generalized least squares; the best k is a change
of load where s is beyond doubt, where the stands right before and after it show it too (a drift does not), and where more than
one wheel takes part (a body does not sink at one wheel alone; a sensor's lever slips so).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parsers.drive import Decision, Drive
from pipelines.joint.vehicle.suspension import STUCK
from pipelines.models.roll import GRAVITY
from pipelines.prepare.decided import decided
from pipelines.prepare.stands import Stands, find_stands, spring_rates, weight_of
from pipelines.results import FloatArray
from pipelines.vehicles.spring_base import rigid_axle
from pipelines.vehicles.vehicle import Vehicle

STUCK_LEAVES = 0.03
"""Friction at rest over the load of a vehicle with leaf springs (of others: `joint.vehicle.suspension.STUCK`)."""
CONTACT = 0.004
"""Scatter of loads that are measured at the road, where no friction is in between, over the weight."""
SLOPE, DRIFT, BENT = 0.4, 0.015, 0.0075
"""Spreads over the weight: what a slope of 1 g takes from a wheel or the sum; drift over half a drive, even and bent."""
SURE, SURE_ALONE = 5.0, 8.0
"""Standard deviations for a step, and for one with a single rest before or behind it, which may be odd by itself."""
FITTED = 4
"""Of the level, the step, two slopes and two drifts as many are told by the rests, as a rule."""
LEAST = 0.025
"""Of the weight: less is a tank of fuel, or somebody who leans out."""
NEAR = 3
AT_ONCE = 0.4
"""Share of the step that the NEAR stands before and after it have to show."""
ALONE = 0.75
"""Share of all wheels' steps that no single wheel takes: a load above one wheel lifts another one by the body's lean."""
APART = (-0.5, 1.5)
"""Share of the rear axle: of loads behind it or ahead of the front one, as far as a vehicle reaches."""
AGREES = 0.5
"""Where several carriers are there, each has to show that share of the step."""


@dataclass(frozen=True)
class LoadStep:
    """A load that came or went. after_s, before_s: between which instants, from the drive's start. change_kg: + what came; std_kg of it.

    rear, left: share of it on the rear axle and on the left wheels (left None where only axles are measured). source: signals.
    """

    after_s: float
    before_s: float
    change_kg: float
    std_kg: float
    rear: float
    left: float | None
    source: str

    @property
    def found(self) -> str:
        """The sentence for the reader."""
        where = (
            "more at the rear"
            if self.rear > 0.6
            else "more at the front"
            if self.rear < 0.4
            else "at both axles"
        )
        rounded = 10 * round(self.change_kg / 10)
        when = 0.5 * (self.after_s + self.before_s)
        return f"the load changed at about {when:.0f} s (by about {rounded:+d} kg, {where})"

    @property
    def decision(self) -> Decision:
        """As it stands in the import record: nothing was done about it."""
        evidence = (
            f"{self.change_kg:+.0f} ± {self.std_kg:.0f} kg by {self.source} at rest, between {self.after_s:.0f} and {self.before_s:.0f} s; "
            f"{100 * self.rear:.0f} % of it at the rear"
        )
        action = "split the drive there; mass, place and heights are weak, with half of what the load changes in their spreads"
        return Decision("", "load", self.found, action, evidence, applied=False)


@dataclass(frozen=True)
class _Fit:
    """The best step: index of its first stand, step of the sum and of each wheel (or axle), std of the sum's, N; residuals of
    the sum with the step left in, (n,)."""

    first: int
    total: float
    std: float
    parts: FloatArray
    left_in: FloatArray


def _friction(stands: Stands, carrier: str, vehicle: Vehicle) -> float:
    """Scatter of the sum between rests, N: four wheels stick each for itself."""
    weight = weight_of(stands, carrier, vehicle)
    if carrier in ("tire_normal_force", "axle_load"):
        return CONTACT * weight
    return 0.5 * weight * (STUCK_LEAVES if rigid_axle(vehicle, "rear") else STUCK)


def _nuisances(stands: Stands, weight: float) -> FloatArray:
    """(n, 4) what slopes and drift add to a sum, each in its spread, N."""
    middle = 0.5 * (stands.begin_s + stands.end_s)
    t = 2 * (middle - middle[0]) / max(float(middle[-1] - middle[0]), 1.0) - 1
    lean = SLOPE * weight / GRAVITY
    columns = (lean * stands.along, lean * stands.across, DRIFT * weight * t, BENT * weight * t * t)
    return np.column_stack([each - each.mean() for each in columns])


def _scatter(left: FloatArray, rest: NDArray[np.int64], first: int) -> float:
    """Root mean square of what the fit leaves, (n,) N, rest by rest: one that the step cuts counts as two, figures fitted as none."""
    pieces = np.arange(len(rest))
    _, group = np.unique(2 * rest + (pieces >= first), return_inverse=True)
    means = np.bincount(group, weights=left) / np.bincount(group)
    return math.sqrt(float(means @ means) / max(len(means) - FITTED, 1))


def _fit(stands: Stands, carrier: str, vehicle: Vehicle, at: NDArray[np.int64]) -> _Fit:
    """Generalized least squares for a step before each stand of `at`, and the best of them."""
    parts = stands.loads[carrier]
    stuck = _friction(stands, carrier, vehicle)
    slopes = _nuisances(stands, weight_of(stands, carrier, vehicle))
    n = len(parts)
    # friction holds all of a rest alike; pieces of one rest differ by half as much (somebody moves, a brake is let go)
    own = stuck**2 * (stands.rest[:, None] == stands.rest[None, :]) + (0.5 * stuck) ** 2 * np.eye(n)
    inverse = np.linalg.inv(own + slopes @ slopes.T)
    once = inverse.sum(axis=1)
    seen = inverse - np.outer(once, once) / once.sum()
    steps = (np.arange(n)[:, None] >= at[None, :]).astype(np.float64)
    columns = np.column_stack([parts.sum(axis=1), parts])
    power = np.einsum("ij,ij->j", steps, seen @ steps)
    found = (steps.T @ seen @ columns) / power[:, None]
    best = int(np.argmax(found[:, 0] ** 2 * power))
    rest = columns[:, 0] - found[best, 0] * steps[:, best]
    without = columns[:, 0] - slopes @ (slopes.T @ seen @ rest)
    left = without - found[best, 0] * steps[:, best]
    left = left - float(once @ left) / float(once.sum())
    scale = max(1.0, _scatter(left, stands.rest, int(at[best])) / stuck)
    std = scale / math.sqrt(float(power[best]))
    return _Fit(int(at[best]), float(found[best, 0]), std, found[best, 1:], without)


def _surely(stands: Stands, fit: _Fit, weight: float) -> bool:
    """Whether the step is large, beyond doubt, and there at once."""
    before, after = stands.rest[: fit.first], stands.rest[fit.first :]
    single = min(len(np.unique(before)), len(np.unique(after))) < 2
    if abs(fit.total) < max(LEAST * weight, (SURE_ALONE if single else SURE) * fit.std):
        return False
    levels = fit.left_in
    at_once = np.median(levels[fit.first : fit.first + NEAR]) - np.median(
        levels[max(fit.first - NEAR, 0) : fit.first]
    )
    return bool(at_once * np.sign(fit.total) > AT_ONCE * abs(fit.total))


def _of_a_body(fit: _Fit) -> bool:
    """Whether the wheels' steps are those of a body with more or less on it, and not of one sensor."""
    rear = float(fit.parts[len(fit.parts) // 2 :].sum()) / fit.total
    if not APART[0] < rear < APART[1]:
        return False
    size = np.abs(fit.parts)
    return len(size) == 2 or float(size.max()) < ALONE * float(size.sum())


def load_step(drive: Drive, vehicle: Vehicle) -> LoadStep | None:
    """The largest change of load in mid-drive; None where there is none, or the log cannot tell."""
    stands = find_stands(drive, vehicle)
    if stands is None or len(np.unique(stands.rest)) < 2:
        return None
    carrier, *others = stands.loads
    fit = _fit(stands, carrier, vehicle, np.arange(1, len(stands.rest)))
    if not (_surely(stands, fit, weight_of(stands, carrier, vehicle)) and _of_a_body(fit)):
        return None
    again = (_fit(stands, other, vehicle, np.array([fit.first])) for other in others)
    if any(each.total * np.sign(fit.total) < AGREES * abs(fit.total) for each in again):
        return None
    # what the springs' rates are unsure by, and a twentieth for springs that stiffen and sensors' scales
    rates = spring_rates(vehicle)[1] if carrier == "suspension_deflection" else 0.0
    half = len(fit.parts) // 2
    return LoadStep(
        after_s=float(stands.end_s[fit.first - 1]),
        before_s=float(stands.begin_s[fit.first]),
        change_kg=fit.total / GRAVITY,
        std_kg=math.hypot(fit.std, math.hypot(0.05, rates) * fit.total) / GRAVITY,
        rear=float(fit.parts[half:].sum()) / fit.total,
        left=float(fit.parts[0::2].sum()) / fit.total if half > 1 else None,
        source=f"{carrier.replace(chr(95), chr(32))}s",
    )


def with_load_step(drive: Drive, step: LoadStep | None) -> Drive:
    """The drive with what was found in its record."""
    return drive if step is None else decided(drive, [step.decision])
