"""What the textbook car drives and what is known of it: course, sensors with errors, and a vehicle file that errs.

Everything of a drive follows from its seed: a car, one unknown load, a mixed, calm or hard drive on a flat or a rolling
road, sensor errors (scale, offset, noise, a turned inertial unit), and a data sheet of the empty car, each figure wrong
by a usual spread; every third sheet lacks what data sheets often lack. The truth stands in the file's [reference].
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import polars as pl
import textbook_motion as tm
from scipy.ndimage import gaussian_filter1d
from textbook_car import KINDS, Car, G, Load, draw_car, loaded, roll_arm, sprung, static_forces

from pipelines.results import FloatArray

WHEELS = ("fl", "fr", "rl", "rr")
SENSORS = ("deflection", "ins", "production", "all")
"""On top of a production car's sensors: strut deflections; roll and pitch angle at 100 Hz; nothing; both at 50 Hz with
strut forces and vertical accelerations at the body's corners."""
BODIES = {"suv": "SUV", "sedan": "Sedan", "van": "Van"}
HARDEST = {"mixed": 5.0, "calm": 2.5, "track": 6.0}
"""Highest acceleration asked, m/s²."""
OFTEN_UNTOLD = ("pitch_center_height_m", "pitch_center_height_drive_m", "unsprung_mass_front_kg",
                "unsprung_mass_rear_kg", "roll_inertia_kgm2", "pitch_inertia_kgm2", "damper_rate_front_nspm",
                "damper_rate_rear_nspm", "drag_area_m2")  # fmt: skip


@dataclass(frozen=True)
class Log:
    """A simulated drive: the motion (columns of `textbook_motion`), what was logged of it, and the vehicle file."""

    motion: FloatArray
    frame: pl.DataFrame
    vehicle: str


def smooth(values: FloatArray, seconds: float) -> FloatArray:
    """A Gaussian over the course's steps."""
    return np.asarray(gaussian_filter1d(values, seconds / tm.STEP_S), dtype=float)


def steps(seconds: float) -> int:
    """Whole steps of the course in so many seconds."""
    return int(seconds / tm.STEP_S)


@dataclass
class Program:
    """A drive as it is put together: speed, road wheel angle and braking (m/s²) at each step, written up to `at`."""

    rng: np.random.Generator
    count: int
    at: int = 0
    v: float = 0.0
    hardest: float = 0.0
    speed: FloatArray = field(init=False)
    steer: FloatArray = field(init=False)
    braking: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        """Stand for five seconds, wheels straight."""
        self.speed, self.steer, self.braking = np.zeros((3, self.count))
        self.at = steps(5)
        self.hardest = HARDEST[str(self.rng.choice(list(HARDEST)))]

    def _follow(self, speed: FloatArray) -> int:
        """Write speeds; how many there was room for."""
        room = min(len(speed), self.count - self.at)
        self.speed[self.at : self.at + room] = speed[:room]
        self.at += room
        return room

    def go_to(self, speed: float, rate: float) -> None:
        """A ramp of speed."""
        length = max(steps(abs(speed - self.v) / rate), 1)
        if self._follow(np.linspace(self.v, speed, length)):
            self.v = float(self.speed[self.at - 1])

    def stop(self) -> None:
        """Down to standstill by the driver's own brake, and wait."""
        rate = self.rng.uniform(1.5, self.hardest)
        length = steps(self.v / rate) + steps(0.5)
        self._follow(np.maximum(self.v - rate * np.arange(length) * tm.STEP_S, 0))
        self.v = 0.0
        self._follow(np.zeros(steps(self.rng.uniform(2, 5))))

    def brake(self) -> None:
        """A push of the pedal by pressure, not below 3 m/s."""
        length = min(steps(self.rng.uniform(0.6, 2)), self.count - self.at)
        rate = self.rng.uniform(1.5, self.hardest)
        length = min(length, steps((self.v - 3) / rate))
        if length > 0:
            time = np.arange(length) * tm.STEP_S
            self.braking[self.at : self.at + length] = rate * (1 - np.exp(-time / 0.15))
            self._follow(np.asarray(self.v - rate * time, dtype=float))
            self.v = float(self.speed[self.at - 1])

    def turn(self, how: str) -> None:
        """Sine, circle or steps of the steering at one speed, or straight on."""
        length = min(steps(self.rng.uniform(4, 10)), self.count - self.at)
        time = np.arange(length) * tm.STEP_S
        lateral = self.rng.uniform(0.3, 1) * self.hardest
        angle = min(lateral * 2.7 * (1 + self.v**2 * 0.0025) / self.v**2, 0.35)
        shape = np.zeros(length)
        if how == "sine":
            shape = np.sin(2 * np.pi * self.rng.uniform(0.15, 0.9) * time)
        elif how == "circle":
            shape = np.full(length, float(self.rng.choice([-1, 1])))
        elif how == "steps":
            shape = np.sign(np.sin(2 * np.pi * self.rng.uniform(0.1, 0.25) * time))
        fade = np.minimum(1, np.minimum(time / 0.7, (time[-1] - time) / 0.7))
        self.steer[self.at : self.at + length] = angle * shape * fade
        self._follow(np.full(length, self.v))

    def fill(self) -> None:
        """Manoeuvres by chance, then a stop; a hand that is never quite still."""
        names, chances = zip(("accelerate", 0.2), ("stop", 0.12), ("sine", 0.17), ("circle", 0.15), ("steps", 0.12),
                             ("cruise", 0.12), ("brake", 0.12), strict=True)  # fmt: skip
        while self.at < self.count - steps(15):
            what = str(self.rng.choice(names, p=chances))
            if self.v < 6 or what == "accelerate":
                self.go_to(self.rng.uniform(8, 28), self.rng.uniform(0.8, 2.5))
            elif what == "stop":
                self.stop()
            elif what == "brake":
                self.brake()
            else:
                self.turn(what)
        self.go_to(0.0, 2.0)
        self.steer = smooth(self.steer, 0.12) + 0.003 * smooth(self.rng.standard_normal(self.count), 0.5)


