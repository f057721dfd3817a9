"""Logs and vehicle files as strangers write them: other rates, filters, steps of a bus, drift, axes, and hardly any figures.

The same rows as `foreign_logs`, read by other recorders: 20, 50, 200 or 1000 Hz; an inertial unit behind a low-pass that
makes it late; counts of a bus; offsets that walk; SAE axes (y right, z down). Files that hold five figures or eight.
"""

from __future__ import annotations

from dataclasses import replace

import foreign_algebra
import foreign_bicycle
import foreign_parts as fp
import foreign_planes
import foreign_rig
import numpy as np
import polars as pl
from foreign_car import Array, Car, draw_car, draw_load, squeezed, with_load
from foreign_course import make_course
from foreign_logs import WHEELS, Case, Log, known_figures, truth_of
from foreign_parts import Choices

STRANGERS = {
    "algebra": (foreign_algebra, Choices(axis=0.0, links=0.0, tips=0.0), True),
    "algebra, level": (foreign_algebra, Choices(axis=0.0, links=0.0, tips=1.0), True),
    "bicycle": (foreign_bicycle, Choices(links=0.0), False),
    "bicycle, axis in the ground": (foreign_bicycle, Choices(axis=0.0, links=0.0), True),
    "rig": (foreign_rig, Choices(), False),
    "rig with leaf springs": (foreign_rig, Choices(stiff=2.0, links=0.0), False),
    "planes, no hubs": (foreign_planes, Choices(tips=0.0, links=0.0, axis=0.0), True),
}  # fmt: skip
"""Simulators, their authors' choices, and whether the author knows no unsprung mass nor roll centre."""

STRANGE_SENSORS = ("deflection", "ins", "struts", "axle", "tyres", "roll", "rig", "all")
SPARSE = ("mass_kg", "wheelbase_m", "track_", "spring_rate_")
FEW = (*SPARSE, "cg_to_front_axle_m", "anti_roll_", "roll_inertia_kgm2", "brake_gain_nmppa", "wheel_radius_m")
LONG = (*FEW, "pitch_inertia_kgm2", "damper_rate_", "unsprung_mass_", "roll_center_", "tire_vertical_rate_npm",
        "drag_area_m2", "rolling_resistance")  # fmt: skip
STRANGE_FILES = {"sparse": SPARSE, "few": FEW, "long": LONG}
STEPS = {"accel": 0.01, "rate": 0.0005, "speed": 0.01, "angle": 0.0005, "deflection": 5e-4, "force": 10.0,
         "pressure": 1e4, "torque": 5.0}  # fmt: skip
"""What one count of the bus is worth."""


def plain_car(car: Car) -> Car:
    """The car without what simple authors never heard of: unsprung masses and roll centres."""
    return replace(car, unsprung=(1e-3, 1e-3), centre=(0.0, 0.0))


