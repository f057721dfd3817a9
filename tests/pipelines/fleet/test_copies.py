"""Drives that another drive of their vehicle is already."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipelines.fleet.copies import Copy, Finished, copies_of
from pipelines.fleet.gather import gather
from pipelines.fleet.rows import rows_bytes, rows_from, rows_of
from pipelines.fleet.store import open_store
from pipelines.fleet.stored import StoredDrive
from pipelines.results import Trace
from tests.pipelines.fleet.stored_drives import (
    fleet_of,
    found_drive,
    join_plainly,
    kept_of_drive,
    results_of_drive,
)

START = "2024-05-01T08:00:00.000+00:00"
SIGNALS = ("accel_y", "speed", "yaw_rate")


def drive(
    number: int,
    start: str | None = START,
    seconds: float = 120.0,
    signals: tuple[str, ...] = SIGNALS,
    log: int | None = None,
) -> Finished:
    rows = replace(
        rows_of(results_of_drive(log or number)), start_utc=start, duration_s=seconds, signals=signals
    )
    return Finished(StoredDrive(found_drive(number), "k", "done"), rows, start)


def test_the_same_bytes_count_once() -> None:
    drives = [drive(1, None), drive(2, None, log=1), drive(3, None)]
    assert copies_of(drives) == {drives[1].drive_id: Copy(drives[0].drive_id, part=False)}


def test_a_copy_that_was_cut_off_is_a_part_of_the_longer_one() -> None:
    cut, whole = drive(1, seconds=119.9), drive(2, "2024-05-01T08:00:00.400+00:00")
    assert copies_of([cut, whole]) == {cut.drive_id: Copy(whole.drive_id, part=True)}
    # saved with a signal less
    poor = drive(3, seconds=60.0, signals=SIGNALS[:2])
    assert copies_of([cut, poor, whole]).keys() == {cut.drive_id, poor.drive_id}
    # the same bytes as the one that is a part
    again = drive(4, seconds=119.9, log=1)
    assert copies_of([cut, again, whole]).keys() == {cut.drive_id, again.drive_id}


@pytest.mark.parametrize(
    "other",
    [
        drive(2, "2024-05-01T08:00:02.000+00:00", 60.0),
        drive(2, seconds=60.0, signals=("heave", "speed")),
        drive(2, None, 60.0),
        drive(2, "2024-05-01T08:00:00.000", 60.0),
        drive(2, seconds=60.0, signals=()),
    ],
    ids=["later", "a recorder of its own", "no date", "zone unknown", "stored long ago"],
)
def test_what_may_tell_something_of_its_own_is_no_copy(other: Finished) -> None:
    longer = drive(1, seconds=121.0)
    assert copies_of([longer, other]) == {}


def _with_pace(one: Finished, pace: tuple[float, ...]) -> Finished:
    return replace(one, rows=replace(one.rows, pace=pace))


def test_drives_whose_clock_begins_alike_each_time_are_no_copies() -> None:
    """A recorder without a battery begins on the first of January 2000 whenever it is switched on."""
    pace = (0.0, 3.0, 8.0, 12.0, 13.0, 9.0)
    whole, cut = _with_pace(drive(1), pace), _with_pace(drive(2, seconds=22.0), (0.3, 3.4, 7.2, 12.0))
    assert copies_of([whole, cut]).keys() == {cut.drive_id}
    other = _with_pace(drive(3, seconds=22.0), (0.0, 9.0, 16.0, 20.0))
    assert copies_of([whole, other]) == {}
    # too little is known
    short = _with_pace(drive(4, seconds=11.0), (0.0, 9.0, 16.0))
    assert copies_of([whole, short]).keys() == {short.drive_id}


def test_a_drives_pace_is_its_speed_in_even_steps() -> None:
    time_s = np.linspace(0.0, 21.0, 43)
    values = np.where((time_s > 9) & (time_s < 11), np.nan, 2.0 * time_s)
    traces = (Trace("yaw_rate", time_s, {"yaw_rate": time_s}), Trace("speed", time_s, {"speed": values}))
    rows = rows_of(replace(results_of_drive(1), signals=traces))
    assert rows.pace == (0.0, 10.0, 20.0, 30.0, 40.0)
    assert rows_from(rows_bytes(rows)) == rows
    assert rows_of(replace(results_of_drive(1), signals=traces[:1])).pace == ()


def test_two_clocks_of_unknown_zone_are_one_recorders() -> None:
    drives = [drive(1, "2024-05-01T08:00:00.000"), drive(2, "2024-05-01T08:00:00.005", 60.0)]
    assert copies_of(drives) == {drives[1].drive_id: Copy(drives[0].drive_id, part=True)}


def test_a_part_is_told_of_and_tells_nothing_twice(tmp_path: Path) -> None:
    store, told = open_store(str(tmp_path / "store"), create=True), []
    drives = {n: found_drive(n) for n in (1, 2)}
    for number, seconds in ((1, 60.0), (2, 61.0)):
        whole = results_of_drive(number, None)
        record = replace(whole.record, start_utc=START, duration_s=seconds)
        results = replace(whole, record=record)
        store.put(drives[number], "k", {}, results, kept_of_drive(number), {})

    def join(vehicle_id: str, given: list) -> object:
        told.append([each.kept is not None for each in given])
        return join_plainly(vehicle_id, given)

    tables = gather(store, fleet_of(*drives.values()), join, lambda *_: ())
    assert told == [[False, True]]
    said = [[note for note in notes if note.endswith("counts once")] for notes in tables["drives"]["notes"]]
    assert [len(notes) for notes in said] == [1, 0]
    assert "lies within it" in said[0][0]
    assert tables["drives"]["apart"].to_list() == ["copy", None]
    # kept, and read again
    again = gather(store, fleet_of(*drives.values()), join, lambda *_: ())
    assert again["drives"].equals(tables["drives"])
    assert len(told) == 1


def test_of_a_recording_and_its_damaged_copy_the_whole_one_counts() -> None:
    damaged, whole = (
        replace(each, rows=replace(each.rows, import_status=status))
        for each, status in ((drive(1), "malformed"), (drive(2), "complete"))
    )
    assert copies_of([damaged, whole]) == {damaged.drive_id: Copy(whole.drive_id, part=True)}
