"""Does what is carried change in mid-drive? Steps between two stands, beyond what friction, slopes and drift explain.

What the wheels carry at stand i is, wheel by wheel and for their sum,

    F_i = c + b_x f_x + b_y f_y + d_1 t + d_2 t² + sum_k s_k [i >= k] + e_i

with f_x, f_y what the accelerometers read (a slope, against held brakes and by links that lift), t over the drive in -1 to 1 (a sensor
that drifts), and e_i what dry friction holds at that rest. b and d are known beforehand within the spreads below, so that two stands tell a
step as well as twenty, if less well. Steps are taken in one after the other, each where it explains most beside those before it, all
fitted together by generalized least squares: somebody who rides along for a part of the drive is two steps, of which neither explains
much alone. A step is a change of load where s is beyond doubt, where the stands right before and after it show it too (a drift does
not), and where more than one wheel takes part (a body does not sink at one wheel alone; a sensor's lever slips so).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

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
MOST_STEPS = 5
"""More are not looked for: a drive of so many loads is told as weakly with five as with ten."""


@dataclass(frozen=True)
class LoadStep:
    """A load that came or went. after_s, before_s: between which instants, from the drive's start. change_kg: + what came; std_kg of it.

    rear, left: share of it on the rear axle and on the left wheels (left None where only axles are measured). source: signals.
    others: of a drive with several the smaller ones, in the order of time.
    """

    after_s: float
    before_s: float
    change_kg: float
    std_kg: float
    rear: float
    left: float | None
    source: str
    others: tuple[LoadStep, ...] = ()

    @property
    def in_order(self) -> tuple[LoadStep, ...]:
        """This one and the others as they came."""
        return tuple(sorted((replace(self, others=()), *self.others), key=lambda step: step.after_s))

    @property
    def most_kg(self) -> float:
        """By how much the heaviest load of the drive is beyond the lightest."""
        loads = np.cumsum([0.0, *(step.change_kg for step in self.in_order)])
        return float(loads.max() - loads.min())

    @property
    def found(self) -> str:
        """The sentence for the reader."""
        return "the load changed " + " and ".join(step._when for step in self.in_order)

    @property
    def _when(self) -> str:
        where = (
            "more at the rear"
            if self.rear > 0.6
            else "more at the front"
            if self.rear < 0.4
            else "at both axles"
        )
        rounded = 10 * round(self.change_kg / 10)
        when = 0.5 * (self.after_s + self.before_s)
        return f"at about {when:.0f} s (by about {rounded:+d} kg, {where})"

    @property
    def decision(self) -> Decision:
        """As it stands in the import record: nothing was done about it."""
        evidence = "; ".join(
            f"{step.change_kg:+.0f} ± {step.std_kg:.0f} kg by {step.source} at rest, between {step.after_s:.0f} and {step.before_s:.0f} s, "
            f"{100 * step.rear:.0f} % of it at the rear"
            for step in self.in_order
        )
        action = "split the drive there; mass, place and heights are weak, with half of what the load changes in their spreads"
        return Decision("", "load", self.found, action, evidence, applied=False)


@dataclass(frozen=True)
class _Fit:
    """One step among others. first: index of its first stand; begin, end: from and up to which stand no other step comes.

    total, std: of the sum, N; parts: of each wheel (or axle). left_in: (n,) residuals of the sum with this step left in.
    """

    first: int
    begin: int
    end: int
    total: float
    std: float
    parts: FloatArray
    left_in: FloatArray


@dataclass(frozen=True)
class _Sums:
    """What generalized least squares need of one carrier. loads: (n, 1 + wheels) the sum and each; slopes: (n, 4) nuisances; once: (n,)
    the weights of a mean; seen: (n, n) the inverse of all covariances, for what has no mean; stuck: what a rest's sum scatters by, N."""

    loads: FloatArray
    slopes: FloatArray
    once: FloatArray
    seen: FloatArray
    stuck: float

    def powers(self, steps: FloatArray, beside: FloatArray) -> FloatArray:
        """(m,) what each of the steps (n, m) explains beside those that are there (n, k), in chi²."""
        y = self.loads[:, 0]
        power = np.einsum("ij,ij->j", steps, self.seen @ steps)
        pull = steps.T @ (self.seen @ y)
        if beside.shape[1]:
            across = steps.T @ self.seen @ beside
            inverse = np.linalg.inv(beside.T @ self.seen @ beside)
            power = power - np.einsum("ij,jk,ik->i", across, inverse, across)
            pull = pull - across @ inverse @ (beside.T @ self.seen @ y)
        # a step that is there already explains nothing more
        return np.where(power > 1e-9 * np.max(np.abs(power)), pull**2 / np.maximum(power, 1e-300), 0.0)


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


def _sums(stands: Stands, carrier: str, vehicle: Vehicle) -> _Sums:
    parts = stands.loads[carrier]
    stuck = _friction(stands, carrier, vehicle)
    slopes = _nuisances(stands, weight_of(stands, carrier, vehicle))
    # friction holds all of a rest alike; pieces of one rest differ by half as much (somebody moves, a brake is let go)
    own = stuck**2 * (stands.rest[:, None] == stands.rest[None, :]) + (0.5 * stuck) ** 2 * np.eye(len(parts))
    inverse = np.linalg.inv(own + slopes @ slopes.T)
    once = inverse.sum(axis=1)
    seen = inverse - np.outer(once, once) / once.sum()
    return _Sums(np.column_stack([parts.sum(axis=1), parts]), slopes, once, seen, stuck)


def _steps(count: int, firsts: Sequence[int]) -> FloatArray:
    """(n, m) 0 before a step, 1 from it on."""
    return (np.arange(count)[:, None] >= np.asarray(firsts, dtype=np.int64)[None, :]).astype(np.float64)


