"""Which recordings are one drive, with clocks and contents that are given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import pytest

from pipelines.fleet.clocks import NS, Clock
from pipelines.fleet.group import group_folder
from pipelines.fleet.logs import Log
from pipelines.fleet.names import stem_of
from pipelines.fleet.together import Moments

T0 = 1_714_557_600
TITLES = {"blf": "blf", "vbo": "vbo", "csv": "csv", "mcap": "mcap", "asc": "asc", "bag": "rosbag1"}


@dataclass
class Given:
    """Clocks in seconds (first, last, absolute) and signals by file name."""

    clocks: Mapping[str, tuple[float, float, bool]] = field(default_factory=dict)
    contents: Mapping[str, Mapping[str, Moments]] = field(default_factory=dict)
    asked: list[str] = field(default_factory=list)

    def clock(self, log: Log) -> Clock | None:
        self.asked.append(log.name)
        if log.name not in self.clocks:
            return None
        first, last, absolute = self.clocks[log.name]
        return Clock(round(first * NS), round(last * NS), absolute)

    def content(self, log: Log) -> Mapping[str, Moments] | None:
        return self.contents.get(log.name)


def logs(*names: str, folder: str = "suv") -> list[Log]:
    return [
        Log(f"/f/{folder}/{n}", f"{folder}/{n}", 1000, stem_of(n), TITLES[n.rpartition(".")[2]], "")
        for n in names
    ]


def drives(facts: Given, *names: str) -> list[list[str]]:
    return [[log.name for log in drive.logs] for drive in group_folder(logs(*names), facts).drives]


def row(*spans: tuple[float, float], absolute: bool = True) -> dict[str, tuple[float, float, bool]]:
    at = T0 if absolute else 0
    return {f"tour_{k}.blf": (at + a, at + b, absolute) for k, (a, b) in enumerate(spans, start=1)}


def test_parts_in_a_row_are_one_drive_and_it_is_said_why():
    facts = Given(row((0, 60), (60.01, 120), (119.5, 180)))
    grouped = group_folder(logs(*facts.clocks), facts)
    assert [len(drive.logs) for drive in grouped.drives] == [3]
    assert "within 500 ms" in grouped.drives[0].notes[0]


@pytest.mark.parametrize(
    "clocks",
    [
        row((0, 60), (62, 120)),
        row((0, 60), (58, 120)),
        row((0, 60), (0, 60)),
        row((0, 60), (0, 60), absolute=False),
        row((0, 0.5), (0.5, 60), absolute=False),
        {**row((0, 60)), "tour_2.blf": (60, 120, False)},
        row((0, 60)),
        {},
    ],
    ids=[
        "gap",
        "overlap",
        "same time",
        "clock begins anew",
        "begins at zero",
        "two clocks",
        "unknown",
        "none known",
    ],
)
def test_in_doubt_parts_are_drives_of_their_own(clocks):
    assert drives(Given(clocks), "tour_1.blf", "tour_2.blf") == [["tour_1.blf"], ["tour_2.blf"]]


def test_a_relative_clock_that_goes_on_joins():
    facts = Given(row((0, 60), (60.02, 120), absolute=False))
    assert drives(facts, *facts.clocks) == [["tour_1.blf", "tour_2.blf"]]


def test_a_missing_part_parts_the_drive():
    facts = Given(row((0, 60), (60, 120), (120, 180), (180, 240)))
    names = ["tour_1.blf", "tour_2.blf", "tour_4.blf"]
    assert drives(facts, *names) == [["tour_1.blf", "tour_2.blf"], ["tour_4.blf"]]


def test_a_row_is_no_longer_than_a_day():
    facts = Given(row(*((k * 36_000, (k + 1) * 36_000) for k in range(4))))
    assert [len(row) for row in drives(facts, *facts.clocks)] == [2, 2]


def test_clocks_are_not_asked_of_names_that_do_not_go_together():
    facts = Given()
    assert len(drives(facts, "monday.blf", "tuesday.blf", "wednesday.csv")) == 3
    assert facts.asked == []


def test_two_cars_that_start_together_stay_two():
    at = (T0, T0 + 600, True)
    facts = Given(dict.fromkeys(("car1.blf", "car2.blf", "golf.vbo", "passat.csv"), at))
    assert len(drives(facts, *facts.clocks)) == 4
    facts = Given(dict.fromkeys(("car1_can.blf", "car2_gps.vbo"), at))
    assert len(drives(facts, *facts.clocks)) == 2
    facts = Given(dict.fromkeys(("gps1.csv", "gps2.csv"), at))
    assert len(drives(facts, *facts.clocks)) == 2


def test_recorders_that_run_together_are_one_drive():
    facts = Given(
        {
            "can.blf": (T0, T0 + 600, True),
            "gps.vbo": (T0 + 5, T0 + 610, True),
            "imu.csv": (T0 - 3, T0 + 590, True),
        }
    )
    grouped = group_folder(logs(*facts.clocks), facts)
    assert [[log.name for log in drive.logs] for drive in grouped.drives] == [
        ["can.blf", "gps.vbo", "imu.csv"]
    ]
    assert "recorders of one drive" in grouped.drives[0].notes[-1]


def test_recorders_whose_clocks_do_not_agree_stay_apart():
    apart = Given({"can.blf": (T0, T0 + 600, True), "gps.vbo": (T0 + 601, T0 + 900, True)})
    assert len(drives(apart, *apart.clocks)) == 2
    relative = Given({"can.blf": (0, 600, False), "gps.vbo": (0, 600, False)})
    assert len(drives(relative, *relative.clocks)) == 2
    day = Given({"can.blf": (T0, T0 + 600, True), "gps.vbo": (T0 - 9000, T0 + 9000, True)})
    assert len(drives(day, *day.clocks)) == 2


def test_two_drives_of_two_recorders_are_paired_by_the_clock():
    facts = Given(
        {
            "can_10-00-00.blf": (T0, T0 + 600, True),
            "can_11-00-00.blf": (T0 + 3600, T0 + 4000, True),
            "gps_10-00-04.vbo": (T0 + 4, T0 + 604, True),
            "gps_11-00-02.vbo": (T0 + 3602, T0 + 4001, True),
        }
    )
    found = drives(facts, *facts.clocks)
    assert found == [["can_10-00-00.blf", "gps_10-00-04.vbo"], ["can_11-00-00.blf", "gps_11-00-02.vbo"]]


def test_two_of_one_kind_with_one_of_another_are_not_guessed():
    at = (T0, T0 + 600, True)
    facts = Given({"can_a1.blf": at, "a1_can.csv": at, "a1_gps.vbo": at})
    grouped = group_folder(logs(*facts.clocks), facts)
    assert len(grouped.drives) == 3
    assert all("drive.toml" in drive.lacks[0] for drive in grouped.drives)


def test_a_row_of_parts_and_a_recorder_beside_it_are_one():
    facts = Given(
        {
            "can_1.blf": (T0, T0 + 300, True),
            "can_2.blf": (T0 + 300.01, T0 + 600, True),
            "gps.vbo": (T0 + 1, T0 + 599, True),
        }
    )
    assert drives(facts, *facts.clocks) == [["can_1.blf", "can_2.blf", "gps.vbo"]]


SIGNALS = {"speed": Moments(20.0, 3.0), "accel_y": Moments(0.1, 1.5)}


def test_one_name_one_length_one_content_is_one_recording():
    facts = Given(
        {"d.blf": (T0, T0 + 60, True), "d.asc": (0, 60, False), "d.mcap": (T0, T0 + 60, True)},
        {"d.blf": SIGNALS, "d.asc": {"speed": Moments(20.01, 3.01)}, "d.mcap": {"speed": Moments(21.0, 3.0)}},
    )
    grouped = group_folder(logs(*facts.clocks), facts)
    assert [[log.name for log in d.logs] for d in grouped.drives] == [["d.blf"], ["d.mcap"]]
    assert [place for place, _ in grouped.left_out] == ["/f/suv/d.asc"]
    assert "d.asc is the same recording" in grouped.drives[0].notes[0]
    assert "same name" in grouped.drives[1].lacks[0]


def test_one_name_and_other_signals_are_recorders():
    facts = Given(
        {"d.blf": (T0, T0 + 60, True), "d.vbo": (T0, T0 + 61, True)},
        {"d.blf": SIGNALS, "d.vbo": {"latitude": Moments(48.0, 0.01)}},
    )
    assert drives(facts, "d.blf", "d.vbo") == [["d.blf", "d.vbo"]]
    facts.contents = {}
    assert drives(facts, "d.blf", "d.vbo") == [["d.blf", "d.vbo"]]
    facts.clocks = {"d.blf": (0, 60, False), "d.vbo": (0, 61, False)}
    assert drives(facts, "d.blf", "d.vbo") == [["d.blf"], ["d.vbo"]]


def test_one_name_and_another_length_are_two_drives():
    facts = Given(
        {"d.csv": (0, 60, False), "d.mcap": (T0, T0 + 70, True)}, {"d.csv": SIGNALS, "d.mcap": SIGNALS}
    )
    assert len(drives(facts, "d.csv", "d.mcap")) == 2


def test_parts_that_are_there_in_two_formats_count_once():
    clocks = {
        "tour_1.blf": (T0, T0 + 60, True),
        "tour_2.blf": (T0 + 60, T0 + 120, True),
        "tour_1.asc": (0, 60, False),
        "tour_2.asc": (0, 60, False),
    }
    facts = Given(clocks, dict.fromkeys(clocks, SIGNALS))
    grouped = group_folder(logs(*clocks), facts)
    assert [[log.name for log in d.logs] for d in grouped.drives] == [["tour_1.blf", "tour_2.blf"]]
    assert [place for place, _ in grouped.left_out] == ["/f/suv/tour_1.asc", "/f/suv/tour_2.asc"]
    assert len(grouped.drives[0].notes) == 3
