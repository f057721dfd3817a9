"""A paper's page: every figure that it is given stands in it, in print, in HTML and as data."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipelines.reproduce.base import Claim, Column, ReproducedTable, Reproduction, StudyRow, study_row
from pipelines.results import Scatter, Trace
from reports.html import html_of
from reports.reproduction import build_reproduction, study_cells
from reports.reproduction_text import reproduction_json, reproduction_text, write_reproduction


def made() -> Reproduction:
    """A reproduction with one of everything."""
    time = np.linspace(0, 10, 50)
    line = np.linspace(0.0, 1.0, 50)
    return Reproduction(
        paper="someone",
        title="Someone et al.: a method <b>",
        citation="Someone, A Journal, 2001",
        setup=("a car on a road",),
        tables=(
            ReproducedTable(
                "Table I",
                "Mass by noise",
                (Column("Run"), Column("Paper", "kg"), Column("Ours", "kg", 2)),
                (("1", 803.0, 803.127), ("2", None, float("nan"))),
                "the noise is not printed",
            ),
        ),
        claims=(
            Claim("Section V", "within 8 %", "6.1 %", "0.2 %", "agrees"),
            Claim("Section V", "in 100 s", "in 140 s", "", "differs", "another terrain"),
        ),
        study=(
            StudyRow("asphalt", "as published", "mass", "kg", 803.0, 50, -44.0, 45.0, 0.97, 0.12, None, ""),
            StudyRow("asphalt", "companion", "mass", "kg", 803.0, 50, 0.1, 1.1, 0.97, 0.94, 1.2, ""),
            StudyRow("asphalt", "too proud", "mass", "kg", 803.0, 50, 0.1, 1.9, 0.97, 0.94, 1.2, ""),
        ),
        traces=(Trace("Fig. 4", time, {"mass": 800 * line}, {"mass": "kg"}, "over time"),),
        scatters=(Scatter("s", "Force by speed", "m/s", "N", line, line, line, line, line, line),),
    )


def test_every_figure_is_printed() -> None:
    text = reproduction_text(made(), 120)
    for word in (
        "803.13",
        "within 8 %",
        "[differs]",
        "another terrain",
        "1.13",
        "46.39",
        "0.94",
        "The noise",
    ):
        assert word.lower() in text.lower(), word
    assert "target missed" in text
    assert text.count("target missed") == 1
    assert max(len(line) for line in text.splitlines()) <= 120


def test_page_holds_claims_bound_tables_and_figures() -> None:
    html = html_of(build_reproduction(made(), "1.2"))
    assert "What the paper claims" in html
    assert "a method &lt;b&gt;" in html
    assert html.count("<svg") >= 2
    assert "1 of 2 claims" in html
    assert "1 of 2 targets" in html


def test_data_are_strict_json() -> None:
    data = json.loads(reproduction_json(made(), "1.2"))
    assert data["tables"][0]["rows"][1] == ["2", None, None]
    assert data["study"][1]["ratio"] == pytest.approx(1.1 / 0.97)
    assert "traces" not in data


def test_all_forms_are_written(tmp_path: Path) -> None:
    paths = write_reproduction(made(), "1.2", tmp_path / "pages", ("html", "pdf", "json"))
    assert [path.name for path in paths] == ["someone.html", "someone.pdf", "someone.json"]
    assert paths[1].read_bytes().startswith(b"%PDF")


def test_study_row_counts_lost_runs_as_misses() -> None:
    estimates = np.array([1.0, 1.2, np.nan, 0.8])
    intervals = np.column_stack([estimates - 0.3, estimates + 0.3])
    row = study_row("set-up", "method", "h", "m", 1.0, estimates, intervals, 0.1)
    assert row.bias == pytest.approx(0.0)
    assert row.rmse == pytest.approx(np.sqrt(0.08 / 3))
    assert row.coverage == pytest.approx(0.75)
    assert "1 of 4 runs" in row.remark
    assert row.ratio == pytest.approx(row.rmse / 0.1)


def _row(ratio: float, runs: int, target: float | None = 1.05) -> StudyRow:
    return StudyRow(
        "plant", "batch", "K", "N·m/rad", 60000.0, runs, 0.0, ratio * 2000.0, 2000.0, 0.95, target
    )


@pytest.mark.parametrize(
    ("ratio", "runs", "met"),
    [(1.09, 20, "open"), (1.11, 20, "open"), (1.04, 20, "kept"), (1.09, 5000, "missed"), (1.6, 20, "missed")],
)
def test_a_target_is_missed_only_beyond_what_so_few_seeds_scatter(ratio: float, runs: int, met: str) -> None:
    row = _row(ratio, runs)
    assert row.target_met == met
    text = reproduction_text(replace(made(), study=(row,)), 120)
    assert ("target missed" in text) == (met == "missed")
    assert (f"not told by {runs} seeds" in text) == (met == "open")


def test_a_ratio_beside_a_target_has_its_sampling_error() -> None:
    assert study_cells(_row(1.09, 20))[6] == "1.09 ± 0.17 (≤ 1.05)"
    assert study_cells(_row(1.09, 20, None))[6] == "1.09"
    html = html_of(build_reproduction(replace(made(), study=(_row(1.09, 20), _row(1.0, 20))), "1.2"))
    assert "1 of 2 targets against the Cramér-Rao bound are kept, 1 not told by so few seeds." in html
