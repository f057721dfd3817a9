"""The roll motion as evidence: the coefficients a, b, c of c p'' + b p' + a p = f, and what a vehicle would make of them.

With κ = K / (K + K_tyre), M the moment of a unit of lateral acceleration about the axis (tyres' lean included):

    a = K (1 - κ) / M    b = D (1 - κ)² m h / M²    c = (I + z (M - κ m_u R)) / M - κ (1 + γ) b² / ((1 - κ) a)

I: of the body about its CG, z: its height above the accelerometer. Against the axles K, D and M are the suspension's own, and all
three grow with the share of the travel that the deflections show (1 / their scale). D: of the dampers, and of dry friction by the
energy that it takes at the drive's own speeds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pipelines.estimators.roll_map.answers import Coefficients, likelihood_of, quick_enough
from pipelines.estimators.roll_map.tyre_share import off_banked_roads, turns_with_the_road
from pipelines.evidence import Evidence, Unknown, Values
from pipelines.joint.mirror import QUICK_ROLL
from pipelines.joint.vehicle.body import hub_height
from pipelines.joint.vehicle.book import AXLES
from pipelines.joint.vehicle.laden import axis_lever, roll_springs
from pipelines.joint.vehicle.outputs import (
    body_at,
    inertias_of,
    roll_damping_of,
    roll_stiffness_of,
)
from pipelines.joint.vehicle.unknowns import CORNERS
from pipelines.joint.ways.travel_scale import GYRO_BESIDE_SPRINGS
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle

LEAST = 0.1
"""Information, in units of the fit's own weak priors, below which a direction is not handed on."""

RUBS = Unknown("roll_rubs", 0.5, 0.4)
"""Share of the dry friction that takes energy in roll: all of it where it slides at every turn, little where bushings and leaves give
by more than the drive moves them."""

DEPENDS = (
    "wheelbase", "track_front", "track_rear", "spring_base_front", "spring_base_rear", "radius", "hub_low", "empty_mass", "empty_x", "empty_y", "empty_h",
    "unsprung_front", "unsprung_rear", "load", "load_x", "load_y", "load_h", "load_wide", "spring_front", "spring_rear",
    "square_front", "square_rear", "cube_front", "cube_rear", "free_front", "free_rear", "stop_front", "stop_rear",
    "bar_front", "bar_rear", "bump_front", "bump_rear", "friction_front", "friction_rear", "rebound_front", "rebound_rear", "roll_center_front",
    "roll_center_rear", "roll_inertia", "imu_h", "tyre_rate", "track_grows", "axis_sinks", "sinks_front", "sinks_rear", "side_path", "wheel_plane", "paths_told", "path_front", "path_rear", "lean_path", "camber",
)  # fmt: skip

GAIN = "rate_gain"
SCALES = tuple(f"scale_{wheel}" for wheel in CORNERS)


@dataclass(frozen=True)
class Motion:
    """How the drive moved the body.

    banked_share: of the lateral acceleration's power, what bends of a road may have made. friction: s/rad, what dry friction
    of 1 N m in roll adds to the damping at this drive's own speeds (`motion.friction_damping`).
    """

    against_axles: bool
    banked_share: float
    friction: float


def _damping(values: Values, motion: Motion) -> FloatArray:
    """Of the suspension as this drive moved it, N m s/rad: of the dampers, and of dry friction, which no log tells from them."""
    held = sum(
        values[f"friction_{axle}"] * values[f"spring_base_{axle}"] * values[f"track_{axle}"] for axle in AXLES
    )
    return np.asarray(roll_damping_of(values) + values[RUBS.name] * motion.friction * held)


