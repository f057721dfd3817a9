"""Does what the wheels carry change from rest to rest, beyond what friction, slopes and drift explain?

What they carry at stand i is, wheel by wheel and for their sum,

    F_i = c + b_x f_x + b_y f_y + d_1 t + d_2 t² + sum_k s_k [i >= k] + e_i

with f_x, f_y what the accelerometers read (a slope, against held brakes and by links that lift), t over the drive in -1 to 1 (a sensor
that drifts), and e_i what dry friction holds at that rest. Steps are fitted as `pipelines.prepare.steps` says. A step is a change of load
where s is beyond doubt, where the stands right before and after it show it too (a drift does not), and where more than one wheel takes
part (a body does not sink at one wheel alone; a sensor's lever slips so).
"""

from __future__ import annotations

import math

import numpy as np

from pipelines.joint.vehicle.suspension import STUCK
from pipelines.models.roll import GRAVITY
from pipelines.prepare.load_change import LoadStep
from pipelines.prepare.stands import Stands, spring_rates, weight_of
from pipelines.prepare.steps import Levels, StepFit, fit_steps, make_levels, steps_beyond_doubt
from pipelines.results import FloatArray
from pipelines.vehicles.spring_base import rigid_axle
from pipelines.vehicles.vehicle import Vehicle

STUCK_LEAVES = 0.03
"""Friction at rest over the load of a vehicle with leaf springs (of others: `joint.vehicle.suspension.STUCK`)."""
CONTACT = 0.004
"""Scatter of loads that are measured at the road, where no friction is in between, over the weight."""
SLOPE, DRIFT, BENT = 0.4, 0.015, 0.0075
"""Spreads over the weight: what a slope of 1 g takes from a wheel or the sum; drift over half a drive, even and bent."""
FITTED = 4
"""Of the level, the step, two slopes and two drifts as many are told by the rests, as a rule."""
LEAST = 0.025
"""Of the weight: less is a tank of fuel, or somebody who leans out."""
ALONE = 0.75
"""Share of all wheels' steps that no single wheel takes: a load above one wheel lifts another one by the body's lean."""
APART = (-0.5, 1.5)
"""Share of the rear axle: of loads behind it or ahead of the front one, as far as a vehicle reaches."""
AGREES = 0.5
"""Where several carriers are there, each has to show that share of the step."""


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


def _levels(stands: Stands, carrier: str, vehicle: Vehicle) -> Levels:
    parts = stands.loads[carrier]
    stuck = _friction(stands, carrier, vehicle)
    slopes = _nuisances(stands, weight_of(stands, carrier, vehicle))
    # friction holds all of a rest alike; pieces of one rest differ by half as much (somebody moves, a brake is let go)
    own = stuck**2 * (stands.rest[:, None] == stands.rest[None, :]) + (0.5 * stuck) ** 2 * np.eye(len(parts))
    return make_levels(np.column_stack([parts.sum(axis=1), parts]), stands.rest, own, slopes, stuck, FITTED)


def _of_a_body(fit: StepFit) -> bool:
    """Whether the wheels' steps are those of a body with more or less on it, and not of one sensor."""
    rear = float(fit.parts[len(fit.parts) // 2 :].sum()) / fit.total
    if not APART[0] < rear < APART[1]:
        return False
    size = np.abs(fit.parts)
    return len(size) == 2 or float(size.max()) < ALONE * float(size.sum())


def changes_at_rest(stands: Stands, vehicle: Vehicle) -> tuple[LoadStep, ...]:
    """The changes of load between stands of two rests or more, in the order of time."""
    carrier, *others = stands.loads
    least = LEAST * weight_of(stands, carrier, vehicle)
    fits = steps_beyond_doubt(_levels(stands, carrier, vehicle), least, _of_a_body)
    firsts = [fit.first for fit in fits]
    for other in others if fits else ():
        again = fit_steps(_levels(stands, other, vehicle), firsts)
        if any(
            a.total * np.sign(fit.total) < AGREES * abs(fit.total) for a, fit in zip(again, fits, strict=True)
        ):
            return ()
    # what the springs' rates are unsure by, and a twentieth for springs that stiffen and sensors' scales
    rates = spring_rates(vehicle)[1] if carrier == "suspension_deflection" else 0.0
    return tuple(_told(fit, stands, carrier, math.hypot(0.05, rates)) for fit in fits)


def _told(fit: StepFit, stands: Stands, carrier: str, unsure: float) -> LoadStep:
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
