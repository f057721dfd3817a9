"""Logs that were filed at another place of the folder: they count there, and no longer where they were."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import polars as pl

from pipelines.fleet.batch import Absent, Batch, plan_of
from pipelines.fleet.gather import gather
from pipelines.fleet.keys import key_of
from pipelines.fleet.moved import lost
from pipelines.fleet.records import Choices, FoundDrive, FoundFleet
from pipelines.fleet.store import Store, open_store
from tests.pipelines.fleet.stored_drives import (
    found_drive,
    join_plainly,
    kept_of_drive,
    results_of_drive,
)


def drive(root: Path, number: int, vehicle: str) -> FoundDrive:
    """A drive whose log is there."""
    made = replace(found_drive(number, vehicle), vehicle=None)
    path = root / made.name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(f"log {number:03d}".encode())
    return replace(made, logs=(str(path),), size=path.stat().st_size)


def put(store: Store, found: FoundDrive, number: int) -> None:
    key, facts = key_of(found, Choices(), {})
    store.put(found, key, facts, results_of_drive(number), kept_of_drive(number), {})


def refile(root: Path, found: FoundDrive, number: int, vehicle: str) -> FoundDrive:
    """The drive's log, moved to another vehicle's folder."""
    Path(found.logs[0]).unlink()
    return drive(root, number, vehicle)


def test_a_log_filed_under_another_vehicle_counts_there_alone(tmp_path: Path) -> None:
    root, store = tmp_path / "fleet", open_store(str(tmp_path / "store"), create=True)
    drives = {n: drive(root, n, "w1" if n < 4 else "w2") for n in (1, 2, 3, 4)}
    for number, found in drives.items():
        put(store, found, number)
    there = refile(root, drives[3], 3, "w2")
    fleet = FoundFleet(str(root), (drives[1], drives[2], drives[4], there))
    # before the batch, and after it
    for stored in (False, True):
        if stored:
            put(store, there, 3)
        known = lost(store.all(), fleet)
        assert known.gone == ()
        assert known.moved == {drives[3].drive_id: there}
    tables = gather(store, fleet, join_plainly, lambda *_: ())
    assert drives[3].drive_id not in tables["drives"]["drive_id"]
    assert drives[3].drive_id not in tables["parameters"]["drive_id"]
    assert dict(tables["vehicles"].select("vehicle_id", "drives").iter_rows()) == {"w1": 2, "w2": 2}
    row = tables["drives"].filter(drive_id=there.drive_id).row(0, named=True)
    assert "moved here from w1/drive_003.csv of vehicle w1" in row["notes"]
    assert not tables["drives"]["gone"].any()


def test_a_log_that_is_nowhere_still_counts(tmp_path: Path) -> None:
    root, store = tmp_path / "fleet", open_store(str(tmp_path / "store"), create=True)
    drives = {n: drive(root, n, "w1") for n in (1, 2)}
    for number, found in drives.items():
        put(store, found, number)
    # another log of the same size
    Path(drives[2].logs[0]).unlink()
    fleet = FoundFleet(str(root), (drives[1], drive(root, 5, "w2")))
    assert lost(store.all(), fleet).gone == (drives[2].drive_id,)
    assert lost(store.all(), fleet).moved == {}
    tables = gather(store, fleet, join_plainly, lambda *_: ())
    assert tables["drives"].filter(pl.col("gone"))["drive_id"].to_list() == [drives[2].drive_id]


def test_a_dry_run_names_what_is_gone_and_what_was_moved(tmp_path: Path) -> None:
    root, store = tmp_path / "fleet", open_store(str(tmp_path / "store"), create=True)
    drives = {n: drive(root, n, "w1") for n in (1, 2, 3)}
    for number, found in drives.items():
        put(store, found, number)
    Path(drives[1].logs[0]).unlink()
    there = refile(root, drives[3], 3, "w2")
    fleet = FoundFleet(str(root), (drives[2], there))
    plan = plan_of(Batch(str(root), store.place, Choices()), fleet)
    assert plan.states[there.drive_id] == "new"
    assert plan.absent == (
        Absent(drives[1].drive_id, "w1/drive_001.csv", "w1"),
        Absent(drives[3].drive_id, "w1/drive_003.csv", "w1", "w2/drive_003.csv"),
    )
