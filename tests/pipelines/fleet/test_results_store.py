"""The store: drives put and read back, what is damaged is said and done again, and what is no store is refused."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from parsers.errors import StoreError
from pipelines.fleet.gather import prune
from pipelines.fleet.moved import lost
from pipelines.fleet.records import Facts
from pipelines.fleet.rows import rows_bytes, rows_from, rows_of
from pipelines.fleet.storage_local import LocalStorage
from pipelines.fleet.store import STORE_FILE, Store, folder_of, open_store
from pipelines.fleet.tables import TABLES
from tests.pipelines.fleet.stored_drives import (
    facts_of_drive,
    fleet_of,
    found_drive,
    kept_of_drive,
    results_of_drive,
)
from tests.reports.sample_fleet import sample_fleet

ROOT = Path(__file__).resolve().parents[3]
DRIVE = found_drive(1)
FILES = {"results.json": b"{}", "report.html": b"<p>report</p>"}


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return open_store(str(tmp_path / "store"), create=True)


def put(store: Store, number: int = 1, key: str = "key") -> Path:
    """Store a drive; its folder."""
    drive = found_drive(number)
    store.put(drive, key, facts_of_drive(number), results_of_drive(number), kept_of_drive(number), FILES)
    return Path(store.place) / folder_of(drive.drive_id)


def test_reads_back_what_was_put(store: Store) -> None:
    folder = put(store)
    stored = store.stored(DRIVE.drive_id)
    assert stored is not None
    assert (stored.drive, stored.key, stored.status, stored.reason) == (DRIVE, "key", "done", "")
    assert stored.facts == facts_of_drive(1)
    assert sorted(p.name for p in folder.iterdir()) == sorted(
        ["drive.json", "relations.parquet", "report.html", "results.json", "rows.json"]
    )
    assert store.file(stored, "report.html") == b"<p>report</p>"
    assert store.file(stored, "report.pdf") is None
    assert store.report(stored) == f"{folder_of(DRIVE.drive_id)}/report.html"
    assert store.rows(stored) == rows_of(results_of_drive(1))
    kept = store.kept(DRIVE.drive_id)
    assert kept is not None
    np.testing.assert_array_equal(kept.rows, kept_of_drive(1).rows)
    assert store.kept("no-such-drive") is None


@pytest.mark.parametrize(
    ("reason", "refused"),
    [
        (
            "the log and what was known contradict each other beyond doubt (a): one of them is wrong; from b; c",
            "the log and what was known contradict each other beyond doubt (a): one of them is wrong; ",
        ),
        (
            "the vehicle file has 60% of the empty weight at the rear: was it measured from the rear axle? from b",
            "the vehicle file has 60% of the empty weight at the rear: was it measured from the rear axle? ",
        ),
        ("from b; no measured SUV has its CG so low; c", ""),
    ],
)
def test_rows_of_before_a_refusal_was_a_field_still_say_it(reason: str, refused: str) -> None:
    rows = rows_of(results_of_drive(1))
    entry = replace(next(iter(rows.verdict.values())), reason=reason)
    new = rows_bytes(replace(rows, verdict={entry.name: entry}))
    assert rows_from(new).verdict[entry.name].refused == ""
    old = json.loads(new)
    del old["verdict"][entry.name]["refused"]
    assert rows_from(json.dumps(old).encode()).verdict[entry.name].refused == refused


def test_the_same_drive_gives_the_same_bytes(store: Store) -> None:
    folder = put(store)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    put(store)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_fresh_means_done_with_this_key_and_these_reports(store: Store) -> None:
    put(store)
    stored = store.stored(DRIVE.drive_id)
    assert stored is not None
    assert stored.fresh("key")
    assert stored.fresh("key", ["html"])
    assert not stored.fresh("key", ["html", "pdf"])
    assert not stored.fresh("other")
    assert not replace(stored, status="error").fresh("key")


def test_a_failure_has_a_folder_until_it_succeeds(store: Store) -> None:
    store.put_failure(DRIVE, "key", facts_of_drive(1), "timeout", "took longer than 5 s")
    stored = store.stored(DRIVE.drive_id)
    assert stored is not None
    assert (stored.status, stored.reason) == ("timeout", "took longer than 5 s")
    assert store.rows(stored) is None
    assert store.kept(stored) is None
    assert store.report(stored) is None
    folder = put(store)
    assert (store.stored(DRIVE.drive_id) or stored).status == "done"
    store.put_failure(DRIVE, "key", {}, "error", "again")
    assert [p.name for p in folder.iterdir()] == ["drive.json"]


def test_all_drives_by_name(store: Store) -> None:
    for number in (3, 1, 2):
        put(store, number)
    stranger = Path(store.place) / "drives" / "zz" / "stranger"
    stranger.mkdir(parents=True)
    (stranger / "drive.json").write_text("{}")
    catalogue = store.all()
    assert list(catalogue.drives) == [found_drive(n).drive_id for n in (1, 2, 3)]
    assert catalogue.damaged == {}
    assert catalogue.drives[DRIVE.drive_id] == store.stored(DRIVE.drive_id)


def test_forget_and_prune(store: Store) -> None:
    for number in (1, 2, 3):
        put(store, number)
    store.forget(DRIVE.drive_id)
    store.forget(DRIVE.drive_id)
    assert store.stored(DRIVE.drive_id) is None
    assert prune(store, fleet_of(found_drive(2))) == (found_drive(3).drive_id,)
    assert list(store.all().drives) == [found_drive(2).drive_id]


def test_what_cannot_be_looked_into_is_not_pruned(store: Store) -> None:
    """A share that is away takes no results with it."""
    for number in (1, 2, 3):
        put(store, number)
    hidden = found_drive(3).name.rpartition("/")[0] or found_drive(3).name
    found = replace(fleet_of(found_drive(2)), unread=(hidden,))
    gone = prune(store, found)
    assert found_drive(3).drive_id not in gone
    assert found_drive(3).drive_id in store.all().drives
    assert found_drive(3).drive_id not in lost(store.all(), found).gone


def test_note_brings_facts_up_to_date(store: Store) -> None:
    folder = put(store)
    stored = store.stored(DRIVE.drive_id)
    assert stored is not None
    before = (folder / "drive.json").stat().st_mtime_ns
    store.note(stored, DRIVE, facts_of_drive(1))
    assert (folder / "drive.json").stat().st_mtime_ns == before
    touched = {"/data/fleet/1": Facts(1001, "99", "ab")}
    store.note(stored, replace(DRIVE, notes=("new",)), touched)
    again = store.stored(DRIVE.drive_id)
    assert again is not None
    assert (again.facts, again.drive.notes, again.files) == (touched, ("new",), stored.files)


def test_a_url_keeps_its_password_to_itself(store: Store) -> None:
    url = "sftp://user:secret@host/fleet/a.csv"
    store.put_failure(replace(DRIVE, logs=(url,)), "k", {url: Facts(1, "2", "3")}, "error", "no")
    text = (Path(store.place) / folder_of(DRIVE.drive_id) / "drive.json").read_text()
    assert "secret" not in text
    assert "host/fleet/a.csv" in text


DAMAGE = {
    "no drive.json": lambda folder: (folder / "drive.json").unlink(),
    "empty drive.json": lambda folder: (folder / "drive.json").write_bytes(b""),
    "half drive.json": lambda folder: (folder / "drive.json").write_bytes((folder / "drive.json").read_bytes()[:99]),
    "no JSON table": lambda folder: (folder / "drive.json").write_text("[1]"),
    "deep JSON": lambda folder: (folder / "drive.json").write_text("[" * 200_000),
    "wrong types": lambda folder: (folder / "drive.json").write_text(
        json.dumps({**json.loads((folder / "drive.json").read_text()), "key": 5})
    ),
    "another drive's": lambda folder: (folder / "drive.json").write_text(
        (folder / "drive.json").read_text().replace("v1-drive-001", "v1-drive-002")
    ),
    "a folder for drive.json": lambda folder: ((folder / "drive.json").unlink(), (folder / "drive.json").mkdir()),
    "truncated parquet": lambda folder: os.truncate(folder / "relations.parquet", 100),
    "no rows": lambda folder: (folder / "rows.json").unlink(),
    "rows cut": lambda folder: os.truncate(folder / "rows.json", 10),
}  # fmt: skip


@pytest.mark.parametrize("kind", DAMAGE)
def test_a_damaged_folder_is_said_and_done_again(store: Store, kind: str) -> None:
    put(store, 2)
    DAMAGE[kind](put(store))
    assert store.stored(DRIVE.drive_id) is None
    problem = store.damage(DRIVE.drive_id)
    assert problem
    catalogue = store.all()
    assert catalogue.damaged == {DRIVE.drive_id: problem}
    assert list(catalogue.drives) == [found_drive(2).drive_id]
    put(store)
    assert store.damage(DRIVE.drive_id) is None
    assert store.stored(DRIVE.drive_id) is not None


@pytest.mark.parametrize("name", ["relations.parquet", "rows.json"])
def test_a_file_that_was_changed_without_changing_its_size_is_refused(store: Store, name: str) -> None:
    folder = put(store)
    content = bytearray((folder / name).read_bytes())
    content[len(content) // 2] ^= 0xFF
    (folder / name).write_bytes(content)
    stored = store.stored(DRIVE.drive_id)
    assert stored is not None
    with pytest.raises(StoreError, match="is not what was written there"):
        store.kept(stored) if name == "relations.parquet" else store.rows(stored)


def test_what_is_no_store_is_refused(tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="no results store"):
        open_store(str(tmp_path))
    (tmp_path / "thesis.tex").write_text("x")
    with pytest.raises(StoreError, match=r"holds 'thesis.tex' and is no results store"):
        open_store(str(tmp_path), create=True)
    assert os.listdir(tmp_path) == ["thesis.tex"]
    with pytest.raises(StoreError):
        open_store(str(tmp_path / "thesis.tex"), create=True)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ('{"cogest_store": 2}', "format 2, this cogest reads 1"),
        ('{"cogest_store": true}', "not that of a results store"),
        ('{"other": 1}', "not that of a results store"),
        ("no json", "not whole JSON"),
        ("", "not whole JSON"),
    ],
)
def test_a_store_of_another_format_is_refused(tmp_path: Path, content: str, problem: str) -> None:
    (tmp_path / STORE_FILE).write_text(content)
    with pytest.raises(StoreError, match=problem):
        open_store(str(tmp_path), create=True)


def test_reading_makes_nothing(tmp_path: Path, store: Store) -> None:
    put(store)
    before = sorted(str(path) for path in tmp_path.rglob("*"))
    opened = open_store(store.place)
    opened.all()
    with pytest.raises(StoreError, match="not there yet"):
        opened.read_table("drives")
    with pytest.raises(StoreError, match="unknown table"):
        opened.read_table("../drives")
    assert sorted(str(path) for path in tmp_path.rglob("*")) == before


def test_tables_can_be_read_while_they_are_replaced(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    old, new = sample_fleet(8, 2), sample_fleet(12, 2)
    store.write_tables(old)
    write, seen = LocalStorage.write, []

    def watched(self: LocalStorage, name: str, content: bytes) -> None:
        write(self, name, content)
        # as any reader would in this moment
        seen.append([open_store(store.place).read_table(n).equals(new[n]) for n in TABLES])

    monkeypatch.setattr(LocalStorage, "write", watched)
    store.write_tables(new)
    assert not all(seen[0])
    assert all(seen[-1])


def test_a_damaged_table_is_refused_before_it_is_unpacked(store: Store) -> None:
    store.write_tables(sample_fleet(8, 2))
    path = Path(store.place) / "drives.parquet"
    content = bytearray(path.read_bytes())
    content[-40] ^= 0xFF
    path.write_bytes(content)
    with pytest.raises(StoreError, match="is not what was written there"):
        store.read_table("drives")
    assert store.read_table("vehicles").height
    (Path(store.place) / "tables.json").write_text('{"vehicles": 5}')
    with pytest.raises(StoreError, match="is not what was written there"):
        store.read_table("vehicles")


PUTTER = """
import sys
sys.path.insert(0, sys.argv[2])
from pipelines.fleet.store import open_store
from tests.pipelines.fleet.stored_drives import *
store = open_store(sys.argv[1], create=True)
for _ in range(10):
    store.put(found_drive(1), "key", facts_of_drive(1), results_of_drive(1), kept_of_drive(1), {"report.html": b"x"})
"""


def test_two_processes_put_the_same_drive(tmp_path: Path) -> None:
    place = str(tmp_path / "store")
    running = [subprocess.Popen([sys.executable, "-c", PUTTER, place, str(ROOT)], cwd=ROOT) for _ in range(2)]
    assert [process.wait(timeout=60) for process in running] == [0, 0]
    store = open_store(place)
    stored = store.stored(DRIVE.drive_id)
    assert stored is not None
    assert store.rows(stored) == rows_of(results_of_drive(1))
    assert list((tmp_path / "store" / ".partial").iterdir()) == []
