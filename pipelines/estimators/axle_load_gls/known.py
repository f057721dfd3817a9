"""What is known beside the log for the balance of axle loads: loaded mass, pitch under acceleration, small parts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipelines.estimators.axle_load_gls.data import AxleData, axle_load
from pipelines.models.axle_load import GRAVITY, GRAVITY_SHARE, mean_error
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import Prepared
from pipelines.results import Assumption, FloatArray
from pipelines.vehicles.kinds import kind_of, usual_load
from pipelines.vehicles.vehicle import Quantity, Vehicle

DRIVER = (75.0, 35.0)
LOAD_MEAN_SHARE = 0.09
LOAD_MOST_SHARE = 0.8
"""Where no load is stated: a driver (kg), and further load as a share of the empty mass: mean of an exponential law
and its end, of a car; of others as `usual_load` has it."""

WHEEL_SPIN_SHARE = (0.014, 0.009)
ROLLING = (0.009, 0.004)
RADIUS_SHARE = (0.118, 0.02)
RIDE_HZ = (1.5, 0.35)
SPRUNG_SHARE = 0.91
PITCH_AXIS = (0.035, 0.03)
PITCH_ARM_STD = 0.45
AIR_DENSITY = 1.2
DRAG_AREA_LIGHT = (0.75, 0.2)
DRAG_AREA_HEAVY = (4.5, 1.5)
HEAVY_KG = 3500.0
PITCH_INERTIA = (0.22, 0.06)
DRAG_HEIGHT = (1.1, 0.35)
"""Where the vehicle file is silent. WHEEL_SPIN_SHARE: spin inertia over radius of all wheels, as a share of m h.
RADIUS_SHARE: wheel radius over wheelbase. RIDE_HZ: natural frequency of the body in heave. PITCH_INERTIA: over m L².
PITCH_AXIS: height of the axis that the links make, over the wheelbase. PITCH_ARM_STD: how far the CG's shift with pitch
may differ, over h: a body tips over its round wheels' hubs or over the links' axis, which are 0.3 to 0.5 h apart; and in simple
simulators over none, as wheels there may take no torque to spin up.
DRAG_HEIGHT: height at which drag acts (lift counted in), as a share of the CG's; each mean and standard deviation."""

PITCH_BAND_HZ = 0.4
LEAST_PITCH_EXPLAINED = 0.3


@dataclass(frozen=True)
class MassKnowledge:
    """Draws of the loaded mass (k,) in kg, in words where from, and whether the load's mass is known."""

    draws: FloatArray
    how: str
    load_known: bool


def loaded_mass(vehicle: Vehicle, rng: np.random.Generator, count: int) -> MassKnowledge | None:
    """Empty mass plus load, as draws; None where the vehicle file gives no mass.

    Without a [load] table the load is unknown: a driver and an exponential tail, and the interval shows it.
    """
    empty = vehicle.get("mass_kg")
    if empty is None:
        return None
    masses = empty.value + empty.std * rng.standard_normal(count)
    stated = vehicle.load.get("mass_kg")
    if stated is not None:
        load = np.maximum(stated.value + stated.std * rng.standard_normal(count), 0.0)
        words = f"{empty.value:.0f} kg empty and {stated.value:.0f} ± {stated.std:.0f} kg load (vehicle file)"
        return MassKnowledge(masses + load, words, True)
    share, end = LOAD_MEAN_SHARE, LOAD_MOST_SHARE
    if kind_of(vehicle) != "car":
        usual = usual_load(vehicle, empty.value)
        share, end = usual.further / empty.value, usual.most / empty.value
    further = rng.exponential(share * empty.value, count)
    driver = np.maximum(DRIVER[0] + DRIVER[1] * rng.standard_normal(count), 0.0)
    most = end * empty.value
    words = (
        f"{empty.value:.0f} kg empty (vehicle file), a driver, and an unknown load (none stated: "
        f"{share:.0%} of the empty mass in the mean, at most {end:.0%})"
    )
    return MassKnowledge(masses + driver + np.minimum(further, most), words, False)


