"""Drives for calibration: random vehicles, loads, manoeuvres and sensors from a seed, simulated once and kept on disk.

A kept drive is what its sensors gave, its vehicle file and its truth; the verdict's code may change under it. It is made anew where
the plan differs; where only the simulation's code differs, it is used and counted as old.
"""

from __future__ import annotations

import hashlib
import json
import math
import zipfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.vehicle_data import levelled, measured, zeroed
from benchmarks.wrong_figures import drawn_wrong, with_wrong
from parsers.drive import Drive
from parsers.errors import SettingsError
from parsers.signals import WHEELS
from pipelines.models.roll import GRAVITY
from pipelines.simulation.loads import Load
from pipelines.simulation.logs.as_drive import drive_of
from pipelines.simulation.logs.drive import Choice, simulate_log
from pipelines.simulation.logs.loads import PLACES
from pipelines.simulation.manoeuvres.base import Options
from pipelines.simulation.plant.random_vehicle import random_vehicle
from pipelines.simulation.plant.vehicle import PlantVehicle
from pipelines.simulation.records import Air
from pipelines.simulation.sensors.truth import rotation
from pipelines.simulation.sensors.units import SensorGroup, SensorLog
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

DRIVER_KG = 75.0
PERSONS_KG = 225.0
"""DRIVER_KG alone; PERSONS_KG: three beside the driver."""

PAYLOAD = {"Pickup": 0.40, "Van": 0.45}
CAR_PAYLOAD = 0.27
"""Of the empty vehicle's mass, beside the driver, by body: about what a registration allows."""

LOADS: dict[str, tuple[float, float, float]] = {
    "none": (0.08, 0.0, 0.0),
    "driver": (0.17, 0.0, 0.0),
    "roof": (0.15, 25.0, 150.0),
    "rear": (0.17, 40.0, 500.0),
    "side": (0.11, 40.0, 300.0),
    "seats": (0.15, 60.0, 350.0),
    "full": (0.10, 200.0, 700.0),
    "tail": (0.07, 40.0, 150.0),
}
"""Place -> chance, least and greatest mass in kg beside the driver ("none": nobody, as a test robot drives; "full": people on
all seats, then luggage above the rear axle and a fifth of it on the roof; "tail": on the tow bar or against the tailgate)."""

ROADS = {"public_road": 0.22, "rural": 0.12, "urban": 0.12, "hills": 0.09, "handling_track": 0.08}
TESTS = {
    "mixed_minute": 0.06, "slalom": 0.05, "slalom_36m": 0.03, "sine_with_dwell": 0.05, "double_lane_change": 0.03,
    "slowly_increasing_steer": 0.02, "step_steer": 0.02, "steady_circle": 0.03, "straight_braking": 0.02,
    "launch_and_stop": 0.04, "weave": 0.02,
}  # fmt: skip
"""Manoeuvres and their chances: roads last 1 to 12 minutes, tests 1 to 4."""

SENSORS = {
    "deflection": 0.28, "production": 0.16, "ins": 0.20, "axle_load": 0.12, "struts": 0.12, "imu": 0.12,
}  # fmt: skip


@dataclass(frozen=True)
class Plan:
    """One drive before it is driven. mirrored: loads and driver on the right instead of the left. told: whether the vehicle file gives the height about which the links pitch the body. wrong: a kind of figures (`benchmarks.wrong_figures`) that is off by several of its stated spreads.

    error_scale: of the sensors; sheet_errors: of the vehicle file; both 1 = as large as their kind's. air: density, kg/m³, and wind, m/s,
    ahead and to the left of the start.
    """

    seed: int
    manoeuvre: str
    sensors: str
    load: str
    load_kg: float
    minutes: float
    severity: float = 1.0
    friction: float | None = None
    surface: str | None = None
    error_scale: float = 1.0
    sheet_errors: float = 1.0
    dropouts_per_s: float = 0.0
    outlier_share: float = 0.0
    told: bool = True
    mirrored: bool = False
    wrong: str = ""
    air: tuple[float, float, float] = (1.2, 0.0, 0.0)

    @property
    def key(self) -> str:
        """Names its file: a hash of all that decides the drive (what is wrong in the vehicle file does not)."""
        figures = {name: value for name, value in asdict(self).items() if name != "wrong"}
        return hashlib.sha256(json.dumps(figures, sort_keys=True).encode()).hexdigest()[:16]

    @property
    def text(self) -> str:
        """In a few words."""
        return f"seed {self.seed}: {self.manoeuvre}, {self.minutes:.1f} min, {self.sensors}, {self.load} {self.load_kg:.0f} kg"