def _coefficients(values: Values, motion: Motion) -> list[FloatArray]:
    """a, b, c and the rate gain of the vehicles."""
    body = body_at(values, {})
    stiffness = np.asarray(roll_springs(values, body, roll_stiffness_of(values)))
    damping = _damping(values, motion)
    axis = np.asarray(axis_lever(values, np.asarray(body.whole_x) / values["wheelbase"]))
    own = body.sprung * (body.h - axis)
    hub = body.unsprung * np.asarray(hub_height(values))
    ground = body.sprung * axis + hub
    width = 0.5 * (np.asarray(values["track_front"]) + values["track_rear"])
    kappa = stiffness / (stiffness + values["tyre_rate"] * width**2)
    moment = own + kappa * ground
    reach = body.h - np.asarray(values["imu_h"])
    road_a, road_b = stiffness * (1 - kappa) / moment, damping * (1 - kappa) ** 2 * own / moment**2
    share = (1 - kappa) * own / moment
    if motion.against_axles:
        c = (inertias_of(values)[0] / own + reach) / share
        # what is measured is the angle over the deflections' scale
        scale = np.mean(np.broadcast_arrays(*(values[name] for name in SCALES)), axis=0)
        return [scale * part for part in (stiffness / own, damping / own, np.asarray(c), 1 / share)]
    inertia = (inertias_of(values)[0] + reach * (moment - kappa * hub)) / moment
    return [
        road_a,
        road_b,
        np.asarray(inertia - kappa * (1 + ground / own) / (1 - kappa) * road_b**2 / road_a),
        np.asarray(1 / share),
    ]


def _predict(weights: FloatArray, motion: Motion) -> Callable[[Values], FloatArray]:
    count = weights.shape[1]

    def predict(values: Values) -> FloatArray:
        return np.asarray(weights @ np.array(np.broadcast_arrays(*_coefficients(values, motion)[:count])))

    return predict


def _whitened(coefficients: Coefficients, against_axles: bool) -> tuple[FloatArray, FloatArray] | None:
    """Independent combinations (m, k) of the coefficients, each of unit variance, and their values (m,)."""
    likelihood = likelihood_of(coefficients, against_axles=against_axles)
    scale = coefficients.prior_std
    values, vectors = np.linalg.eigh(likelihood.information * np.outer(scale, scale))
    kept = values > LEAST
    if not kept.any():
        return None
    root = np.sqrt(values[kept])
    observed = (vectors.T @ (scale * likelihood.linear))[kept] / root
    return (root[:, None] * vectors.T[kept]) / scale, observed


def _some(coefficients: Coefficients, chosen: list[int]) -> Coefficients:
    """The coefficients with all but the chosen ones as unknown as before."""
    wide = np.diag((100 * coefficients.prior_std) ** 2)
    wide[np.ix_(chosen, chosen)] = coefficients.covariance[np.ix_(chosen, chosen)]
    return replace(coefficients, covariance=wide)


def evidence_of(
    coefficients: Coefficients, motion: Motion, vehicle: Vehicle, source: str
) -> tuple[Evidence, ...]:
    """The coefficients' likelihood without the fit's own priors.

    Against the axles the steady part (a) stands for itself: it is the roll balance by deflections, which other
    estimators see as well; damping and inertia are not. Empty where the motion told nothing. Without the mass the gyro's gain over
    the springs is all that is handed on: of how tyres share the roll, or the deflections' scale.
    """
    gyro = motion.against_axles and GAIN in coefficients.names
    if gyro and turns_with_the_road(coefficients, motion.banked_share):
        gyro = False
        coefficients = _some(coefficients, [0, 1, 2])
    if vehicle.get("mass_kg") is None:
        if not gyro:
            return ()
        coefficients = _some(coefficients, [coefficients.names.index(GAIN)])
    # a motion that is too slow for them gives damping and inertia with the model's errors and without their spread
    quick = zip((1, 2), quick_enough(coefficients), strict=True)
    slow = [i for i, told in quick if not told]
    coefficients = _some(coefficients, [i for i in range(len(coefficients.mean)) if i not in slow])
    parts = [("horizon", "roll motion against the horizon", coefficients)]
    if motion.against_axles:
        coefficients = off_banked_roads(coefficients, motion.banked_share)
        rest = list(range(1, len(coefficients.mean)))
        parts = [
            ("spring deflections", "steady roll against the axles", _some(coefficients, [0])),
            (
                GYRO_BESIDE_SPRINGS if gyro else "quick spring deflections",
                "quick roll motion against the axles",
                _some(coefficients, rest),
            ),
        ]
    depends = (*DEPENDS, *SCALES) if motion.against_axles else DEPENDS
    given = {} if 2 in slow else {QUICK_ROLL: 1.0}
    found = []
    for carrier, title, part in parts:
        seen = _whitened(part, motion.against_axles)
        if seen is not None:
            weights, observed = seen
            predict = _predict(weights, motion)
            found.append(
                Evidence(
                    "roll",
                    carrier,
                    title,
                    source,
                    observed,
                    np.eye(len(observed)),
                    predict,
                    (*depends, RUBS.name),
                    (RUBS,),
                    given,
                )
            )
    return tuple(found)
