"""What was taken as given stands once in the report, with everyone who used it."""

from __future__ import annotations

from dataclasses import replace

from pipelines.results import Assumption, DriveResults, Estimate
from reports.blocks import Folded, Table
from reports.sections import assumptions, estimators
from tests.reports.sample_results import rich

BASE = Assumption("wheelbase_m", "2.786 ± 0.0056 m", "vehicle file")


def _tables(results: DriveResults) -> tuple[Table, Table]:
    """What is printed, by source, and what is folded, entry by entry."""
    printed, folded = assumptions.build(results, {})
    assert isinstance(printed, Table)
    assert isinstance(folded, Folded)
    (single,) = folded.blocks
    assert isinstance(single, Table)
    return printed, single


def _table(*entries: tuple[str, Assumption]) -> list[tuple[str, ...]]:
    plain = rich()
    silent = {name: replace(p, prior=None) for name, p in plain.verdict.items()}
    ran = tuple(Estimate(name, "ran", "", assumptions=(entry,)) for name, entry in entries)
    every = tuple(dict.fromkeys(entry for _, entry in entries))
    _, table = _tables(replace(plain, verdict=silent, estimates=ran, assumptions=every))
    return [tuple(cell.text for cell in row) for row in table.rows]


def test_one_row_for_all_who_used_it() -> None:
    rows = _table(("roll_map", BASE), ("load_balance", BASE))
    assert rows == [("wheelbase_m", "2.786 ± 0.0056 m", "vehicle file", "roll_map, load_balance")]


def test_the_same_figures_written_in_two_ways_are_one() -> None:
    other = replace(BASE, value="2.786 ± 0.00557")
    assert [row[3] for row in _table(("a", BASE), ("b", other))] == ["a, b"]


def test_other_figures_or_sources_stand_apart() -> None:
    wider = replace(BASE, value="2.786 ± 0.1 m")
    guessed = replace(BASE, source="usual")
    rows = _table(("a", BASE), ("b", wider), ("c", guessed))
    assert [row[3] for row in rows] == ["a", "b", "c"]


def test_what_no_estimator_names_is_for_all() -> None:
    plain = rich()
    silent = {name: replace(p, prior=None) for name, p in plain.verdict.items()}
    _, table = _tables(replace(plain, verdict=silent, estimates=(), assumptions=(BASE,)))
    assert table.rows[0][3].text == "all"


def test_on_paper_all_of_one_source_share_a_row() -> None:
    printed, single = _tables(rich())
    rows = {row[0].text: row[1].text for row in printed.rows}
    assert "track 1.549 m ± 0.008 m" in rows["Vehicle file"]
    assert "prior: Mass 1563 ± 16" in rows["Vehicle file"]
    assert len(printed.rows) < len(single.rows)


def test_diagnostics_fill_rows_of_pairs() -> None:
    figures = {f"figure_{i}": float(i) for i in range(4)}
    told = replace(rich(), estimates=(Estimate("m", "ran", "", diagnostics=figures),))
    folded = estimators.build(told, {})[-1]
    assert isinstance(folded, Folded)
    table = folded.blocks[-1]
    assert isinstance(table, Table)
    assert [cell.text for cell in table.rows[1]] == ["figure 3", "3", "", "", "", ""]
    (printed,) = folded.printed
    assert isinstance(printed, Table)
    assert [cell.text for cell in printed.rows[0]] == ["m", "figure 0 0; figure 1 1; figure 2 2; figure 3 3"]
