"""From the two moments to height, position and mass, with everything that is not exactly known drawn along."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipelines.estimators.axle_load_gls.balance import Balance
from pipelines.estimators.axle_load_gls.data import AxleData
from pipelines.estimators.axle_load_gls.known import (
    PITCH_ARM_STD,
    MassKnowledge,
    Pitch,
    pitch_axis,
    rolling_arm,
    spin_moment,
)
from pipelines.models.axle_load import GRAVITY, GRAVITY_SHARE, patch_shift
from pipelines.results import FloatArray, Identification, ParameterEstimate, Prior
from pipelines.vehicles.axle_loads import by_springs
from pipelines.vehicles.priors import measured_cg_height
from pipelines.vehicles.vehicle import Quantity, Vehicle

USUAL_HEIGHT_SHARE = (0.22, 0.13)
"""CG height over wheelbase, mean and standard deviation: stands in where the drive does not tell the height but the
axle load's mean still tells the position."""

IDENTIFIED, WEAK = 0.06, 0.25
"""Largest standard deviation as a share of the height for these words; of the position, a third of it as a share of
the wheelbase."""

STATED_RATIO = 0.5
"""Of the spread of a stated height, below which a height that a drive tells is identified, as in the verdict."""

FEW_ROWS = 20.0
"""Rows that do not hang together below which a height is weak at best: the residual's own colour is not known from fewer."""


@dataclass(frozen=True)
class Errors:
    """Standard deviations of what the sensors and the model may be wrong by.

    load_scale, force_scale, model: shares. load_offset: N an axle. force_offset: mean and standard deviation in m/s².
    """

    load_scale: float
    load_offset: float
    force_scale: float
    force_offset: tuple[float, float]
    model: float


@dataclass(frozen=True)
class Draws:
    """Draws of the answers, each (k,); mass None where neither the log nor the file tells it."""

    height: FloatArray
    axle: FloatArray
    mass: FloatArray | None
    mass_measured: bool
    load_known: bool
    moment_share: float


def _normal(rng: np.random.Generator, count: int, mean: float, std: float) -> FloatArray:
    return np.asarray(mean + std * rng.standard_normal(count))


def usual_moment(data: AxleData, wheelbase: float, mass_kg: float | None) -> tuple[float, float]:
    """m h as it usually is, kg·m: mean and standard deviation."""
    if data.front is not None and data.rear is not None:
        mass = (data.front + data.rear) / GRAVITY
    elif mass_kg is not None:
        mass = 1.1 * mass_kg
    else:
        mass = 2 * max(data.front or 0.0, data.rear or 0.0) / GRAVITY
    return mass * USUAL_HEIGHT_SHARE[0] * wheelbase, mass * USUAL_HEIGHT_SHARE[1] * wheelbase


