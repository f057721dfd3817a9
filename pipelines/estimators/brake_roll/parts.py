"""The three parts of the batch on a log: slips in braking, roll in cornering, the longitudinal balance."""

from __future__ import annotations

import math

import numpy as np

from parsers.channels import IntArray
from pipelines.estimators.base import Settings
from pipelines.estimators.brake_roll.data import BrakeRollData, wheel_scales
from pipelines.estimators.brake_roll.lateral import LateralData, LateralFit, LateralKnown, fit_lateral
from pipelines.estimators.brake_roll.mass import BRAKE_TORQUE_STD, MassFit, MassKnown, fit_mass
from pipelines.estimators.brake_roll.rows import within
from pipelines.estimators.brake_roll.slip import SlipData, SlipFit, SlipKnown, fit_slip
from pipelines.estimators.brake_roll.vehicle import BrakeRollVehicle
from pipelines.estimators.roll_map.vehicle import VehiclePart
from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import BoolArray, Prepared
from pipelines.results import FloatArray
from pipelines.vehicles.usual import usual_engine_drag
from pipelines.vehicles.vehicle import Quantity, Vehicle

ONSET_S = 0.4
LEAST_TOLD = 0.25
"""Largest relative standard deviation of the roll per lateral acceleration that counts as following."""

LEAST_STIFFNESS = 2 * GRAVITY
"""Stiffness over m h in (m/s²)/rad that every sprung vehicle has: below it the ground tilts, not the body."""

TYRE_RATE = 220_000.0
"""N/m, vertical rate of a road car's tyre."""

WHEEL_DELAY_STD_S = 0.02
"""The speed is aligned with the accelerometer; the wheel speeds have a delay of their own."""

ENGINE_DRAG = 0.15
"""m/s², spread of what an engine in gear holds back while the brakes are on and no drive torque tells; a tenth of it where one does."""

RATIO_ERROR = 0.15
"""Of the quotient of the axles' slips: wear, pressure, toe, and what bends the slip curve otherwise."""

ARM_SHARE = (0.0, 0.3)
"""Share of a tyre's deflection by which a torque's arm is shorter than the rolling radius, and its spread. It cannot be by
much: a shorter arm would give more power than was put in. What a rolling radius in a vehicle file is good for is in it."""

STIFFENING = (1.0e-3, 1.5e-3)
"""(m/s²)^-2, by what share the roll at 1 m/s² stays behind one that goes straight: springs a few percent stiffer 50 mm from ride
height (docs/vehicle.md), and stops that begin, at seven degrees a g."""

PITCH_STD, CORNERING_PITCH_STD = 0.006, 2e-4
"""rad per m/s² along (three degrees a g) and per (m/s²)² across (0.3 degrees at half a g) that bodies pitch by."""

WHEELS_STD = 0.02
"""Share by which wheels' speeds are off a vehicle's: radii of tyres that nobody measured."""

USUAL_GAIN = (1.06, 0.03)
"""What the accelerometer reads per m/s² of braking where it could not be told: the nose dives 5-7 %."""


def _settings(settings: Settings, name: str, default: float) -> float:
    return float(settings.get(name, default))


def segments_of(prepared: Prepared) -> tuple[IntArray, IntArray]:
    """First rows and rows past the last."""
    return (
        np.array([s.start for s in prepared.segments], dtype=np.int64),
        np.array([s.stop for s in prepared.segments], dtype=np.int64),
    )


def forward_gain(data: BrakeRollData) -> tuple[float, float]:
    """What accel_x reads per m/s² of specific force in the road plane, and how well that is known.

    The nose dives in proportion to the specific force, so that the alignment with the speed tells it.
    """
    if data.true is None or not data.true.told or data.true.gain_std > USUAL_GAIN[1]:
        return USUAL_GAIN
    return data.true.gain, max(data.true.gain_std, 0.003)


