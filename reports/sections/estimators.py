"""Which estimators ran, and exactly what each of the others lacks; what each method says beside the verdict."""

from __future__ import annotations

from pipelines.results import DriveResults, Estimate
from reports.blocks import Block, Cell, Column, Heading, Paragraph, Table, Tone
from reports.sections.contract import Plots
from reports.sections.values import deviation_text, interval_cell, status_cell, value_text
from reports.sections.verdict import ordered
from reports.text import DASH, clean, gist, percent, seconds, sentence, significant, spec_of

INTRO = (
    "The verdict on the first page is the answer of the method that identified a parameter best. Published methods stand "
    "beside it as witnesses; where methods that call a parameter identified contradict each other, its interval is wider."
)
TONES: dict[str, Tone] = {"ran": "good", "skipped": "quiet", "failed": "bad"}
MOST_DIAGNOSTICS = 24
PAIRS = 3
"""Diagnostics stand in so many pairs of name and value a row."""


def _runs(results: DriveResults) -> Table:
    rows = tuple(
        (
            Cell(clean(e.estimator, 60), sub="published method, a witness" if e.witness else ""),
            Cell(e.status, kind="badge", tone=TONES[e.status]),
            Cell(sentence(e.reason, 1200)),
            Cell(percent(e.used_fraction) if e.status == "ran" else DASH),
            Cell(seconds(e.runtime_s) if e.status == "ran" else DASH),
        )
        for e in sorted(results.estimates, key=lambda e: ("ran", "failed", "skipped").index(e.status))
    )
    columns = (
        Column("Estimator", weight=1),
        Column("", "left", 0),
        Column("What it did, or lacks", weight=4),
        Column("Of the drive used", "right", 0),
        Column("Time", "right", 0),
    )
    return Table(columns, rows)


def _witnesses(results: DriveResults) -> Table | None:
    rows = []
    for method in results.estimates:
        for estimate in ordered(method.parameters.values()):
            rows.append(
                (
                    Cell(spec_of(estimate.name).title),
                    Cell(clean(method.estimator, 60), tone="quiet"),
                    Cell(value_text(estimate)),
                    Cell(deviation_text(estimate), tone="quiet"),
                    interval_cell(estimate),
                    status_cell(estimate),
                    Cell(sentence(gist(estimate.reason))),
                )
            )
    if not rows:
        return None
    columns = (
        Column("Parameter", weight=1.6),
        Column("Method", weight=0.9),
        Column("Value", "right", 0),
        Column("± std", "right", 0),
        Column("95 % interval", "right", 0),
        Column("Status", "left", 0),
        Column("Why", weight=2.4),
    )
    return Table(columns, tuple(rows))


def _diagnostics(estimate: Estimate) -> list[Block]:
    """Named figures, several pairs a row: they are for the one who digs."""
    named = list(estimate.diagnostics.items())[:MOST_DIAGNOSTICS]
    if not named:
        return []
    cells = [
        (Cell(clean(name.replace("_", " "), 80), tone="quiet"), Cell(significant(float(value), 4)))
        for name, value in named
    ]
    cells += [(Cell(""), Cell(""))] * (-len(cells) % PAIRS)
    rows = tuple(
        tuple(cell for pair in cells[first : first + PAIRS] for cell in pair)
        for first in range(0, len(cells), PAIRS)
    )
    columns = (Column("Figure", weight=2), Column("Value", "right", 1)) * PAIRS
    return [Heading(f"Diagnostics: {clean(estimate.estimator, 60)}"), Table(columns, rows)]


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """The chapter."""
    if not results.estimates:
        return (Paragraph("No estimator was asked for.", "quiet"),)
    blocks: list[Block] = [_runs(results)]
    witnesses = _witnesses(results)
    if witnesses is not None:
        blocks += [Heading("What each method says"), witnesses]
    for estimate in results.estimates:
        blocks += _diagnostics(estimate)
    return tuple(blocks)