def draw_course(car: Car, rng: np.random.Generator) -> tm.Course:
    """Two to four minutes of driving and the road under them; three roads in ten are flat."""
    program = Program(rng, steps(rng.uniform(120, 260)))
    program.fill()
    count = program.count
    rolling = 0.0 if rng.random() < 0.3 else 1.0

    def slope(seconds: float, low: float, high: float) -> FloatArray:
        shape = smooth(rng.standard_normal(count), seconds) * np.sqrt(seconds / tm.STEP_S) * 1.9
        return np.asarray(rolling * shape * rng.uniform(low, high))

    grade, bank = slope(4, 0.005, 0.03), slope(3, 0.003, 0.02)
    roughness = rng.uniform(0.001, 0.005)
    way = np.maximum(program.speed, 0.5) * tm.STEP_S

    def profile() -> FloatArray:
        height = np.cumsum(rng.standard_normal(count) * np.sqrt(way)) * roughness * 0.6
        height -= smooth(height, 1.5)
        return smooth(height * (program.speed > 0.3), 0.004)

    left = profile()
    right = 0.6 * left + 0.8 * profile()
    pressure = program.braking * car.mass * car.radius / car.brake_gain
    return tm.Course(program.steer, program.speed, pressure, left, right, grade, bank)


def draw_load(car: Car, rng: np.random.Generator) -> Load:
    """A driver alone, or people on the seats, roof load, or a full boot."""
    place = str(rng.choice(["none", "seats", "roof", "boot"], p=[0.2, 0.3, 0.3, 0.2]))
    length = car.wheelbase
    loads = {
        "none": Load(75, 0.45 * length, 0.35, 0.75),
        "seats": Load(rng.uniform(75, 350), rng.uniform(0.42, 0.7) * length, rng.uniform(-0.2, 0.35), 0.75),
        "roof": Load(rng.uniform(60, 180), 0.5 * length, rng.uniform(-0.1, 0.1), car.cg_height * 2.4 + 0.1),
        "boot": Load(rng.uniform(80, 350), 0.98 * length, rng.uniform(-0.3, 0.3), 0.75),
    }
    return loads[place]


def squeezed_by_load(empty: Car, full: Car) -> FloatArray:
    """Deflection at rest of the loaded car against the empty one, where its sensors were set to zero, m."""
    extra = static_forces(full) - static_forces(empty)
    stiffness = np.zeros((4, 4))
    for axle, spring, bar in ((0, full.spring_front, full.bar_front), (2, full.spring_rear, full.bar_rear)):
        per_metre = bar / full.track**2
        pair = [[spring + per_metre, -per_metre], [-per_metre, spring + per_metre]]
        stiffness[axle : axle + 2, axle : axle + 2] = pair
    return np.asarray(np.linalg.solve(stiffness, extra), dtype=float)