@dataclass(frozen=True)
class Kept:
    """A drive that was driven, or why it could not be (drive is None). sizes: what errors are related to."""

    plan: Plan
    drive: Drive | None
    sheet: str
    truth: dict[str, float]
    sizes: dict[str, float]
    body: str
    reason: str
    old: bool
    level: dict[str, float]
    zeros: dict[str, float] | None

    def vehicle(self, mass_std: float | None = None, data: str = "sheet") -> Vehicle:
        """Its vehicle file. data: how well it knows the vehicle (`benchmarks.vehicle_data`).

        mass_std: the empty mass drawn anew with this relative spread instead of the data sheet's.
        """
        file = with_wrong(parse_vehicle(self.sheet, Path("vehicle.toml")), self.plan.wrong, self.plan.seed)
        if data != "sheet":
            rng = np.random.default_rng([self.plan.seed, 23])
            file = measured(file, plan_vehicle(self.plan), rng, self.plan.sheet_errors)
        if data in ("levelled", "zeroed"):
            rng = np.random.default_rng([self.plan.seed, 24])
            file = levelled(file, self.level, rng, self.plan.sheet_errors)
        if data == "zeroed":
            if self.zeros is None:
                raise ValueError("this drive was kept before sensors' zeros were: take another --cache")
            rng = np.random.default_rng([self.plan.seed, 25])
            file = zeroed(file, self.zeros, rng, self.plan.sheet_errors)
        if mass_std is None:
            return file
        draw = float(np.clip(np.random.default_rng([self.plan.seed, 22]).standard_normal(), -2.5, 2.5))
        weighed = plan_vehicle(self.plan).mass_kg * (1 + mass_std * draw)
        mass = Quantity(weighed, mass_std * weighed, "vehicle file")
        return replace(file, quantities={**file.quantities, "mass_kg": mass})


def _chosen(rng: np.random.Generator, chances: dict[str, float]) -> str:
    share = np.array(list(chances.values()))
    return str(rng.choice(list(chances), p=share / share.sum()))


def random_plan(seed: int, sensors: str | None = None) -> Plan:
    """A plan of the calibration study. sensors: a set, or None = any."""
    rng = np.random.default_rng([seed, 20])
    manoeuvre = _chosen(rng, ROADS | TESTS)
    minutes = float(rng.uniform(1, 12 if manoeuvre in ROADS else 4))
    load, kilos = _random_load(rng)
    drawn = _chosen(rng, SENSORS)
    wet, rough, lossy = rng.random(3) < (0.15, 0.25, 0.15)
    return Plan(
        seed, manoeuvre, sensors or drawn, load, round(kilos, 1), round(minutes, 2),
        severity=round(float(rng.uniform(0.7, 1.2)), 3),
        friction=round(float(rng.uniform(0.5, 0.75)), 3) if wet else None,
        surface=str(rng.choice(["A", "B", "C"])) if rough else None,
        error_scale=round(float(np.exp(np.clip(0.25 * rng.standard_normal(), -0.5, 0.4))), 3),
        dropouts_per_s=0.01 if lossy else 0.0,
        outlier_share=1e-4 if lossy else 0.0,
        told=bool(rng.random() < 0.5),
        mirrored=bool(rng.random() < 0.5),
        wrong=drawn_wrong(seed),
        air=_air(seed),
    )  # fmt: skip