def measured_mass(
    prepared: Prepared, vehicle: Vehicle, scale_std: float, rng: np.random.Generator, count: int
) -> MassKnowledge | None:
    """The loaded mass as the mean sum of both axles' loads; None where one of them is not there."""
    parts = [axle_load(prepared.columns, axle, vehicle) for axle in ("front", "rear")]
    if parts[0] is None or parts[1] is None:
        return None
    total = parts[0][0] + parts[1][0]
    total = total[np.isfinite(total)]
    if not len(total):
        return None
    mass = float(np.mean(total)) / GRAVITY
    own = mean_error(total, prepared.rate_hz) / GRAVITY
    std = math.hypot(
        math.hypot(scale_std, GRAVITY_SHARE) * mass, own, parts[0][1] / GRAVITY, parts[1][1] / GRAVITY
    )
    return MassKnowledge(mass + std * rng.standard_normal(count), "sum of both axles' loads", True)


@dataclass(frozen=True)
class Pitch:
    """g times the body's pitch against the road per longitudinal specific force (no unit): value, std, source."""

    gain: float
    std: float
    how: str


def _angle_steps(prepared: Prepared, wheelbase: float) -> tuple[FloatArray, str, float] | None:
    """Changes of the body's pitch over one step, rad, what they are from, and the scale's error."""
    columns = prepared.columns
    corners = [columns.get(f"suspension_deflection_{w}") for w in ("fl", "fr", "rl", "rr")]
    if all(c is not None for c in corners):
        fl, fr, rl, rr = (c for c in corners if c is not None)
        # the tyres, which the sensors do not see, add about a seventh
        angle = 1.15 * (fl + fr - rl - rr) / (2 * wheelbase)
        return np.gradient(angle), "suspension deflections", 0.12
    if "pitch" in columns:
        return np.gradient(columns["pitch"]), "pitch angle", 0.1
    if "pitch_rate" in columns:
        return columns["pitch_rate"] / prepared.rate_hz, "pitch rate", 0.1
    return None


def measured_pitch(prepared: Prepared, data: AxleData, wheelbase: float) -> Pitch | None:
    """The gain from the pitch that goes with changes of the force; None where the log does not show it.

    Changes, not values: the slope of the road turns an angle against the horizon but changes slowly.
    """
    steps = _angle_steps(prepared, wheelbase)
    if steps is None:
        return None
    changes, source, scale = steps
    # summed on the grid that they were taken on: the data may be coarser
    there, angle = np.isfinite(changes), np.nancumsum(changes)
    force = data.force()
    rate, x, y = data.rate_hz, [], []
    span = max(1, round(rate))
    for first, past in data.runs():
        rows = data.rows[first:past]
        if past - first < 8 * span or not there[rows].all():
            continue
        a, f = (lowpass(v, rate, PITCH_BAND_HZ) for v in (angle[rows], force[first:past]))
        x.append(f[span:] - f[:-span])
        y.append(a[span:] - a[:-span])
    if not x:
        return None
    df, da = np.concatenate(x), np.concatenate(y)
    power = float(df @ df)
    slope = float(df @ da) / power if power > 0 else 0.0
    left = da - slope * df
    total = float(da @ da)
    if total <= 0 or 1 - float(left @ left) / total < LEAST_PITCH_EXPLAINED:
        return None
    # forward is nose up, hence the minus; what lies within two seconds hangs together
    error = math.sqrt(float(left @ left) / len(left) * 2 * rate / power)
    gain = -GRAVITY * slope
    if data.accel is not None:
        # the accelerometer's own reading holds the gain already
        gain /= 1 - gain
    return Pitch(gain, math.hypot(GRAVITY * error, scale * abs(gain), 0.002), f"fitted to the {source}")


def usual_pitch(vehicle: Vehicle, wheelbase: float, axle: float, height: float) -> Pitch:
    """The gain from springs where the file has them, else from the usual ride frequency: g h' / (omega² a b)."""
    arm = max(height - PITCH_AXIS[0] * wheelbase, 0.1)
    front, rear = vehicle.get("spring_rate_front_npm"), vehicle.get("spring_rate_rear_npm")
    mass = vehicle.get("mass_kg")
    behind = wheelbase - axle
    if front is not None and rear is not None and mass is not None:
        tyre = vehicle.get("tire_vertical_rate_npm")
        soft = [k.value if tyre is None else 1 / (1 / k.value + 1 / tyre.value) for k in (front, rear)]
        stiffness = 2 * soft[0] * axle**2 + 2 * soft[1] * behind**2
        gain = SPRUNG_SHARE * mass.value * GRAVITY * arm / stiffness
        return Pitch(gain, 0.25 * gain, "spring rates of the vehicle file")
    omega2 = (2 * math.pi * RIDE_HZ[0]) ** 2
    gain = GRAVITY * arm / (omega2 * max(axle * behind, 0.1 * wheelbase**2))
    return Pitch(gain, gain * 2 * RIDE_HZ[1] / RIDE_HZ[0], "usual ride frequency of 1.5 ± 0.35 Hz")


