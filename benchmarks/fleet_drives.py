"""A simulated fleet: vehicles that each drive many times, with what stays and what changes from drive to drive.

python benchmarks/fleet_drives.py --cache DIR [--vehicles 20] [--drives 20] [--seed 0] [--always]

Of a vehicle stays: the vehicle, its data sheet with its errors (drawn once), where and how askew its inertial unit sits, nine
tenths of the sensors' scale errors and half of the variance of their zero errors. Each drive has its own load, road, driver,
tyre pressure (2 % of the tyres' rate), oil temperature (5 % of the dampers' rates) and the rest of the sensors' errors, so that
a single drive sees errors of the same size as in `calibration_drives`. A kept drive is what it told: its relations, its verdict
and its truth.
"""

from __future__ import annotations

import argparse
import pickle
import sys
import time
import zlib
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from benchmarks.calibration_drives import LOADS, Plan, plan_loads  # noqa: E402
from benchmarks.calibration_study import WITNESSES  # noqa: E402
from parsers.errors import SettingsError  # noqa: E402
from pipelines.analyze import run_estimator  # noqa: E402
from pipelines.estimators.registry import estimators  # noqa: E402
from pipelines.hierarchy.records import DriveTold  # noqa: E402
from pipelines.simulation.logs.as_drive import drive_of  # noqa: E402
from pipelines.simulation.logs.drive import Choice, default_mount, simulate_log  # noqa: E402
from pipelines.simulation.logs.vehicle import data_sheet  # noqa: E402
from pipelines.simulation.manoeuvres.base import Options  # noqa: E402
from pipelines.simulation.plant.random_vehicle import random_vehicle  # noqa: E402
from pipelines.simulation.plant.vehicle import PlantVehicle  # noqa: E402
from pipelines.simulation.sensors.sets import sensor_set  # noqa: E402
from pipelines.simulation.sensors.units import SensorSet, SensorUnit  # noqa: E402
from pipelines.vehicles.vehicle_file import parse_vehicle  # noqa: E402
from pipelines.verdict.combine import verdict_of  # noqa: E402

ALWAYS = (
    "deflection",
    "ins",
    "deflection",
    "imu",
    "production",
    "struts",
    "deflection",
    "ins",
    "deflection",
    "axle_load",
)
"""A fleet whose vehicles each have one recorder for good, in turn: most have deflections or a navigation unit."""

OFTEN = {"production": 0.55, "deflection": 0.20, "imu": 0.15, "ins": 0.10}
"""A fleet as they are: a vehicle's drives are recorded from the bus, some by a logger with six axes alone, and now and then with
ride heights or a borrowed navigation unit. Its first drive is its test: everything on it, the driver
alone in it (which nobody is told)."""

FIRST = "everything"

ROADS = {"public_road": 0.5, "rural": 0.3, "urban": 0.2}
MINUTES = (1.5, 4.0)
SCALE_KEPT, ZERO_KEPT = 0.9, 0.5
"""Share of the variance of a sensor's scale and zero error that stays the vehicle's."""
TYRES, OIL = 0.02, 0.05
FIRST_DAY = datetime(2024, 1, 1, 6, tzinfo=UTC)
DAYS = 730
PARAMETERS = (
    "cg_height_m", "mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m", "roll_stiffness_nmprad",
    "sprung_cg_height_m", "roll_damping_nmsprad", "roll_inertia_kgm2", "roll_center_height_m",
)  # fmt: skip


@dataclass(frozen=True)
class FleetDrive:
    """A drive of the fleet. told: what `join_vehicle` is given; truth: by parameter, and the empty vehicle's figures."""

    vehicle: int
    number: int
    sensors: str
    text: str
    told: DriveTold
    truth: dict[str, float]
    seconds: float