def median_plan(seed: int, sensors: str, told: bool = True) -> Plan:
    """A plan for the medians by sensor set: ten minutes of mixed public road, an unknown load."""
    rng = np.random.default_rng([seed, 21])
    load, kilos = _random_load(rng)
    mirrored = bool(rng.random() < 0.5)
    return Plan(
        seed,
        "public_road",
        sensors,
        load,
        round(kilos, 1),
        10.0,
        told=told,
        mirrored=mirrored,
        air=_air(seed),
    )


def _air(seed: int) -> tuple[float, float, float]:
    """Air of -5 to 35 °C between the sea and some 500 m, and a wind of up to 6 m/s (2.5 m/s usual) toward anywhere, from a stream of its own."""
    rng = np.random.default_rng([seed, 25])
    wind = np.clip(rng.standard_normal(2), -2.0, 2.0) * 2.0
    return round(float(rng.uniform(1.1, 1.3)), 3), round(float(wind[0]), 2), round(float(wind[1]), 2)


def _random_load(rng: np.random.Generator) -> tuple[str, float]:
    load = _chosen(rng, {name: chance for name, (chance, _, _) in LOADS.items()})
    return load, float(rng.uniform(*LOADS[load][1:]))


def plan_vehicle(plan: Plan) -> PlantVehicle:
    """The random vehicle of a plan."""
    return random_vehicle(np.random.default_rng([plan.seed, 3]))


def plan_loads(plan: Plan, vehicle: PlantVehicle) -> tuple[Load, ...]:
    """A driver (left or right), and on top what the plan says as far as the vehicle may carry it; nothing where it is "none"."""
    if plan.load == "none":
        return ()
    side = -1.0 if plan.mirrored else 1.0
    return tuple(replace(load, left_m=side * load.left_m) for load in _left_loads(plan, vehicle))


def _left_loads(plan: Plan, vehicle: PlantVehicle) -> tuple[Load, ...]:
    driver = PLACES["seats"][1](vehicle, DRIVER_KG)
    kilos = min(plan.load_kg, PAYLOAD.get(vehicle.body, CAR_PAYLOAD) * vehicle.mass_kg)
    if plan.load == "driver" or kilos < 1:
        return tuple(driver)
    if plan.load == "seats":
        return tuple(PLACES["seats"][1](vehicle, DRIVER_KG + kilos))
    if plan.load == "full":
        people = min(kilos, PERSONS_KG)
        roof = 0.2 * (kilos - people)
        shares = {"seats": DRIVER_KG + people, "rear": kilos - people - roof, "roof": roof}
        return tuple(
            load for place, part in shares.items() if part > 1 for load in PLACES[place][1](vehicle, part)
        )
    if plan.load == "tail":
        return (
            *driver,
            Load(kilos, 1.2 * vehicle.wheelbase_m, 0.0, vehicle.wheel_radius_rear_m + 0.3, 0.3, 0.8, 0.5),
        )
    return (*driver, *PLACES[plan.load][1](vehicle, kilos))


def _choice(plan: Plan) -> Choice:
    vehicle = plan_vehicle(plan)
    options = Options(
        severity=plan.severity, duration_s=60 * plan.minutes, friction=plan.friction, surface=plan.surface
    )
    return Choice(
        plan.manoeuvre, vehicle, plan_loads(plan, vehicle), options, plan.sensors, error_scale=plan.error_scale,
        dropouts_per_s=plan.dropouts_per_s, outlier_share=plan.outlier_share, sheet_errors=plan.sheet_errors,
        seed=plan.seed, air=Air(*plan.air),
    )  # fmt: skip


def simulation_hash(root: Path) -> str:
    """Of the simulation's code: tells whether a kept drive is of today's."""
    found = hashlib.sha256()
    for path in sorted((root / "pipelines" / "simulation").rglob("*.py")):
        found.update(path.read_bytes())
    return found.hexdigest()[:16]


