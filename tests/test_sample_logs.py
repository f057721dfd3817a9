"""The sample logs are what their script makes, and the small fleet is as it is described."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from parsers.errors import LogError
from parsers.load import load_drive
from pipelines.discover import databases_beside, nearest
from pipelines.simulation.logs.loads import parse_load
from pipelines.simulation.plant.vehicle import PRESETS
from pipelines.vehicles.vehicle_file import read_vehicle

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
sys.path.insert(0, str(Path(__file__).resolve().parent / "parsers"))
from test_importer_contract import options_for

from sample_logs.make_sample_logs import RATE_HZ, sample_drive
from sample_logs.writers import text
from sample_logs.writers.fleet import FLEET

CUT = "wednesday.mcap"


def test_the_script_makes_the_samples(samples: Path, tmp_path: Path) -> None:
    drive = sample_drive(tmp_path)
    text.write_csv(drive, tmp_path / "drive.csv")
    made, kept = pl.read_csv(tmp_path / "drive.csv"), pl.read_csv(samples / "csv" / "drive.csv")
    assert made.columns == kept.columns
    assert made.height == kept.height
    for column in made.columns:
        ours, theirs = made[column].to_numpy(), kept[column].to_numpy()
        # another machine's rounding may carry a value over a step of quantisation now and then
        off = np.abs(ours - theirs) > 1e-6 * np.abs(theirs).max()
        assert off.mean() < 0.01, column
    assert (tmp_path / "vehicle.toml").read_text() == (samples / "vehicle.toml").read_text()
    truth = json.loads((samples / "truth.json").read_text())
    assert truth["parameters"] == pytest.approx(
        json.loads((tmp_path / "truth.json").read_text())["parameters"], rel=1e-9
    )


def test_the_sample_drive_brakes_corners_and_stands(samples: Path) -> None:
    drive = load_drive([samples / "csv" / "drive.csv"])
    signal = {name: found.values for name, found in drive.signals.items()}
    assert np.abs(signal["accel_y"]).max() > 4
    assert signal["accel_x"].min() < -5
    assert signal["accel_x"].max() > 2
    assert np.count_nonzero(signal["speed"] == 0) > 4 * RATE_HZ
    reference = read_vehicle(samples / "vehicle.toml").reference
    assert {"cg_height_m", "mass_kg", "cg_to_front_axle_m", "roll_stiffness_nmprad"} <= set(reference)


def test_the_fleet_has_vehicles_loads_formats_one_broken_log_and_one_unreadable(samples: Path) -> None:
    suffixes = {drive.file.rpartition(".")[2] for vehicle in FLEET for drive in vehicle.drives}
    assert len(FLEET) == 4
    assert len(suffixes) >= 6
    broken = [drive.file for vehicle in FLEET for drive in vehicle.drives if drive.broken]
    assert broken == [CUT]
    unreadable = [drive.file for vehicle in FLEET for drive in vehicle.drives if drive.unreadable]
    assert unreadable == ["harbour.parquet"]
    for vehicle in FLEET:
        folder = samples / "fleet" / vehicle.folder
        assert 2 <= len(vehicle.drives) <= 3
        assert len({drive.loads for drive in vehicle.drives}) == len(vehicle.drives)
        assert {path.name for path in folder.iterdir()} == {
            "vehicle.toml",
            *(name for name, _ in vehicle.beside),
            *(drive.file for drive in vehicle.drives),
            *(f"{Path(drive.file).stem}.truth.json" for drive in vehicle.drives),
        }
        sheet = read_vehicle(folder / "vehicle.toml")
        assert not sheet.load_stated
        assert not sheet.reference


@pytest.mark.parametrize("vehicle", FLEET, ids=lambda vehicle: vehicle.folder)
def test_every_log_of_the_fleet_is_read(samples: Path, vehicle) -> None:
    plant = PRESETS[vehicle.preset]
    for drive in vehicle.drives:
        log = samples / "fleet" / vehicle.folder / drive.file
        assert nearest("vehicle.toml", log) == (log.parent / "vehicle.toml").resolve()
        assert len(databases_beside(log)) == (vehicle.folder == "van")
        if drive.unreadable:
            with pytest.raises(LogError, match="truncated: its table of contents"):
                load_drive([log], options_for(log))
            continue
        found = load_drive([log], options_for(log))
        assert found.record.status == ("truncated" if drive.broken else "complete")
        assert {"accel_y", "speed", "roll", "brake_pressure", "suspension_deflection_rr"} <= set(
            found.signals
        )
        truth = json.loads((log.parent / f"{log.stem}.truth.json").read_text())
        whole = found.record.duration_s / truth["duration_s"]
        assert (0.3 < whole < 0.9) if drive.broken else (0.99 < whole < 1.01)
        loads = [part.mass_kg for spec in drive.loads for part in parse_load(spec, plant)]
        assert truth["parameters"]["mass_kg"] == pytest.approx(plant.mass_kg + sum(loads))
        assert truth["manoeuvre"] == drive.manoeuvre
