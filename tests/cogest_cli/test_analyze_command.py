"""`cogest analyze`: what it writes and prints, several logs, files that are found, options that count."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import polars as pl
import pytest


def results_in(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "results.json").read_text(encoding="utf-8"))


def numbers_in(folder: Path) -> dict[str, Any]:
    """The results without what differs from run to run: the time of day and how long it took."""
    results = results_in(folder)
    for estimate in results["estimates"]:
        del estimate["runtime_s"]
    if results["joint"] is not None:
        del results["joint"]["runtime_s"]
    return {key: value for key, value in results.items() if key != "inputs"}


def test_a_sample_log_gives_a_report_and_a_verdict_and_the_report_comes_again_without_the_log(
    cogest, samples, quick, tmp_path
):
    folder = tmp_path / "drive"
    folder.mkdir()
    log = folder / "drive.csv"
    shutil.copy(samples / "csv" / "drive.csv", log)
    shutil.copy(samples / "vehicle.toml", tmp_path / "vehicle.toml")
    run = cogest("analyze", log, "--settings", quick, "--out", tmp_path / "out")
    assert (run.code, run.err) == (0, "")
    for name in ("report.html", "report.pdf", "results.json"):
        assert (tmp_path / "out" / name).stat().st_size > 1000
        assert str(tmp_path / "out" / name) in run.out.splitlines()
    for text in ("CG height above ground", "95 % interval", "identified", "not identifiable"):
        assert text in run.out
    results = results_in(tmp_path / "out")
    assert results["inputs"]["vehicle"] == str(tmp_path / "vehicle.toml")
    assert results["inputs"]["log"]["path"] == str(log)
    assert results["import"]["status"] == "complete"
    assert results["verdict"]["roll_gradient_degpg"]["status"] == "identified"

    first = (tmp_path / "out" / "report.html").read_bytes()
    log.unlink()
    again = cogest("report", tmp_path / "out", "--out", tmp_path / "again")
    assert (again.code, again.err) == (0, "")
    assert (tmp_path / "again" / "report.html").read_bytes() == first
    assert (tmp_path / "again" / "report.pdf").exists()
    assert not (tmp_path / "again" / "results.json").exists()


def test_json_alone_and_the_same_seed_the_same_numbers(inside, samples, quick, tmp_path):
    log = samples / "csv" / "drive.csv"
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        run = inside(
            "analyze", log, "--format", "json", "--seed", seed, "--settings", quick, "--out", tmp_path / name
        )
        assert (run.code, run.err) == (0, "")
    assert not list(tmp_path.glob("*/report.*"))
    assert numbers_in(tmp_path / "a") == numbers_in(tmp_path / "b")
    assert numbers_in(tmp_path / "a")["verdict"] != numbers_in(tmp_path / "c")["verdict"]
    assert results_in(tmp_path / "c")["inputs"]["seed"] == 2
    assert results_in(tmp_path / "c")["inputs"]["settings"] == str(quick)


def test_one_estimator_by_name(inside, samples, quick, tmp_path):
    for name in ("report.html", "report.pdf", "results.json"):
        (tmp_path / name).write_text("of an earlier run")
    log = samples / "csv" / "drive.csv"
    run = inside(
        "analyze", log, "--estimators", "roll_map", "--format", "json", "--settings", quick, "--out", tmp_path
    )
    assert run.code == 0
    assert [e["estimator"] for e in results_in(tmp_path)["estimates"]] == ["roll_map"]
    assert sorted(p.name for p in tmp_path.glob("report*")) == []


def test_no_fix_leaves_the_data_alone(inside, drive, quick, tmp_path):
    frame = pl.read_csv(drive)
    frame.with_columns(-pl.col("yaw_rate_radps")).write_csv(drive)
    for name, options in (("fixed", ()), ("left", ("--no-fix",))):
        run = inside(
            "analyze",
            drive,
            *options,
            "--format",
            "json",
            "--settings",
            quick,
            "--out",
            tmp_path / name,
        )
        assert run.code == 0
    fixed, left = (results_in(tmp_path / name)["import"]["decisions"] for name in ("fixed", "left"))
    (sign,) = [d for d in fixed if d["signal"] == "yaw_rate" and d["kind"] == "sign"]
    assert (sign["applied"], sign["action"]) == (True, "inverted")
    assert left
    assert not any(d["applied"] for d in left)
    assert any(d["signal"] == "yaw_rate" and "--no-fix" in d["action"] for d in left)
    for name, turned in (("fixed", -1), ("left", 1)):
        options = () if turned < 0 else ("--no-fix",)
        assert inside("convert", drive, *options, "--out", tmp_path / "tables" / name).code == 0
        (table,) = (tmp_path / "tables" / name).glob("*.parquet")
        yaw = pl.read_parquet(table)["yaw_rate_radps"].to_numpy()
        assert yaw == pytest.approx(turned * -frame["yaw_rate_radps"].to_numpy(), abs=1e-12)


def signals_of(run_folder: Path) -> pl.DataFrame:
    """All tables of a folder side by side, by stamp."""
    tables = [pl.read_parquet(path) for path in sorted(run_folder.glob("*.parquet"))]
    whole = tables[0]
    for table in tables[1:]:
        whole = whole.join(table, on="time_ns", how="full", coalesce=True)
    return whole.sort("time_ns").select(sorted(whole.columns))


def test_a_drive_recorded_in_parts(inside, drive, quick, tmp_path):
    lines = drive.read_text(encoding="utf-8").splitlines()
    one, two = tmp_path / "one.csv", tmp_path / "two.csv"
    # the parts share three rows, as those of loggers do that cut while they write
    one.write_text("\n".join(lines[:643]) + "\n", encoding="utf-8")
    two.write_text("\n".join([lines[0], *lines[640:]]) + "\n", encoding="utf-8")
    assert inside("convert", drive, "--out", tmp_path / "whole").code == 0
    assert inside("convert", one, two, "--out", tmp_path / "parts").code == 0
    assert signals_of(tmp_path / "parts").equals(signals_of(tmp_path / "whole"))
    for name, logs in (("a", [drive]), ("b", [two, one])):
        run = inside("analyze", *logs, "--format", "json", "--settings", quick, "--out", tmp_path / name)
        assert run.code == 0
    a, b = results_in(tmp_path / "a"), results_in(tmp_path / "b")
    assert b["verdict"] == a["verdict"]
    assert b["inputs"]["log"]["paths"] == [str(two), str(one)]
    assert b["import"]["messages"] == a["import"]["messages"] + 3
    assert b["import"]["gaps"] == []


def test_two_recorders_of_one_drive(inside, drive, tmp_path):
    frame = pl.read_csv(drive)
    inertial, vehicle = tmp_path / "imu.csv", tmp_path / "bus.csv"
    frame.drop("speed_mps").write_csv(inertial)
    frame.select("time_s", "speed_mps").gather_every(2).write_csv(vehicle)
    run = inside("convert", inertial, vehicle, "--out", tmp_path / "out")
    assert run.code == 0
    found = signals_of(tmp_path / "out")
    assert found["speed_mps"].drop_nulls().to_list() == frame["speed_mps"].gather_every(2).to_list()
    assert found["accel_y_mps2"].drop_nulls().to_list() == frame["accel_y_mps2"].to_list()
    assert "the logs' stamps are relative" in run.out


def test_the_same_log_twice_counts_once_and_says_so(inside, drive, tmp_path):
    run = inside("convert", drive, drive, "--out", tmp_path / "out")
    assert run.code == 0
    assert "roll is in several logs over the same time" in run.out
    record = json.loads((tmp_path / "out" / "import_record.json").read_text(encoding="utf-8"))
    used = [entry["used"] for entry in record["mapped"] if entry["signal"] == "roll"]
    assert used == [True, False]


def test_a_vehicle_is_found_up_the_folders_and_one_given_wins(inside, samples, quick, tmp_path):
    deep = tmp_path / "fleet" / "car" / "monday"
    deep.mkdir(parents=True)
    shutil.copy(samples / "csv" / "drive.csv", deep)
    (tmp_path / "fleet" / "vehicle.toml").write_text('[vehicle]\nname = "far"\n', encoding="utf-8")
    (tmp_path / "fleet" / "car" / "vehicle.toml").write_text('[vehicle]\nname = "near"\n', encoding="utf-8")
    given = tmp_path / "given.toml"
    given.write_text('[vehicle]\nname = "given"\n', encoding="utf-8")
    for name, options in (("near", ()), ("given", ("--vehicle", given))):
        run = inside(
            "analyze",
            deep / "drive.csv",
            *options,
            "--format",
            "json",
            "--settings",
            quick,
            "--out",
            tmp_path / name,
        )
        assert run.code == 0
        assert results_in(tmp_path / name)["inputs"]["vehicle_name"] == name


def test_a_map_that_is_given_is_strict_and_one_that_is_found_is_not(inside, drive, tmp_path):
    text = '[signals.speed]\nchannel = "speed_mps"\n[signals.roll]\nchannel = "body_roll"\n'
    (drive.parent / "map.toml").write_text(text, encoding="utf-8")
    run = inside("convert", drive, "--out", tmp_path / "found")
    assert run.code == 0
    assert "map.toml maps roll to 'body_roll', which is not in this log" in run.out
    given = inside("convert", drive, "--map", drive.parent / "map.toml", "--out", tmp_path / "given")
    assert given.code == 1
    assert "[signals.roll]: channel 'body_roll' is not in the log" in given.err


def test_databases_lie_beside_the_log_or_are_given(inside, samples, tmp_path):
    log = tmp_path / "drive.log"
    shutil.copy(samples / "can" / "drive.log", log)
    for name in ("map.toml", "chassis.dbc"):
        shutil.copy(samples / "can" / name, tmp_path)
    beside = inside("inspect", log)
    assert beside.code == 0
    assert "Inertial1.AccelY" in beside.out
    (tmp_path / "databases").mkdir()
    (tmp_path / "chassis.dbc").rename(tmp_path / "databases" / "chassis.dbc")
    without = json.loads(inside("inspect", log, "--json").out)
    assert "Inertial1.AccelY" not in {channel["name"] for channel in without["channels"]}
    given = inside("inspect", log, "--dbc", tmp_path / "databases" / "chassis.dbc")
    assert given.code == 0
    assert given.out == beside.out


def test_databases_beside_a_log_without_frames_are_not_named_as_used(inside, drive, samples, quick, tmp_path):
    options = ("--estimators", "roll_map", "--format", "json", "--settings", quick)
    database = samples / "can" / "chassis.dbc"
    shutil.copy(database, drive.parent)
    run = inside("analyze", drive, *options, "--out", tmp_path / "table")
    assert (run.code, run.err) == (0, "")
    assert "database:" not in run.out
    assert results_in(tmp_path / "table")["inputs"]["dbc"] == []
    given = inside("analyze", drive, *options, "--dbc", database, "--out", tmp_path / "given")
    assert "--dbc chassis.dbc was not used" in given.out
    assert "database:" not in given.out
    frames = inside("analyze", samples / "can" / "drive.log", *options, "--out", tmp_path / "frames")
    assert frames.code == 0
    assert f"database: {database}" in frames.out.splitlines()
    assert results_in(tmp_path / "frames")["inputs"]["dbc"] == [str(database)]


def test_a_database_that_fits_nothing_is_said_and_not_blamed_on_the_map(inside, samples, quick, tmp_path):
    other = tmp_path / "other.dbc"
    other.write_text('VERSION ""\nBU_: E\nBO_ 1234 M: 2 E\n SG_ v : 0|16@1+ (0.1,0) [0|0] "km/h" E\n')
    log, right = samples / "can" / "drive.blf", samples / "can" / "chassis.dbc"
    options = ("--estimators", "roll_map", "--format", "json", "--settings", quick)
    # a map.toml lies beside the log, whose channels are all missing for want of a database
    alone = inside("analyze", log, *options, "--dbc", other, "--out", tmp_path / "alone")
    assert alone.code == 1
    assert "none of the log's 7 CAN identifiers" in alone.err
    assert "map.toml" not in alone.err
    both = inside("analyze", log, *options, "--dbc", other, "--dbc", right, "--out", tmp_path / "both")
    assert (both.code, both.err) == (0, "")
    assert "--dbc other.dbc decoded nothing: none of its messages is in the log." in both.out.splitlines()
    assert results_in(tmp_path / "both")["inputs"]["dbc"] == [str(right)]


def test_settings_beside_the_log_are_found_and_named(inside, drive, quick, tmp_path):
    """As `cogest batch` does: the log's own before the folder's, and what was given before both."""
    options = ("--estimators", "roll_map", "--format", "json", "--out", tmp_path / "out")
    (tmp_path / "settings.toml").write_text(quick.read_text(encoding="utf-8"), encoding="utf-8")
    run = inside("analyze", drive, *options)
    assert (run.code, run.err) == (0, "")
    assert f"settings file: {tmp_path / 'settings.toml'}" in run.out.splitlines()
    assert results_in(tmp_path / "out")["inputs"]["settings"] == str(tmp_path / "settings.toml")
    found = numbers_in(tmp_path / "out")
    assert inside("analyze", drive, *options, "--settings", quick).code == 0
    assert numbers_in(tmp_path / "out") == found
    own = tmp_path / "drive.settings.toml"
    own.write_text("[no_such_estimator]\nx = 1\n", encoding="utf-8")
    run = inside("analyze", drive, *options)
    assert run.code != 0
    assert str(own) in run.err
    own.unlink()
    (tmp_path / "settings.toml").unlink()
    assert "settings file" not in inside("analyze", drive, *options, "--settings", quick).out.replace(
        f"settings file: {quick}", ""
    )