class Recorder:
    """How one log is written. late: low-pass of the inertial unit, Hz (0: none); counts: steps of a bus; drift: a minute's."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.rate = float(rng.choice([20.0, 50.0, 200.0, 1000.0], p=[0.25, 0.35, 0.3, 0.1]))
        self.late = float(rng.choice([0.0, 5.0, 12.0]))
        self.counts = bool(rng.random() < 0.5)
        self.drift = float(rng.choice([0.0, 1.0]))
        self.sae = bool(rng.random() < 0.25)
        self.size = float(rng.uniform(0.3, 1.5))

    def read(self, values: Array, kind: str, noise: float, offset: float = 0.0, scale: float = 0.0) -> Array:
        """A channel at the log's rate."""
        v, rng = values, self.rng
        if kind in ("accel", "rate") and self.late:
            pole = np.exp(-2 * np.pi * self.late / fp.LOG_HZ)
            for _ in range(2):
                v = _followed(v, pole)
        count = int(len(v) / fp.LOG_HZ * self.rate)
        at = np.arange(count) * fp.LOG_HZ / self.rate
        if self.rate < fp.LOG_HZ:
            width = int(fp.LOG_HZ / self.rate)
            v = v[: len(v) // width * width].reshape(-1, width).mean(axis=1)[:count]
        else:
            v = np.interp(at, np.arange(len(v)), v)
        v = v * (1 + scale * rng.standard_normal()) + self.size * offset * rng.standard_normal()
        noise *= self.size * np.sqrt(self.rate / 100.0)
        v = v + noise * rng.standard_normal(len(v))
        if kind in ("accel", "rate") and self.drift:
            walk = np.cumsum(rng.standard_normal(len(v))) / np.sqrt(60 * self.rate)
            v = v + self.drift * offset * 0.5 * walk
        return np.asarray(np.round(v / STEPS[kind]) * STEPS[kind] if self.counts else v)


def _followed(values: Array, pole: float) -> Array:
    from scipy.signal import lfilter

    first = values[0] * pole
    return np.asarray(lfilter([1 - pole], [1, -pole], values, zi=[first])[0])


def _unit(rec: Recorder, rows: Array, full: Car, mount: Array) -> dict[str, Array]:
    place = np.array([full.sprung_x - mount[0], mount[1] - full.sprung_y, mount[2] - full.sprung_height])
    rate, turning = rows[:, fp.P : fp.R + 1], rows[:, fp.DP : fp.DR + 1]
    accel = rows[:, fp.FX : fp.FZ + 1] + np.cross(turning, place) + np.cross(rate, np.cross(rate, place))
    askew = rec.rng.normal(0, np.radians(0.3), 3)
    accel, rate = accel + np.cross(accel, askew), rate + np.cross(rate, askew)
    out = {f"accel_{a}_mps2": rec.read(accel[:, i], "accel", 0.05, 0.03) for i, a in enumerate("xyz")}
    for i, axis in enumerate(("roll", "pitch", "yaw")):
        out[f"{axis}_rate_radps"] = rec.read(rate[:, i], "rate", 0.003, 0.001)
    return out


def _wheels(
    rec: Recorder, name: str, unit: str, values: Array, kind: str, *errors: float
) -> dict[str, Array]:
    return {f"{name}_{w}_{unit}": rec.read(values[:, i], kind, *errors) for i, w in enumerate(WHEELS)}


def _more(rec: Recorder, rows: Array, empty: Car, full: Car, sensors: str) -> dict[str, Array]:
    out = {"steering_wheel_angle_rad": rec.read(rows[:, fp.STEER] * full.steering, "angle", 0.005)}
    if sensors not in ("roll", "rig"):
        out["brake_pressure_pa"] = np.maximum(
            rec.read(rows[:, fp.BRAKE] / full.brake_gain, "pressure", 1e4, 0, 0.01), 0
        )
    if sensors in ("ins", "axle", "all"):
        out["drive_torque_nm"] = rec.read(rows[:, fp.DRIVE], "torque", 10, 0, 0.02)
    if sensors in ("deflection", "rig", "all"):
        squeeze = rows[:, fp.DEFLECTION : fp.DEFLECTION + 4] + squeezed(empty, full)
        out |= _wheels(rec, "suspension_deflection", "m", squeeze, "deflection", 5e-4, 8e-4, 0.005)
    if sensors in ("ins", "roll", "all"):
        out["roll_rad"] = rec.read(rows[:, fp.ROLL], "angle", 1e-3, 2e-3)
    if sensors in ("ins", "all"):
        out["pitch_rad"] = rec.read(rows[:, fp.PITCH], "angle", 1e-3, 2e-3)
    if sensors in ("struts", "rig"):
        turned, f = rows[:, fp.DP : fp.DQ + 1], fp.flat(full)
        lift = rows[:, fp.FZ, None] + np.outer(turned[:, 0], f.left) - np.outer(turned[:, 1], f.ahead)
        out |= _wheels(rec, "accel_z_sprung", "mps2", lift, "accel", 0.05, 0.03)
    if sensors == "struts":
        out |= _wheels(rec, "suspension_force", "n", rows[:, fp.STRUT : fp.STRUT + 4], "force", 20, 20, 0.005)
    if sensors == "rig":
        hubs = (rows[:, fp.NORMAL : fp.NORMAL + 4] - rows[:, fp.STRUT : fp.STRUT + 4]) / np.maximum(
            fp.flat(full).hub, 1.0
        )
        out |= _wheels(rec, "accel_z_unsprung", "mps2", hubs, "accel", 0.1, 0.03)
    normal = rows[:, fp.NORMAL : fp.NORMAL + 4]
    if sensors == "tyres":
        out |= _wheels(rec, "tire_normal_force", "n", normal, "force", 40, 20, 0.005)
    if sensors == "axle":
        for name, pair in (("front", normal[:, :2]), ("rear", normal[:, 2:])):
            out[f"axle_load_{name}_n"] = rec.read(pair.sum(axis=1), "force", 60, 40, 0.005)
    if sensors in ("axle", "all"):
        out |= _wheels(
            rec, "wheel_speed", "mps", np.maximum(rows[:, fp.SPEEDS : fp.SPEEDS + 4], 0), "speed", 0.02
        )
    return out


SAE_TURNED = ("accel_y", "accel_z_mps2", "pitch_rate", "yaw_rate", "pitch_rad", "steering")


def _file(
    case: Case, figures: dict[str, float], mount: Array, truth: dict[str, float], body: str, plain: bool
) -> str:
    keys = STRANGE_FILES[case.file]
    kept = {k: v for k, v in figures.items() if k.startswith(keys)}
    if plain:
        kept = {k: v for k, v in kept.items() if not k.startswith(("unsprung", "roll_center", "tire_v"))}
    lines = ["[vehicle]", 'name = "stranger"', f'body = "{body}"' if case.seed % 2 else ""]
    lines += [f"{k} = {v:.7g}" for k, v in kept.items()]
    if case.file == "long":
        names = ("imu_behind_front_axle_m", "imu_left_m", "imu_above_ground_m")
        lines += ["[sensors]", *(f"{n} = {v:.4f}" for n, v in zip(names, mount, strict=True))]
    lines += ["[reference]", *(f"{k} = {v:.7g}" for k, v in truth.items())]
    return "\n".join(lines) + "\n"


def make_stranger(case: Case) -> Log:
    """Simulate a case of STRANGERS, STRANGE_SENSORS and STRANGE_FILES; all else follows from the seed."""
    rng = np.random.default_rng([case.seed, 1848])
    simulator, choices, plain = STRANGERS[case.style]
    car = draw_car(rng)
    load = draw_load(car, rng)
    if plain:
        car = plain_car(car)
    full = with_load(car, load, sags=bool(rng.random() < 0.5))
    course = make_course(full, case.drive, rng, hilly=bool(rng.random() < 0.3))
    rows = simulator.run(full, course, choices)
    rec = Recorder(rng)
    # simple authors have their unit at the CG
    middle = np.array([full.sprung_x, full.sprung_y, full.sprung_height])
    mount = (
        middle if plain else np.array([rng.uniform(1.0, 1.8), rng.uniform(-0.2, 0.2), rng.uniform(0.35, 0.8)])
    )
    speed = np.maximum(rec.read(rows[:, fp.V], "speed", 0.03, 0, 0.002), 0)
    columns = {"time_s": np.arange(len(speed)) / rec.rate, "speed_mps": speed * (speed > 0.1)}
    columns |= _unit(rec, rows, full, mount) | _more(rec, rows, car, full, case.sensors)
    least = min(map(len, columns.values()))
    columns = {k: v[:least] for k, v in columns.items()}
    if rec.sae:
        columns |= {k: -v for k, v in columns.items() if k.startswith(SAE_TURNED)}
    figures = known_figures(car, choices, rng, 0.0 if case.exact else 1.0)
    truth = truth_of(full, choices.axis, rows, level=case.style == "algebra, level")
    return Log(pl.DataFrame(columns), _file(case, figures, mount, truth, car.body, plain), truth)
