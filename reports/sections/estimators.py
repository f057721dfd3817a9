"""Which estimators ran, and exactly what each of the others lacks; their diagnostics."""

from __future__ import annotations

from pipelines.drive_results import DriveResults
from pipelines.results import Estimate
from reports.blocks import Block, Cell, Column, Folded, Heading, Paragraph, Table, Tone
from reports.method_names import code_of
from reports.sections.contract import Plots
from reports.sections.diagnostic_words import diagnostic
from reports.text import DASH, clean, percent, seconds, sentence

INTRO = "Which estimators ran and how, and exactly what each of the others lacks. Below each its name for --estimators."
TONES: dict[str, Tone] = {"ran": "good", "skipped": "quiet", "failed": "bad"}
MOST_DIAGNOSTICS = 24
PRINTED_DIAGNOSTICS = 4
MORE = f"The first few of each; report.html has up to {MOST_DIAGNOSTICS} of each, results.json all."
PAIRS = 3
"""Diagnostics stand in so many pairs of name and value a row."""


def _code(estimate: Estimate) -> str:
    """Its name for `--estimators`, and whether it runs as published."""
    return ", ".join(filter(None, (code_of(estimate.estimator), "published" if estimate.witness else "")))


def _runs(results: DriveResults) -> Table:
    rows = tuple(
        (
            Cell(clean(e.estimator, 60), sub=_code(e)),
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
    return Table(columns, rows, dense=True)


def _pairs(estimate: Estimate, most: int) -> list[tuple[str, str]]:
    """Named figures, ready for print."""
    named = list(estimate.diagnostics.items())[:most]
    return [diagnostic(name, float(value)) for name, value in named]


def _diagnostics(estimate: Estimate) -> list[Heading | Table]:
    """Named figures, several pairs a row: they are for the one who digs."""
    cells = [(Cell(name, tone="quiet"), Cell(value)) for name, value in _pairs(estimate, MOST_DIAGNOSTICS)]
    if not cells:
        return []
    cells += [(Cell(""), Cell(""))] * (-len(cells) % PAIRS)
    rows = tuple(
        tuple(cell for pair in cells[first : first + PAIRS] for cell in pair)
        for first in range(0, len(cells), PAIRS)
    )
    columns = (Column("Figure", weight=2), Column("Value", "right", 1)) * PAIRS
    left = len(estimate.diagnostics) - MOST_DIAGNOSTICS
    note = f"{left} more are in results.json." if left > 0 else ""
    return [Heading(clean(estimate.estimator, 60)), Table(columns, rows, dense=True, note=note)]


def _folded(results: DriveResults) -> Folded | None:
    """All diagnostics, folded; on paper the first few of each estimator."""
    inside = [block for estimate in results.estimates for block in _diagnostics(estimate)]
    if not inside:
        return None
    rows = tuple(
        (
            Cell(clean(estimate.estimator, 60)),
            Cell("; ".join(f"{name} {value}" for name, value in _pairs(estimate, PRINTED_DIAGNOSTICS))),
        )
        for estimate in results.estimates
        if estimate.diagnostics
    )
    printed = Table(
        (Column("Estimator", weight=1), Column("Diagnostics", weight=4.5)), rows, dense=True, note=MORE
    )
    return Folded("Diagnostics of every estimator", tuple(inside), (printed,))


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """The chapter."""
    if not results.estimates:
        return (Paragraph("No estimator was asked for.", "quiet"),)
    folded = _folded(results)
    return (_runs(results),) if folded is None else (_runs(results), folded)