def _drive(plan: Plan) -> tuple[SensorLog | None, dict[str, object]]:
    choice = _choice(plan)
    vehicle = choice.vehicle
    sizes = {"cg_to_front_axle_m": vehicle.wheelbase_m, "cg_lateral_offset_m": vehicle.track_front_m}
    about: dict[str, object] = {"plan": asdict(plan), "body": vehicle.body, "sizes": sizes}
    try:
        made = simulate_log(choice)
    except SettingsError as error:
        return None, about | {"reason": str(error), "sheet": "", "truth": {}}
    if made.rolled_over:
        return None, about | {"reason": "rolled over", "sheet": "", "truth": {}}
    sheet = made.sheet
    if not plan.told:
        sheet = "\n".join(line for line in sheet.splitlines() if not line.startswith("pitch_center_height"))
    return made.log, about | {
        "reason": "", "sheet": sheet, "truth": dict(made.run.truth), "level": level_reading(made.log),
        "zeros": zero_readings(made.log),
    }  # fmt: skip


def zero_readings(log: SensorLog) -> dict[str, float]:
    """What the drive's deflection sensors show with the empty vehicle at rest, m."""
    names = [f"suspension_deflection_{wheel}" for wheel in WHEELS]
    return {f"{name}_m": log.drawn[name].offset for name in names if name in log.drawn}


def level_reading(log: SensorLog) -> dict[str, float]:
    """What the drive's inertial unit shows on level ground, in degrees: its mounting and its accelerometer's offset and scale."""
    mount = next((m for unit, m in log.mounts.items() if unit in ("imu", "ins")), None)
    if mount is None or not {"accel_x", "accel_y"} <= log.drawn.keys():
        return {}
    upward = rotation(*mount.misalignment_rad).T @ np.array([0.0, 0.0, GRAVITY])
    forward, left = (
        float(upward[row] * (1 + log.drawn[name].scale_error) + log.drawn[name].offset)
        for row, name in enumerate(("accel_x", "accel_y"))
    )
    return {
        "imu_roll_deg": math.degrees(math.asin(left / GRAVITY)),
        "imu_pitch_deg": -math.degrees(math.asin(forward / GRAVITY)),
    }


def _write(path: Path, log: SensorLog | None, about: dict[str, object]) -> None:
    arrays: dict[str, object] = {}
    groups: list[tuple[str, float, list[str]]] = []
    for number, group in enumerate(log.groups if log else ()):
        names = list(group.columns)
        groups.append((group.name, group.rate_hz, names))
        arrays[f"time_{number}"] = group.time_ns
        arrays |= {f"v_{number}_{name}": group.columns[name] for name in names}
    about = about | {"groups": groups}
    temporary = path.with_suffix(".part.npz")
    np.savez_compressed(temporary, about=np.array(json.dumps(about)), **arrays)  # type: ignore[arg-type]
    temporary.replace(path)


def _read(path: Path, plan: Plan, today: str) -> Kept:
    with np.load(path) as file:
        about = json.loads(str(file["about"]))
        groups: Sequence[SensorGroup] = [
            SensorGroup(
                name,
                rate,
                file[f"time_{number}"],
                {column: file[f"v_{number}_{column}"] for column in columns},
            )
            for number, (name, rate, columns) in enumerate(about["groups"])
        ]
    drive = drive_of(SensorLog(tuple(groups), {}, {})) if groups else None
    return Kept(
        plan, drive, about["sheet"], about["truth"], about["sizes"], about["body"], about["reason"],
        about["code"] != today, about.get("level", {}), about.get("zeros"),
    )  # fmt: skip


def kept_drive(plan: Plan, cache: Path, today: str) -> Kept:
    """The drive of a plan, from the cache or driven now. today: `simulation_hash`."""
    path = cache / f"{plan.key}.npz"
    if path.exists():
        try:
            return _read(path, plan, today)
        except (zipfile.BadZipFile, KeyError, ValueError, OSError):
            path.unlink()
    cache.mkdir(parents=True, exist_ok=True)
    log, about = _drive(plan)
    _write(path, log, about | {"code": today})
    return _read(path, plan, today)
