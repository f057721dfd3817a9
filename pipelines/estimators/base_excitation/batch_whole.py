"""What the heave of four corners tells: why it tells nothing, masses and place with their spreads, the damping."""

from __future__ import annotations

import math

import numpy as np

from pipelines.estimators.base_excitation.answers import BodyFigures, answer, figure
from pipelines.estimators.base_excitation.batch_heave import HARDENING, NAMES, HeaveFit
from pipelines.estimators.base_excitation.batch_parts import (
    HEAVE_EXPLAINED,
    LEAST_EXPLAINED,
    MOST_STIFFER,
    not_rough,
)
from pipelines.estimators.base_excitation.data import RideData, stiffer
from pipelines.results import FloatArray, ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle

MODEL_ERROR = 0.015
"""What is left of curved springs and dampers, links and tilt on a whole vehicle, as a share of the sprung mass."""

PLACE_ERROR = 0.006
"""The same for the CG's place, as a share of wheelbase and track."""

GENTLE_MPS2 = 8.0
"""RMS of the hubs below which these errors are the larger share: friction, tilt and the links' forces have a size of their own."""


def rougher(hub_rms: float) -> float:
    """Factor on the model's errors for how lively the drive was."""
    return math.hypot(1.0, GENTLE_MPS2 / max(hub_rms, 0.1))


HEAVE_DAMPING_ERROR = 0.25
USUAL_HARDENING, STOP_SHARE = 0.3, 0.6
"""Stiffening in deep compression that progressive springs have; what of a further one may be there at rest already."""

SQRT_12 = math.sqrt(12)
LEAST_CLARITY = 0.5
"""Share of the masses' information that must not be accelerometer noise."""


def refused(data: RideData, fit: HeaveFit, vehicle: Vehicle) -> str:
    """Why the heave of this drive tells no mass; "" where it does."""
    unlike = not_rough(data)
    if unlike:
        return unlike
    if fit.clarity < LEAST_CLARITY:
        return "the body's acceleration is mostly sensor noise; drive over rough ground"
    if fit.explained < LEAST_EXPLAINED or not fit.plausible:
        return (
            "body and hub accelerations do not follow from one another: check channels, signs and wheels; "
            "drive over rough ground"
        )
    if fit.explained < HEAVE_EXPLAINED:
        return (
            f"springs and dampers explain {fit.explained:.0%} of the heave only ({HEAVE_EXPLAINED:.0%} on rough ground); dry friction, "
            "bends or brakes may have too large a share, or hubs that shake quicker than half the log's rate are folded into it, where nothing "
            "filters before the sampling; drive straight over rough ground, and record filtered or quicker"
        )
    more = stiffer_axles(fit, vehicle)
    if max(more) > MOST_STIFFER:
        axle = "front" if more[0] > more[1] else "rear"
        return (
            f"the {axle} suspension may be {max(more):.0%} stiffer than its springs (high roll centre, or resting on its "
            "stops), and the mass comes in proportion to the stiffness"
        )
    return ""


def stiffer_axles(fit: HeaveFit, vehicle: Vehicle) -> tuple[float, float]:
    """How much stiffer than its springs each axle may be: guides and bushes, and stops that it seems to rest on."""
    ahead, behind = stiffer(float(fit.values[0]), float(fit.values[1]), vehicle)
    hard = [STOP_SHARE * max(float(v) - USUAL_HARDENING, 0.0) for v in fit.values[HARDENING : HARDENING + 2]]
    return ahead + hard[0], behind + hard[1]


def body_of(fit: HeaveFit, covariance: FloatArray, vehicle: Vehicle, hub_rms: float) -> BodyFigures:
    """Masses and place with their spreads; covariance with the springs' part. hub_rms: how lively the drive was, m/s²."""
    model, place = (rougher(hub_rms) * share for share in (MODEL_ERROR, PLACE_ERROR))
    seen_front, seen_rear, lateral = (float(v) for v in fit.values[:3])
    more = stiffer_axles(fit, vehicle)
    # bushes and guides add stiffness and never take any: the middle of what they may add
    front, rear = seen_front * (1 + more[0] / 2), seen_rear * (1 + more[1] / 2)
    sprung = front + rear
    doubt = (more[0] * seen_front / SQRT_12, more[1] * seen_rear / SQRT_12)

    def spread(slopes: tuple[float, float, float], floor: float) -> float:
        w = np.array(slopes)
        return math.hypot(math.sqrt(float(w @ covariance[:3, :3] @ w)), floor)

    behind, left = rear / sprung, lateral / sprung
    uneven = behind * (1 - behind) * max(more) / SQRT_12
    return BodyFigures(
        front_kg=front,
        rear_kg=rear,
        front_std=spread((1, 0, 0), math.hypot(model * front, doubt[0])),
        rear_std=spread((0, 1, 0), math.hypot(model * rear, doubt[1])),
        sum_std=spread((1, 1, 0), math.hypot(model * sprung, sum(doubt))),
        upwards=0.0,
        behind=(
            behind,
            spread((-behind / sprung, (1 - behind) / sprung, 0), math.hypot(place, uneven)),
        ),
        left=(left, spread((-left / sprung, -left / sprung, 1 / sprung), place)),
        said=(
            f"heave of four corners over {fit.blocks.count} blocks of {fit.blocks.rows / fit.blocks.rate_hz:g} s; bushes "
            f"and guides may stiffen the suspension by up to {more[0]:.0%} in front and {more[1]:.0%} behind, half of "
            "which is allowed for"
        ),
    )


def mean_damping(fit: HeaveFit, covariance: FloatArray, vehicle: Vehicle, source: str) -> ParameterEstimate:
    """Mean damping of a wheel; covariance with the springs' part. source: the estimator's name."""
    damping = float(np.mean(fit.values[3:7]))
    weights = np.zeros(len(NAMES))
    weights[3:7] = 0.25
    std = math.hypot(math.sqrt(float(weights @ covariance @ weights)), HEAVE_DAMPING_ERROR * damping)
    return answer(
        "suspension_damping_nspm",
        figure(damping, std),
        vehicle,
        source,
        "mean of all wheels and directions, at the speeds that the dampers met: blow-off lowers it",
    )
