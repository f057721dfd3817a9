"""Wu et al.'s truck runs: three accelerations and two decelerations, on the flat and over a slope."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.manoeuvres.base import Options, Scenario, VehicleFigures
from pipelines.simulation.manoeuvres.script import STEP_S, Script, proving_ground
from pipelines.simulation.records import GRAVITY
from pipelines.simulation.roads.profile import altitude_m, eased_in, even_places

_START_MPS = 15 / 3.6
_FRICTION = 0.85
_PULSES = ((1.5, 4.5, 2.1), (6.5, 3.5, -1.7), (10.5, 4.5, 1.9), (15.5, 4.0, -1.6), (20.5, 3.5, 1.7))
"""Start [s], length [s] and peak [m/s²] of each pulse: three up, two down within 25 s, between +2.1 and -1.7 m/s²."""
STEEPEST_RAD = np.radians(6.0)
RISE_M = 8.0


def accelerations(time_s: FloatArray) -> FloatArray:
    """The acceleration [m/s²] the driver aims at: raised-cosine pulses with flat tops, (n,)."""
    out = np.zeros(len(time_s))
    for start, length, peak in _PULSES:
        x = np.clip((time_s - start) / length, 0.0, 1.0)
        out += peak * np.clip(1.5 * np.sin(np.pi * x), 0.0, 1.0)
    return out


def _speeds(vehicle: VehicleFigures, options: Options, friction: float, grade_mps2: float) -> FloatArray:
    """Speeds over one run, never below 2 m/s; peaks are lowered where the power or the grip is short.

    The paper's rear wheels slip by up to 0.08 at its peaks: 85 % of the grip may be used.
    """
    start = options.speed(_START_MPS)
    t = even_places(round(25.0 / STEP_S) + 1, STEP_S)[1:]
    wanted = options.severity * accelerations(t)
    speed = np.maximum(start + np.cumsum(wanted) * STEP_S, 2.0)
    most = np.array([vehicle.acceleration_mps2(float(v), friction, 0.85) for v in speed[::10]]) - grade_mps2
    most = np.maximum(np.interp(np.arange(len(speed)), np.arange(0, len(speed), 10), most), 0.1)
    return np.maximum(start + np.cumsum(np.minimum(wanted, most)) * STEP_S, 2.0)


def _grade(place_m: FloatArray, steepest_rad: float, start_m: float, room_m: float) -> FloatArray:
    """A hill within the room there is: eased up to the steepest grade and back to level, a short top, the same down.

    8 m high where the room allows it, else lower: the angle stays.
    """
    # each side is eased over a quarter of its length at both ends, so that its mean grade is 3/4 of the steepest
    length = min(RISE_M / np.sin(0.75 * steepest_rad), (room_m - 3.0) / 2)
    grade = np.zeros(len(place_m))
    for side, begin in ((1.0, start_m), (-1.0, start_m + length + 3.0)):
        x = (place_m - begin) / length
        grade += side * steepest_rad * eased_in(x, 0.25) * eased_in(1 - x, 0.25)
    return grade


def _run(
    name: str, title: str, vehicle: VehicleFigures, options: Options, rng: np.random.Generator, slope: bool
) -> Scenario:
    """One run of 25 s from a rolling start, or as many as fit the duration, each back at the starting speed."""
    start = options.speed(_START_MPS)
    steepest = STEEPEST_RAD * min(options.severity, 2.0) if slope else 0.0
    friction = options.grip(_FRICTION)
    speeds = _speeds(vehicle, options, friction, 0.5 * GRAVITY * float(np.sin(steepest)))

    def write(repeats: int) -> Script:
        script = Script(vehicle, friction, start)
        for k in range(repeats):
            if k:
                script.reach(start, 1.5)
                script.hold(2.0)
            script.follow(speeds)
        return script

    repeats = 1
    if options.duration_s is not None:
        unit = write(2).duration_s - 25.0
        repeats = 1 + max(int((options.duration_s - 25.0) / unit), 0)
    script = write(repeats)
    road = proving_ground(script.distance_m, _FRICTION, options, vehicle, rng)
    notes = [f"{repeats} run(s) of 25 s from {3.6 * start:.0f} km/h, rolling start"]
    if slope:
        place = even_places(len(road.grade_rad), road.step_m)
        run = write(1).distance_m
        grade = np.zeros(len(place))
        for k in range(repeats):
            grade += _grade(place, float(steepest), 5.0 + k * (script.distance_m / repeats), 0.93 * run)
        road = replace(road, grade_rad=grade)
        notes.append(
            f"{run:.0f} m with a hill of {np.max(altitude_m(road)):.1f} m, {np.degrees(steepest):.1f} deg at most"
        )
    return Scenario(name, title, "Wu et al. section 4", script.demand(), road, tuple(notes))


def truck_flat(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Truck on the flat: three accelerations, two decelerations in 25 s.

    Wu et al., simulation on a flat road: 15 km/h at the start (rolling: the paper's run does not begin at rest), friction
    0.85, acceleration between +2.1 and -1.7 m/s². When each happens is read off no table: ours are even pulses.
    """
    return _run("truck_flat", "Truck, flat road", vehicle, options, rng, slope=False)


def truck_slope(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Truck over a hill of 8 m and 6 degrees, else as on the flat.

    Wu et al., simulation on a sloped road (their Fig 8): the slope's height is 8 m and its angle 6 degrees at most.
    """
    return _run("truck_slope", "Truck, sloped road", vehicle, options, rng, slope=True)
