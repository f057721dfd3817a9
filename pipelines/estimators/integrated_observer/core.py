"""Park & Choi's observer on plain columns: gates, LRLS on braking, adaptation on lateral motion, synthesis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.channels import IntArray
from pipelines.estimators.brake_roll.rows import within
from pipelines.filters.bilinear_rls import bilinear_rls
from pipelines.filters.roll_adaptation import AdaptationGains, Adapted, adapt_roll
from pipelines.models.braking import LongitudinalCar, axle_braking_force, front_load_share, lrls_terms
from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import BoolArray
from pipelines.results import FloatArray

FORGETTING = (0.995, 0.999)
START_COVARIANCE = (1e-5, 1e-4)
"""Of m_add and h: the paper prints the first pair, not the second; 1e-6 to 1e-4 and 1e-4 were found to work."""

SMALLEST_SLIP = 0.002
"""Slip of both axles from which (7) is asked: below it the quotient is noise."""


@dataclass(frozen=True)
class ObserverInput:
    """Columns (n,) at rate_hz, SI. Without braking data: front_torque None; without lateral data: roll_rate None.

    speed: true, not the wheels'. front, rear: mean wheel speed of an axle; apart: the larger left-right difference of
    the two axles, less what the turn explains. front_torque, rear_torque: brake torque of both wheels. steering:
    rad at the steering wheel, None where it is not known. allowed: rows with flat road and good satellites.
    """

    rate_hz: float
    speed: FloatArray
    f_x: FloatArray
    f_y: FloatArray
    roll_rate: FloatArray | None
    yaw_rate: FloatArray
    front: FloatArray
    rear: FloatArray
    apart: FloatArray
    front_torque: FloatArray | None
    rear_torque: FloatArray | None
    steering: FloatArray | None
    allowed: BoolArray
    segments: tuple[IntArray, IntArray]


@dataclass(frozen=True)
class Gates:
    """When the LRLS runs. braking: deceleration that the brakes alone would give, m/s² (the threshold of P_mc).

    slip: λ_th. apart_mps: v_w,th. steering in rad and rad/s; the yaw rate stands in where there is no steering signal.
    slowest_mps: below it slips mean nothing. onset_s: after the foot goes down the tyres and the body have to settle.
    """

    braking_mps2: float = 0.7
    slip: float = 0.10
    apart_mps: float = 0.4
    steering_rad: float = 0.17
    steering_radps: float = 0.5
    yaw_radps: float = 0.04
    slowest_mps: float = 2.0
    onset_s: float = 0.5
    lateral_mps2: float = 0.3


@dataclass(frozen=True)
class BrakePart:
    """The braking part, all (n,). braking: K of (39). active: rows that the LRLS took. height, added: its estimates.

    share: F_zf / (m g) of (8). stiffness: normalised slip stiffness of both axles, (n, 2).
    """

    braking: BoolArray
    active: BoolArray
    height: FloatArray
    added: FloatArray
    share: FloatArray
    stiffness: FloatArray
    known_from: int


@dataclass(frozen=True)
class Observed:
    """Both parts and the synthesis. height: h^_int (n,), or the only part's that ran."""

    brake: BrakePart | None
    roll: Adapted | None
    height: FloatArray
    mass: FloatArray


def _since(mask: BoolArray) -> IntArray:
    """Rows since the mask last turned True, 0 where it is False."""
    rows = np.arange(len(mask))
    last = np.maximum.accumulate(np.where(mask, -1, rows))
    return np.asarray(rows - last, dtype=np.int64)


def _straight(data: ObserverInput, gates: Gates) -> BoolArray:
    """Rows without lateral motion, (39)."""
    if data.steering is None:
        return np.asarray(
            (np.abs(data.yaw_rate) <= gates.yaw_radps) & (np.abs(data.f_y) <= 3 * gates.lateral_mps2)
        )
    rate = np.gradient(data.steering) * data.rate_hz
    return np.asarray((np.abs(data.steering) <= gates.steering_rad) & (np.abs(rate) <= gates.steering_radps))


def locked_or_cycling(data: ObserverInput, slip: FloatArray, gates: Gates) -> BoolArray:
    """Rows within half a second of brake control: slip beyond λ_th, or wheels that swing by more than a slip does."""
    limit = gates.slip
    swing = np.zeros(len(slip))
    for wheel in (data.front, data.rear):
        acceleration = np.gradient(wheel) * data.rate_hz
        swing = np.maximum(swing, np.abs(acceleration - data.f_x))
    bad = (np.abs(slip) >= limit) | (swing > 8.0)
    reach = max(1, round(0.5 * data.rate_hz))
    return within(bad, reach)


