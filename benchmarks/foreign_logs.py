"""What is logged of a foreign drive and what its owner wrote of the car: columns by their canonical names, and TOML.

Sensors are simple, as in a quick test: white noise, a constant offset and scale, an inertial unit that stands somewhere
in the body and a little askew. Vehicle files are short or long, and right or wrong by what data sheets are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import foreign_parts as fp
import foreign_pillars
import foreign_planes
import foreign_ride
import numpy as np
import polars as pl
from foreign_car import Array, Car, G, draw_car, draw_load, squeezed, with_load
from foreign_course import make_course
from foreign_parts import Choices

WHEELS = ("fl", "fr", "rl", "rr")
SENSORS = ("deflection", "ins", "imu", "struts", "axle", "all")
FILES = ("full", "plain", "minimal")

STYLES = {
    "planes": (foreign_planes, Choices(magic=0.0)),
    "planes without tipping": (foreign_planes, Choices(tips=1.0, links=0.0)),
    "ride": (foreign_ride, Choices(stiff=2.0)),
    "ride without anti-dive": (foreign_ride, Choices(links=0.0)),
    "ride, hubs past the springs": (foreign_ride, Choices(lean=0.0, nose=0.0)),
    "ride, axis in the ground": (foreign_ride, Choices(axis=0.0, links=0.0, lean=0.0)),
    "ride, all simple": (foreign_ride, Choices(links=0.0, lean=0.0, tips=1.0, magic=0.0, turned=0.0, spin=0.0)),
    "pillars": (foreign_pillars, Choices(axis=0.0, links=0.0)),
}  # fmt: skip
"""The simulators and their authors' choices."""


@dataclass(frozen=True)
class Case:
    """One drive to judge. exact: whether the vehicle file's figures are the car's own."""

    style: str
    drive: str
    sensors: str
    file: str
    seed: int
    exact: bool = False


@dataclass(frozen=True)
class Log:
    """A drive as a user has it."""

    frame: pl.DataFrame
    vehicle: str
    truth: dict[str, float]


def noisy(
    values: Array, rng: np.random.Generator, noise: float, offset: float = 0.0, scale: float = 0.0
) -> Array:
    """Values with white noise, and a constant offset and scale error drawn with these standard deviations."""
    wrong = values * (1 + scale * rng.standard_normal()) + offset * rng.standard_normal()
    return np.asarray(wrong + noise * rng.standard_normal(len(values)))


def _unit(rows: Array, full: Car, mount: Array, rng: np.random.Generator) -> dict[str, Array]:
    """Six axes at `mount` (behind the front axle, left, above the road)."""
    place = np.array([full.sprung_x - mount[0], mount[1] - full.sprung_y, mount[2] - full.sprung_height])
    rate, turning = rows[:, fp.P : fp.R + 1], rows[:, fp.DP : fp.DR + 1]
    accel = rows[:, fp.FX : fp.FZ + 1] + np.cross(turning, place) + np.cross(rate, np.cross(rate, place))
    askew = rng.normal(0, np.radians(0.4), 3)
    accel, rate = accel + np.cross(accel, askew), rate + np.cross(rate, askew)
    size = rng.uniform(0.4, 1.5)
    out = {f"accel_{a}_mps2": noisy(accel[:, i], rng, 0.05 * size, 0.04 * size) for i, a in enumerate("xyz")}
    for i, axis in enumerate(("roll", "pitch", "yaw")):
        out[f"{axis}_rate_radps"] = noisy(rate[:, i], rng, 0.003 * size, 0.001 * size)
    return out


def _pedals(rows: Array, full: Car, rng: np.random.Generator, *, torque: bool) -> dict[str, Array]:
    pressure = rows[:, fp.BRAKE] / full.brake_gain
    out = {"brake_pressure_pa": np.maximum(noisy(pressure, rng, 1e4, 0, 0.01), 0)}
    if torque:
        out["drive_torque_nm"] = noisy(rows[:, fp.DRIVE], rng, 10, 0, 0.02)
    return out


def _by_wheel(name: str, unit: str, values: Array) -> dict[str, Array]:
    return {f"{name}_{w}_{unit}": values[:, i] for i, w in enumerate(WHEELS)}