def _unit(unit: SensorUnit, rng: np.random.Generator) -> SensorUnit:
    """The unit as it is built into one vehicle: what stays of its errors is drawn, the rest is left for each drive."""
    sensors = []
    for s in unit.sensors:
        zero, scale = rng.standard_normal(2)
        sensors.append(
            replace(
                s,
                offset=s.offset + np.sqrt(ZERO_KEPT) * s.offset_std * zero,
                offset_std=np.sqrt(1 - ZERO_KEPT) * s.offset_std,
                scale_error=s.scale_error + np.sqrt(SCALE_KEPT) * s.scale_std * scale,
                scale_std=np.sqrt(1 - SCALE_KEPT) * s.scale_std,
            )
        )
    mount = unit.mount
    # a navigation unit is borrowed: it sits askew anew in every drive
    if mount is not None and unit.name != "ins":
        turned = mount.misalignment_std_rad * rng.standard_normal(3)
        mount = replace(mount, misalignment_rad=(turned[0], turned[1], turned[2]), misalignment_std_rad=0.0)
    return replace(unit, sensors=tuple(sensors), mount=mount)


def recorder(seed: int, vehicle: int, number: int, mixed: bool) -> str:
    """The sensor set of a drive."""
    if not mixed:
        return ALWAYS[vehicle % len(ALWAYS)]
    if number == 0:
        return FIRST
    rng = np.random.default_rng([seed, 46, vehicle, number])
    return str(rng.choice(list(OFTEN), p=list(OFTEN.values())))


def fleet_vehicle(seed: int, vehicle: int, name: str) -> tuple[PlantVehicle, SensorSet, str]:
    """A vehicle of the fleet, its sensors as built in, and its data sheet's text. name: of the sensor set."""
    plant = random_vehicle(np.random.default_rng([seed, 40, vehicle]))
    bare = sensor_set(name, default_mount(plant))
    # one stream a box: the same box in two sets has the same errors
    units = (
        _unit(unit, np.random.default_rng([seed, 41, vehicle, zlib.crc32(unit.name.encode())]))
        for unit in bare.units
    )
    sensors = replace(bare, units=tuple(units))
    sheet = data_sheet(plant, default_mount(plant), np.random.default_rng([seed, 42, vehicle]))
    # half of the fleet's owners do not know about which height the links pitch the body
    if np.random.default_rng([seed, 43, vehicle]).random() < 0.5:
        sheet = "\n".join(line for line in sheet.splitlines() if not line.startswith("pitch_center_height"))
    return plant, sensors, sheet


def _choice(seed: int, vehicle: int, number: int, attempt: int, name: str) -> tuple[Choice, str]:
    plant, sensors, _ = fleet_vehicle(seed, vehicle, name)
    rng = np.random.default_rng([seed, 44, vehicle, number, attempt])
    place = str(
        rng.choice(
            list(LOADS), p=np.array([c for c, _, _ in LOADS.values()]) / sum(c for c, _, _ in LOADS.values())
        )
    )
    kilos = float(rng.uniform(*LOADS[place][1:]))
    if name == FIRST:
        place = "driver"
    road = str(rng.choice(list(ROADS), p=list(ROADS.values())))
    minutes, severity = float(rng.uniform(*MINUTES)), float(rng.uniform(0.7, 1.2))
    plan = Plan(seed, road, sensors.name, place, kilos, minutes, mirrored=bool(vehicle % 2))
    tyres, oil = 1 + TYRES * rng.standard_normal(), 1 + OIL * rng.standard_normal()
    rates = {f"tire_vertical_rate_{a}_npm": tyres for a in ("front", "rear")}
    rates |= {
        f"damper_{way}_{a}_nspm": oil for way in ("compression", "extension") for a in ("front", "rear")
    }
    today = replace(plant, **{key: factor * getattr(plant, key) for key, factor in rates.items()})
    options = Options(severity=severity, duration_s=60 * minutes)
    drive_seed = int(rng.integers(2**31))
    return Choice(road, today, plan_loads(plan, plant), options, sensors, seed=drive_seed), plan.text