def run_braking(
    data: ObserverInput,
    car: LongitudinalCar,
    gates: Gates,
    height_m: float,
    *,
    start_covariance: tuple[float, float],
) -> BrakePart | None:
    """The LRLS of (8)-(20) over the drive; None without brake torques. height_m: h^_long before the first stop."""
    if data.front_torque is None or data.rear_torque is None:
        return None
    ahead = axle_braking_force(
        data.front_torque, np.gradient(data.front) * data.rate_hz, car.wheel_radius_m, car.wheel_inertia_kgm2
    )
    behind = axle_braking_force(
        data.rear_torque, np.gradient(data.rear) * data.rate_hz, car.wheel_radius_m, car.wheel_inertia_kgm2
    )
    v = np.maximum(data.speed, 0.5)
    slips = np.stack([1 - data.front / v, 1 - data.rear / v], axis=1)
    share = front_load_share(ahead, behind, data.speed, data.front, data.rear)
    threshold = gates.braking_mps2 * car.mass_kg * car.wheel_radius_m
    pressed = data.front_torque + data.rear_torque >= threshold
    braking = pressed & _straight(data, gates)
    active = (
        braking
        & data.allowed
        & (data.speed >= gates.slowest_mps)
        & (_since(pressed) >= gates.onset_s * data.rate_hz)
        & (data.apart < gates.apart_mps)
        & ~locked_or_cycling(data, slips.max(axis=1), gates)
        & (slips.min(axis=1) > SMALLEST_SLIP)
        & (data.f_x < -0.5 * gates.braking_mps2)
        & np.isfinite(share)
    )
    y, terms = lrls_terms(np.where(active, share, 0.5), data.f_x, data.speed, car)
    theta, _ = bilinear_rls(
        y, terms, active, start=(0.0, height_m), covariance=start_covariance, forgetting=FORGETTING
    )
    weight = car.mass_kg * GRAVITY
    with np.errstate(divide="ignore", invalid="ignore"):
        stiffness = np.stack(
            [ahead / (share * weight) / slips[:, 0], behind / ((1 - share) * weight) / slips[:, 1]], axis=1
        )
    stiffness[~active] = np.nan
    first = int(np.argmax(active)) if active.any() else len(active)
    share = np.where(active, share, np.nan)
    return BrakePart(braking, active, theta[:, 1], theta[:, 0], share, stiffness, first)


def observe(
    data: ObserverInput,
    car: LongitudinalCar,
    gains: AdaptationGains | None,
    gates: Gates,
    *,
    height_m: float,
    reset: bool = True,
    use_added: bool = True,
    start_covariance: tuple[float, float] = START_COVARIANCE,
) -> Observed:
    """Run the parts that the data allow. height_m: where every estimate starts.

    use_added: the lateral part takes m0 + m^_add as its mass, as published. reset: see `roll_adaptation`.
    """
    rows = len(data.speed)
    brake = run_braking(data, car, gates, height_m, start_covariance=start_covariance)
    mass = np.full(rows, car.mass_kg)
    if brake is not None and use_added:
        mass = mass + np.clip(brake.added, -0.3 * car.mass_kg, 0.5 * car.mass_kg)
    if gains is None or data.roll_rate is None:
        height = np.full(rows, height_m) if brake is None else brake.height
        return Observed(brake, None, height, mass)
    nobody = np.zeros(rows, dtype=bool)
    begun = np.arange(rows) >= (rows if brake is None else brake.known_from)
    braking = nobody if brake is None else brake.braking & data.allowed & begun
    long = np.full(rows, height_m) if brake is None else brake.height
    adapted = adapt_roll(
        data.f_y,
        data.roll_rate,
        data.yaw_rate * data.speed,
        mass,
        long,
        braking,
        data.allowed & (data.speed > gates.slowest_mps),
        data.segments,
        gains,
        rate_hz=data.rate_hz,
        height_m=height_m,
        reset=reset,
    )
    return Observed(brake, adapted, adapted.height, mass)


def robustness_bound(roll: Adapted, f_y: FloatArray, gains: AdaptationGains) -> FloatArray:
    """The mass error that (33) allows at each row in kg; NaN where there is hardly any lateral acceleration."""
    arm = np.maximum(roll.arm, 1e-3)
    with np.errstate(divide="ignore", invalid="ignore"):
        bound = gains.stiffness_nmprad / (gains.gamma * arm) * np.abs(roll.error / f_y)
    return np.where(np.abs(f_y) > 0.3, bound, np.nan)