def _more(rows: Array, empty: Car, full: Car, sensors: str, rng: np.random.Generator) -> dict[str, Array]:
    """What the set has beside the inertial unit and the speed."""
    out: dict[str, Array] = {}
    if sensors != "imu":
        out |= _pedals(rows, full, rng, torque=sensors in ("ins", "axle", "all"))
    if sensors in ("deflection", "all"):
        squeeze = rows[:, fp.DEFLECTION : fp.DEFLECTION + 4] + squeezed(empty, full)
        read = np.column_stack([noisy(squeeze[:, i], rng, 5e-4, 8e-4, 0.005) for i in range(4)])
        out |= _by_wheel("suspension_deflection", "m", read)
    if sensors in ("ins", "all"):
        out["roll_rad"] = noisy(rows[:, fp.ROLL], rng, 1e-3, 2e-3)
        out["pitch_rad"] = noisy(rows[:, fp.PITCH], rng, 1e-3, 2e-3)
    if sensors == "struts":
        forces = np.column_stack([noisy(rows[:, fp.STRUT + i], rng, 20, 20, 0.005) for i in range(4)])
        turned = rows[:, fp.DP : fp.DQ + 1]
        lift = (
            rows[:, fp.FZ, None]
            + np.outer(turned[:, 0], fp.flat(full).left)
            - np.outer(turned[:, 1], fp.flat(full).ahead)
        )
        corners = np.column_stack([noisy(lift[:, i], rng, 0.05, 0.03) for i in range(4)])
        out |= _by_wheel("suspension_force", "n", forces) | _by_wheel("accel_z_sprung", "mps2", corners)
    if sensors == "axle":
        normal = rows[:, fp.NORMAL : fp.NORMAL + 4]
        for name, pair in (("front", normal[:, :2]), ("rear", normal[:, 2:])):
            out[f"axle_load_{name}_n"] = noisy(pair.sum(axis=1), rng, 60, 40, 0.005)
    if sensors in ("axle", "all"):
        speeds = rows[:, fp.SPEEDS : fp.SPEEDS + 4]
        out |= _by_wheel(
            "wheel_speed", "mps", np.maximum(speeds + 0.02 * rng.standard_normal(speeds.shape), 0)
        )
    return out


def known_figures(car: Car, choices: Choices, rng: np.random.Generator, share: float) -> dict[str, float]:
    """Every figure of the empty car; share: 0 exact, 1 wrong as data sheets are."""

    def about(value: float, spread: float) -> float:
        return value * (1 + share * spread * float(np.clip(rng.standard_normal(), -2.5, 2.5)))

    def near(value: float, spread: float) -> float:
        return value + share * spread * float(rng.standard_normal())

    pairs = {
        "track_{}_m": (car.track, 0.003),
        "spring_rate_{}_npm": (car.spring, 0.02),
        "anti_roll_stiffness_{}_nmprad": (car.bar, 0.04),
        "unsprung_mass_{}_kg": (car.unsprung, 0.05),
        "damper_rate_{}_nspm": (car.damper, 0.08),
    }
    found = {
        name.format(axle): about(values[i], spread)
        for name, (values, spread) in pairs.items()
        for i, axle in enumerate(("front", "rear"))
    }
    for i, axle in enumerate(("front", "rear")):
        found[f"roll_center_height_{axle}_m"] = near(choices.axis * car.centre[i], 0.02)
    return found | {
        "mass_kg": about(car.mass, 0.01),
        "wheelbase_m": about(car.wheelbase, 0.002),
        "cg_to_front_axle_m": near(car.x, 0.01),
        "pitch_center_height_m": near(choices.links * car.dive * car.height, 0.02),
        "pitch_center_height_drive_m": near(choices.links * car.squat * car.height, 0.03),
        "roll_inertia_kgm2": about(car.inertia[0], 0.05),
        "pitch_inertia_kgm2": about(car.inertia[1], 0.05),
        "roll_stiffness_nmprad": about(car.roll_stiffness, 0.02),
        "tire_vertical_rate_npm": about(car.tyre_rate, 0.05),
        "wheel_radius_m": about(car.radius, 0.004),
        "wheel_inertia_kgm2": about(car.wheel_inertia, 0.1),
        "steering_ratio": car.steering,
        "brake_gain_nmppa": about(car.brake_gain, 0.02),
        "brake_front_share": car.brake_front,
        "drive_front_share": car.drive_front,
        "drag_area_m2": about(car.drag_area, 0.05),
        "rolling_resistance": about(car.rolling, 0.1),
    }


PLAIN = ("mass_kg", "wheelbase_m", "cg_to_front_axle_m", "track_", "spring_rate_", "anti_roll_", "wheel_radius_m",
         "brake_gain_nmppa", "roll_center_")  # fmt: skip