def quantity(vehicle: Vehicle, key: str, usual: tuple[float, float], words: str) -> Quantity:
    """The file's quantity, else a usual one."""
    found = vehicle.get(key)
    return found if found is not None else Quantity(usual[0], usual[1], words)


def drag_moment(vehicle: Vehicle, height: float, heavy: bool) -> tuple[float, float, Assumption]:
    """Moment of drag (and lift) about the ground over v², N·m per (m/s)²: mean, std, and the assumption."""
    usual = DRAG_AREA_HEAVY if heavy else DRAG_AREA_LIGHT
    area = quantity(vehicle, "drag_area_m2", usual, "usual for its mass")
    mean = 0.5 * AIR_DENSITY * area.value * DRAG_HEIGHT[0] * height
    std = mean * math.hypot(area.std / area.value, DRAG_HEIGHT[1] / DRAG_HEIGHT[0])
    words = f"drag area {area.value:.2g} ± {area.std:.2g} m² at {DRAG_HEIGHT[0]:g} ± {DRAG_HEIGHT[1]:g} of the CG height"
    return mean, std, Assumption("drag's moment", words, area.source)


def pitch_axis(vehicle: Vehicle, wheelbase: float) -> tuple[float, float, str]:
    """Height above ground of the axis about which load transfer pitches the body, m: mean, std, source.

    Of braking and of driving where the file has both; else a usual share of the wheelbase.
    """
    known = [
        q
        for key in ("pitch_center_height_m", "pitch_center_height_drive_m")
        if (q := vehicle.get(key)) is not None
    ]
    if not known:
        return PITCH_AXIS[0] * wheelbase, PITCH_AXIS[1] * wheelbase, "usual for the wheelbase"
    mean = sum(q.value for q in known) / len(known)
    apart = max(abs(q.value - mean) for q in known) if len(known) > 1 else 0.03
    return mean, math.hypot(max(q.std for q in known), apart), "vehicle file"


def pitch_inertia(vehicle: Vehicle, wheelbase: float, mass: float) -> tuple[float, float, str]:
    """Pitch inertia of the whole vehicle, kg·m²: mean, std, source. mass: about what it weighs, kg."""
    stated = vehicle.get("pitch_inertia_kgm2")
    if stated is not None:
        # the load adds to the empty vehicle's
        return stated.value, math.hypot(stated.std, 0.2 * stated.value), stated.source
    usual = PITCH_INERTIA[0] * mass * wheelbase**2
    return usual, PITCH_INERTIA[1] * mass * wheelbase**2, "usual for mass and wheelbase"


def spin_moment(vehicle: Vehicle, moment: float) -> tuple[float, float, str]:
    """Spin inertia of all wheels over the radius, kg·m: mean, std, source. moment: m h in kg·m."""
    inertia, radius = vehicle.get("wheel_inertia_kgm2"), vehicle.get("wheel_radius_m")
    if inertia is None or radius is None:
        return WHEEL_SPIN_SHARE[0] * moment, WHEEL_SPIN_SHARE[1] * moment, "usual share of m h"
    value = 4 * inertia.value / radius.value
    return value, value * math.hypot(inertia.std / inertia.value, radius.std / radius.value), "vehicle file"


def rolling_arm(vehicle: Vehicle, wheelbase: float) -> tuple[float, float, str]:
    """Rolling resistance times wheel radius, m: mean, std, source."""
    radius = quantity(
        vehicle,
        "wheel_radius_m",
        (RADIUS_SHARE[0] * wheelbase, RADIUS_SHARE[1] * wheelbase),
        "usual for the wheelbase",
    )
    factor = quantity(vehicle, "rolling_resistance", ROLLING, "usual for road tyres")
    value = factor.value * radius.value
    # whether the resistance turns the axle loads as (1)-(2) say hangs on the tyre: half of it is doubt
    return value, math.hypot(0.5 * value, factor.std * radius.value), factor.source