@dataclass(frozen=True)
class Errors:
    """Draws the errors of sensors that log `count` values each."""

    rng: np.random.Generator
    count: int

    def of(
        self, values: FloatArray, scale: float = 0.0, offset: float = 0.0, noise: float = 0.0
    ) -> FloatArray:
        """Values with a drawn scale error (share) and offset, and noise; figures are standard deviations."""
        wrong = values * (1 + self.rng.normal(0, scale)) if scale else values
        if offset:
            wrong = wrong + self.rng.normal(0, offset)
        return wrong + noise * self.rng.standard_normal(self.count)


def production_columns(rows: FloatArray, car: Car, errors: Errors) -> dict[str, FloatArray]:
    """What a production car logs; the inertial unit is turned by half a degree or so."""
    turned = errors.rng.normal(0, np.radians(0.6), 3)
    accel, rate = rows[:, tm.COL_ACCEL : tm.COL_RATE], rows[:, tm.COL_RATE : tm.COL_ROLL]
    accel, rate = accel + np.cross(accel, turned), rate + np.cross(rate, turned)
    brake, drive = rows[:, tm.COL_BRAKE], rows[:, tm.COL_DRIVE]
    moving = rows[:, tm.COL_SPEED] > 0.1
    columns = {"time_s": rows[:, tm.COL_TIME]}
    columns["speed_mps"] = np.maximum(errors.of(rows[:, tm.COL_SPEED], 0.004, noise=0.03), 0) * moving
    for i, axis in enumerate("xyz"):
        columns[f"accel_{axis}_mps2"] = errors.of(accel[:, i], 0.004, 0.05, 0.05)
    for i, axis in enumerate(("roll", "pitch", "yaw")):
        columns[f"{axis}_rate_radps"] = errors.of(rate[:, i], 0.004, 0.002, 0.003)
    columns["steering_wheel_angle_rad"] = errors.of(rows[:, tm.COL_STEER] * car.steering_ratio, noise=0.003)
    columns["brake_pressure_pa"] = np.maximum(errors.of(brake / car.brake_gain, 0.02, noise=5e3), 0)
    columns["drive_torque_nm"] = errors.of(drive, 0.03, noise=8)
    columns["brake_torque_nm"] = errors.of(brake, 0.03, noise=8)
    for i, wheel in enumerate(WHEELS):
        true = rows[:, tm.COL_WHEEL_SPEED + i]
        scaled = true * (1 + errors.rng.normal(0, 0.003))
        columns[f"wheel_speed_{wheel}_mps"] = (
            scaled + 0.02 * errors.rng.standard_normal(errors.count) * moving
        )
    return columns


def more_columns(rows: FloatArray, zero: FloatArray, sensors: str, errors: Errors) -> dict[str, FloatArray]:
    """What the set has on top (see `SENSORS`). zero: deflection at rest."""
    columns = {}
    if sensors in ("deflection", "all"):
        for i, wheel in enumerate(WHEELS):
            true = rows[:, tm.COL_DEFLECTION + i] + zero[i]
            columns[f"suspension_deflection_{wheel}_m"] = errors.of(true, 0.01, 0.0012, 0.0006)
    if sensors in ("ins", "all"):
        columns["roll_rad"] = errors.of(rows[:, tm.COL_ROLL], offset=0.003, noise=0.0008)
        columns["pitch_rad"] = errors.of(rows[:, tm.COL_PITCH], offset=0.003, noise=0.0008)
    if sensors == "all":
        for i, wheel in enumerate(WHEELS):
            corner, strut = rows[:, tm.COL_CORNER + i], rows[:, tm.COL_STRUT + i]
            columns[f"accel_z_sprung_{wheel}_mps2"] = errors.of(corner, offset=0.03, noise=0.05)
            columns[f"suspension_force_{wheel}_n"] = errors.of(strut, 0.005, 15, 20)
    return columns


