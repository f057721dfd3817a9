"""What would narrow a parameter most: more driving, a sensor that is not there, or a figure of the vehicle file.

Every candidate is information that could be had, as rows on the unknowns with a spread that such a measurement has in
practice; what it would leave follows from the posterior's covariance without any new drive.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pipelines.joint.posterior import Joint, both_ways, central, values_at
from pipelines.joint.vehicle.laden import side_moment
from pipelines.joint.vehicle.outputs import body_at, roll_axis_of, roll_stiffness_of
from pipelines.joint.vehicle.poles import pole_drop
from pipelines.joint.vehicle.stated import LEVEL, shown_on_level_ground
from pipelines.models.roll import GRAVITY
from pipelines.results import FloatArray, NextMeasurement

LEAST_GAIN = 0.9
"""Share of the spread that an action must leave less than to be worth naming."""

Way = Literal["driving", "signal", "figure", "workshop"]
"""More of the same drive, a signal that the log lacks, a figure of the vehicle file, or a test that is no drive: the best of
each is named, as who asks can do one and not another."""

Seen = Callable[[Mapping[str, FloatArray]], list[FloatArray]]


@dataclass(frozen=True)
class Candidate:
    """Something to measure. seen: figures that it gives, (n,) each; std: of each, in its unit, or relative (a share).

    carriers: signals that are then there; a drive that has one of them already needs no such sensor. effort: what it leaves
    counts so many times as wide where actions are compared, so that two sensors are named where four tell little more.
    """

    way: Way
    action: str
    seen: Seen
    std: tuple[float, ...]
    relative: bool = True
    carriers: tuple[str, ...] = ()
    effort: float = 1.0


def _known(*names: str) -> Seen:
    return lambda v: [np.asarray(v[n]) for n in names]


def _scales(v: Mapping[str, FloatArray]) -> list[FloatArray]:
    body = body_at(v, {})
    return [body.mass * np.asarray(body.whole_x), body.mass * np.asarray(body.whole_y), np.asarray(body.mass)]


def _deflections(v: Mapping[str, FloatArray]) -> list[FloatArray]:
    """Pitch and roll in a metre per second squared, and how far each axle's springs are down under the load."""
    body = body_at(v, {})
    a, b = body.x, v["wheelbase"] - body.x
    pitch = 2 * (v["spring_front"] * a * a + v["spring_rear"] * b * b)
    carried = body.sprung - (v["empty_mass"] - v["unsprung_front"] - v["unsprung_rear"])
    return [
        np.asarray((body.moment - body.mass * (v["pitch_center_brake"] - pole_drop(v))) / pitch),
        np.asarray(body.sprung * (body.h - roll_axis_of(v, body)) / roll_stiffness_of(v)),
        np.asarray(9.81 * carried / (2 * (v["spring_front"] + v["spring_rear"]))),
    ]


def _rear_deflections(v: Mapping[str, FloatArray]) -> list[FloatArray]:
    """How far the rear springs come up in braking at 1 m/s², m, and how far they are down under the load."""
    body = body_at(v, {})
    length, rate = v["wheelbase"], 2 * v["spring_rear"]
    empty = v["empty_mass"] - v["unsprung_front"] - v["unsprung_rear"]
    before = (v["empty_mass"] * v["empty_x"] - v["unsprung_rear"] * length) / empty
    return [
        np.asarray((body.moment - body.mass * (v["pitch_center_brake"] - pole_drop(v))) / (length * rate)),
        np.asarray(GRAVITY * (body.sprung * body.x - empty * before) / (length * rate)),
    ]


def _roll(v: Mapping[str, FloatArray]) -> list[FloatArray]:
    body = body_at(v, {})
    return [np.asarray(body.sprung * (body.h - roll_axis_of(v, body)) / roll_stiffness_of(v))]


def _moment(v: Mapping[str, FloatArray]) -> list[FloatArray]:
    return [np.asarray(body_at(v, {}).moment)]


def _mass(v: Mapping[str, FloatArray]) -> list[FloatArray]:
    return [np.asarray(body_at(v, {}).mass)]


