"""`cogest suspension-map` and `analyze --suspension-map`, by the installed program: train, judge, apply, refuse."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import polars as pl
import pytest

Runner = Any

SETTINGS = ("--sensors", "wheel_force")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, inside: Runner) -> Path:
    """Two drives of one vehicle: one to train on, one with another load; in folders of their own."""
    root = tmp_path_factory.mktemp("suspension")
    drives = {
        "train": ("handling_track", "--duration", 70, "--load", "seats:75"),
        "other": ("slalom", "--duration", 40, "--load", "seats:150", "--load", "roof:80"),
    }
    for name, (manoeuvre, *options) in drives.items():
        (root / name).mkdir()
        done = inside("simulate", manoeuvre, "--out", root / name / "drive.csv", *SETTINGS, *options)
        assert done.code == 0
    return root


@pytest.fixture(scope="module")
def trained(folder: Path, cogest: Runner) -> tuple[Path, str]:
    """The map, and what the program printed."""
    out = folder / "suspension.toml"
    done = cogest(
        "suspension-map", folder / "train/drive.csv", "--validate", folder / "other/drive.csv", "--out", out
    )
    assert done.code == 0, done.err
    return out, done.out


def test_prints_training_and_validation_errors(trained: tuple[Path, str]) -> None:
    _, out = trained
    assert "Training from strut forces" in out
    assert "Training from deflections alone" in out
    assert "Validation from strut forces: drive.csv" in out
    assert "(chosen)" in out
    assert "times the training's" in out
    assert out.rstrip().endswith("suspension.toml")


def test_json_holds_the_same(folder: Path, trained: tuple[Path, str], inside: Runner) -> None:
    again = folder / "again.toml"
    logs = (folder / "train/drive.csv", "--validate", folder / "other/drive.csv")
    done = inside("suspension-map", *logs, "--out", again, "--json")
    found = json.loads(done.out)
    assert again.read_bytes() == trained[0].read_bytes()
    assert found["training"]["struts"]["rms_n"] > 0
    (struts,) = [entry for entry in found["validation"] if entry["from"] == "struts"]
    assert struts["ratio_to_training"] < 2
    assert set(struts["wheels"]) == {"fl", "fr", "rl", "rr"}
    assert 100 < struts["load_against_training_kg"] < 220


def test_the_training_drive_is_no_validation(folder: Path, inside: Runner, tmp_path: Path) -> None:
    """By its bytes, so that another path or a copy does not pass either."""
    copy = tmp_path / "copy.csv"
    copy.write_bytes((folder / "train/drive.csv").read_bytes())
    logs = (folder / "train/drive.csv", "--validate", copy, "--validate", folder / "other/drive.csv")
    told = inside("suspension-map", *logs, "--out", tmp_path / "made.toml").out
    assert "NO VALIDATION from strut forces: copy.csv" in told
    assert told.count("trained on this very drive") == 2  # struts, springs
    assert "Validation from strut forces: drive.csv" in told
    data = json.loads(inside("suspension-map", *logs, "--out", tmp_path / "made.toml", "--json").out)
    assert {entry["log"]: entry["trained_on"] for entry in data["validation"]} == {
        "copy.csv": True,
        "drive.csv": False,
    }


def test_analyze_applies_it(folder: Path, trained: tuple[Path, str], cogest: Runner, tmp_path: Path) -> None:
    log = folder / "other/drive.csv"
    done = cogest(
        "analyze", log, "--suspension-map", trained[0], "--estimators", "suspension_mapping", "--out", tmp_path,
        "--format", "html,json",
    )  # fmt: skip
    assert done.code == 0, done.err
    assert "Mapped tyre normal forces against the measuring wheels" in done.out
    results = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert results["inputs"]["suspension_map"] == str(trained[0])
    (estimate,) = results["estimates"]
    assert estimate["status"] == "ran"
    assert results["verdict"]["tire_normal_force_fl_n"]["status"] == "identified"
    frame = pl.read_parquet(tmp_path / "tire_normal_forces.parquet")
    assert frame.columns[0] == "time_ns"
    assert frame.height > 1000
    low, value, high = (frame[f"tire_normal_force_rr_{part}"] for part in ("low_n", "n", "high_n"))
    assert (low < value).all()
    assert (value < high).all()
    assert frame["time_ns"].is_sorted()
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "suspension_mapping" in page
    assert page.lower().count("tyre normal force") > 3


def test_the_vehicle_file_may_name_it(
    folder: Path, trained: tuple[Path, str], inside: Runner, tmp_path: Path
) -> None:
    sheet = (folder / "other/vehicle.toml").read_text(encoding="utf-8")
    (tmp_path / "map.s.toml").write_bytes(trained[0].read_bytes())
    (tmp_path / "vehicle.toml").write_text(
        sheet.replace("[vehicle]\n", '[vehicle]\nsuspension_map = "map.s.toml"\n', 1), encoding="utf-8"
    )
    done = inside(
        "analyze", folder / "other/drive.csv", "--vehicle", tmp_path / "vehicle.toml", "--estimators",
        "suspension_mapping", "--out", tmp_path / "out", "--format", "json",
    )  # fmt: skip
    assert done.code == 0
    assert (tmp_path / "out" / "tire_normal_forces.parquet").is_file()


def test_without_a_map_no_file_stays(folder: Path, inside: Runner, tmp_path: Path) -> None:
    (tmp_path / "tire_normal_forces.parquet").write_bytes(b"of an earlier run")
    done = inside(
        "analyze",
        folder / "other/drive.csv",
        "--estimators",
        "suspension_mapping",
        "--out",
        tmp_path,
        "--format",
        "json",
    )
    assert done.code == 0
    assert not (tmp_path / "tire_normal_forces.parquet").exists()


def test_refusals_are_one_line(
    folder: Path, trained: tuple[Path, str], cogest: Runner, inside: Runner, samples: Path, tmp_path: Path
) -> None:
    broken = tmp_path / "broken.toml"
    broken.write_text(
        trained[0].read_text(encoding="utf-8").replace("own_lateral", "own_latteral", 1), encoding="utf-8"
    )
    log = folder / "other/drive.csv"
    cases = {
        ("analyze", log, "--suspension-map", broken, "--out", tmp_path / "r"): "did you mean 'own_lateral'",
        (
            "analyze",
            log,
            "--suspension-map",
            tmp_path / "none.toml",
            "--out",
            tmp_path / "r",
        ): "cannot be read",
        ("analyze", log, "--suspension-map", log, "--out", tmp_path / "r"): "not valid TOML",
        (
            "suspension-map",
            samples / "csv/drive.csv",
            "--out",
            tmp_path / "m.toml",
        ): "wheel-force transducers",
        ("suspension-map", log, "--out", tmp_path): "is a folder",
        ("suspension-map", log, "--out", tmp_path / "map.toml"): "looks for a file of another kind",
        ("suspension-map", log, "--out", tmp_path / "drive.vehicle.toml"): "looks for a file of another kind",
    }
    for arguments, words in cases.items():
        done = inside(*arguments)
        assert done.code == 1, arguments
        assert words in done.err
        assert done.err.startswith("cogest: ")
        assert done.err.count("\n") == 1
    assert inside("suspension-map", log).code == 2
    assert cogest("suspension-map", log, "--out", tmp_path).code == 1


def test_stated_zeros_are_taken_off(folder: Path, inside: Runner, tmp_path: Path) -> None:
    """As `analyze` takes them off: a map trained with a sensor that shows 12 mm at nothing would be 12 mm off in every drive."""
    wheels = [f"suspension_deflection_{wheel}_m" for wheel in ("fl", "fr", "rl", "rr")]
    table = pl.read_csv(folder / "train/drive.csv", comment_prefix="#")
    sheet = (folder / "train/vehicle.toml").read_text("utf-8")
    made = []
    for name, zero in (("straight", 0.0), ("askew", 0.012)):
        own = tmp_path / name
        own.mkdir()
        table.with_columns(pl.col(wheel) + zero for wheel in wheels).write_csv(own / "drive.csv")
        stated = "".join(f"{wheel} = {{value = {zero}, std = 0.0005}}\n" for wheel in wheels)
        (own / "vehicle.toml").write_text(sheet.replace("[sensors]\n", f"[sensors]\n{stated}", 1), "utf-8")
        done = inside("suspension-map", own / "drive.csv", "--out", own / "suspension.toml")
        assert done.code == 0, done.err
        lines = (own / "suspension.toml").read_text("utf-8").splitlines()
        text = "\n".join(line for line in lines if "sha256" not in line)
        made.append([float(number) for number in re.findall(r"-?\d+\.?\d*(?:e[+-]\d+)?", text)])
    assert len(made[0]) > 100
    # the same but for how 12 mm round in a file of decimals
    assert made[1] == pytest.approx(made[0], rel=1e-6)
