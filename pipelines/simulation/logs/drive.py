"""A whole simulated drive: manoeuvre, plant and sensors, from one seed, and its truth as a record."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace

import numpy as np

from parsers.errors import SettingsError
from pipelines.results import FloatArray
from pipelines.simulation.loads import Load, loaded, truth
from pipelines.simulation.logs.vehicle import data_sheet, rolling_radii_m
from pipelines.simulation.manoeuvres.base import Options, Scenario, figures_of
from pipelines.simulation.manoeuvres.registry import make_scenario
from pipelines.simulation.plant.random_vehicle import random_vehicle
from pipelines.simulation.plant.run import simulate
from pipelines.simulation.plant.vehicle import PRESETS, PlantVehicle
from pipelines.simulation.records import GRAVITY, Air, PlantRun
from pipelines.simulation.sensors.sets import sensor_set
from pipelines.simulation.sensors.truth import Fit, Mount
from pipelines.simulation.sensors.units import SensorLog, SensorSet, apply

RUN_RATES_HZ = (200.0, 500.0, 1000.0)
"""The plant writes at the first of these that is at least twice the fastest sensor's rate."""

MOUNT_SHARE, MOUNT_ABOVE_GROUND_M = 0.45, 0.25
"""Where the inertial unit sits: on the tunnel, this share of the wheelbase behind the front axle, so far above the hubs."""


@dataclass(frozen=True)
class Choice:
    """What to simulate. sensors: a named set, or one of your own. rate_hz: all sensors at this rate; None = each at its own.

    air: its density, and wind. error_scale: factor on the sensors' errors. dropouts_per_s: lost messages of each unit; outlier_share: wild samples.
    sheet_errors: factor on how far the vehicle file's figures lie from the truth; tell_load: whether it says the load.
    """

    manoeuvre: str
    vehicle: PlantVehicle
    loads: tuple[Load, ...] = ()
    options: Options = field(default_factory=Options)
    sensors: str | SensorSet = "deflection"
    rate_hz: float | None = None
    error_scale: float = 1.0
    dropouts_per_s: float = 0.0
    outlier_share: float = 0.0
    sheet_errors: float = 1.0
    tell_load: bool = False
    seed: int = 0
    air: Air = field(default_factory=Air)


@dataclass(frozen=True)
class SimulatedLog:
    """A drive as its sensors give it, with all that is true of it. sheet: the vehicle file's text."""

    choice: Choice
    scenario: Scenario
    run: PlantRun
    sensors: SensorSet
    log: SensorLog
    sheet: str

    @property
    def rolled_over(self) -> bool:
        """Whether the drive ended before its time, on the vehicle's side."""
        return float(self.run.time_s[-1]) < self.scenario.demand.duration_s - 1.0


RANDOM = "random"
"""The name for a vehicle that nobody built: the seed says which."""
_VEHICLE_STREAM = 3


def preset(name: str, seed: int = 0) -> PlantVehicle:
    """A preset vehicle, or the seed's random one. Raises SettingsError for an unknown name, naming the nearest."""
    if name == RANDOM:
        return random_vehicle(np.random.default_rng([seed, _VEHICLE_STREAM]))
    if name not in PRESETS:
        near = difflib.get_close_matches(name, (*PRESETS, RANDOM), n=1, cutoff=0.5)
        raise SettingsError(
            f"there is no vehicle {name!r}",
            hint=f"did you mean {near[0]!r}?"
            if near
            else f"known are {', '.join((*PRESETS, RANDOM))}, or give a vehicle file",
            wrong_usage=True,
        )
    return PRESETS[name]


def _check_load(vehicle: PlantVehicle, loads: Sequence[Load]) -> None:
    """Raise SettingsError where the vehicle cannot carry its load, or does not stand under it."""
    weight = sum(load.mass_kg for load in loads)
    if weight > vehicle.mass_kg:
        raise SettingsError(
            f"{vehicle.name} cannot carry {weight:.0f} kg",
            hint=f"at most its own {vehicle.mass_kg:.0f} kg",
            wrong_usage=True,
        )
    try:
        truth(vehicle, loads)
    except ValueError as error:
        raise SettingsError(
            f"{vehicle.name} cannot carry this load: {error}", hint="give less, or lower", wrong_usage=True
        ) from error


def default_mount(vehicle: PlantVehicle) -> Mount:
    """Where the inertial unit of a simulated vehicle sits."""
    return Mount(
        round(MOUNT_SHARE * vehicle.wheelbase_m, 2),
        0.0,
        round(vehicle.wheel_radius_m + MOUNT_ABOVE_GROUND_M, 2),
    )


