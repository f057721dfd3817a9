"""Other models of the registry than the default one, on drives of the full plant: never sure of what is not so."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from parsers.drive import Drive, ImportRecord, Signal
from pipelines.analyze import run_estimator
from pipelines.estimators.base import FullSettings
from pipelines.estimators.gpc_bayesian_map.estimator import DEFAULTS, GpcBayesianMap
from pipelines.results import Estimate
from pipelines.simulation.loads import Load
from pipelines.simulation.logs.drive import Choice, SimulatedLog, preset, simulate_log
from pipelines.vehicles.vehicle_file import parse_vehicle


def run(made: SimulatedLog, model: str) -> Estimate:
    signals = {}
    for group in made.log.groups:
        for name, values in group.columns.items():
            there = np.isfinite(values)
            signals[name] = Signal(name, group.time_ns[there], values[there], "simulated")
    seconds = float(made.run.time_s[-1])
    record = ImportRecord("simulated", (), "", "complete", 0, {}, (), "simulated", None, seconds, ())
    vehicle = parse_vehicle(made.sheet, Path("vehicle.toml"))
    settings = FullSettings(dict(DEFAULTS), {"model": model})
    return run_estimator(GpcBayesianMap(), Drive(signals, record), vehicle, settings, 0)


def drive(manoeuvre: str, car: str, sensors: str) -> SimulatedLog:
    load = Load(150, 1.5, 0.0, 1.0)
    return simulate_log(Choice(manoeuvre, preset(car), (load,), sensors=sensors, seed=3))


def test_axle_loads_tell_mass_place_and_height() -> None:
    made = drive("launch_and_stop", "suv", "everything")
    found = run(made, "axle_load")
    assert set(found.parameters) == {"mass_kg", "cg_to_front_axle_m", "cg_height_m"}
    for name, answer in found.parameters.items():
        assert answer.status == "identified"
        assert answer.low is not None
        assert answer.high is not None
        assert answer.low <= made.run.truth[name] <= answer.high


@pytest.mark.parametrize(("manoeuvre", "car"), [("slalom", "suv"), ("sine_with_dwell", "sedan")])
def test_roll_alone_does_not_tell_stiffness_from_arm(manoeuvre: str, car: str) -> None:
    made = drive(manoeuvre, car, "ins")
    found = run(made, "roll")
    assert found.status == "ran"
    assert found.diagnostics["explained_share"] > 0.9
    for name in ("roll_stiffness_nmprad", "roll_arm_m"):
        answer = found.parameters[name]
        assert answer.status != "identified"
        assert answer.low is not None
        assert answer.high is not None
        assert answer.low <= made.run.truth[name] <= answer.high
