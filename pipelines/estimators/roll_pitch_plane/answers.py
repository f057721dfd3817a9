"""From the balances' coefficients to parameters, with all that is not exactly known drawn along."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pipelines.estimators.roll_pitch_plane.data import Planes
from pipelines.estimators.roll_pitch_plane.fit import LinearFit
from pipelines.estimators.roll_pitch_plane.known import (
    DRAWS,
    RADIUS,
    WHEEL_INERTIA,
    Draws,
)
from pipelines.results import FloatArray, Identification, ParameterEstimate, Prior
from pipelines.vehicles.usual import usual_unsprung
from pipelines.vehicles.vehicle import Vehicle

QUANTILES = (0.025, 0.5, 0.975)
LEFT_SHARE = 0.3
"""How much of the unexplained moment, as a root of its share, may go with an estimated motion."""

HEAVY_KG, HEAVY_FACTOR = 3500.0, 2.0
"""Lorries stand on rigid axles and leaf springs, whose links do more than those of cars: the model's errors times this."""


@dataclass(frozen=True)
class SensorErrors:
    """Standard deviations: force_scale, accel_scale shares; force_offset N; accel_offset m/s²; model: see the settings."""

    force_scale: float
    force_offset: float
    accel_scale: float
    accel_offset: float
    arm_model: float
    inertia_model: float
    mass_model: float


def unexplained(errors: SensorErrors, fit: LinearFit, sprung_kg: float) -> SensorErrors:
    """The model's own errors with a part of what the balance leaves unexplained: it may go with what is estimated."""
    left = LEFT_SHARE * float(np.sqrt(max(1 - fit.explained, 0.0)))
    wider = HEAVY_FACTOR if sprung_kg > HEAVY_KG else 1.0
    return replace(
        errors,
        arm_model=float(np.hypot(wider * errors.arm_model, left)),
        inertia_model=float(np.hypot(wider * errors.inertia_model, left)),
    )


@dataclass(frozen=True)
class Masses:
    """Draws (DRAWS,): sprung mass; unsprung masses of both axles; wheels' radius and spin inertia over it; scale of the
    dynamic forces; static forces (DRAWS, 4) as they may truly be, N."""

    sprung: FloatArray
    front: FloatArray
    rear: FloatArray
    radius: FloatArray
    spin: FloatArray
    force_scale: FloatArray
    static: FloatArray

    @property
    def unsprung(self) -> FloatArray:
        """Of all wheels."""
        return self.front + self.rear

    @property
    def whole(self) -> FloatArray:
        """The whole vehicle's mass."""
        return self.sprung + self.unsprung


def draw_masses(draws: Draws, planes: Planes, load: LinearFit, errors: SensorErrors) -> Masses:
    """What the struts carry, less the links' part, with the force sensors' errors; and the wheels."""
    scales = 1 + errors.force_scale * draws.rng.standard_normal((DRAWS, 4))
    zeros = errors.force_offset * draws.rng.standard_normal((DRAWS, 4))
    static = planes.loads * scales - zeros
    # the fit knows the force's mean part that braking and cornering take; the sensors' errors come on top
    share = static.sum(axis=1) / planes.loads.sum()
    sprung = draws.normal(load.value("mass"), load.std("mass")) * share
    sprung = sprung * draws.normal(1.0, errors.mass_model)
    kilos = load.value("mass")
    front, rear = (usual_unsprung(draws.vehicle, axle, kilos) for axle in ("front", "rear"))
    radius = np.maximum(draws.of("wheel_radius_m", RADIUS), 0.1)
    inertia = np.maximum(draws.of("wheel_inertia_kgm2", WHEEL_INERTIA), 0.0)
    return Masses(
        sprung=sprung,
        front=np.maximum(draws.of("unsprung_mass_front_kg", front), 0.0),
        rear=np.maximum(draws.of("unsprung_mass_rear_kg", rear), 0.0),
        radius=radius,
        spin=4 * inertia / radius,
        force_scale=scales.mean(axis=1),
        static=static,
    )


def coefficient_draws(fit: LinearFit, rng: np.random.Generator) -> dict[str, FloatArray]:
    """Draws of every coefficient together, (DRAWS,) each."""
    values, vectors = np.linalg.eigh(fit.covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    table = fit.values + rng.standard_normal((DRAWS, len(fit.names))) @ root.T
    return {name: table[:, i] for i, name in enumerate(fit.names)}


@dataclass(frozen=True)
class Said:
    """How an answer is called: limits of the standard deviation, as a share of `scale` (None: of the value itself), for
    "identified" and "weak"; the reason; why not (what the drive lacks), None where it does not."""

    identified: float
    weak: float
    reason: str
    lacks: str | None = None
    scale: float | None = None
    low: float = -np.inf
    high: float = np.inf
    prior: Prior | None = None


def unknown(name: str, reason: str, vehicle: Vehicle, prior: Prior | None = None) -> ParameterEstimate:
    """An answer that the drive does not give; figures are the prior's where there is one."""
    reference = vehicle.reference.get(name)
    if prior is None:
        return ParameterEstimate(name, None, None, None, None, "not_identifiable", reason, None, reference)
    half = 1.96 * prior.std
    words = f"{reason}; the figures are the prior's"
    return ParameterEstimate(
        name, prior.value, prior.std, prior.value - half, prior.value + half, "not_identifiable", words, prior,
        reference, ("prior",),
    )  # fmt: skip


def answer(name: str, draws: FloatArray, said: Said, vehicle: Vehicle, source: str) -> ParameterEstimate:
    """A parameter from its draws: status by its spread, against what was known before where that is something."""
    if said.lacks is not None:
        return unknown(name, said.lacks, vehicle, said.prior)
    low, value, high = (float(q) for q in np.quantile(draws, QUANTILES))
    std = float(np.std(draws))
    share = std / (abs(value) if said.scale is None else said.scale) if value != 0 else np.inf
    if not said.low < value < said.high:
        words = f"it comes out at {value:.4g}, which no vehicle has: forces and accelerations contradict each other (signs, units)"
        return unknown(name, words, vehicle, said.prior)
    if not share <= said.weak:
        words = f"{said.reason}; open to {100 * share:.0f} %"
        return unknown(name, words, vehicle, said.prior)
    status: Identification = "identified" if share <= said.identified else "weak"
    words = said.reason
    if said.prior is not None and std > 0.7 * said.prior.std:
        status = "weak"
        words += f"; hardly narrower than what is known without the log (± {said.prior.std:.3g})"
    return ParameterEstimate(
        name, value, std, low, high, status, words, said.prior, vehicle.reference.get(name), (source,)
    )
