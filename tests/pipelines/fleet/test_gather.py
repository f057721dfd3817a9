"""The fleet's tables: what is in them, in which order, and that they are the same bytes whatever happened on the way."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import polars as pl
import pytest

from pipelines.fleet.gather import gather, kinds
from pipelines.fleet.moved import away
from pipelines.fleet.records import FoundFleet
from pipelines.fleet.store import Store, folder_of, open_store
from pipelines.fleet.tables import TABLES
from pipelines.hierarchy.records import Outlier
from tests.pipelines.fleet.stored_drives import (
    facts_of_drive,
    fleet_of,
    found_drive,
    join_plainly,
    kept_of_drive,
    results_of_drive,
)

VEHICLES = {"v1": (1, 2, 3), "v2": (4, 5), "v3": (6,)}
DRIVES = {n: found_drive(n, vehicle) for vehicle, numbers in VEHICLES.items() for n in numbers}
FAILED = 5
FLEET = fleet_of(*DRIVES.values())


def no_outliers(*_: object) -> tuple[Outlier, ...]:
    return ()


def put(store: Store, number: int) -> None:
    """Store one drive; number 5 fails."""
    drive = DRIVES[number]
    if number == FAILED:
        store.put_failure(drive, "key", facts_of_drive(number), "crashed", "the worker died")
        return
    results, kept = results_of_drive(number), kept_of_drive(number)
    store.put(drive, f"key {number}", facts_of_drive(number), results, kept, {"report.html": b"x"})


def filled(place: Path, numbers: tuple[int, ...] = tuple(DRIVES)) -> Store:
    store = open_store(str(place), create=True)
    for number in numbers:
        put(store, number)
    return store


def tables_of(
    store: Store, fleet: FoundFleet = FLEET, join: Callable = join_plainly
) -> dict[str, pl.DataFrame]:
    return gather(store, fleet, join, no_outliers)


def written(store: Store) -> dict[str, bytes]:
    """The tables as they lie in the store."""
    store.write_tables(tables_of(store))
    return {name: (Path(store.place) / f"{name}.parquet").read_bytes() for name in TABLES}


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    return filled(tmp_path_factory.mktemp("gather") / "store")


@pytest.fixture(scope="module")
def tables(store: Store) -> dict[str, pl.DataFrame]:
    return tables_of(store)


def test_all_tables_with_their_columns(tables: dict[str, pl.DataFrame]) -> None:
    assert list(tables) == list(TABLES)
    for name, table in tables.items():
        assert dict(table.schema) == TABLES[name]


def test_a_row_a_drive_by_vehicle_and_time(tables: dict[str, pl.DataFrame]) -> None:
    drives = tables["drives"]
    assert drives["vehicle_id"].to_list() == ["v1"] * 3 + ["v2"] * 2 + ["v3"]
    assert drives.sort("vehicle_id", "start_utc", "drive", nulls_last=True).equals(drives)
    first = drives.row(0, named=True)
    assert first["status"] == "done"
    assert first["logs"] == ["v1/drive_001.csv"]
    assert first["report"] == f"{folder_of(first['drive_id'])}/report.html"
    assert first["static_stability_factor"] == pytest.approx(
        results_of_drive(1).rollover.static_stability_factor.value  # type: ignore[union-attr]
    )
    assert first["notes"][-1] == "one note"
    assert first["gone"] is False


def test_failures_are_there_with_their_reason(tables: dict[str, pl.DataFrame]) -> None:
    row = tables["drives"].row(4, named=True)
    assert (row["status"], row["reason"]) == ("crashed", "the worker died")
    assert (row["start_utc"], row["duration_s"], row["report"]) == (None, None, None)
    assert tables["parameters"].filter(pl.col("drive_id") == row["drive_id"]).is_empty()


def test_own_and_joined_answers(tables: dict[str, pl.DataFrame]) -> None:
    mass = tables["parameters"].filter(parameter="mass_kg")
    assert mass["source"].to_list() == ["drive", "fleet"] * 5
    own = mass.filter(source="drive")
    expected = [results_of_drive(n).verdict["mass_kg"].value for n in (1, 2, 3, 4, 6)]
    assert own["value"].to_list() == expected
    assert mass.filter(source="fleet")["reason"].unique().to_list() == ["joined"]


def test_vehicles_changes_and_trends(tables: dict[str, pl.DataFrame]) -> None:
    assert tables["vehicles"]["drives"].to_list() == [3, 1, 1]
    assert tables["load_changes"]["before"].to_list() == [found_drive(1).drive_id, found_drive(2).drive_id]
    assert tables["trends"]["vehicle_id"].to_list() == ["v1", "v2", "v3"]


def test_the_table_of_vehicles_says_what_its_drives_doubt(tables: dict[str, pl.DataFrame]) -> None:
    """Who opens that table alone sees it: a doubt that drives share once, with who has it."""
    rows = {row["vehicle_id"]: row["doubts"] for row in tables["vehicles"].iter_rows(named=True)}
    shared = "the log is truncated: only what was whole is used"
    assert rows["v1"][0] == "one note"
    assert f"v1/drive_001.csv, v1/drive_002.csv, v1/drive_003.csv: {shared}" in rows["v1"]
    assert f"v2/drive_004.csv: {shared}" in rows["v2"]


@pytest.mark.parametrize("seed", range(4))
def test_any_order_of_completion_gives_the_same_bytes(store: Store, tmp_path: Path, seed: int) -> None:
    order = list(DRIVES)
    random.Random(seed).shuffle(order)
    other = filled(tmp_path / "store", tuple(order[:3]))
    # a batch that was stopped, its tables written, and went on later
    written(other)
    for number in order[2:]:
        put(other, number)
    assert written(other) == written(store)
    assert written(other) == written(store)
    shuffled = replace(FLEET, drives=tuple(random.Random(seed).sample(FLEET.drives, len(FLEET.drives))))
    for name, table in tables_of(other, shuffled).items():
        assert table.equals(pl.read_parquet(Path(store.place) / f"{name}.parquet"))


def test_a_folder_that_was_moved_gives_the_same_tables(store: Store, tmp_path: Path) -> None:
    moved = [replace(d, logs=tuple(p.replace("/data/fleet", "/mnt/x") for p in d.logs)) for d in FLEET.drives]
    there = FoundFleet("/mnt/x/", tuple(moved))
    for name, table in tables_of(store, there).items():
        assert table.equals(tables_of(store)[name])


def test_unchanged_vehicles_are_not_joined_again(tmp_path: Path) -> None:
    store, joined = filled(tmp_path / "store"), []

    def join(vehicle_id: str, drives: list) -> object:
        joined.append(vehicle_id)
        return join_plainly(vehicle_id, drives)

    first = tables_of(store, join=join)
    assert joined == ["v1", "v2", "v3"]
    again = tables_of(store, join=join)
    assert joined == ["v1", "v2", "v3"]
    assert all(again[name].equals(first[name]) for name in TABLES)
    store.put(DRIVES[4], "new", {}, results_of_drive(40), kept_of_drive(4), {})
    tables_of(store, join=join)
    assert joined[3:] == ["v2"]
    for path in (Path(store.place) / "vehicles").rglob("*.json"):
        path.write_bytes(path.read_bytes()[:-40])
    tables_of(store, join=join)
    assert joined[4:] == ["v1", "v2", "v3"]


def test_a_vehicle_that_cannot_be_joined_costs_itself_alone(tmp_path: Path) -> None:
    store = filled(tmp_path / "store")

    def join(vehicle_id: str, drives: list) -> object:
        if vehicle_id == "v1":
            raise ValueError("array must not contain infs\nor NaNs")
        return join_plainly(vehicle_id, drives)

    tables = tables_of(store, join=join)
    assert tables["vehicles"]["vehicle_id"].unique().sort().to_list() == ["v2", "v3"]
    notes = tables["drives"].filter(vehicle_id="v1")["notes"].to_list()
    assert {note[-1] for note in notes} == {
        "the drives of its vehicle could not be joined: array must not contain infs"
    }
    assert tables["parameters"].filter(vehicle_id="v1")["source"].unique().to_list() == ["drive"]
    assert tables_of(store)["vehicles"].height == 3


def test_drives_whose_logs_are_gone_stay_and_are_marked(
    store: Store, tables: dict[str, pl.DataFrame]
) -> None:
    fewer = fleet_of(*(DRIVES[n] for n in (1, 3, 4)))
    assert away(store.all(), fewer) == tuple(sorted(DRIVES[n].drive_id for n in (2, 5, 6)))
    found = tables_of(store, fewer)
    assert found["drives"]["gone"].to_list() == [False, True, False, False, True, True]
    assert found["drives"].drop("gone").equals(tables["drives"].drop("gone"))
    assert found["parameters"].equals(tables["parameters"])


def test_a_drive_that_was_found_but_is_not_stored_is_left_out(store: Store) -> None:
    more = fleet_of(*FLEET.drives, found_drive(99))
    assert tables_of(store, more)["drives"].height == 6


def test_a_damaged_drive_that_is_gone_is_left_as_it_is(tmp_path: Path) -> None:
    store = filled(tmp_path / "store")
    folder = Path(store.place) / folder_of(DRIVES[2].drive_id)
    content = bytearray((folder / "relations.parquet").read_bytes())
    content[9] ^= 0xFF
    (folder / "relations.parquet").write_bytes(content)
    tables = tables_of(store, fleet_of(*(d for n, d in DRIVES.items() if n != 2)))
    row = tables["drives"].filter(drive_id=DRIVES[2].drive_id).row(0, named=True)
    assert "no longer in the folder" in row["reason"]
    assert tables["vehicles"].filter(vehicle_id="v1")["drives"].to_list() == [2]
    stored = store.stored(DRIVES[2].drive_id)
    assert stored is not None
    assert stored.key == "key 2"


@pytest.mark.parametrize("name", ["rows.json", "relations.parquet", "drive.json"])
def test_damage_is_told_in_the_tables(tmp_path: Path, name: str) -> None:
    store = filled(tmp_path / "store")
    path = Path(store.place) / folder_of(DRIVES[6].drive_id) / name
    content = bytearray(path.read_bytes())
    content[5] ^= 0xFF
    path.write_bytes(content)
    tables = tables_of(store)
    row = tables["drives"].filter(vehicle_id="v3").row(0, named=True)
    assert row["status"] == "error"
    assert "is damaged" in row["reason"]
    assert tables["vehicles"]["vehicle_id"].unique().sort().to_list() == ["v1", "v2"]
    # seen or not before: the next batch does it again
    stored = store.stored(DRIVES[6].drive_id)
    assert stored is None or not stored.fresh("key 6")
    put(store, 6)
    assert tables_of(store)["drives"].filter(vehicle_id="v3")["status"].to_list() == ["done"]


def test_what_is_told_of_a_drive_is_what_was_found_now(store: Store) -> None:
    renamed = fleet_of(*(replace(d, vehicle_name="New name", notes=("new note",)) for d in FLEET.drives))
    drives = tables_of(store, renamed)["drives"]
    assert drives["vehicle_name"].unique().to_list() == ["New name"]
    assert drives["notes"].list.first().unique().to_list() == ["new note"]


def test_a_start_that_the_user_says_counts_where_the_log_says_none(tmp_path: Path) -> None:
    store, told = open_store(str(tmp_path / "store"), create=True), []
    starts = {1: None, 2: "2024-05-02T00:00:00.000+00:00", 3: "2024-05-01T00:00:00.000+00:00"}
    drives = {n: found_drive(n, start_utc=start) for n, start in starts.items()}
    for number, drive in drives.items():
        store.put(drive, "k", {}, results_of_drive(number, None), None, {})

    def join(vehicle_id: str, drives: list) -> object:
        told.append([drive.start_utc for drive in drives])
        return join_plainly(vehicle_id, drives)

    tables = tables_of(store, fleet_of(*drives.values()), join)
    assert tables["drives"]["start_utc"].to_list() == [starts[3], starts[2], None]
    assert tables["load_changes"]["start_utc"].to_list() == [starts[2], None]
    later = fleet_of(drives[1], drives[2], replace(drives[3], start_utc="2024-05-03T00:00:00.000+00:00"))
    tables_of(store, later, join)
    assert told == [[starts[3], starts[2], None], [starts[2], "2024-05-03T00:00:00.000+00:00", None]]


def test_odd_text_goes_into_a_table(tmp_path: Path) -> None:
    store = open_store(str(tmp_path / "store"), create=True)
    odd = found_drive(1, name="v1/\udcff.csv", notes=("a\x00b\u202e", "lone \ud800"))
    store.put_failure(odd, "k", {}, "error", "bad byte \udc80")
    row = tables_of(store, fleet_of(odd))["drives"].row(0, named=True)
    assert (row["drive"], row["reason"]) == ("v1/?.csv", "bad byte ?")


def test_vehicles_are_compared_with_their_kind() -> None:
    names = {f"a{n}": "Model A" for n in range(4)} | {"b": "Model B", "c": None, "d": "Model D"}
    bodies = {**dict.fromkeys(names, "SUV"), "d": None}
    found = kinds(names, bodies)
    assert {found[f"a{n}"] for n in range(4)} == {"Model A, SUV"}
    assert found["b"] == found["c"] == "any SUV"
    assert "d" not in found


def test_drives_of_unknown_time_zone_stand_where_their_clock_says(tmp_path: Path) -> None:
    store = open_store(str(tmp_path / "store"), create=True)
    starts = {1: "2024-05-03T10:00:00.000", 2: "2024-05-02T10:00:00.000+00:00", 3: None}
    whole = {n: results_of_drive(n, None) for n in starts}
    drives = {n: found_drive(n) for n in starts}
    for n, start in starts.items():
        results = replace(whole[n], record=replace(whole[n].record, start_utc=start))
        store.put(drives[n], "k", {}, results, None, {})
    assert tables_of(store, fleet_of(*drives.values()))["drives"]["start_utc"].to_list() == [
        starts[2],
        starts[1],
        None,
    ]
    # what a user says of the moment is better than a clock of unknown zone, and no better than one of a known zone
    said = "2024-05-01T08:00:00.000+00:00"
    fleet = fleet_of(*(replace(drive, start_utc=said) for drive in drives.values()))
    assert tables_of(store, fleet)["drives"]["start_utc"].to_list() == [said, said, starts[2]]