def _height(v: Mapping[str, FloatArray]) -> list[FloatArray]:
    return [np.asarray(body_at(v, {}).whole_h)]


def _paths(v: Mapping[str, FloatArray]) -> list[FloatArray]:
    """m a rad: what each axle's load takes off its roll stiffness, over that load."""
    body = body_at(v, {})
    front = body.sprung * (1 - body.x / v["wheelbase"])
    shares = {"front": front, "rear": body.sprung - front}
    return [np.asarray(side_moment(v, body, axle) / (GRAVITY * share)) for axle, share in shares.items()]


def _level(v: Mapping[str, FloatArray]) -> list[FloatArray]:
    return [shown_on_level_ground(key, v) for key in LEVEL]


CANDIDATES: tuple[Candidate, ...] = (
    Candidate("workshop", "weigh the loaded vehicle on wheel scales (0.3 %)", _scales, (6.0, 8.0, 5.0), False),
    Candidate("signal", "log drive and brake torque (2 %) with the longitudinal acceleration", _mass, (0.02,), True, ("torques",)),
    Candidate(
        "signal", "a suspension deflection sensor at each wheel (1.5 mm, 1 %)", _deflections, (0.015, 0.015, 0.15), True,
        ("spring deflections",), 1.15,
    ),
    Candidate(
        "signal", "suspension deflection sensors on the rear axle, as headlamp levelling has them (2 mm, 2 %)", _rear_deflections,
        (0.00025, 0.003), False, ("spring deflections", "front spring deflections", "rear spring deflections"),
    ),
    Candidate("signal", "log the roll angle or roll rate and corner at 0.3 g", _roll, (0.02,), True, ("horizon",)),
    Candidate("signal", "axle loads or tyre forces (1.5 %) in braking", _moment, (0.015,), True, ("axle loads", "tyre normal forces")),
    Candidate("workshop", "a tilt table or a raised-axle weighing (1 %)", _height, (0.01,)),
    Candidate("figure", "measured spring rates (0.5 %)", _known("spring_front", "spring_rear"), (0.005, 0.005)),
    Candidate("figure", "measured anti-roll bar rates (1 %)", _known("bar_front", "bar_rear"), (0.01, 0.01)),
    Candidate(
        "figure", "roll centre heights from the suspension's kinematics (5 mm)",
        _known("roll_center_front", "roll_center_rear"), (0.005, 0.005), False,
    ),
    Candidate(
        "figure", "pitch centre heights (anti-dive, anti-squat) from the suspension's kinematics (5 mm)",
        _known("pitch_center_brake", "pitch_center_drive"), (0.005, 0.005), False,
    ),
    Candidate(
        "figure", "wheel rates 50 mm above and below ride height and how far roll centres come down with the body, from a kinematics rig",
        _known("axis_sinks", "square_front", "square_rear", "cube_front", "cube_rear"), (0.25, 0.35, 0.35, 0.12, 0.12),
    ),
    Candidate(
        "figure", "what the wheels' loads take off the roll stiffness, from a kinematics rig (patch_path_front_mprad and _rear_, 25 mm a rad)", _paths,
        (0.025, 0.025), False,
    ),
    Candidate(
        "figure", "how far patches and wheel centres go along in pitch and braking, from a kinematics and a tyre rig (patch_path_pitch_mprad, "
        "wheel_recession_front and _rear, tire_longitudinal_rate_npm)", _known("pitch_path", "hubs_past", "patch_lag"), (0.01, 0.03, 0.002), False,
    ),
    Candidate("figure", "the tyres' lateral rate (10 %)", _known("patch_side"), (1.2,)),
    Candidate("figure", "the empty vehicle weighed (5 kg, 5 mm)", _known("empty_mass", "empty_x"), (0.003, 0.002)),
    Candidate("figure", "the empty vehicle's lateral CG place (2 mm)", _known("empty_y"), (0.002,), False),
    Candidate(
        "figure", "the load's mass (5 kg) and place (height, along, across: 5 cm) in [load]",
        _known("load", "load_h", "load_x", "load_y"), (5.0, 0.05, 0.05, 0.05), False,
    ),
    Candidate(
        "figure", "what the inertial unit shows on level ground (0.1 deg) in [sensors], imu_roll_deg and imu_pitch_deg", _level,
        (0.1, 0.1), False,
    ),
    Candidate(
        "figure", "what the deflection sensors show with the empty vehicle on level ground (0.3 mm) in [sensors], suspension_deflection_fl_m "
        "and its like", _known("zero_fl", "zero_fr", "zero_rl", "zero_rr"), (12.0, 12.0, 12.0, 12.0), False,
    ),
    Candidate("figure", "a measured roll inertia (2 %)", _known("roll_inertia"), (0.02,)),
    Candidate("figure", "damper rates from a test rig (3 %)", _known("bump_front", "rebound_front", "bump_rear", "rebound_rear"),
              (0.03, 0.03, 0.03, 0.03)),
    Candidate("figure", "the brakes' gain from a test (1 %)", _known("brake_gain", "brake_scale"), (0.01, 0.01)),
)  # fmt: skip