def _sensors(choice: Choice) -> SensorSet:
    front, rear = rolling_radii_m(choice.vehicle)
    fit = Fit(front, rear)
    if isinstance(choice.sensors, SensorSet):
        made = replace(choice.sensors, fit=fit)
    else:
        made = sensor_set(choice.sensors, default_mount(choice.vehicle), fit)
    if choice.rate_hz is not None:
        made = made.at_rate(choice.rate_hz)
    if choice.error_scale != 1:
        made = made.scaled(choice.error_scale)
    if choice.dropouts_per_s > 0 or choice.outlier_share > 0:
        made = made.spoiled(choice.dropouts_per_s, choice.outlier_share)
    return made


def _run_rate_hz(sensors: SensorSet) -> float:
    fastest = max(unit.rate_hz for unit in sensors.units)
    return next((rate for rate in RUN_RATES_HZ if rate >= 2 * fastest), RUN_RATES_HZ[-1])


def simulate_log(choice: Choice) -> SimulatedLog:
    """Run the whole chain. Manoeuvre, sensors and vehicle file draw from streams of their own, all from one seed.

    Raises SettingsError for a name that is not known, or a vehicle that cannot carry its load or do the manoeuvre.
    """
    sensors = _sensors(choice)
    road_rng, sensor_rng, sheet_rng = (np.random.default_rng([choice.seed, part]) for part in range(3))
    _check_load(choice.vehicle, choice.loads)
    driven = figures_of(loaded(choice.vehicle, choice.loads))
    scenario = make_scenario(choice.manoeuvre, driven, choice.options, road_rng)
    try:
        run = simulate(
            choice.vehicle,
            scenario.demand,
            scenario.road,
            loads=choice.loads,
            air=choice.air,
            rate_hz=_run_rate_hz(sensors),
        )
    except ValueError as error:
        raise SettingsError(
            f"{choice.vehicle.name} cannot do {choice.manoeuvre}: {error}",
            hint="choose another speed, severity or load",
        ) from error
    log = apply(run, sensors, sensor_rng)
    sheet = data_sheet(
        choice.vehicle,
        default_mount(choice.vehicle),
        sheet_rng,
        errors=choice.sheet_errors,
        load=_told(choice) if choice.tell_load else None,
        reference=run.truth,
    )
    return SimulatedLog(choice, scenario, run, sensors, log, sheet)


def _told(choice: Choice) -> tuple[float, float]:
    mass = sum(load.mass_kg for load in choice.loads)
    if mass == 0:
        return 0.0, 0.0
    return mass, sum(load.mass_kg * load.above_ground_m for load in choice.loads) / mass


def _peak(values: FloatArray) -> float:
    return float(np.max(np.abs(values)))


def extremes(run: PlantRun) -> dict[str, float]:
    """How far the drive went: peaks of the true motion."""
    c = run.columns
    return {
        "speed_mps": _peak(c["speed_mps"]),
        "accel_x_mps2": _peak(c["accel_x_mps2"]),
        "lateral_acceleration_g": _peak(c["accel_y_mps2"]) / GRAVITY,
        "roll_rad": _peak(c["roll_rad"]),
        "wheel_load_least_n": float(
            min(np.min(c[f"tire_normal_force_{w}_n"]) for w in ("fl", "fr", "rl", "rr"))
        ),
    }


def truth_record(simulated: SimulatedLog, version: str) -> dict[str, object]:
    """All that is true of a simulated drive, as JSON can hold it."""
    choice, log = simulated.choice, simulated.log
    cross = choice.vehicle.cross_weight_kg
    warp = {"cross_weight_kg": cross} if cross else {}
    return {
        "cogest": version,
        "manoeuvre": choice.manoeuvre,
        "title": simulated.scenario.title,
        "standard": simulated.scenario.standard,
        "notes": list(simulated.scenario.notes),
        "seed": choice.seed,
        "options": {key: value for key, value in asdict(choice.options).items() if value is not None},
        "air": asdict(choice.air),
        "duration_s": float(simulated.run.time_s[-1]),
        "rolled_over": simulated.rolled_over,
        "vehicle": choice.vehicle.name,
        "loads": [asdict(load) for load in choice.loads],
        **warp,
        "parameters": dict(simulated.run.truth),
        "extremes": extremes(simulated.run),
        "sensors": {
            "set": simulated.sensors.name,
            "error_scale": choice.error_scale,
            "groups": {group.name: group.rate_hz for group in log.groups},
            "mounts": {name: asdict(mount) for name, mount in log.mounts.items()},
            "drawn": {signal: asdict(errors) for signal, errors in log.drawn.items()},
            "models": {
                sensor.signal: {
                    key: value
                    for key, value in asdict(sensor).items()
                    if key != "signal" and value and np.isfinite(value)
                }
                for unit in simulated.sensors.units
                for sensor in unit.sensors
            },
        },
    }