MINIMAL = ("mass_kg", "wheelbase_m", "track_", "roll_stiffness_nmprad", "brake_gain_nmppa")


def _gradient(rows: Array, level: bool) -> float:
    """Roll against the road in degrees for a g of sensed lateral acceleration, quick motion taken out.

    level: the rows hold it without what an accelerometer would sense of the body's lean.
    """
    moving = rows[:, fp.V] > 4
    roll = (rows[:, fp.ROLL] - rows[:, fp.BANK])[moving]
    because = rows[moving][:, [fp.FY, fp.P, fp.DP]]
    because[:, 0] += G * np.sin(roll) * level
    if np.ptp(because[:, 0]) < 2:
        return float("nan")
    return float(np.degrees(np.linalg.lstsq(because, roll, rcond=None)[0][0]) * G)


def truth_of(full: Car, axis: float, rows: Array, *, level: bool = False) -> dict[str, float]:
    """The loaded car. level: see `_gradient`."""
    height = full.axis * axis
    found = {
        "mass_kg": full.mass, "cg_height_m": full.height, "cg_to_front_axle_m": full.x, "cg_lateral_offset_m": full.y,
        "sprung_mass_kg": full.sprung, "sprung_cg_height_m": full.sprung_height,
        "roll_arm_m": full.sprung_height - height,
        "roll_stiffness_nmprad": full.roll_stiffness, "roll_inertia_kgm2": full.inertia[0],
        "pitch_inertia_kgm2": full.inertia[1], "roll_gradient_degpg": _gradient(rows, level),
        "corner_mass_fl_kg": float(full.resting[0] / G + full.unsprung[0] / 2),
        "corner_mass_rr_kg": float(full.resting[3] / G + full.unsprung[1] / 2),
    }  # fmt: skip
    return {name: value for name, value in found.items() if np.isfinite(value)}


def _file(case: Case, figures: dict[str, float], mount: Array, truth: dict[str, float], body: str) -> str:
    keys = {"full": ("",), "plain": PLAIN, "minimal": MINIMAL}[case.file]
    kept = {k: v for k, v in figures.items() if k.startswith(keys)}
    if case.file == "full":
        kept.pop("roll_stiffness_nmprad")
        if STYLES[case.style][0] is foreign_planes:
            kept.pop("tire_vertical_rate_npm")
    lines = ["[vehicle]", 'name = "foreign"', f'body = "{body}"' if case.file != "minimal" else ""]
    lines += [f"{k} = {v:.7g}" for k, v in kept.items()]
    if case.file == "full":
        names = ("imu_behind_front_axle_m", "imu_left_m", "imu_above_ground_m")
        lines += ["[sensors]", *(f"{n} = {v:.4f}" for n, v in zip(names, mount, strict=True))]
    lines += ["[reference]", *(f"{k} = {v:.7g}" for k, v in truth.items())]
    return "\n".join(lines) + "\n"


def make_log(case: Case) -> Log:
    """Simulate a case; the car, its load and the course follow from the seed, whatever the style and the sensors."""
    rng = np.random.default_rng([case.seed, 4711])
    simulator, choices = STYLES[case.style]
    car = draw_car(rng)
    if rng.random() < 0.5:
        car = replace(car, drive_front=1.0)
    full = with_load(car, draw_load(car, rng), sags=bool(rng.random() < 0.5))
    course = make_course(full, case.drive, rng, hilly=bool(rng.random() < 0.5))
    rows = simulator.run(full, course, choices)
    every = int(rng.choice([1, 2, 4]))
    rows = rows[: len(rows) // every * every].reshape(-1, every, fp.WIDTH).mean(axis=1)
    mount = np.array([rng.uniform(1.0, 1.8), rng.uniform(-0.2, 0.2), rng.uniform(0.35, 0.8)])
    columns = {"time_s": rows[:, fp.T] - rows[0, fp.T]}
    columns["speed_mps"] = np.maximum(noisy(rows[:, fp.V], rng, 0.03, 0, 0.002), 0) * (rows[:, fp.V] > 0.05)
    columns |= _unit(rows, full, mount, rng) | _more(rows, car, full, case.sensors, rng)
    figures = known_figures(car, choices, rng, 0.0 if case.exact else 1.0)
    truth = truth_of(full, choices.axis, rows)
    return Log(pl.DataFrame(columns), _file(case, figures, mount, truth, car.body), truth)
