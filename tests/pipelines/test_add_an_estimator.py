"""A new estimator is one file and one registry line: this test adds one, and the contract holds for all of them."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import pipelines.estimators.registry
from parsers.load import load_drive
from pipelines.analyze import Request, analyze
from pipelines.estimators.registry import estimators
from pipelines.parameters import PARAMETERS
from pipelines.results import ParameterEstimate
from pipelines.simulation.logs.drive import Choice, preset, simulate_log
from pipelines.simulation.logs.write import write_log, write_vehicle
from pipelines.simulation.manoeuvres.base import Options
from pipelines.suspension_mapping.file import map_text
from pipelines.suspension_mapping.train import train, training_drive
from pipelines.vehicles.vehicle_file import read_vehicle

MODULE = """
import numpy as np

from pipelines.estimators.base import Need, Setting
from pipelines.prepare.signals import prepare_signals
from pipelines.results import Estimate, ParameterEstimate


class SteadyGradient:
    name = "steady_gradient"
    title = "Roll gradient by straight-line fit"
    source = "textbook: steady-state roll"
    signal_needs = (Need(("accel_y",), "the input"), Need(("roll",), "the output"))
    vehicle_needs = ()
    parameters = ("roll_gradient_degpg",)
    settings = (Setting("cutoff_hz", 2.0, "Hz", "low-pass on both signals", 0.1, 20.0),)

    def prepare(self, drive, settings):
        return prepare_signals(drive, ["accel_y", "roll"], rate_hz=None, cutoff_hz=settings["cutoff_hz"])

    def estimate(self, prepared, vehicle, settings, rng):
        slope = np.polyfit(prepared.columns["accel_y"], prepared.columns["roll"], 1)[0] * 9.80665 * 180 / np.pi
        entry = ParameterEstimate("roll_gradient_degpg", slope, 0.5, slope - 1, slope + 1, "identified", "a line")
        return Estimate(self.name, "ran", "", {"roll_gradient_degpg": entry})
"""


def test_one_file_and_one_line(tmp_path: Path, samples: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "steady_gradient.py").write_text(MODULE, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(
        pipelines.estimators.registry,
        "ESTIMATORS",
        (*pipelines.estimators.registry.ESTIMATORS, "steady_gradient:SteadyGradient"),
    )
    results = analyze(Request((samples / "csv/drive.csv",), estimators="steady_gradient"))
    (estimate,) = results.estimates
    assert estimate.status == "ran"
    value = estimate.parameters["roll_gradient_degpg"].value
    assert value is not None
    assert 6 < value < 9
    sys.modules.pop("steady_gradient", None)


@pytest.mark.parametrize("name", [e.name for e in estimators()])
def test_declaration(name: str) -> None:
    estimator = next(e for e in estimators() if e.name == name)
    assert estimator.title
    assert estimator.source
    assert set(estimator.parameters) <= set(PARAMETERS)
    assert estimator.signal_needs
    for setting in estimator.settings:
        assert setting.low <= setting.default <= setting.high
        assert setting.meaning


def check_estimate(entry: ParameterEstimate) -> None:
    """What every parameter of every estimate keeps to."""
    assert entry.reason
    numbers = (entry.value, entry.std, entry.low, entry.high)
    if any(number is None for number in numbers):
        assert numbers == (None, None, None, None)
        assert entry.status == "not_identifiable"
        return
    value, std, low, high = (float(number) for number in numbers if number is not None)
    assert np.isfinite([value, std, low, high]).all()
    assert low <= value <= high
    assert std > 0


OTHER_LOGS = (
    Choice("truck_flat", preset("truck"), sensors="axle_load"),
    Choice("off_road", preset("off_road"), options=Options(duration_s=40.0), sensors="vertical"),
)
"""Logs of kinds that the sample drive is not: a truck with an axle load sensor, accelerometers on body and hubs."""


@pytest.fixture(scope="module")
def logs(samples: Path, tmp_path_factory: pytest.TempPathFactory) -> list[tuple[Path, Path]]:
    """Logs with their vehicle files: each estimator finds what it needs in one of them."""
    found = [(samples / log, samples / "vehicle.toml") for log in ("csv/drive.csv", "parquet/drive.parquet")]
    for choice in OTHER_LOGS:
        simulated = simulate_log(choice)
        log = tmp_path_factory.mktemp(choice.manoeuvre) / "drive.csv"
        write_log(simulated.log, log)
        found.append((log, write_vehicle(simulated.sheet, log)))
    return [*found, _with_suspension_map(tmp_path_factory.mktemp("wheel_force"))]


def _with_suspension_map(folder: Path) -> tuple[Path, Path]:
    """A drive with struts and measuring wheels, its vehicle file naming the map that it taught."""
    choice = Choice("slalom", preset("suv"), options=Options(duration_s=40.0), sensors="wheel_force")
    simulated, log = simulate_log(choice), folder / "drive.csv"
    write_log(simulated.log, log)
    sheet = write_vehicle(simulated.sheet, log)
    rows = training_drive(load_drive([log]), "drive.csv")
    text = map_text(train([rows], read_vehicle(sheet), "suv (simulated)"))
    (folder / "suspension.toml").write_text(text, encoding="utf-8")
    named = '[vehicle]\nsuspension_map = "suspension.toml"\n'
    sheet.write_text(sheet.read_text(encoding="utf-8").replace("[vehicle]\n", named, 1), encoding="utf-8")
    return log, sheet


@pytest.mark.parametrize("name", [e.name for e in estimators()])
def test_estimates_keep_the_contract_and_repeat_exactly(name: str, logs: list[tuple[Path, Path]]) -> None:
    ran = 0
    for log, vehicle in logs:
        ran += _keeps_the_contract(Request((log,), vehicle=vehicle, estimators=name, seed=7))
    assert ran, "no log has what it needs"


def _keeps_the_contract(request: Request) -> bool:
    """Check one estimator on one log; whether it ran. Skipping is right only where the log lacks something."""
    first, second = analyze(request), analyze(request)
    (estimate,) = first.estimates
    if estimate.status == "skipped":
        assert "lacks" in estimate.reason
        return False
    assert estimate.status == "ran", estimate.reason
    assert 0 <= estimate.used_fraction <= 1
    for key, entry in estimate.parameters.items():
        assert key == entry.name
        check_estimate(entry)
    assert estimate.parameters == second.estimates[0].parameters
    assert first.verdict == second.verdict
    return True
