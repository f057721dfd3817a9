"""A drive whose load changed holds two vehicles or more: what rests on all of it is no surer than the way from one to the other.

With the change dm of a mass m (from the lightest to the heaviest of several), the share r of it on the rear axle and the wheelbase L, half of what the change makes goes into each
spread (so that 95 % intervals about either state or between them hold both):

    mass, sprung mass               dm / 2
    CG to front axle                dm / (2 m) · |r L - x|
    lateral place                   dm / (2 m) · |y_l - y|, with y_l by the wheels' sides; 0.25 tracks at least
    heights, roll and pitch arm     dm / (2 m) · REACH · the height or arm: a load lies up to that far above or below the CG
    corner masses, tyre loads       half of that axle's change: between its even half at both and all of it at one
    inertias                        dm / 2 · (r L - x)² in pitch, dm / 2 · (0.25 tracks)² and the mass's own share in roll
    roll gradient                   its value · dm / (2 m) · (1 + REACH)
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipelines.models.roll import GRAVITY
from pipelines.prepare.load_change import LoadStep
from pipelines.results import JointVerdict, Learned, ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle
from pipelines.verdict.widened import widened

REACH = 0.6
"""How far from the CG's height a load lies, over the height: a roof's at 2.5 times it is rarer than seats and boots at 1.1 to 1.6."""
SIDE = 0.25
"""Of the track: how far off the middle a load may lie where springs hardly show it."""
USUAL_MASS, USUAL_LENGTH, USUAL_TRACK = 1800.0, 2.7, 1.55

HEIGHTS = ("cg_height_m", "sprung_cg_height_m", "roll_arm_m", "pitch_arm_m")


@dataclass(frozen=True)
class _About:
    """The vehicle as far as the spreads need it: mass kg, CG behind the front axle, left of the middle, wheelbase and track, m."""

    mass: float
    x: float
    y: float
    length: float
    track: float


def _about(verdict: Mapping[str, ParameterEstimate], vehicle: Vehicle) -> _About:
    def told(name: str, usual: float) -> float:
        entry = verdict.get(name)
        if entry is not None and entry.value is not None and math.isfinite(entry.value):
            return entry.value
        stated = vehicle.get(name)
        return usual if stated is None else stated.value

    length = told("wheelbase_m", USUAL_LENGTH)
    return _About(
        max(told("mass_kg", USUAL_MASS), 1.0),
        told("cg_to_front_axle_m", 0.46 * length),
        told("cg_lateral_offset_m", 0.0),
        length,
        told("track_front_m", USUAL_TRACK),
    )


def half_of_it(name: str, value: float, step: LoadStep, about: _About) -> float | None:
    """Half of what the change makes of a parameter (module's head), in its own unit; None for what does not hang on the load."""
    dm = step.most_kg
    share = dm / (2 * about.mass)
    # where no wheel tells it, it may lie above either axle
    places = (0.0, 1.0) if step.rear is None else (step.rear,)
    off = max(abs(rear * about.length - about.x) for rear in places)
    if name in ("mass_kg", "sprung_mass_kg"):
        return 0.5 * dm
    if name == "cg_to_front_axle_m":
        return share * off
    if name == "cg_lateral_offset_m":
        # springs show the side less than it is: bars hold a part of the lean
        measured = 0.5 if step.left is None else step.left
        return share * max(abs((measured - 0.5) * about.track - about.y), SIDE * about.track)
    if name in HEIGHTS:
        return share * REACH * abs(value)
    if name == "roll_gradient_degpg":
        return share * (1 + REACH) * abs(value)
    if name == "pitch_inertia_kgm2":
        return 0.5 * dm * off**2
    if name == "roll_inertia_kgm2":
        return 0.5 * dm * (SIDE * about.track) ** 2 + 0.5 * share * abs(value)
    for start, unit in (("corner_mass_", 1.0), ("tire_normal_force_", GRAVITY)):
        if name.startswith(start):
            behind = name.removeprefix(start).startswith("r")
            at = max(abs(rear if behind else 1 - rear) for rear in places)
            return 0.5 * unit * dm * max(at, 0.1)
    return None


def holding_both_loads(
    verdict: Mapping[str, ParameterEstimate], step: LoadStep | None, vehicle: Vehicle
) -> dict[str, ParameterEstimate]:
    """The verdict, where what hangs on the load is at best weak, with half of what the load changes in its spread."""
    found = dict(verdict)
    if step is None:
        return found
    about = _about(verdict, vehicle)
    for name, entry in verdict.items():
        if entry.value is None or entry.std is None or entry.status == "not_identifiable":
            continue
        half = half_of_it(name, entry.value, step, about)
        if half is None:
            continue
        words = f"{step.found}: half of what that changes is in the spread"
        found[name] = widened(entry, math.hypot(entry.std, half), words, opens=True)
    return found


def taught_with_both_loads(
    joint: JointVerdict | None, step: LoadStep | None, verdict: Mapping[str, ParameterEstimate]
) -> JointVerdict | None:
    """What the drive taught, with as many bits as the widened verdict has: no measurement narrows a drive of two loads, and no
    density of one load is drawn."""
    if joint is None or step is None:
        return joint
    learned: dict[str, Learned] = dict(joint.learned)
    for name, entry in joint.learned.items():
        told = verdict.get(name)
        if told is None or told.std is None or not told.reason.startswith(step.found):
            continue
        bits = max(math.log2(entry.prior.std / told.std), 0.0)
        none = np.zeros(0)
        learned[name] = replace(entry, bits=bits, next=(), grid=none, prior_density=none, density=none)
    return replace(joint, learned=learned)
