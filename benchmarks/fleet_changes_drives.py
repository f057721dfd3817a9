"""Drives for `fleet_changes`: vehicles of the simulated fleet with a load, and dampers, that are known to change or not."""

from __future__ import annotations

import pickle
import sys
import zlib
from dataclasses import dataclass, replace
from datetime import timedelta
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from benchmarks.calibration_drives import Plan, plan_loads  # noqa: E402
from benchmarks.calibration_study import WITNESSES  # noqa: E402
from benchmarks.fleet_drives import FIRST_DAY, MINUTES, OIL, ROADS, TYRES, fleet_vehicle  # noqa: E402
from parsers.errors import SettingsError  # noqa: E402
from pipelines.analyze import run_estimator  # noqa: E402
from pipelines.estimators.registry import estimators  # noqa: E402
from pipelines.hierarchy.records import DriveTold  # noqa: E402
from pipelines.simulation.logs.as_drive import drive_of  # noqa: E402
from pipelines.simulation.logs.drive import Choice, simulate_log  # noqa: E402
from pipelines.simulation.manoeuvres.base import Options  # noqa: E402
from pipelines.simulation.plant.vehicle import PlantVehicle  # noqa: E402
from pipelines.vehicles.vehicle_file import parse_vehicle  # noqa: E402
from pipelines.verdict.combine import verdict_of  # noqa: E402

SEED = 7
BOOT_KG = 100.0
DAMPERS = tuple(
    f"damper_{way}_{axle}_nspm" for way in ("compression", "extension") for axle in ("front", "rear")
)


@dataclass(frozen=True)
class Wanted:
    """One drive. more_kg: in the boot, beside driver and 100 kg; faded: dampers' rates less 1; day: after the first."""

    vehicle: int
    sensors: str
    number: int
    more_kg: float = 0.0
    faded: float = 0.0
    day: float = 0.0

    @property
    def name(self) -> str:
        """Of its file and of the drive."""
        return f"v{self.vehicle:02d}_{self.sensors}_{self.number:03d}_{self.more_kg:+.0f}kg_{1e3 * self.faded:+.0f}"


@dataclass(frozen=True)
class Made:
    """A drive that was driven. truth: parameters; roll_damping at today's rates of the dampers."""

    wanted: Wanted
    told: DriveTold
    truth: dict[str, float]


def _today(plant: PlantVehicle, faded: float, rng: np.random.Generator) -> PlantVehicle:
    """The vehicle as it is that day: worn dampers, warm or cold oil, tyres of some pressure."""
    tyres, oil = 1 + TYRES * rng.standard_normal(), 1 + OIL * rng.standard_normal()
    rates = {f"tire_vertical_rate_{a}_npm": tyres for a in ("front", "rear")}
    rates |= dict.fromkeys(DAMPERS, oil * (1 + faded))
    return replace(plant, **{key: factor * getattr(plant, key) for key, factor in rates.items()})


def _choice(wanted: Wanted, attempt: int) -> Choice:
    plant, sensors, _ = fleet_vehicle(SEED, wanted.vehicle, wanted.sensors)
    rng = np.random.default_rng([SEED, 50, zlib.crc32(wanted.name.encode()), attempt])
    road = str(rng.choice(list(ROADS), p=list(ROADS.values())))
    minutes, severity = float(rng.uniform(*MINUTES)), float(rng.uniform(0.7, 1.2))
    plan = Plan(SEED, road, wanted.sensors, "rear", BOOT_KG + wanted.more_kg, minutes)
    options = Options(severity=severity, duration_s=60 * minutes)
    today = _today(plant, wanted.faded, rng)
    return Choice(road, today, plan_loads(plan, plant), options, sensors, seed=int(rng.integers(2**31)))


def _make(wanted: Wanted) -> Made:
    """Raises SettingsError where the vehicle cannot drive it."""
    for attempt in range(6):
        choice = _choice(wanted, attempt)
        try:
            made = simulate_log(choice)
        except SettingsError:
            continue
        if not made.rolled_over:
            break
    else:
        raise SettingsError(f"{wanted.name} cannot be driven")
    _, _, sheet = fleet_vehicle(SEED, wanted.vehicle, wanted.sensors)
    file, drive = parse_vehicle(sheet, Path("vehicle.toml")), drive_of(made.log)
    results = [
        run_estimator(e, drive, file, {s.name: s.default for s in e.settings}, choice.seed)
        for e in estimators()
        if e.name not in WITNESSES
    ]
    verdict = verdict_of(results, file)
    start = (FIRST_DAY + timedelta(days=wanted.day)).isoformat()
    told = DriveTold(wanted.name, start, verdict.parameters, verdict.kept)
    return Made(wanted, told, {k: float(v) for k, v in made.run.truth.items()})


def drive(wanted: Wanted, cache: Path) -> Made:
    """From the cache of this study, or made now. Raises SettingsError where it cannot be driven."""
    path = cache / f"{wanted.name}.pkl"
    if path.exists():
        with path.open("rb") as file:
            told, truth = pickle.load(file)
        start = (FIRST_DAY + timedelta(days=wanted.day)).isoformat()
        return Made(wanted, replace(told, start_utc=start), truth)
    made = _make(wanted)
    cache.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_bytes(pickle.dumps((made.told, made.truth)))
    part.replace(path)
    return made
