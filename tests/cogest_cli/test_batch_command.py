"""`cogest batch` through the installed program: a fleet, its failures, doing again only what changed, kill -9, two at once."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import polars as pl
import pytest

TABLES = ("drives", "parameters", "vehicles", "load_changes", "trends", "outliers")


@pytest.fixture(scope="module")
def little_fleet(samples: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three vehicles, five drives, one of which is no log at all."""
    fleet = tmp_path_factory.mktemp("fleet")
    for vehicle, logs in {
        "sedan": ("track.vbo",),
        "suv": ("tuesday.csv",),
        "van": ("yard.csv", "tour_1.blf"),
    }.items():
        (fleet / vehicle).mkdir()
        for name in (*logs, "vehicle.toml", "map.toml", "chassis.dbc"):
            source = samples / "fleet" / vehicle / name
            if source.exists():
                shutil.copy(source, fleet / vehicle / name)
    (fleet / "suv" / "broken.mcap").write_bytes(b"\x89MCAP0\r\n" + b"\0" * 50)
    return fleet


def tables_of(store: Path) -> dict[str, bytes]:
    return {name: (store / f"{name}.parquet").read_bytes() for name in TABLES}


OPTIONS = ("--estimators", "load_balance,load_transfer", "--reports", "none", "--format", "html")
"""Two estimators and no drives' reports are enough to see that a batch does what it must."""


@pytest.fixture(scope="module")
def done(cogest, little_fleet: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, object]:
    """The store of one whole batch, and what the program said."""
    store = tmp_path_factory.mktemp("done") / "store"
    run = cogest("batch", little_fleet, "--out", store, *OPTIONS)
    return store, run


def test_a_broken_log_costs_that_drive_alone_and_the_code_is_3(done) -> None:
    store, run = done
    assert run.code == 3
    drives = pl.read_parquet(store / "drives.parquet")
    assert drives.height == 5
    failed = drives.filter(pl.col("status") != "done")
    assert failed["drive"].to_list() == ["suv/broken.mcap"]
    assert "broken.mcap" in run.out + run.err
    # the row names the drive: its path is not said a second time
    assert failed["reason"][0]
    assert "broken.mcap" not in failed["reason"][0]
    assert (run.out + run.err).count("broken.mcap") == 2
    assert (store / "fleet.html").stat().st_size > 1000


def test_again_does_nothing_and_a_change_does_only_what_changed(cogest, done, little_fleet, tmp_path) -> None:
    # a fleet and its store that were moved to another folder are the same
    fleet = tmp_path / "fleet"
    shutil.copytree(little_fleet, fleet)
    first = tmp_path / "store"
    shutil.copytree(done[0], first)
    before = tables_of(first)
    again = [
        json.loads(line)
        for line in cogest("batch", fleet, "--out", first, "--json", *OPTIONS).out.splitlines()
    ]
    assert [event["event"] for event in again if event["event"] == "ended"] == []
    assert again[-1]["event"] == "finished"
    assert again[-1]["kept"] == 4
    assert tables_of(first) == before
    # a touched file is no change; a changed vehicle file is one for its drives
    os.utime(fleet / "suv" / "tuesday.csv")
    text = (fleet / "van" / "vehicle.toml").read_text()
    (fleet / "van" / "vehicle.toml").write_text(text + "\n# another word\n")
    events = [
        json.loads(line)
        for line in cogest("batch", fleet, "--out", first, "--json", *OPTIONS).out.splitlines()
    ]
    assert sorted(event["name"] for event in events if event["event"] == "ended") == [
        "van/tour_1.blf",
        "van/yard.csv",
    ]


def test_engines_give_the_same_tables(cogest, done, little_fleet, tmp_path) -> None:
    store, _ = done
    for engine, more in (("serial", []), ("dask", ["--workers", 2])):
        if engine == "dask":
            pytest.importorskip("distributed")
        other = tmp_path / engine
        run = cogest("batch", little_fleet, "--out", other, "--engine", engine, *more, *OPTIONS)
        assert run.code == 3
        assert tables_of(other) == tables_of(store), engine


