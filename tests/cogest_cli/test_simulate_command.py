"""`cogest simulate`: logs with their truth, read back by the other commands."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from parsers.load import load_drive
from parsers.signals import SIGNALS
from pipelines.simulation.logs.drive import Choice, SimulatedLog, preset, simulate_log
from pipelines.simulation.logs.vehicle import RELATIVE, sheet_values
from pipelines.simulation.manoeuvres.base import Options
from pipelines.vehicles.vehicle_file import read_vehicle

Runner = Any

SHORT = ("obstacle_avoidance", "--duration", "20", "--direction", "left", "--seed", "7")


def direct(**changes: object) -> SimulatedLog:
    """What the command simulates with SHORT, without files."""
    choice = Choice(
        "obstacle_avoidance", preset("suv"), options=Options(duration_s=20.0, direction="left"), seed=7
    )
    return simulate_log(Choice(**{**choice.__dict__, **changes}))  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["drive.csv", "drive.parquet", "drive"])
def test_what_is_written_is_what_the_sensors_gave(inside: Runner, tmp_path: Path, name: str) -> None:
    out = tmp_path / name
    run = inside("simulate", *SHORT, "--out", out)
    assert run.code == 0
    expected = direct().log
    drive = load_drive([out])
    assert drive.record.status == "complete"
    assert not [d for d in drive.record.decisions if d.applied]
    for group in expected.groups:
        for signal, values in group.columns.items():
            there = np.isfinite(values)
            found = drive.signals[signal]
            start = drive.start_ns if name != "drive.csv" else 0
            assert np.array_equal(found.time_ns - start, group.time_ns[there]), signal
            tolerance = 1e-12 if name != "drive.csv" else 6e-5 * max(np.nanstd(values), 1e-3)
            assert np.abs(found.values - values[there]).max() <= tolerance, signal


def test_a_parquet_file_is_one_table_whatever_the_rates(inside: Runner, tmp_path: Path) -> None:
    out = tmp_path / "drive.parquet"
    out.mkdir()
    assert inside("simulate", *SHORT, "--out", out).code == 0
    assert out.is_file()
    frame = pl.read_parquet(out)
    assert frame["accel_y_mps2"].null_count() == 0 < frame["speed_mps"].null_count()
    assert inside("simulate", *SHORT, "--rate", "40", "--out", out).code == 0
    drive = load_drive([out])
    lengths = {len(drive.signals[name].values) for name in ("accel_y", "speed", "brake_pressure")}
    rows = int(40 * direct().run.time_s[-1] + 1e-6) + 1
    assert lengths == {rows}


def test_the_same_seed_gives_the_same_bytes(inside: Runner, tmp_path: Path) -> None:
    made = []
    for folder, seed in (("a", "7"), ("b", "7"), ("c", "8")):
        out = tmp_path / folder / "drive.csv"
        assert inside("simulate", *SHORT[:-1], seed, "--out", out, "--load", "seats:150").code == 0
        made.append({path.name: path.read_bytes() for path in out.parent.iterdir()})
    assert set(made[0]) == {"drive.csv", "drive.truth.json", "vehicle.toml"}
    assert made[0] == made[1]
    assert all(made[0][name] != made[2][name] for name in made[0])


def test_truth_and_vehicle_file(inside: Runner, tmp_path: Path) -> None:
    out = tmp_path / "drive.csv"
    spec = "100@x=1.5,y=0.2,z=1.8"
    assert (
        inside(
            "simulate", *SHORT, "--vehicle", "van", "--load", spec, "--load", "seats:75", "--out", out
        ).code
        == 0
    )
    truth = json.loads((tmp_path / "drive.truth.json").read_text())
    van = preset("van")
    assert truth["seed"] == 7
    assert truth["vehicle"] == "van"
    assert truth["manoeuvre"] == "obstacle_avoidance"
    assert [load["mass_kg"] for load in truth["loads"]] == [100.0, 75.0]
    assert truth["parameters"]["mass_kg"] == pytest.approx(van.mass_kg + 175)
    assert set(truth["sensors"]["drawn"]) <= set(SIGNALS)
    assert abs(truth["sensors"]["drawn"]["accel_y"]["offset"]) > 0
    assert any(truth["sensors"]["mounts"]["imu"]["misalignment_rad"])
    vehicle = read_vehicle(tmp_path / "vehicle.toml")
    assert vehicle.body == van.body
    assert not vehicle.load_stated
    assert vehicle.reference["cg_height_m"] == pytest.approx(truth["parameters"]["cg_height_m"], rel=1e-6)
    exact = sheet_values(van)
    assert set(vehicle.quantities) == set(exact) | {"spring_base_rear_m"}
    off = {k: (vehicle.quantities[k].value / exact[k] - 1) / RELATIVE[k] for k in RELATIVE}
    # off by what it says, and not more: 22 figures, each within 2.5 std
    assert 0.5 < np.sqrt(np.mean(np.square(list(off.values())))) < 1.6
    assert max(map(abs, off.values())) <= 2.5 + 1e-4
    for key, quantity in vehicle.quantities.items():
        assert quantity.std_stated, key


def test_a_told_load_and_an_exact_sheet(inside: Runner, tmp_path: Path) -> None:
    out = tmp_path / "drive.csv"
    run = inside(
        "simulate", *SHORT, "--tell-load", "--load", "roof:80", "--vehicle-errors", "0", "--out", out
    )
    assert run.code == 0
    vehicle = read_vehicle(tmp_path / "vehicle.toml")
    assert vehicle.load["mass_kg"].value == pytest.approx(80)
    assert vehicle.load["height_m"].value > 1.5
    for key, value in sheet_values(preset("suv")).items():
        assert vehicle.quantities[key].value == pytest.approx(value, rel=1e-5), key


def test_another_drive_in_the_folder_keeps_its_vehicle_file(inside: Runner, tmp_path: Path) -> None:
    first, second = tmp_path / "first.csv", tmp_path / "second.csv"
    assert inside("simulate", *SHORT, "--out", first).code == 0
    kept = (tmp_path / "vehicle.toml").read_bytes()
    run = inside("simulate", *SHORT, "--load", "roof:80", "--out", second)
    assert (tmp_path / "vehicle.toml").read_bytes() == kept
    assert (tmp_path / "second.vehicle.toml").is_file()
    assert f"cogest analyze {second} --vehicle" in run.out
    assert inside("simulate", *SHORT, "--out", first).code == 0
    assert sorted(path.name for path in tmp_path.glob("*.toml")) == ["second.vehicle.toml", "vehicle.toml"]


def test_a_vehicle_file_makes_the_plant(inside: Runner, tmp_path: Path) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text(
        '[vehicle]\nname = "mine"\nbody = "Sedan"\nmass_kg = 1650\ncg_to_front_axle_m = 1.25\ncg_height_m = 0.58\n'
        "wheelbase_m = 2.8\nspring_rate_front_npm = 30000\nroll_inertia_kgm2 = 600\nunsprung_mass_front_kg = 90\n"
    )
    out = tmp_path / "drive.csv"
    made = inside("simulate", *SHORT, "--vehicle", mine, "--out", out)
    assert made.code == 0
    assert "note:" not in made.out
    truth = json.loads((tmp_path / "drive.truth.json").read_text())["parameters"]
    for name, value in (("mass_kg", 1650), ("cg_to_front_axle_m", 1.25), ("cg_height_m", 0.58)):
        assert truth[name] == pytest.approx(value, rel=1e-3), name
    assert truth["roll_inertia_kgm2"] == pytest.approx(600, rel=0.01)
    sheet = read_vehicle(tmp_path / "vehicle.toml")
    assert sheet.quantities["spring_rate_front_npm"].value == pytest.approx(30000, rel=0.06)


def test_what_the_plant_does_not_take_of_a_vehicle_file_is_said(inside: Runner, tmp_path: Path) -> None:
    mine = tmp_path / "mine.toml"
    mine.write_text('[vehicle]\nbody = "Hatchback"\nmass_kg = 1355\nroll_stiffness_nmprad = 62000\n')
    made = inside("simulate", *SHORT, "--vehicle", mine, "--out", tmp_path / "drive.csv")
    assert made.code == 0
    notes = [line for line in made.out.splitlines() if line.startswith("note: ")]
    assert notes == [
        "note: no preset is a Hatchback: what it does not state is that of `suv`",
        "note: the simulated vehicle does not take the file's roll_stiffness_nmprad: its springs and bars make its own",
    ]


def test_the_other_commands_read_it(cogest: Runner, quick: Path, tmp_path: Path) -> None:
    out = tmp_path / "drive.csv"
    run = cogest("simulate", *SHORT, "--sensors", "ins", "--out", out)
    assert run.code == 0, run.err
    assert "CG 0.6" in run.out
    assert f"next: cogest analyze {out}" in run.out
    seen = json.loads(cogest("inspect", out, "--json").out)
    assert {"roll", "accel_y", "gps_speed_3d"} <= {m["signal"] for m in seen["import"]["mapped"]}
    done = cogest(
        "analyze", out, "--settings", quick, "--estimators", "roll_map", "--format", "json", "--out", tmp_path
    )
    assert done.code == 0, done.err
    results = json.loads((tmp_path / "results.json").read_text())
    truth = json.loads((tmp_path / "drive.truth.json").read_text())["parameters"]
    height = results["verdict"]["cg_height_m"]
    assert height["reference"] == pytest.approx(truth["cg_height_m"])
    assert results["import"]["status"] == "complete"


def test_the_list_names_everything(inside: Runner) -> None:
    run = inside("simulate", "--list")
    assert run.code == 0
    for name in ("public_road", "sine_with_dwell", "suv", "truck_4wd", "roof:KG", "deflection", "perfect"):
        assert any(line.split()[:1] == [name] for line in run.out.splitlines()), name


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("public_roads",), "did you mean 'public_road'"),
        (("slalom", "--vehicle", "suf"), "did you mean 'suv'"),
        (("slalom", "--vehicle", "absent.toml"), "absent.toml"),
        (("slalom", "--sensors", "deflections"), "did you mean 'deflection'"),
        (("slalom", "--load", "rof:10"), "did you mean 'roof'"),
        (("slalom", "--load", "heavy"), "write MASS@x="),
        (("slalom", "--load", "10@x=1,y=a,z=1"), "found 'a', expected a number"),
        (("slalom", "--load", "-5@x=1,y=0,z=1"), "more than 0"),
        (("slalom", "--load", "5@x=90,y=0,z=1"), "wheelbase"),
        (("slalom", "--load", "roof:nan"), "expected a number"),
        (("slalom", "--load", "roof:25000"), "cannot carry"),
        (("slalom", "--speed", "900"), "--speed is"),
        (("slalom", "--surface", "Z"), "surface"),
        (("slalom", "--rate", "0"), "--rate is 0"),
        (("slalom", "--outliers", "3"), "--outliers is 3"),
        (("slalom", "--dropouts", "-1"), "--dropouts is -1"),
        (("slalom", "--sensor-errors", "nan"), "--sensor-errors is nan"),
    ],
)
def test_wrong_words_are_one_line(
    inside: Runner, capfd: pytest.CaptureFixture[str], tmp_path: Path, arguments: tuple[str, ...], words: str
) -> None:
    run = inside("simulate", *arguments, "--out", tmp_path / "drive.csv")
    assert run.code == (1 if words == "absent.toml" else 2)
    assert words in run.err
    assert run.err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_format_that_is_not_written(inside: Runner, tmp_path: Path) -> None:
    run = inside("simulate", "slalom", "--out", tmp_path / "drive.mf4")
    assert run.code == 2
    assert "'.mf4'" in run.err
    assert ".parquet" in run.err


@pytest.mark.parametrize("arguments", [(), ("slalom",), ("slalom", "--direction", "up", "--out", "x.csv")])
def test_wrong_usage(inside: Runner, arguments: tuple[str, ...]) -> None:
    assert inside("simulate", *arguments).code == 2


def test_a_folder_of_others_is_left_alone(inside: Runner, tmp_path: Path) -> None:
    folder = tmp_path / "drive"
    folder.mkdir()
    (folder / "theirs.parquet").write_bytes(b"PAR1")
    run = inside("simulate", *SHORT, "--out", folder)
    assert run.code == 1
    assert "did not write" in run.err
    assert [path.name for path in folder.iterdir()] == ["theirs.parquet"]


def test_a_folder_with_another_log_is_left_alone(inside: Runner, tmp_path: Path) -> None:
    (tmp_path / "theirs.csv").write_text("a,b")
    run = inside("simulate", *SHORT, "--out", tmp_path)
    assert run.code == 1
    assert "holds other files (theirs.csv)" in run.err
    assert not list(tmp_path.glob("*.parquet"))


def test_a_roll_over_is_told(inside: Runner, tmp_path: Path) -> None:
    out = tmp_path / "drive.csv"
    hard = ("--vehicle", "van", "--load", "roof:700", "--severity", "4")
    run = inside("simulate", "sine_with_dwell", *hard, "--out", out)
    assert run.code == 0
    assert "rolled over after" in run.out
    truth = json.loads((tmp_path / "drive.truth.json").read_text())
    assert truth["rolled_over"]
    assert load_drive([out]).record.duration_s == pytest.approx(truth["duration_s"], abs=0.05)


def test_lost_messages_and_wild_samples(inside: Runner, tmp_path: Path) -> None:
    out = tmp_path / "drive.parquet"
    run = inside(
        "simulate", *SHORT, "--sensors", "ins", "--dropouts", "0.2", "--outliers", "0.001", "--out", out
    )
    assert run.code == 0
    drive = load_drive([out])
    assert any(gap.signal == "accel_y" for gap in drive.record.gaps)


def test_the_vehicle_file_is_valid_toml_for_every_preset() -> None:
    for name in ("sedan", "truck", "off_road"):
        made = simulate_log(
            Choice("straight_braking", preset(name), options=Options(duration_s=5.0), sensors="production")
        )
        assert tomllib.loads(made.sheet)["vehicle"]["name"].startswith(name)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--speed", "-5"), "--speed is -5 km/h: expected 1.8 to 252"),
        (("--speed", "5000"), "--speed is 5000 km/h"),
        (("--load", "roof:999999"), "at most 30000"),
    ],
)
def test_limits_are_told_in_the_units_of_the_options(
    inside: Runner, tmp_path: Path, arguments: tuple[str, str], words: str
) -> None:
    run = inside("simulate", "slalom", *arguments, "--out", tmp_path / "x.csv")
    assert run.code == 2
    assert words in run.err