def static_moments(
    data: AxleData, wheelbase: float, usual: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """(M_h, M_c) and covariance where the force hardly changes: M_h as usual, M_c from the mean load."""
    force = float(np.mean(data.force()))
    mean = wheelbase * float(np.mean(data.load))
    blocks = max(2, int(data.size / (5 * data.rate_hz)))
    scatter = float(np.std([np.mean(p) for p in np.array_split(data.load, blocks)])) * wheelbase
    central = mean / GRAVITY - usual[0] * force / GRAVITY
    leak = force / GRAVITY
    variance = (usual[1] * leak) ** 2 + (scatter / GRAVITY) ** 2
    cross = -(usual[1] ** 2) * leak
    return np.array([usual[0], central]), np.array([[usual[1] ** 2, cross], [cross, variance]])


def draw_answers(
    data: AxleData, moments: FloatArray, covariance: FloatArray, by_speed: bool, vehicle: Vehicle,
    wheelbase: Quantity, mass: MassKnowledge | None, pitch: Pitch, errors: Errors, rng: np.random.Generator, count: int,
) -> Draws:  # fmt: skip
    """Height, position and mass from draws of everything (count each)."""
    lever = _normal(rng, count, wheelbase.value, wheelbase.std)
    root = np.linalg.cholesky(covariance + np.diag(1e-12 * np.diag(covariance) + 1e-12))
    both = moments + rng.standard_normal((count, 2)) @ root.T
    m_h, m_c = both[:, 0] * lever / wheelbase.value, both[:, 1] * lever / wheelbase.value
    scale = {axle: _normal(rng, count, 1.0, errors.load_scale) for axle in ("front", "rear")}
    offset = {
        axle: _normal(rng, count, 0.0, math.hypot(errors.load_offset, data.added_std)) for axle in scale
    }
    shift = np.zeros(count)
    total = np.zeros(count)
    for axle, mean, share in (("front", data.front, -data.share_front), ("rear", data.rear, data.share_rear)):
        if mean is not None:
            wrong = mean * (scale[axle] - 1) + offset[axle]
            shift += share * wrong
            total += mean + wrong
    m_h = m_h * (data.share_rear * scale["rear"] + data.share_front * scale["front"])
    m_h = m_h * _normal(rng, count, 1.0, errors.force_scale)
    m_h = m_h + moments[1] * _normal(rng, count, 0.0, data.vertical_leak)
    force_offset = _normal(rng, count, *errors.force_offset)
    m_c = m_c + shift * lever / GRAVITY + m_h * force_offset / GRAVITY
    measured = data.front is not None and data.rear is not None
    known: FloatArray | None
    if measured:
        total += _normal(rng, count, 0.0, data.total_std)
        total *= _normal(rng, count, 1.0, GRAVITY_SHARE)
        known = total / (GRAVITY * float(np.mean(np.cos(data.grade_source.angle[data.rows]))))
    else:
        known = None if mass is None else mass.draws
    heavy = known if known is not None else np.full(count, np.nan)
    gain = np.clip(_normal(rng, count, pitch.gain, pitch.std), 0.0, 0.3)
    height_of_axis = pitch_axis(vehicle, wheelbase.value)
    axis = _normal(rng, count, height_of_axis[0], height_of_axis[1])
    # springs do not see what the links carry
    felt = data.share_of("suspension") + data.share_of("axle") * (rng.random(count) < by_springs(vehicle))
    m_h = m_h + felt * heavy * axis
    spin = spin_moment(vehicle, float(moments[0]))
    effective = m_h if by_speed else m_h * (1 + gain)
    own = effective - _normal(rng, count, spin[0], spin[1]) + heavy * axis * gain
    arm_over_height = _normal(rng, count, 1.0, PITCH_ARM_STD)
    height = own / (heavy * (1 + arm_over_height * gain)) * _normal(rng, count, 1.0, errors.model)
    if data.share_of("suspension") == 0.0:
        empty, rate = vehicle.get("mass_kg"), vehicle.get("tire_vertical_rate_npm")
        patch = patch_shift(empty.value if empty else None, rate.value if rate else None)
        height = height - _normal(rng, count, *patch)
    arm = rolling_arm(vehicle, wheelbase.value)
    axle_at = m_c / heavy + data.share_front * lever - _normal(rng, count, arm[0], arm[1])
    axle_at = axle_at + _normal(rng, count, 0.0, errors.model * 0.3 * wheelbase.value)
    share = math.sqrt(float(covariance[0, 0])) / max(abs(float(moments[0])), 1e-9)
    return Draws(height, axle_at, known, measured, measured or (mass is not None and mass.load_known), share)


def _estimate(
    name: str,
    draws: FloatArray,
    status: Identification,
    reason: str,
    vehicle: Vehicle,
    prior: Prior | None = None,
) -> ParameterEstimate:
    low, value, high = (float(v) for v in np.quantile(draws, (0.025, 0.5, 0.975)))
    return ParameterEstimate(
        name, value, float(np.std(draws)), low, high, status, reason, prior, vehicle.reference.get(name), ("axle_load_gls",)
    )  # fmt: skip


def height_prior(vehicle: Vehicle) -> Prior | None:
    """What is known of the height without the log."""
    stated = vehicle.get("cg_height_m")
    if stated is not None:
        return Prior(stated.value, stated.std, f"{stated.source} (empty vehicle)")
    mass = vehicle.get("mass_kg")
    return measured_cg_height(vehicle.body, None if mass is None else mass.value, vehicle.powertrain)


def unknown(name: str, reason: str, vehicle: Vehicle) -> ParameterEstimate:
    """An answer that the drive does not give; the height's figures are then what is known without it."""
    reference = vehicle.reference.get(name)
    prior = height_prior(vehicle) if name == "cg_height_m" else None
    if prior is None:
        return ParameterEstimate(name, None, None, None, None, "not_identifiable", reason, None, reference)
    half = 1.96 * prior.std
    words = f"{reason}; the figures are the prior's"
    return ParameterEstimate(
        name, prior.value, prior.std, prior.value - half, prior.value + half, "not_identifiable", words, prior,
        reference, ("prior",),
    )  # fmt: skip


def _word(std: float, identified: float, weak: float) -> Identification:
    return "identified" if std <= identified else ("weak" if std <= weak else "not_identifiable")


def against_stated(
    status: Identification, std: float, reason: str, vehicle: Vehicle
) -> tuple[Identification, str]:
    """A height's status, weak at most where its spread is more than half of what the file states of it: the drive then taught little."""
    stated = height_prior(vehicle) if vehicle.get("cg_height_m") is not None else None
    if status != "identified" or stated is None or std <= STATED_RATIO * stated.std:
        return status, reason
    return (
        "weak",
        f"{reason}; little narrower than what the vehicle file says of the empty vehicle (± {stated.std:.3f} m)",
    )


def answers(
    draws: Draws, balance: Balance, wheelbase: float, vehicle: Vehicle, told: str | None
) -> Mapping[str, ParameterEstimate]:
    """The parameters. told: why the height is not to be had from this drive, None where it is."""
    found: dict[str, ParameterEstimate] = {}
    only = (
        f"of the load only m h = {balance.moments[0]:.0f} kg·m (± {100 * draws.moment_share:.1f} %) is told"
    )
    if draws.mass is None:
        reason = (
            f"no mass: {only}, and the vehicle file gives no mass_kg and the log no load of the other axle"
        )
        return {
            name: unknown(name, told or reason, vehicle) for name in ("cg_height_m", "cg_to_front_axle_m")
        }
    mass_words = "mass from both axle loads" if draws.mass_measured else "mass from the vehicle file"
    if not draws.load_known:
        mass_words += ", the load unknown: the interval holds any usual load ([load] mass_kg would narrow it)"
    if told is None:
        std = float(np.std(draws.height)) / max(abs(float(np.median(draws.height))), 1e-9)
        status = _word(std, IDENTIFIED, WEAK)
        sane = 0.1 < float(np.median(draws.height)) < 0.8 * wheelbase
        if status == "not_identifiable" or not sane:
            why = f"the load transfer leaves m h open to {100 * draws.moment_share:.0f} %: too little braking and driving"
            if not sane:
                why = f"the load transfer gives {np.median(draws.height):.2f} m, which no vehicle is: the signals contradict the balance of axle loads"
            found["cg_height_m"] = unknown("cg_height_m", why, vehicle)
        else:
            reason = f"load transfer over {balance.force_spread:.2f} m/s² of force; {mass_words}"
            status, reason = against_stated(status, float(np.std(draws.height)), reason, vehicle)
            if balance.rows_told < FEW_ROWS:
                status = "weak"
                reason = f"only {balance.rows_told:.0f} rows that do not hang together; {reason}"
            found["cg_height_m"] = _estimate("cg_height_m", draws.height, status, reason, vehicle)
    else:
        found["cg_height_m"] = unknown("cg_height_m", told, vehicle)
    std = float(np.std(draws.axle)) / wheelbase
    status = _word(std, IDENTIFIED / 3, WEAK / 3)
    place = float(np.median(draws.axle)) / wheelbase
    if status == "not_identifiable" or not 0.05 < place < 0.95:
        why = f"{mass_words}: the position is open to {100 * std:.0f} % of the wheelbase"
        if not 0.05 < place < 0.95:
            why = f"the mean axle load puts the CG at {place:.2f} wheelbases, outside the axles: mass and load do not go together"
        found["cg_to_front_axle_m"] = unknown("cg_to_front_axle_m", why, vehicle)
    else:
        reason = f"mean axle load with grade and force taken out; {mass_words}"
        found["cg_to_front_axle_m"] = _estimate("cg_to_front_axle_m", draws.axle, status, reason, vehicle)
    if draws.mass_measured:
        spread = float(np.std(draws.mass) / np.median(draws.mass))
        reason = "sum of the axle loads over the drive"
        found["mass_kg"] = _estimate("mass_kg", draws.mass, _word(spread, 0.03, 0.1), reason, vehicle)
    return found