@pytest.mark.skipif(sys.platform == "win32", reason="kill -9 is of POSIX")
def test_killed_at_any_moment_it_goes_on_to_the_same_bytes(
    cogest, program, done, little_fleet, tmp_path
) -> None:
    store, _ = done
    killed = tmp_path / "store"
    rng = random.Random(1)
    for _ in range(2):
        process = subprocess.Popen(
            [*program, "batch", str(little_fleet), "--out", str(killed), *OPTIONS],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        time.sleep(rng.uniform(2.0, 6.0))
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert cogest("batch", little_fleet, "--out", killed, *OPTIONS).code == 3
    assert tables_of(killed) == tables_of(store)


def test_two_at_once_share_the_work(cogest, program, done, little_fleet, tmp_path) -> None:
    store, _ = done
    both = tmp_path / "store"
    command = [*program, "batch", str(little_fleet), "--out", str(both), "--workers", "1", "--json"]
    runs = [subprocess.Popen([*command, *OPTIONS], stdout=subprocess.PIPE, text=True) for _ in range(2)]
    told = [run.communicate()[0] for run in runs]
    assert [run.returncode for run in runs] == [3, 3]
    ended = [e for text in told for e in map(json.loads, text.splitlines()) if e["event"] == "ended"]
    worked = [e["name"] for e in ended if e["status"] == "done"]
    assert len(worked) == len(set(worked)) == 4
    assert tables_of(both) == tables_of(store)


def test_a_dry_run_lists_and_makes_nothing(cogest, little_fleet, tmp_path) -> None:
    run = cogest("batch", little_fleet, "--out", tmp_path / "store", "--dry-run")
    assert run.code == 0
    assert "track.vbo" in run.out
    assert not (tmp_path / "store").exists()


def test_a_dry_run_lists_the_estimators_that_are_chosen_alone(cogest, little_fleet, tmp_path) -> None:
    run = cogest(
        "batch", little_fleet, "--out", tmp_path / "store", "--dry-run", "--json", "--estimators", "roll_map"
    )
    outlooks = [each["outlook"] for each in json.loads(run.out)["drives"] if each.get("outlook")]
    assert outlooks
    able = [each for each in outlooks if each["ready"]]
    assert able
    assert all(each["ready"] == ["roll_map"] for each in able)
    assert {name for each in outlooks for name, _ in each["missing"]} <= {"roll_map"}
    # what no chosen estimator gives is not among what may be told
    assert all(
        dict(each["cannot"])["cg_to_front_axle_m"] == "none of the chosen estimators tells it"
        for each in able
    )


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere"], "nowhere"),
        (["{fleet}", "--engine", "locale"], "local"),
        (["{fleet}", "--reports", "docx"], "docx"),
        (["{fleet}", "--estimators", "roll_mapp"], "roll_map"),
        (["{fleet}", "--scheduler", "tcp://127.0.0.1:1"], "dask"),
    ],
)
def test_what_cannot_be_is_one_line(cogest, little_fleet, tmp_path, arguments, said) -> None:
    given = [str(little_fleet) if a == "{fleet}" else a for a in arguments]
    run = cogest("batch", *given, "--out", tmp_path / "store")
    assert run.code == (1 if said == "nowhere" else 2)
    assert said in run.err
    assert len(run.err.splitlines()) == 1


def test_a_limit_costs_the_drives_that_break_it_and_they_are_tried_again(
    cogest, done, little_fleet, tmp_path
) -> None:
    store, _ = done
    limited = tmp_path / "store"
    run = cogest("batch", little_fleet, "--out", limited, "--time-limit", 1, *OPTIONS)
    assert run.code == 3
    drives = pl.read_parquet(limited / "drives.parquet")
    slow = drives.filter(pl.col("status") == "timeout")
    assert slow.height >= 1
    assert set(slow["reason"]) == {"took longer than 1 s (limit)"}
    assert cogest("batch", little_fleet, "--out", limited, *OPTIONS).code == 3
    assert tables_of(limited) == tables_of(store)


@pytest.mark.skipif(sys.platform == "win32", reason="SIGTERM is of POSIX")
def test_sigterm_puts_away_what_ctrl_c_does(program, little_fleet, tmp_path) -> None:
    store = tmp_path / "store"
    command = [
        *program,
        "batch",
        str(little_fleet),
        "--out",
        str(store),
        "--workers",
        "1",
        "--json",
        *OPTIONS,
    ]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    while json.loads(process.stdout.readline())["event"] != "ended":
        pass
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 143
    assert "ended by SIGTERM" in err
    assert "stopped: " in (store / "batch.log").read_text(encoding="utf-8")
    assert not [path for path in store.rglob("*") if "claim" in path.name and path.is_file()]


@pytest.mark.skipif(sys.platform == "win32", reason="kill -9 is of POSIX")
def test_a_worker_that_dies_costs_its_drive_alone(cogest, program, done, little_fleet, tmp_path) -> None:
    import psutil

    store, _ = done
    hit = tmp_path / "store"
    command = [*program, "batch", str(little_fleet), "--out", str(hit), "--workers", "1", "--json", *OPTIONS]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert process.stdout is not None
    # after the first drive the worker is at work on the next at once; one that dies while it starts would be started again
    while json.loads(process.stdout.readline())["event"] != "ended":
        pass
    time.sleep(0.1)
    for worker in psutil.Process(process.pid).children():
        worker.kill()
    process.communicate(timeout=120)
    assert process.returncode == 3
    drives = pl.read_parquet(hit / "drives.parquet")
    crashed = drives.filter(pl.col("status") == "crashed")
    assert crashed.height == 1
    assert "signal 9" in crashed["reason"][0]
    assert drives.filter(pl.col("status") == "done").height == 3
    assert cogest("batch", little_fleet, "--out", hit, *OPTIONS).code == 3
    assert tables_of(hit) == tables_of(store)