def slip_part(
    prepared: Prepared,
    data: BrakeRollData,
    known: BrakeRollVehicle,
    settings: Settings,
    before: VehiclePart,
    vehicle: Vehicle,
) -> tuple[SlipFit | None, str]:
    """The braking fit, or why there is none."""
    if data.missing:
        return None, f"braking: {'; '.join(data.missing)}"
    if known.front is None or known.wheelbase is None:
        return None, "braking: cg_to_front_axle_m and wheelbase_m are not known"
    assert data.true is not None
    if data.f_x is None or data.front is None or data.rear is None:
        return None, "braking: no accel_x"
    if data.front_torque is None or data.rear_torque is None:
        return None, "braking: no brake torque"
    if not data.true.told:
        return None, "braking: the speed could not be aligned with accel_x: its delay is not known"
    gain, gain_std = forward_gain(data)
    rows, pressed = _slip_rows(prepared, data, data.true.speed, known)
    columns = SlipData(
        prepared.rate_hz, prepared.cutoff_hz, data.true.speed, data.f_x / gain, data.front, data.rear,
        data.front_torque, data.rear_torque, data.drive, rows, pressed,
    )  # fmt: skip
    delay_std = math.hypot(data.true.delay_std_s, WHEEL_DELAY_STD_S)
    slip_known = _slip_known(
        data, known, known.front, known.wheelbase, settings, vehicle, gain_std, delay_std
    )
    prior = before.priors.get("cg_height_m")
    fit = fit_slip(columns, slip_known, 0.6 if prior is None else prior.value)
    if fit is None:
        return (
            None,
            "braking: no straight stop on flat road without brake control, or no free rolling beside it",
        )
    if not (0.0 < fit.height < 3.0 and math.isfinite(fit.std)) or not fit.fit.converged:
        return (
            None,
            f"braking: the slips fit no height ({fit.height:.2f} m): brake data or speed are not what they seem",
        )
    return fit, ""


def _slip_rows(
    prepared: Prepared, data: BrakeRollData, speed: FloatArray, known: BrakeRollVehicle
) -> tuple[BoolArray, BoolArray]:
    """Rows for the slips: flat, straight, without brake control and the onset of braking; and those of firm braking."""
    assert data.front is not None
    assert data.rear is not None
    assert data.front_torque is not None
    assert data.rear_torque is not None
    scale = wheel_scales(data, known)
    total = data.front_torque + data.rear_torque
    pressed = total > 0.7 * known.mass.value * known.radius.value
    touched = total > 0.0
    slip = 1 - np.minimum(data.front / scale.front, data.rear / scale.rear) / np.maximum(speed, 1.0)
    yaw = np.zeros(len(speed)) if data.yaw_rate is None else data.yaw_rate
    rate = prepared.rate_hz
    split = within(data.apart - float(np.median(data.apart)) > 0.4, round(0.3 * rate))
    control = within((slip > 0.12) & (speed > 3.0), round(0.5 * rate))
    onset = touched & ~_past(pressed, round(ONSET_S * rate))
    rows = data.rows & data.allowed & (np.abs(yaw) < 0.06) & ~split & ~control & ~onset
    return rows, pressed & ~onset


def _slip_known(
    data: BrakeRollData,
    known: BrakeRollVehicle,
    front: Quantity,
    wheelbase: Quantity,
    settings: Settings,
    vehicle: Vehicle,
    gain_std: float,
    delay_std_s: float,
) -> SlipKnown:
    """What the fit of the slips is told. front: the CG behind the front axle."""
    share = known.brake_front
    tyre = vehicle.get("tire_vertical_rate_npm")
    driven = vehicle.get("drive_front_share")
    # a motor that charges while the brakes are on holds far more than an engine in gear
    held = max(ENGINE_DRAG, math.hypot(*usual_engine_drag(vehicle)))
    spread = 0.03 if data.share_known else share.std / (share.value * (1 - share.value))
    return SlipKnown(
        known.mass.value, (front.value, front.std), wheelbase.value, known.radius.value,
        known.wheel_inertia.value, known.drag_area.value, spread, gain=gain_std, delay=delay_std_s,
        bend=(_settings(settings, "slip_bend", 0.25), _settings(settings, "slip_bend_std", 0.2)),
        load=(_settings(settings, "slip_load", 0.1), _settings(settings, "slip_load_std", 0.2)),
        squash=(_settings(settings, "squash", 0.25), _settings(settings, "squash_std", 0.12)),
        ratio_error=RATIO_ERROR,
        drive_front=(0.5, 0.5) if driven is None or driven.std > 0.5 else (driven.value, max(driven.std, 0.02)),
        tyre_rate=TYRE_RATE if tyre is None else tyre.value,
        engine_drag=held if data.drive is None else 0.1 * ENGINE_DRAG,
    )  # fmt: skip


def _past(mask: BoolArray, rows: int) -> BoolArray:
    """Rows at least `rows` behind the mask's last turn to True."""
    index = np.arange(len(mask))
    last = np.maximum.accumulate(np.where(mask, -1, index))
    return np.asarray(mask & (index - last >= rows))


