"""What names tell: parts, recorders, copies, and ids that every file system takes."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipelines.fleet.names import copied_from, drive_id, follows, natural, numbered, recorder_name, stem_of


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("tour_001", "tour_002"),
        ("tour_9", "tour_10"),
        ("tour", "tour_1"),
        ("run.part1", "run.part2"),
        ("log (1)", "log (2)"),
        ("2024-05-01-10-00-00_0", "2024-05-01-10-05-00_1"),
        ("rec_2024-05-01_10-00-00", "rec_2024-05-01_10-05-00"),
        ("20240501T100000", "20240501T101500"),
        ("can_1714557600", "can_1714557900"),
        ("x_10-00-00", "x_10-05-00"),
    ],
)
def test_parts_in_a_row_follow_one_another(before, after):
    assert follows(before, after)
    assert not follows(after, before)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("tour_001", "tour_003"),
        ("tour_001", "ride_002"),
        ("monday", "tuesday"),
        ("tour", "tour_7"),
        ("car1_2024-05-01_10-00-00", "car2_2024-05-01_10-05-00"),
        ("a_2024-05-01", "b_2024-05-02"),
        ("tour_001", "tour_001"),
        ("tour_1", "tour"),
    ],
)
def test_other_names_do_not(before, after):
    assert not follows(before, after)


def test_a_stem_is_taken_apart():
    assert numbered("Tour_002").number == 2
    assert numbered("Tour_002").row == numbered("tour").row == "tour"
    assert numbered("log_2024-05-01_10-30-00").moment == "20240501103000"
    assert numbered("log_2024-05-01_10-30-00").number is None


def test_recorders_words_are_not_the_drives():
    assert recorder_name("monday_CAN1").drive == ("monday",)
    assert recorder_name("monday_CAN1").recorder == ("can1",)
    assert recorder_name("gps").drive == ()
    assert recorder_name("scan").recorder == ()


def test_names_of_copies_are_known():
    for name in (
        "drive (1)",
        "drive - Copy",
        "drive - Copy (2)",
        "Copy of drive",
        "drive copy",
        "Kopie von drive",
    ):
        assert copied_from(name) == "drive", name
    for name in ("drive", "drive_1", "copycat", "drive(a)"):
        assert copied_from(name) is None, name


def test_stems_and_order():
    assert stem_of("x_0.db3.zstd") == "x_0"
    assert stem_of("a.b.csv") == "a.b"
    assert stem_of(".csv") == ".csv"
    assert sorted(["p10", "p9", "p1"], key=natural) == ["p1", "p9", "p10"]


@given(st.text(min_size=1, max_size=300))
def test_an_id_is_a_folders_name_on_every_system(name):
    made = drive_id(name, [name])
    assert re.fullmatch(r"[a-z0-9](?:[a-z0-9-]*[a-z0-9])?-[0-9a-f]{10}", made)
    assert len(made) <= 80


def test_ids_tell_names_apart_that_some_systems_take_for_one():
    names = [
        "suv/Drive.csv",
        "suv/drive.csv",
        "suv-drive.csv",
        "suv/drive.csv ",
        "SUV/DRIVE.CSV",
        "ſuv/drive.csv",
    ]
    assert len({drive_id(name, [name]) for name in names}) == len(names)
    assert drive_id("con", ["con"]).startswith("con-")
    assert drive_id("a", ["x", "y"]) == drive_id("a", ["y", "x"])
    assert drive_id("東京/一", ["東京/一"]).startswith("drive-")