AGAIN: Mapping[str, str] = {
    "pitch": "twice as much braking and accelerating, or as much 1.4 times as hard",
    "axle": "twice as much braking and accelerating, or as much 1.4 times as hard, and twice the time at rest",
    "roll": "twice as much cornering, or as much 1.4 times as hard",
    "longitudinal": "twice as much braking and accelerating in a straight line, or as much 1.4 times as hard",
    "vertical": "twice the time at steady speed and at rest",
    "ride": "twice the distance on a rough road",
    "length": "twice the distance on a rough road",
}
"""What doubles a relation's information: it grows with the time and with the square of the motion."""


def _rows(joint: Joint, candidate: Candidate) -> FloatArray:
    """(m, k) derivative of what the measurement sees by u, in its own standard deviations."""
    moved = both_ways(joint.u)
    seen = np.array([np.broadcast_to(x, len(moved)) for x in candidate.seen(values_at(joint.known, moved))])
    std = np.array(candidate.std) * (np.abs(seen[:, 0]) if candidate.relative else 1.0)
    return np.asarray(central(seen) / np.maximum(std, 1e-12)[:, None])


def _with(covariance: FloatArray, rows: FloatArray) -> FloatArray:
    """Covariance after a measurement of rows with unit variance."""
    gain = covariance @ rows.T
    return np.asarray(covariance - gain @ np.linalg.solve(np.eye(len(rows)) + rows @ gain, gain.T))


def next_measurements(
    joint: Joint, gradients: Mapping[str, FloatArray], wider: Mapping[str, float]
) -> dict[str, tuple[NextMeasurement, ...]]:
    """For each parameter what would narrow it most, the best first. wider: as in `shares`."""
    there = {e.carrier for e in joint.evidence}
    options: list[tuple[Way, str, FloatArray, float]] = []
    for candidate in CANDIDATES:
        if there & {*candidate.carriers}:
            continue
        after = _with(joint.covariance, _rows(joint, candidate))
        options.append((candidate.way, candidate.action, after, candidate.effort))
    for kind in dict.fromkeys(e.kind for e in joint.evidence):
        rows = np.concatenate([p.slope for p in joint.parts if p.evidence.kind == kind])
        options.append(("driving", AGAIN[kind], _with(joint.covariance, rows), 1.0))
    found = {}
    for name, g in gradients.items():
        now = float(np.sqrt(g @ joint.covariance @ g))
        best: dict[Way, tuple[float, str, float]] = {}
        for way, action, covariance, effort in options:
            std = float(np.sqrt(max(float(g @ covariance @ g), 0.0)))
            if std < LEAST_GAIN * now and effort * std < best.get(way, (np.inf, "", np.inf))[2]:
                best[way] = (std, action, effort * std)
        # a workshop test beats nearly any drive, and is what one drives to be spared: it comes last
        ranked = sorted(best.items(), key=lambda item: (item[0] == "workshop", item[1][0]))
        found[name] = tuple(NextMeasurement(action, wider[name] * std) for _, (std, action, _) in ranked)
    return found
