"""Vehicles fitted for suspension mapping, and their drives: each with the same instruments in all of them, another load.

The plant's suspension force holds spring, bar, damper and dry friction. A strut's load cell does not feel all of it: here a
part of the dry friction (bushings, ball joints) and in every second vehicle the anti-roll bar go past it, which is what the
dissertation found to be the limit of the method.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from parsers.drive import Drive
from parsers.signals import WHEELS
from pipelines.models.suspension_map import ACROSS, FRONT, dry_friction
from pipelines.prepare.lowpass import lowpass
from pipelines.results import FloatArray
from pipelines.simulation.loads import Load, loaded
from pipelines.simulation.logs.as_drive import drive_of
from pipelines.simulation.logs.drive import default_mount
from pipelines.simulation.logs.vehicle import data_sheet, rolling_radii_m
from pipelines.simulation.manoeuvres.base import Options, figures_of
from pipelines.simulation.manoeuvres.registry import make_scenario
from pipelines.simulation.plant.run import simulate
from pipelines.simulation.plant.vehicle import PRESETS, PlantVehicle
from pipelines.simulation.records import PlantRun
from pipelines.simulation.sensors.errors import SensorModel
from pipelines.simulation.sensors.truth import Fit
from pipelines.simulation.sensors.units import SensorSet, SensorUnit, apply
from pipelines.simulation.sensors.wheel_force import units
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

RUN_HZ = 200.0
KINDS = ("suv", "sedan", "van", "off_road")
DRIVER = Load(75.0, 1.3, 0.37, 0.8)
DRIFTS = 0.2
"""Share of an instrument's constant error that changes from drive to drive; the rest stays with it."""


@dataclass(frozen=True)
class Fitted:
    """A vehicle with instruments. past: share of the dry friction that the struts do not feel; bar_past: nor the bar.

    sheet: its vehicle file, off by data-sheet errors. training, other: loads of the training drive and of all others.
    """

    vehicle: PlantVehicle
    sensors: SensorSet
    past: float
    bar_past: bool
    sheet: Vehicle
    training: tuple[Load, ...]
    other: tuple[Load, ...]


@dataclass(frozen=True)
class Driven:
    """One drive: as its sensors give it, and what was true."""

    run: PlantRun
    drive: Drive

    def true_force(self, wheel: str, time_s: FloatArray, band_hz: float) -> FloatArray:
        """The tyre's normal force at these times, low-passed as the mapping's signals are; (n,)."""
        force = lowpass(self.run.columns[f"tire_normal_force_{wheel}_n"], self.run.rate_hz, band_hz)
        return np.asarray(np.interp(time_s, self.run.time_s, force))


def _instrument(sensor: SensorModel, rng: np.random.Generator) -> SensorModel:
    """One instrument: its constant errors drawn once, a part of them again in every drive."""
    first, second = rng.standard_normal(2)
    if sensor.signal.startswith(("suspension_force", "tire_normal_force")):
        # these state what drifts from drive to drive themselves
        return replace(sensor, scale_error=0.005 * float(first), offset=sensor.offset_std * float(second))
    return replace(
        sensor,
        offset=sensor.offset_std * float(first),
        offset_std=DRIFTS * sensor.offset_std,
        scale_error=sensor.scale_std * float(second),
        scale_std=0.0,
    )


def _unit(unit: SensorUnit, rng: np.random.Generator) -> SensorUnit:
    mount = unit.mount
    if mount is not None:
        roll, pitch, yaw = (float(a) for a in mount.misalignment_std_rad * rng.standard_normal(3))
        mount = replace(mount, misalignment_rad=(roll, pitch, yaw), misalignment_std_rad=0.0)
    return replace(unit, mount=mount, sensors=tuple(_instrument(s, rng) for s in unit.sensors))


def fit_out(rng: np.random.Generator, kind: str) -> Fitted:
    """Draw a vehicle of that kind: its friction, its instruments, its loads, its data sheet."""
    base = PRESETS[kind]
    vehicle = replace(
        base,
        friction_n=base.friction_n * float(rng.uniform(0.5, 2.0, 2).mean()),
        friction_travel_m=float(rng.uniform(0.001, 0.004)),
    )
    mount = default_mount(vehicle)
    sensors = SensorSet(
        "wheel_force", "", tuple(_unit(unit, rng) for unit in units(mount)), Fit(*rolling_radii_m(vehicle))
    )
    length, half = vehicle.wheelbase_m, vehicle.track_rear_m / 2
    # up to a quarter of the vehicle's mass, anywhere between the axles, low or on the roof
    cargo = Load(
        float(rng.uniform(0.05, 0.2)) * vehicle.sprung_mass_kg,
        float(rng.uniform(0.5, 0.95)) * length,
        float(rng.uniform(-0.5, 0.5)) * half,
        float(rng.uniform(0.6, 1.6)),
    )
    sheet = parse_vehicle(data_sheet(vehicle, mount, rng), Path(f"{kind}.toml"))
    return Fitted(
        vehicle,
        sensors,
        float(rng.uniform(0.2, 1.0)),
        bool(rng.integers(2)),
        sheet,
        (DRIVER,),
        (DRIVER, cargo),
    )


def _felt(run: PlantRun, fitted: Fitted) -> PlantRun:
    """The run with the suspension's force as the struts feel it."""
    vehicle, columns = fitted.vehicle, dict(run.columns)
    starts = np.zeros(len(run.time_s))
    starts[0] = 1.0
    for wheel in WHEELS:
        own = columns[f"suspension_deflection_{wheel}_m"]
        dry = dry_friction(own, starts, vehicle.friction_travel_m)
        felt = columns[f"suspension_force_{wheel}_n"] - fitted.past * vehicle.friction_n * dry
        if fitted.bar_past:
            stiffness, track = (
                (vehicle.anti_roll_stiffness_front_nmprad, vehicle.track_front_m)
                if FRONT[wheel]
                else (vehicle.anti_roll_stiffness_rear_nmprad, vehicle.track_rear_m)
            )
            felt = felt - stiffness / track**2 * (own - columns[f"suspension_deflection_{ACROSS[wheel]}_m"])
        columns[f"suspension_force_{wheel}_n"] = felt
    return replace(run, columns=columns)


def drive(
    fitted: Fitted, manoeuvre: str, loads: Sequence[Load], rng: np.random.Generator, options: Options
) -> Driven:
    """Drive a manoeuvre and measure it."""
    scenario = make_scenario(manoeuvre, figures_of(loaded(fitted.vehicle, loads)), options, rng)
    run = simulate(fitted.vehicle, scenario.demand, scenario.road, loads=loads, rate_hz=RUN_HZ)
    return Driven(run, drive_of(apply(_felt(run, fitted), fitted.sensors, rng)))