def _scatter(left: FloatArray, rest: NDArray[np.int64], firsts: Sequence[int]) -> float:
    """Root mean square of what the fit leaves, (n,) N, rest by rest: one that a step cuts counts as two, figures fitted as none."""
    level = _steps(len(rest), firsts).sum(axis=1).astype(np.int64)
    _, group = np.unique((len(firsts) + 1) * rest + level, return_inverse=True)
    means = np.bincount(group, weights=left) / np.bincount(group)
    return math.sqrt(float(means @ means) / max(len(means) - FITTED - len(firsts) + 1, 1))


def _fit(sums: _Sums, rest: NDArray[np.int64], firsts: Sequence[int]) -> tuple[_Fit, ...]:
    """Generalized least squares for steps before the stands `firsts`, in the order of time."""
    n = len(rest)
    steps = _steps(n, firsts)
    covariance = np.linalg.inv(steps.T @ sums.seen @ steps)
    found = covariance @ (steps.T @ sums.seen @ sums.loads)
    without = sums.loads[:, 0] - sums.slopes @ (
        sums.slopes.T @ sums.seen @ (sums.loads[:, 0] - steps @ found[:, 0])
    )
    left = without - steps @ found[:, 0]
    left = left - float(sums.once @ left) / float(sums.once.sum())
    scale = max(1.0, _scatter(left, rest, firsts) / sums.stuck)
    bounds = (0, *firsts, n)
    return tuple(
        _Fit(
            first, bounds[m], bounds[m + 2], float(found[m, 0]), scale * math.sqrt(float(covariance[m, m])), found[m, 1:],
            left + steps[:, m] * found[m, 0],
        )
        for m, first in enumerate(firsts)
    )  # fmt: skip


def _surely(stands: Stands, fit: _Fit, weight: float) -> bool:
    """Whether the step is large, beyond doubt, and there at once."""
    before, after = stands.rest[fit.begin : fit.first], stands.rest[fit.first : fit.end]
    single = min(len(np.unique(before)), len(np.unique(after))) < 2
    if abs(fit.total) < max(LEAST * weight, (SURE_ALONE if single else SURE) * fit.std):
        return False
    levels = fit.left_in
    at_once = np.median(levels[fit.first : min(fit.first + NEAR, fit.end)]) - np.median(
        levels[max(fit.first - NEAR, fit.begin) : fit.first]
    )
    return bool(at_once * np.sign(fit.total) > AT_ONCE * abs(fit.total))


def _of_a_body(fit: _Fit) -> bool:
    """Whether the wheels' steps are those of a body with more or less on it, and not of one sensor."""
    rear = float(fit.parts[len(fit.parts) // 2 :].sum()) / fit.total
    if not APART[0] < rear < APART[1]:
        return False
    size = np.abs(fit.parts)
    return len(size) == 2 or float(size.max()) < ALONE * float(size.sum())


def _found(sums: _Sums, stands: Stands, weight: float) -> tuple[_Fit, ...]:
    """The most steps that are all beyond doubt; none where there are none."""
    n = len(stands.rest)
    every, firsts = np.arange(1, n), list[int]()
    best: tuple[_Fit, ...] = ()
    for _ in range(min(MOST_STEPS, n - 1)):
        explained = sums.powers(_steps(n, every.tolist()), _steps(n, firsts))
        explained[np.isin(every, firsts)] = 0.0
        if not explained.max() > 0:
            break
        firsts = sorted([*firsts, int(every[int(np.argmax(explained))])])
        fits = _fit(sums, stands.rest, firsts)
        if all(_surely(stands, fit, weight) and _of_a_body(fit) for fit in fits):
            best = fits
    return best


def load_step(drive: Drive, vehicle: Vehicle) -> LoadStep | None:
    """The largest change of load in mid-drive, with the others beside it; None where there is none, or the log cannot tell."""
    stands = find_stands(drive, vehicle)
    if stands is None or len(np.unique(stands.rest)) < 2:
        return None
    carrier, *others = stands.loads
    fits = _found(_sums(stands, carrier, vehicle), stands, weight_of(stands, carrier, vehicle))
    if not fits:
        return None
    firsts = [fit.first for fit in fits]
    for other in others:
        again = _fit(_sums(stands, other, vehicle), stands.rest, firsts)
        if any(
            a.total * np.sign(fit.total) < AGREES * abs(fit.total) for a, fit in zip(again, fits, strict=True)
        ):
            return None
    # what the springs' rates are unsure by, and a twentieth for springs that stiffen and sensors' scales
    rates = spring_rates(vehicle)[1] if carrier == "suspension_deflection" else 0.0
    steps = [_told(fit, stands, carrier, math.hypot(0.05, rates)) for fit in fits]
    largest = max(steps, key=lambda step: abs(step.change_kg))
    return replace(largest, others=tuple(step for step in steps if step is not largest))


def _told(fit: _Fit, stands: Stands, carrier: str, unsure: float) -> LoadStep:
    """A step in kg. unsure: share of it that rates and scales leave open."""
    half = len(fit.parts) // 2
    return LoadStep(
        after_s=float(stands.end_s[fit.first - 1]),
        before_s=float(stands.begin_s[fit.first]),
        change_kg=fit.total / GRAVITY,
        std_kg=math.hypot(fit.std, unsure * fit.total) / GRAVITY,
        rear=float(fit.parts[half:].sum()) / fit.total,
        left=float(fit.parts[0::2].sum()) / fit.total if half > 1 else None,
        source=f"{carrier.replace(chr(95), chr(32))}s",
    )


def with_load_step(drive: Drive, step: LoadStep | None) -> Drive:
    """The drive with what was found in its record."""
    return drive if step is None else decided(drive, [step.decision])
