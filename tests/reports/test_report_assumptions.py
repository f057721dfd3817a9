"""What was taken as given stands once in the report, with everyone who used it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pipelines.results import Assumption, Estimate
from pipelines.vehicles.keys import VEHICLE_KEYS
from reports.blocks import Folded, Table
from reports.sections import assumptions
from reports.sections.given_words import file_key, given, words_of
from reports.text import NARROW
from tests.reports.sample_results import rich

BASE = Assumption("wheelbase_m", "2.786 ± 0.0056 m", "vehicle file")


def _table(*entries: tuple[str, Assumption], place: int = 1) -> list[tuple[str, ...]]:
    """The printed rows (place 1: the first table) or, at -1, the folded ones with users."""
    ran = tuple(Estimate(name, "ran", "", assumptions=(entry,)) for name, entry in entries)
    every = tuple(dict.fromkeys(entry for _, entry in entries))
    block = assumptions.build(replace(rich(), estimates=ran, assumptions=every), {})[place]
    table = block.blocks[0] if isinstance(block, Folded) else block
    assert isinstance(table, Table)
    return [tuple(cell.text for cell in row) for row in table.rows]


def test_one_row_for_all_who_used_it_in_words_and_the_files_key_behind_a_fold() -> None:
    entries = (("roll_map", BASE), ("load_balance", BASE))
    assert _table(*entries) == [("Wheelbase", f"2.7860 ± 0.0056{NARROW}m", "Vehicle file")]
    assert _table(*entries, place=-1) == [("Wheelbase", "wheelbase_m", "roll_map, load_balance")]


def test_the_same_figures_written_in_two_ways_are_one() -> None:
    other = replace(BASE, value="2.786 ± 0.00557")
    assert len(_table(("a", BASE), ("b", other))) == 1
    assert _table(("a", BASE), ("b", other))[0][1] == f"2.7860 ± 0.0056{NARROW}m"


def test_a_quantity_by_several_names_is_one() -> None:
    one = Assumption("tire_vertical_rate_npm (a tyre, four in all)", "219418 ± 11000 N/m", "vehicle file")
    other = Assumption("tire_vertical_rate_npm", "2.194e+05 ± 1.1e+04", "vehicle file")
    rows = _table(("a", one), ("b", other))
    assert rows == [
        ("Tyre vertical rate, each", f"219{NARROW}000 ± 11{NARROW}000{NARROW}N/m", "Vehicle file")
    ]


@pytest.mark.parametrize("value", ["1000000000 ± 50000000 N/m", "1e+12 ± 5e+10"])
def test_a_tyre_that_is_stated_to_be_rigid_is_told_as_that(value: str) -> None:
    rows = _table(("a", Assumption("tire_vertical_rate_npm", value, "vehicle file")))
    assert rows == [("Tyre vertical rate, each", "it does not give", "Vehicle file")]


def test_other_figures_or_sources_of_a_quantity_share_its_row() -> None:
    wider = replace(BASE, value="2.786 ± 0.1 m")
    guessed = replace(BASE, source="usual")
    ((_, value, source),) = _table(("a", BASE), ("b", wider), ("c", guessed))
    assert value == f"2.7860 ± 0.0056{NARROW}m; 2.79 ± 0.10{NARROW}m"
    assert source == "Vehicle file; usual"


def test_what_no_estimator_names_is_for_all() -> None:
    block = assumptions.build(replace(rich(), estimates=(), assumptions=(BASE,)), {})[-1]
    assert isinstance(block, Folded)
    assert block.blocks[0].rows[0][2].text == "all"  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("name", "value", "words", "shown"),
    [
        ("brake_gain_nmppa", "0.00073 ± 2.2e-05 N·m/Pa", "Brake torque per pressure", f"73.0 ± 2.2{NARROW}N·m/bar"),
        ("brake_gain_nmppa", "0.00073 ± 2.2e-05", "Brake torque per pressure", f"73.0 ± 2.2{NARROW}N·m/bar"),
        ("spring_rate_front_npm", "2.95e+04 ± 590", "Spring rate, front", f"29{NARROW}500 ± 590{NARROW}N/m"),
        ("load left of the middle, m", "0 ± 0.255", "Load's place left of the middle", f"0.00 ± 0.26{NARROW}m"),
        ("track_rear_m", "1.617 ± 0.00809", "Track, rear", f"1.6170 ± 0.0081{NARROW}m"),
        ("filter", "zero-phase low-pass at 8 Hz", "Filter", "zero-phase low-pass at 8 Hz"),
        ("noise", "within 2.5e+04 N a wheel", "Noise", f"within 25{NARROW}000 N a wheel"),
        ("tyres' slip curve", "bend 0.25 ± 0.2, load 0.1 ± 0.2", "Tyres' slip curve", "bend 0.25 ± 0.2, load 0.1 ± 0.2"),
    ],
)  # fmt: skip
def test_names_in_words_and_values_with_units(name: str, value: str, words: str, shown: str) -> None:
    told = given(name, value)
    assert (told.words, told.value) == (words, shown)


@pytest.mark.parametrize("key", sorted(VEHICLE_KEYS))
def test_every_key_of_the_vehicle_file_has_words(key: str) -> None:
    words = words_of(key)
    assert "_" not in words
    assert words[0].isupper()
    assert not words.endswith((" m", " kg", " npm", " nmprad", " kgm2", " nmppa", " deg", " mprad"))
    assert file_key(key) == key
