"""Simulated drives of a vehicle fitted with struts and measuring wheels, and changes to them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from parsers.drive import Drive, Signal
from parsers.signals import WHEELS
from pipelines.prepare.lowpass import lowpass
from pipelines.results import FloatArray
from pipelines.simulation.loads import Load
from pipelines.simulation.logs.as_drive import drive_of
from pipelines.simulation.logs.drive import Choice, preset, simulate_log
from pipelines.simulation.manoeuvres.base import Options
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle


@dataclass(frozen=True)
class Made:
    """A simulated drive: as sensors give it, its vehicle file, and the true forces (time_s, wheel -> (n,))."""

    drive: Drive
    vehicle: Vehicle
    time_s: FloatArray
    true: Mapping[str, FloatArray]

    def true_at(self, wheel: str, time_s: FloatArray) -> FloatArray:
        return np.interp(time_s, self.time_s, self.true[wheel])


def make(manoeuvre: str, loads: tuple[Load, ...], seed: int, duration_s: float) -> Made:
    simulated = simulate_log(
        Choice(
            manoeuvre, preset("suv"), loads=loads, options=Options(duration_s=duration_s), sensors="wheel_force",
            seed=seed,
        )
    )  # fmt: skip
    run = simulated.run
    true = {w: lowpass(run.columns[f"tire_normal_force_{w}_n"], run.rate_hz, 10.0) for w in WHEELS}
    drive = drive_of(simulated.log)
    drive = replace(drive, record=replace(drive.record, sha256="0" * 64))
    return Made(drive, parse_vehicle(simulated.sheet, Path("suv.toml")), run.time_s, true)


def without(drive: Drive, *beginnings: str) -> Drive:
    """The drive without the signals of these beginnings."""
    return replace(drive, signals={n: s for n, s in drive.signals.items() if not n.startswith(beginnings)})


def scaled(drive: Drive, beginning: str, factor: float) -> Drive:
    """The drive with some signals times a factor."""

    def change(name: str, signal: Signal) -> Signal:
        return replace(signal, values=signal.values * factor) if name.startswith(beginning) else signal

    return replace(drive, signals={n: change(n, s) for n, s in drive.signals.items()})