def make_drive(seed: int, vehicle: int, number: int, mixed: bool) -> FleetDrive:
    """Simulate one drive and ask for its verdict. A plan that cannot be driven is drawn anew. Raises SettingsError."""
    began = time.perf_counter()
    name = recorder(seed, vehicle, number, mixed)
    for attempt in range(6):
        choice, text = _choice(seed, vehicle, number, attempt, name)
        try:
            made = simulate_log(choice)
        except SettingsError:
            continue
        if not made.rolled_over:
            break
    else:
        raise SettingsError(f"vehicle {vehicle} cannot do drive {number}")
    plant, _, sheet = fleet_vehicle(seed, vehicle, name)
    file = parse_vehicle(sheet, Path("vehicle.toml"))
    drive = drive_of(made.log)
    results = []
    for estimator in estimators():
        if estimator.name not in WITNESSES:
            defaults = {s.name: s.default for s in estimator.settings}
            results.append(run_estimator(estimator, drive, file, defaults, choice.seed))
    verdict = verdict_of(results, file)
    day = np.sort(np.random.default_rng([seed, 45, vehicle]).uniform(0, DAYS, 100))[number]
    told = DriveTold(
        f"v{vehicle:02d}_d{number:02d}", (FIRST_DAY + timedelta(days=float(day))).isoformat(), verdict.parameters,
        verdict.kept,
    )  # fmt: skip
    truth = dict(made.run.truth) | _empty_truth(plant)
    return FleetDrive(vehicle, number, name, text, told, truth, time.perf_counter() - began)


def _empty_truth(plant: PlantVehicle) -> dict[str, float]:
    from pipelines.simulation.loads import truth

    empty = truth(plant, ())
    found = {
        "empty_mass": empty["mass_kg"], "empty_h": empty["cg_height_m"], "empty_x": empty["cg_to_front_axle_m"],
        "spring_front": plant.spring_rate_front_npm, "spring_rear": plant.spring_rate_rear_npm,
        "bar_front": plant.anti_roll_stiffness_front_nmprad, "bar_rear": plant.anti_roll_stiffness_rear_nmprad,
        "roll_center_front": plant.roll_center_height_front_m, "roll_center_rear": plant.roll_center_height_rear_m,
        "empty_roll_stiffness": empty["roll_stiffness_nmprad"],
    }  # fmt: skip
    return {f"vehicle:{key}": float(value) for key, value in found.items()}


def kept_drive(
    cache: Path, seed: int, vehicle: int, number: int, mixed: bool = True, make: bool = True
) -> FleetDrive | None:
    """From the study's own cache, or made now; None where it may not be made."""
    path = cache / f"{'mixed' if mixed else 'always'}_s{seed}_v{vehicle:02d}_d{number:02d}.pkl"
    if path.exists():
        with path.open("rb") as file:
            return FleetDrive(**pickle.load(file))
    if not make:
        return None
    cache.mkdir(parents=True, exist_ok=True)
    made = make_drive(seed, vehicle, number, mixed)
    part = path.with_suffix(".part")
    part.write_bytes(pickle.dumps(vars(made)))
    part.replace(path)
    return made


def order(vehicles: int, drives: int) -> list[tuple[int, int]]:
    """A small fleet first, then all vehicles with a few drives, then all."""
    every = [(v, d) for v in range(vehicles) for d in range(drives)]
    return sorted(
        every, key=lambda at: (at[1] > 0 and not (at[0] < 4 and at[1] < 6), at[1] // 5, at[0], at[1])
    )


def main() -> None:
    """Make the fleet, say each drive."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cache", type=Path, required=True)
    parser.add_argument("--vehicles", type=int, default=20)
    parser.add_argument("--drives", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--always", action="store_true", help="each vehicle has one recorder for good")
    chosen = parser.parse_args()
    for vehicle, number in order(chosen.vehicles, chosen.drives):
        try:
            made = kept_drive(chosen.cache, chosen.seed, vehicle, number, not chosen.always)
        except SettingsError as error:
            print(f"vehicle {vehicle} drive {number}: {error}", flush=True)
            continue
        if made is not None:
            print(f"{made.told.drive_id} {made.text}: {made.seconds:.1f} s", flush=True)


if __name__ == "__main__":
    main()
