"""What a dry run prints."""

from __future__ import annotations

import json

import pytest

from pipelines.fleet.batch import Absent
from pipelines.fleet.find import find_drives
from pipelines.fleet.outlook import Outlook
from pipelines.fleet.records import FoundDrive, FoundFleet
from reports.dry_run_text import plan_dict, size_text, text


def drive(name: str, vehicle_id: str = "van", **given: object) -> FoundDrive:
    facts = {
        "drive_id": f"id-{name}",
        "name": name,
        "logs": (f"/f/{name}",),
        "vehicle": "/f/vehicle.toml",
        "vehicle_id": vehicle_id,
        "vehicle_name": None,
        "map": None,
        "settings": None,
        "dbc": (),
        "formats": ("CSV table",),
        "size": 1_500_000,
    }
    return FoundDrive(**{**facts, **given})  # type: ignore[arg-type]


def test_drives_stand_by_vehicle_with_what_would_be_done():
    found = FoundFleet(
        "/f", (drive("van/a.csv"), drive("van/b.csv"), drive("suv/c.csv", "suv", vehicle_name="Suv 3"))
    )
    told = text(found, {"id-van/a.csv": "kept", "id-suv/c.csv": "failed before"}, width=100)
    assert told.startswith("/f: 3 drives of 2 vehicles, 4.5 MB: 1 new, 1 failed before, 1 kept.")
    lines = [line.split() for line in told.splitlines()]
    assert ["Vehicle", "suv:", "Suv", "3"] in lines
    assert ["van/a.csv", "1.5", "MB", "keep:", "done", "CSV", "table"] in lines
    assert ["van/b.csv", "1.5", "MB", "do:", "new", "CSV", "table"] in lines
    assert ["suv/c.csv", "1.5", "MB", "failed", "before", "CSV", "table"] in lines


def test_what_drives_lack_stands_once():
    found = FoundFleet(
        "/f",
        (
            drive("van/a.csv", lacks=("no map",)),
            drive("van/b.csv", lacks=("no map", "no clock")),
            drive("suv/c.csv", "suv", notes=("two files",)),
        ),
    )
    told = text(found, {}, width=100)
    assert told.count("no map") == 1
    assert "all of van: no map" in told
    assert "van/b.csv: no clock" in told
    assert "suv/c.csv: two files" in told
    assert "2 drives lack something" in told


def test_the_channels_outlook():
    found = FoundFleet("/f", (drive("van/a.csv"), drive("van/b.csv")))
    good = Outlook(
        ("accel_y", "speed"), ("roll_map",), (("other", "x"),), (("mass_kg", "other lacks speed"),)
    )
    told = text(found, {}, {"id-van/a.csv": good, "id-van/b.csv": Outlook(problem="too large")}, width=100)
    assert "van/a.csv: 2 signals; can run: roll_map" in told
    assert "cannot tell: Mass; other lacks speed" in told
    assert "van/b.csv: too large" in told


def test_what_was_left_out_stands_by_reason():
    places = tuple((f"/f/pictures/{k}.jpg", "no log") for k in range(9))
    told = text(FoundFleet("/f", (drive("a.csv"),), (*places, ("/elsewhere/x", "gone"))), {}, width=100)
    assert "no log: pictures/0.jpg, pictures/1.jpg, pictures/2.jpg, pictures/3.jpg and 5 more" in told
    assert "gone: /elsewhere/x" in told
    assert "Left out: 10" in told


def test_names_cannot_steer_the_terminal():
    evil = "a\x1b[2J\n\u202e\x07.csv"
    found = FoundFleet(
        "/f\x1b[0m",
        (
            drive(
                evil, vehicle_id=f"v{evil}", vehicle_name=evil, lacks=(evil,), notes=(evil,), formats=(evil,)
            ),
        ),
        ((f"/f/{evil}", evil),),
    )
    told = text(found, {f"id-{evil}": evil}, {f"id-{evil}": Outlook(problem=evil)}, width=80)
    assert all(line.isprintable() for line in told.split("\n"))
    assert "\u202e" not in told


def test_lines_stay_within_the_terminal(samples):
    found = find_drives(str(samples))
    for width in (60, 80, 120):
        told = text(found, {}, width=width)
        # a long name of a drive has a line of its own
        assert all(len(line) <= width for line in told.splitlines())
    assert "25 drives of 5 vehicles" in told


def test_drives_of_no_vehicle_stand_in_one_table():
    alone = [drive(name, name, vehicle=None) for name in ("a.csv", "b.csv")]
    told = text(FoundFleet("/f", tuple(alone)), {}, width=80)
    assert told.count("Without a vehicle file") == 1
    assert "Vehicle a.csv" not in told


def test_the_same_as_json(samples):
    found = find_drives(str(samples / "fleet"))
    plain = json.loads(json.dumps(plan_dict(found, {found.drives[0].drive_id: "kept"}, {})))
    assert [entry["would"] for entry in plain["drives"]] == ["kept"] + ["new"] * 10
    assert plain["left_out"] == []


@pytest.mark.parametrize(
    ("size", "said"),
    [
        (0, "0 B"),
        (999, "999 B"),
        (1000, "1.0 kB"),
        (9949, "9.9 kB"),
        (10_000, "10 kB"),
        (3e9, "3.0 GB"),
        (5e12, "5.0 TB"),
    ],
)
def test_sizes(size, said):
    assert size_text(int(size)) == said


def test_drives_without_any_date_are_told():
    found = FoundFleet(
        "/f",
        (
            drive("van/a.csv"),
            drive("van/b.csv", start_utc="2024-05-01T10:00:00.000+00:00"),
            drive("van/c.asc"),
        ),
    )
    outlooks = {
        "id-van/a.csv": Outlook(dated=False),
        "id-van/b.csv": Outlook(dated=False),
        "id-van/c.asc": Outlook(),
    }
    told = text(found, {}, outlooks, width=200)
    assert "van/a.csv: no date in the log" in told
    assert "1 drive lacks something" in told
    plan = plan_dict(found, {}, outlooks)["drives"]
    assert [len(entry["lacks"]) for entry in plan] == [1, 0, 0]


def test_drives_of_the_store_that_are_no_longer_there_are_named():
    found = FoundFleet("/f", (drive("w2/c.csv", "w2"),))
    absent = (Absent("a", "w1/a.csv", "w1"), Absent("b"), Absent("c", "w1/c.csv", "w1", "w2/c.csv"))
    told = text(found, {}, width=200, absent=absent)
    assert "In the store and no longer at their place: 3 drives" in told
    assert "w1/c.csv: moved to w2/c.csv, and counts there alone" in told
    assert "w1/a.csv, b: the logs are gone" in told
    assert [entry["moved_to"] for entry in plan_dict(found, {}, absent=absent)["absent"]] == [
        None,
        None,
        "w2/c.csv",
    ]