def data_sheet(car: Car, rng: np.random.Generator) -> dict[str, float]:
    """The empty car as its owner knows it."""

    def about(true: float, share: float) -> float:
        return float(true * (1 + share * np.clip(rng.standard_normal(), -2.5, 2.5)))

    def near(true: float, spread: float) -> float:
        return float(true + spread * rng.standard_normal())

    sheet = {
        "mass_kg": about(car.mass, 0.01),
        "unsprung_mass_front_kg": about(car.unsprung_front, 0.05),
        "unsprung_mass_rear_kg": about(car.unsprung_rear, 0.05),
        "wheelbase_m": about(car.wheelbase, 0.002),
        "track_front_m": about(car.track, 0.004),
        "track_rear_m": about(car.track, 0.004),
        "cg_to_front_axle_m": near(car.cg_behind, 0.01),
        "roll_center_height_front_m": near(car.roll_centre_front, 0.02),
        "roll_center_height_rear_m": near(car.roll_centre_rear, 0.02),
        "pitch_center_height_m": near(car.pitch_centre_braking, 0.02),
        "pitch_center_height_drive_m": near(car.pitch_centre_driving, 0.03),
        "roll_inertia_kgm2": about(car.roll_inertia, 0.05),
        "pitch_inertia_kgm2": about(car.pitch_inertia, 0.05),
        "spring_rate_front_npm": about(car.spring_front, 0.02),
        "spring_rate_rear_npm": about(car.spring_rear, 0.02),
        "damper_rate_front_nspm": about(car.damper_front, 0.08),
        "damper_rate_rear_nspm": about(car.damper_rear, 0.08),
        "anti_roll_stiffness_front_nmprad": about(car.bar_front, 0.04),
        "anti_roll_stiffness_rear_nmprad": about(car.bar_rear, 0.04),
        "tire_vertical_rate_npm": about(car.tyre_rate, 0.05),
        "wheel_radius_m": about(car.radius, 0.004),
        "wheel_inertia_kgm2": about(car.wheel_inertia, 0.1),
        "steering_ratio": about(car.steering_ratio, 0.01),
        "brake_gain_nmppa": about(car.brake_gain, 0.03),
        "brake_front_share": car.brake_front,
        "drive_front_share": car.drive_front,
        "drag_area_m2": about(car.drag_area, 0.05),
        "rolling_resistance": about(car.rolling, 0.1),
    }
    poor = rng.random() < 0.35
    return {key: value for key, value in sheet.items() if not (poor and key in OFTEN_UNTOLD)}


def truth(car: Car) -> dict[str, float]:
    """The loaded car's figures that a verdict may name."""
    kg, _, _, height = sprung(car)
    springs = (car.spring_front + car.spring_rear) * car.track**2 / 2
    static = static_forces(car)
    return {
        "mass_kg": car.mass,
        "cg_height_m": car.cg_height,
        "cg_to_front_axle_m": car.cg_behind,
        "cg_lateral_offset_m": car.cg_left,
        "sprung_mass_kg": kg,
        "sprung_cg_height_m": height,
        "roll_stiffness_nmprad": springs + car.bar_front + car.bar_rear,
        "roll_inertia_kgm2": car.roll_inertia,
        "pitch_inertia_kgm2": car.pitch_inertia,
        "corner_mass_fl_kg": static[0] / G + car.unsprung_front / 2,
        "corner_mass_rr_kg": static[3] / G + car.unsprung_rear / 2,
        "roll_arm_m": roll_arm(car),
    }


def vehicle_text(kind: str, empty: Car, full: Car, mount: FloatArray, rng: np.random.Generator) -> str:
    """The vehicle file: data sheet of the empty car, the inertial unit's place, the loaded car's truth."""
    places = ("imu_behind_front_axle_m", "imu_left_m", "imu_above_ground_m")
    sections = {
        "vehicle": data_sheet(empty, rng),
        "sensors": dict(zip(places, mount, strict=True)),
        "reference": truth(full),
    }
    lines = []
    for section, values in sections.items():
        lines.append(f"[{section}]")
        if section == "vehicle":
            lines += ['name = "textbook car"', f'body = "{BODIES[kind]}"']
        lines += [f"{key} = {float(value):.8g}" for key, value in values.items()]
    return "\n".join(lines) + "\n"


def make_log(seed: int, sensors: str) -> Log:
    """One drive. sensors: one of SENSORS; the motion is the same with each."""
    rng = np.random.default_rng([seed, 991])
    kind = str(rng.choice(list(KINDS)))
    empty = draw_car(kind, rng)
    full = loaded(empty, draw_load(empty, rng))
    course = draw_course(full, rng)
    mount = np.array([rng.uniform(1, 1.8), rng.uniform(-0.2, 0.2), rng.uniform(0.35, 0.75)])
    motion = tm.run(full, course, mount)
    every = 1 if sensors == "ins" else 2
    rows = gaussian_filter1d(motion, 0.4 * every, axis=0)[::every]
    errors = Errors(rng, len(rows))
    columns = production_columns(rows, full, errors)
    columns |= more_columns(rows, squeezed_by_load(empty, full), sensors, errors)
    return Log(motion, pl.DataFrame(columns), vehicle_text(kind, empty, full, mount, rng))
