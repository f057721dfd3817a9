"""Events: the keys that scripts rely on, one line each, and numbers that JSON knows."""

from __future__ import annotations

import json
from dataclasses import fields
from typing import get_args

import pytest

from pipelines.fleet.events import (
    DriveEnded,
    Event,
    Finished,
    Found,
    Joining,
    Kept,
    Reported,
    Started,
    event_json,
    to_all,
)
from pipelines.fleet.records import BatchSummary, Ended, FoundDrive

DRIVE = FoundDrive(
    "id1", "van/ya\nrd\udc80.csv", ("/f/van/yard.csv",), None, "van", None, None, None, (), ("CSV",), 7
)
SUMMARY = BatchSummary(3, 1, 1, (Ended(DRIVE, "error", 'no "time"', 0.1, "w1"),), 2, 12.34567)

KEYS = {
    Found: "drives to_do kept left_out bytes_to_do folder store engine workers version left_out_first",
    Kept: "drive_id name vehicle_id status reason",
    Started: "drive_id name bytes worker",
    DriveEnded: "drive_id name vehicle_id status reason seconds worker number total bytes",
    Joining: "vehicles",
    Reported: "paths",
    Finished: "found kept done failed gone moved seconds failures",
}
EXAMPLES: list[Event] = [
    Found(3, 2, 1, 0),
    Kept("id2", "a", "van"),
    Started("id1", "a", 7),
    DriveEnded("id1", DRIVE.name, "van", "error", "why\r\n", float("nan"), "w", 1, 2, 7),
    Joining(2),
    Reported(("/s/fleet.html",)),
    Finished(SUMMARY),
]


def test_an_example_of_every_event():
    assert {type(event) for event in EXAMPLES} == set(get_args(Event)) == set(KEYS)
    assert len({event.kind for event in EXAMPLES}) == len(EXAMPLES)


@pytest.mark.parametrize("event", EXAMPLES, ids=lambda event: event.kind)
def test_keys_stay_and_a_line_is_a_line(event):
    line = event_json(event)
    assert line.isascii()
    assert len(line.splitlines()) == 1
    read = json.loads(line)
    assert list(read) == ["event", *KEYS[type(event)].split()]
    assert read["event"] == event.kind
    assert list(json.loads(event_json(event, "2026-01-02T03:04:05+00:00")))[:2] == ["event", "time"]


def test_what_json_has_no_number_for_is_null_and_names_survive():
    read = json.loads(event_json(EXAMPLES[3]))
    assert read["seconds"] is None
    assert read["name"] == DRIVE.name
    assert "NaN" not in event_json(EXAMPLES[3])


def test_the_end_tells_every_failure():
    read = json.loads(event_json(Finished(SUMMARY)))
    assert (read["found"], read["kept"], read["done"], read["failed"], read["gone"]) == (3, 1, 1, 1, 2)
    assert read["seconds"] == 12.346
    assert read["failures"] == [
        {"drive_id": "id1", "name": DRIVE.name, "status": "error", "reason": 'no "time"'}
    ]


def test_several_watchers_hear_the_same_in_order():
    heard: list[tuple[str, Event]] = []
    tell = to_all(lambda event: heard.append(("a", event)), lambda event: heard.append(("b", event)))
    for event in EXAMPLES[:2]:
        tell(event)
    assert heard == [(name, event) for event in EXAMPLES[:2] for name in "ab"]


def test_events_are_frozen():
    for event in EXAMPLES:
        with pytest.raises(AttributeError):
            setattr(event, fields(event)[0].name, None)
