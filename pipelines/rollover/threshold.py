"""The vehicle's limits in g for both sides, with the intervals that follow from the parameters' intervals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pipelines.models.roll import DEGREES
from pipelines.results import FloatArray, ParameterEstimate
from pipelines.rollover.body import Body, mean_track
from pipelines.rollover.draws import summary
from pipelines.rollover.limits import (
    SIDES,
    contact_limit,
    quasi_static_threshold,
    sensed,
    static_stability_factor,
    steady_roll,
    suspension_limit,
)
from pipelines.rollover_results import RolloverLimit, TurnSide
from pipelines.vehicles.vehicle import Vehicle

LARGEST = 10.0
_ROUNDS = 40


def self_consistent(
    limit: Callable[[FloatArray], FloatArray], gradient: FloatArray, start: FloatArray
) -> FloatArray:
    """The signed acceleration at which `limit` (of the roll) is met by the roll that the acceleration itself brings."""
    value, roll = start, steady_roll(start, gradient)
    for _ in range(_ROUNDS):
        value = 0.5 * (value + np.clip(limit(roll), -LARGEST, LARGEST))
        roll = np.clip(gradient * sensed(value, roll), -0.6, 0.6)
    return value


def thresholds(body: Body) -> dict[TurnSide, FloatArray]:
    """Draws (n,) of the quasi-static threshold of each side, in g, positive."""
    found: dict[TurnSide, FloatArray] = {}
    for side, sign in SIDES:
        drawn = quasi_static_threshold(
            sign, body.track, body.offset, body.height + body.spin, body.lever, body.gradient * body.stiffening,
            body.jacking, body.axis, body.tilt, body.give,
        )  # fmt: skip
        found[side] = drawn / body.model
    return found


def _both(
    name: str, title: str, equation: str, make: Callable[[float], FloatArray], body: Body, reason: str,
    reference: dict[TurnSide, float] | None = None,
) -> RolloverLimit:  # fmt: skip
    known = reference or {}
    told = body.told
    left, right = (
        summary(f"{name}_{side}_g", np.abs(make(sign)), told.status, reason, reference=known.get(side), sources=told.sources)
        for side, sign in SIDES
    )  # fmt: skip
    return RolloverLimit(name, title, equation, left, right)


def reference_thresholds(body: Body, vehicle: Vehicle) -> dict[TurnSide, float]:
    """The threshold from the reference's parameters, where it gives height and roll gradient; else empty."""
    truth = vehicle.reference
    if "cg_height_m" not in truth or "roll_gradient_degpg" not in truth:
        return {}
    b = body.nominal()
    height = truth["cg_height_m"]
    found: dict[TurnSide, float] = {}
    for side, sign in SIDES:
        value = quasi_static_threshold(
            sign, b.track, truth.get("cg_lateral_offset_m", 0.0), height + b.spin, b.lever + height - b.height,
            truth["roll_gradient_degpg"] / DEGREES * b.stiffening, b.jacking, b.axis, b.tilt, b.give,
        )  # fmt: skip
        found[side] = float(value[0])
    return found


def _rigid(factor: ParameterEstimate) -> RolloverLimit:
    """The static stability factor as a limit: the same to both sides."""
    left, right = (replace(factor, name=f"rigid_{side}_g", reference=None) for side, _ in SIDES)
    return RolloverLimit("rigid", "Rigid vehicle, CG in the middle", "(157)", left, right)


def limits(body: Body, vehicle: Vehicle) -> tuple[RolloverLimit, ...]:
    """From the rigid vehicle to the one that leans, jacks and whose wheels spin."""
    status = body.told.status.replace("_", " ")
    roll = "" if body.gradient_known else "; the roll gradient is a usual one"
    drawn = thresholds(body)

    def springs(sign: float) -> FloatArray:
        return self_consistent(
            lambda phi: np.asarray(suspension_limit(sign, body.track, body.offset, body.arm, phi)),
            body.gradient, sign * np.ones_like(body.height),
        )  # fmt: skip

    def contact(sign: float) -> FloatArray:
        return self_consistent(
            lambda phi: np.asarray(contact_limit(sign, body.track, body.offset, body.height, body.lever, phi)),
            body.gradient, sign * np.ones_like(body.height),
        )  # fmt: skip

    return (
        _rigid(stability_factor(body, vehicle)),
        _both("suspension", "Springs of the inner side carry nothing", "(155)", springs, body,
              f"height over the roll axis{roll}; the load at the road is more than that in the springs"),
        _both("contact", "Inner wheels carry nothing, with CG offset and roll", "(156), (163)", contact, body,
              f"CG height {status}{roll}"),
        _both("quasi_static", "Threshold: jacking, giving tyres and spinning wheels too", "(163) extended",
              lambda sign: drawn["left" if sign > 0 else "right"], body,
              f"CG height {status}{roll}; the body rises on its roll centres, tyres give sideways and the wheels' spin adds to the height",
              reference_thresholds(body, vehicle)),
    )  # fmt: skip


def stability_factor(body: Body, vehicle: Vehicle) -> ParameterEstimate:
    """T / (2 h) with the mean of the two tracks, as NHTSA has it; with the body's where the file has none."""
    told, track = body.told, mean_track(vehicle)
    middle = float(np.median(body.track))
    value = middle if track is None else track.value
    # the same draws of the height as everything else; the track's own error is that of both axles
    width = value * body.track / middle
    true_height = vehicle.reference.get("cg_height_m")
    return summary(
        "static_stability_factor", np.asarray(static_stability_factor(width, body.height)), told.status,
        f"track / (2 × CG height); the CG height is {told.status.replace('_', ' ')}",
        reference=None if not true_height else value / (2 * true_height), sources=told.sources,
    )  # fmt: skip
