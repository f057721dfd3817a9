"""Two batches on one store: what the one looks at while the other replaces it is no damage, and does none."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from pipelines.engines.base import Limits
from pipelines.fleet import batch as batches
from pipelines.fleet.batch import TABLES, Batch, run_batch
from pipelines.fleet.claims import Claims
from pipelines.fleet.gather import gather
from pipelines.fleet.records import BatchSummary, Choices, FoundFleet
from pipelines.fleet.storage_local import LocalStorage
from pipelines.fleet.store import STORE_FILE, Store, folder_of, open_store
from tests.pipelines.fleet.stored_drives import (
    facts_of_drive,
    fleet_of,
    found_drive,
    join_plainly,
    kept_of_drive,
    results_of_drive,
)

DRIVE = found_drive(1)


def put(store: Store, number: int = 1, report: bytes = b"x") -> None:
    """The drive as one batch has it; another report: as another has it."""
    drive = found_drive(number)
    results, kept = results_of_drive(number + len(report)), kept_of_drive(number)
    store.put(drive, f"key {len(report)}", facts_of_drive(number), results, kept, {"report.html": report})


@pytest.fixture
def store(tmp_path: Path) -> Store:
    made = open_store(str(tmp_path / "store"), create=True)
    put(made)
    return made


def tables_of(store: Store, fleet: FoundFleet, **others: Any) -> dict[str, pl.DataFrame]:
    join: Any = join_plainly
    return gather(store, fleet, join, lambda *_: (), **others)


class Elsewhere(LocalStorage):
    """Once, right after a look, another batch puts the drive in place of the one that was there."""

    def __init__(self, place: str, after: str, name: str) -> None:
        super().__init__(place)
        self.after, self.name, self.left = after, name, 1

    def _other(self, doing: str, name: str) -> None:
        if (doing, name) == (self.after, self.name) and self.left:
            self.left -= 1
            put(Store(LocalStorage(self.place)), report=b"longer")

    def tree(self, folder: str) -> Mapping[str, int]:
        found = super().tree(folder)
        self._other("tree", folder)
        return found

    def read(self, name: str) -> bytes | None:
        content = super().read(name)
        self._other("read", name)
        return content


@pytest.mark.parametrize(
    ("after", "name"),
    [("tree", "drives"), ("read", f"{folder_of(DRIVE.drive_id)}/drive.json")],
)
def test_a_drive_that_is_replaced_while_it_is_looked_at_is_not_damaged(
    store: Store, after: str, name: str
) -> None:
    """Neither is what was put there: the other batch's folder has another table's row, and stays whole."""
    busy = Store(Elsewhere(store.place, after, name))
    tables = tables_of(busy, fleet_of(DRIVE))
    assert tables["drives"]["status"].to_list() == ["done"]
    assert tables["drives"]["key"].to_list() == ["key 6"]
    assert store.damage(DRIVE.drive_id) is None
    stored = store.stored(DRIVE.drive_id)
    assert stored is not None
    assert stored.key == "key 6"
    assert store.rows(stored) is not None


@pytest.mark.parametrize("how", ["note", "doubt"])
def test_what_was_known_of_a_drive_before_is_not_written_over_it(store: Store, how: str) -> None:
    known = store.stored(DRIVE.drive_id)
    assert known is not None
    put(store, report=b"longer")
    if how == "note":
        store.note(known, DRIVE, facts_of_drive(7))
    else:
        store.doubt(known)
    now = store.stored(DRIVE.drive_id)
    assert now is not None
    assert (now.key, now.facts) == ("key 6", facts_of_drive(1))


def test_damage_is_still_said(store: Store) -> None:
    (Path(store.place) / folder_of(DRIVE.drive_id) / "report.html").write_bytes(b"changed")
    assert store.all().damaged.keys() == {DRIVE.drive_id}


def test_a_store_that_another_batch_begins_just_then_is_taken(tmp_path: Path) -> None:
    class Late(LocalStorage):
        def read(self, name: str) -> bytes | None:
            content = super().read(name)
            if name == STORE_FILE and content is None:
                open_store(self.place, create=True)
            return content

    assert Store(Late(tmp_path / "store"), create=True).all().drives == {}


def test_a_table_that_is_replaced_while_it_is_read_is_read_again(store: Store) -> None:
    """Its seal is of the new one by then."""
    old = tables_of(store, fleet_of(DRIVE))
    store.write_tables(old)
    put(store, 2)
    new = tables_of(store, fleet_of(DRIVE, found_drive(2)))

    class Busy(LocalStorage):
        written = False

        def read(self, name: str) -> bytes | None:
            content = super().read(name)
            if name == "drives.parquet" and not self.written:
                self.written = True
                store.write_tables(new)
            return content

    assert Store(Busy(store.place)).read_table("drives").equals(new["drives"])


def test_a_drive_of_a_batch_that_saw_more_logs_is_not_gone(store: Store) -> None:
    """It came after this one had looked through the folder; one that was there before, and is not found, is."""
    put(store, 2)
    began = {DRIVE.drive_id}
    tables = tables_of(store, fleet_of(), began=began)
    assert dict(tables["drives"].select("drive", "gone").iter_rows()) == {
        DRIVE.name: True,
        found_drive(2).name: False,
    }


def test_one_batch_at_a_time_writes_tables(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """Until its report is made of them; another waits for it."""
    monkeypatch.setattr(batches, "WAIT_S", 0.01)
    asked = Batch("fleet", store.place, Choices(), engine="serial", limits=Limits())
    finished: list[str] = []
    meanwhile: list[bool] = []

    def finish(_: Store, summary: BatchSummary) -> None:
        with Claims(LocalStorage(store.place)) as other:
            meanwhile.append(other.claim(TABLES) is None)
        finished.append(f"{summary.found}")

    def other() -> None:
        run_batch(asked, fleet_of(), "no:job", finish=finish)

    with Claims(LocalStorage(store.place)) as claims:
        held = claims.claim(TABLES)
        assert held is not None
        waiting = threading.Thread(target=other)
        waiting.start()
        waiting.join(0.3)
        assert waiting.is_alive()
        assert not (Path(store.place) / "tables.json").exists()
        claims.release(held)
        waiting.join(30)
    assert (finished, meanwhile) == (["0"], [True])
    assert LocalStorage(store.place).tree("claims") == {}