def lateral_part(
    prepared: Prepared, data: BrakeRollData, known: BrakeRollVehicle, vehicle: Vehicle, settings: Settings
) -> tuple[LateralFit | None, str]:
    """The roll fit, or why there is none."""
    if data.f_y is None or data.roll_rate is None:
        return None, "roll: no accel_y and roll_rate together"
    lag, inertia = (0.08, 0.04), (0.010, 0.005)
    if known.stiffness is not None and known.damping is not None and known.inertia is not None:
        k = known.stiffness.value
        # the body leans about the roll axis: its inertia there is the larger by m h_lat², which is about as much again
        lag = (known.damping.value / k, max(known.damping.std / k, 0.3 * known.damping.value / k))
        inertia = (1.3 * known.inertia.value / k, 0.5 * known.inertia.value / k)
    rear = (1.4, 0.6)
    behind = vehicle.sensors.get("imu_behind_front_axle_m")
    if behind is not None and known.wheelbase is not None:
        rear = (known.wheelbase.value - behind.value, 0.2 + behind.std)
    scale = _settings(settings, "scale_std", 0.005)
    speed = data.rolling if data.true is None else data.true.speed
    if data.true is None and speed is not None:
        scale = math.hypot(scale, WHEELS_STD)
    lateral_known = LateralKnown(
        lag,
        inertia,
        rear,
        stiffening=STIFFENING,
        scale=scale,
        pitch=PITCH_STD,
        cornering_pitch=CORNERING_PITCH_STD,
    )
    measured = data.roll if "roll" in prepared.measured else None
    columns = LateralData(
        prepared.rate_hz, prepared.cutoff_hz, data.f_y, data.roll_rate, data.yaw_rate,
        speed, data.f_x, measured, data.rows, segments_of(prepared),
    )  # fmt: skip
    fit = fit_lateral(columns, lateral_known)
    if fit is None:
        return None, "roll: hardly any cornering (slalom, lane changes or a circle at 0.3 g would show it)"
    if fit.gain <= 0 or fit.std > LEAST_TOLD * fit.gain:
        share = max(0.0, 100 * fit.explained)
        return (
            None,
            f"roll: the body does not follow the lateral acceleration ({share:.0f} % of its rate does)",
        )
    if fit.gain > 1 / LEAST_STIFFNESS:
        return (
            None,
            "roll: the angle goes with the sensed acceleration as on tilting ground: check the roll rate",
        )
    return fit, ""


def mass_part(
    data: BrakeRollData, known: BrakeRollVehicle, settings: Settings, vehicle: Vehicle
) -> tuple[MassFit | None, str]:
    """The longitudinal balance, or why there is none."""
    if data.f_x is None or data.true is None:
        speed = (
            "no vehicle speed that tells more than its wheels' do" if data.rolling is not None else "no speed"
        )
        return None, f"mass: {'no accel_x' if data.f_x is None else speed}"
    brake: FloatArray | None = None
    if data.front_torque is not None and data.rear_torque is not None:
        brake = data.front_torque + data.rear_torque
    if brake is None and data.drive is None:
        return None, "mass: no brake or drive torque"
    gain, gain_std = forward_gain(data)
    relative = BRAKE_TORQUE_STD
    if data.by_pressure and known.gain is not None:
        relative = known.gain.std / known.gain.value
    tyre = vehicle.get("tire_vertical_rate_npm")
    squash = known.mass.value * GRAVITY / (4 * (TYRE_RATE if tyre is None else tyre.value))
    arm = known.radius.value - ARM_SHARE[0] * squash
    arm_std = math.hypot(known.radius.std, ARM_SHARE[1] * squash)
    yaw = np.zeros(len(data.f_x)) if data.yaw_rate is None else data.yaw_rate
    side = np.zeros(len(data.f_x)) if data.f_y is None else data.f_y
    rows = data.rows & (np.abs(yaw) < 0.1) & (np.abs(side) < 2.0)
    mass_known = MassKnown(
        known.mass.value, arm, arm_std, known.wheel_inertia.value,
        (known.drag_area.value, known.drag_area.std), relative,
        drive=_settings(settings, "drive_torque_std", 0.05), pitch=gain_std,
    )  # fmt: skip
    fit = fit_mass(data.f_x / gain, data.true.speed, brake, data.drive, rows, data.rate_hz, mass_known, side)
    if fit is None:
        return None, "mass: too little braking or pulling with a known torque"
    return fit, ""
