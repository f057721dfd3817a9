"""What the ride told, for the joint posterior: masses as the accelerometers see them at the springs that were assumed.

A mass comes in proportion to the spring rate that is put in. The rates are unknowns of the joint, so that the evidence holds
the fitted masses with chance and model error alone, and their prediction moves with the springs: with bushes that stiffen
them (known to this relation alone) and with springs that are stiffer under the load than empty.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.estimators.base_excitation.batch_heave import NAMES, HeaveFit
from pipelines.estimators.base_excitation.batch_whole import (
    HEAVE_DAMPING_ERROR,
    MODEL_ERROR,
    PLACE_ERROR,
    SQRT_12,
    rougher,
    stiffer_axles,
)
from pipelines.estimators.base_excitation.data import RideData, axle_of
from pipelines.evidence import Evidence, FloatArray, Unknown, Values
from pipelines.joint.from_parameters import direct, evidence_of, loaded_body
from pipelines.joint.vehicle.laden import rate_under_load
from pipelines.joint.vehicle.unknowns import AXLES
from pipelines.vehicles.vehicle import Vehicle

SOURCE = "base_excitation_batch"
CARRIER = "hub accelerations"
BODY = (
    "empty_mass", "empty_x", "empty_y", "load", "load_x", "load_y", "unsprung_front", "unsprung_rear", "wheelbase",
)  # fmt: skip
SPRINGS = tuple(f"{name}_{axle}" for axle in AXLES for name in ("spring", "square", "cube", "free", "stop"))
DAMPERS = tuple(f"{name}_{axle}" for axle in AXLES for name in ("rebound", "bump"))


@dataclass(frozen=True)
class CornerSeen:
    """One wheel, or an axle's two as one (wheels): mass in kg a wheel, at `spring_npm`; std: of chance and coupling."""

    wheels: tuple[str, ...]
    mass: float
    std: float
    spring_npm: float


def _masses(values: Values) -> list[float | FloatArray]:
    """Sprung mass over the front and the rear axle, and sprung mass times lateral place over the mean track, kg."""
    body = loaded_body(values)
    rear = body.sprung * body.x / values["wheelbase"]
    track = 0.5 * (values["track_front"] + values["track_rear"])
    return [body.sprung - rear, rear, body.sprung * body.y / track]


def _heave_covariance(fit: HeaveFit, pick: FloatArray, hub_rms: float) -> FloatArray:
    """(4, 4) of the three masses and the mean damping: chance, and what the model leaves out."""
    front, rear, _ = (float(v) for v in fit.values[:3])
    sprung, damping = front + rear, float(np.mean(fit.values[3:7]))
    grown = rougher(hub_rms)
    moved = grown * PLACE_ERROR * sprung
    errors = [
        grown * MODEL_ERROR * np.array([front, rear, fit.values[2], 0.0]),
        moved * np.array([-1.0, 1.0, 0.0, 0.0]),
        moved * np.array([0.0, 0.0, 1.0, 0.0]),
        HEAVE_DAMPING_ERROR * damping * np.array([0.0, 0.0, 0.0, 1.0]),
    ]
    return pick @ fit.covariance @ pick.T + sum(np.outer(e, e) for e in errors)


def heave_evidence(fit: HeaveFit, data: RideData, vehicle: Vehicle) -> Evidence:
    """Of four corners: three masses and the mean damping."""
    pick = np.zeros((4, len(NAMES)))
    pick[0, 0] = pick[1, 1] = pick[2, 2] = 1.0
    pick[3, 3:7] = 0.25
    used = (data.springs["fl"].value, data.springs["rl"].value)
    slopes = fit.spring_slopes @ pick.T

    def parameters(values: Values) -> list[float | FloatArray]:
        found = [*_masses(values), sum(values[name] for name in DAMPERS) / 4]
        for axle, rate, slope in zip(AXLES, used, slopes, strict=True):
            # bushes make the suspension stiffer than its springs, and the seen mass the smaller
            off = rate / (rate_under_load(values, axle) * (1 + values[f"bush_{axle}"])) - 1
            found = [f + float(s) * off for f, s in zip(found, slope, strict=True)]
        return found

    more = stiffer_axles(fit, vehicle)
    own = tuple(
        Unknown(f"bush_{axle}", m / 2, max(m / SQRT_12, 1e-4)) for axle, m in zip(AXLES, more, strict=True)
    )
    return evidence_of(
        "ride", CARRIER, "heave of the body on its springs over a rough road", SOURCE,
        direct((pick @ fit.values).tolist(), _heave_covariance(fit, pick, data.hub_rms)), parameters,
        (*BODY, "track_front", "track_rear", *SPRINGS, *DAMPERS), own,
    )  # fmt: skip


def corner_evidence(corners: Sequence[CornerSeen], uneven: float) -> Evidence | None:
    """Of fewer corners. uneven: share by which left and right of an axle may differ beyond what the CG's place says."""
    if not corners:
        return None

    def parameters(values: Values) -> list[float | FloatArray]:
        front, rear, lateral = _masses(values)
        found: list[float | FloatArray] = []
        for corner in corners:
            axle = axle_of(corner.wheels[0])
            carried, whole = (front if axle == "front" else rear), front + rear
            side = 0.0 if len(corner.wheels) == 2 else (1.0 if corner.wheels[0][1] == "l" else -1.0)
            each = carried * (0.5 + side * lateral / whole)
            found.append(each * corner.spring_npm / rate_under_load(values, axle))
        return found

    spread = [math.hypot(c.std, uneven * c.mass if len(c.wheels) == 1 else 0.0) for c in corners]
    return evidence_of(
        "ride", CARRIER, "single wheels' ride on their springs", SOURCE,
        direct([c.mass for c in corners], np.diag(np.square(spread))), parameters,
        (*BODY, "track_front", "track_rear", *SPRINGS),
    )  # fmt: skip
