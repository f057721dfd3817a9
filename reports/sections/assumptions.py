"""Everything that was taken as given, and where it came from."""

from __future__ import annotations

from pipelines.results import Assumption, DriveResults
from reports.blocks import Block, Cell, Column, Paragraph, Table
from reports.sections.contract import Plots
from reports.sections.values import prior_text
from reports.sections.verdict import ordered
from reports.text import clean, spec_of

INTRO = "A result is no better than these. Put better figures in the vehicle file and run again."
MOST = 150


def _rows(found: tuple[Assumption, ...], who: str) -> list[tuple[Cell, ...]]:
    return [
        (
            Cell(clean(a.name, 120)),
            Cell(clean(a.value, 200)),
            Cell(clean(a.source, 240)),
            Cell(clean(who, 60), tone="quiet"),
        )
        for a in found
    ]


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """The drive's assumptions, each estimator's, and every prior."""
    rows = _rows(results.assumptions, "all")
    for estimate in results.estimates:
        rows += _rows(estimate.assumptions, estimate.estimator)
    for parameter in ordered(results.verdict.values()):
        if parameter.prior is not None:
            rows.append(
                (
                    Cell(f"prior: {spec_of(parameter.name).title}"),
                    Cell(prior_text(parameter.name, parameter.prior)),
                    Cell(clean(parameter.prior.source, 240)),
                    Cell("verdict", tone="quiet"),
                )
            )
    if not rows:
        return (Paragraph("Nothing: no estimator ran and no prior was used.", "quiet"),)
    columns = (
        Column("What", weight=2),
        Column("Value", weight=2),
        Column("Where from", weight=3),
        Column("Used by", weight=1),
    )
    note = f"{len(rows) - MOST} more are in results.json." if len(rows) > MOST else ""
    return (Table(columns, tuple(rows[:MOST]), note=note),)
