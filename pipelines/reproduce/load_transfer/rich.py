"""The rich plant: simulated drives with strut sensors, as the estimators see them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from pipelines.estimators.base import Estimator
from pipelines.estimators.load_transfer.companion import LoadTransferBatch
from pipelines.estimators.load_transfer.published import (
    HighFrequencyLoadTransfer,
    LoadTransfer,
    ModifiedLoadTransfer,
)
from pipelines.results import Estimate, FloatArray
from pipelines.simulation.logs.as_drive import drive_of
from pipelines.simulation.logs.drive import Choice, simulate_log
from pipelines.simulation.plant.vehicle import PRESETS, PlantVehicle
from pipelines.vehicles.vehicle_file import parse_vehicle


@dataclass(frozen=True)
class Method:
    """An estimator with settings that are not its defaults."""

    name: str
    estimator: Estimator
    settings: dict[str, float] = field(default_factory=dict)


METHODS: tuple[Method, ...] = (
    Method("load_transfer", LoadTransfer()),
    Method("MLTM, published (gate_g 0)", ModifiedLoadTransfer(), {"gate_g": 0.0}),
    Method("high_frequency_load_transfer", HighFrequencyLoadTransfer()),
    Method("load_transfer_batch", LoadTransferBatch()),
    Method("MLTM, masses held in turns", ModifiedLoadTransfer()),
)
LTM_AT, MLTM_AT, HFLTM_AT, BATCH_AT = range(4)
"""Places in METHODS; the paper's claims are judged on the MLTM as published."""


@dataclass(frozen=True)
class Driven:
    """A simulated drive with the estimates of METHODS and the truth."""

    name: str
    estimates: tuple[Estimate, ...]
    truth: dict[str, float]
    wheelbase: float
    track: float

    def error(self, method: int, parameter: str) -> float:
        """Estimate less truth, in the parameter's unit; NaN where none was given."""
        value = self.estimates[method].parameters[parameter].value
        return float("nan") if value is None else value - self.truth[parameter]


def hard(vehicle: PlantVehicle) -> PlantVehicle:
    """The vehicle with a hard suspension: springs times 2.5, dampers times 2, less room."""
    springs = {
        f"spring_rate_{a}_npm": 2.5 * getattr(vehicle, f"spring_rate_{a}_npm") for a in ("front", "rear")
    }
    dampers = {
        n: 2.0 * getattr(vehicle, n)
        for n in (f"damper_{way}_{a}_nspm" for way in ("compression", "extension") for a in ("front", "rear"))
    }
    return replace(vehicle, **springs, **dampers)


def run(
    name: str, manoeuvre: str, vehicle: PlantVehicle, seed: int, methods: tuple[Method, ...] = METHODS
) -> Driven:
    """Simulate a drive and let the methods estimate it."""
    made = simulate_log(Choice(manoeuvre, vehicle, sensors="struts", seed=seed))
    file, drive = parse_vehicle(made.sheet, Path("simulated.toml")), drive_of(made.log)
    found = tuple(
        m.estimator.estimate(
            m.estimator.prepare(drive, m.settings), file, m.settings, np.random.default_rng(seed)
        )
        for m in methods
    )
    return Driven(name, found, dict(made.run.truth), vehicle.wheelbase_m, vehicle.track_front_m)


def suv(cross_kg: float = 0.0) -> PlantVehicle:
    """The plant's SUV, with a diagonal shift."""
    return replace(PRESETS["suv"], cross_weight_kg=cross_kg)


def trace(estimate: Estimate, ending: str) -> dict[str, FloatArray]:
    """The columns of the trace whose name ends so."""
    found = next(t for t in estimate.traces if t.name.endswith(ending))
    return {"time_s": found.time_s, **found.columns}
