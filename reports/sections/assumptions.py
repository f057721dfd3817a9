"""Everything that was taken as given, and where it came from."""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import chain

from pipelines.results import Assumption, DriveResults
from reports.blocks import Block, Cell, Column, Paragraph, Table
from reports.sections.contract import Plots
from reports.sections.values import prior_text
from reports.sections.verdict import ordered
from reports.text import clean, spec_of

INTRO = "A result is no better than these. Put better figures in the vehicle file and run again."
MOST = 150


_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def _same(assumption: Assumption) -> tuple[str, str, str]:
    """What makes two entries one: name, source, and the figures to two digits, whatever unit is written behind them."""
    figures = _NUMBER.findall(assumption.value)[:2]
    told = " ".join(f"{float(figure):.1e}" for figure in figures) if figures else assumption.value
    return assumption.name, assumption.source, told


def _merged(found: Iterable[tuple[Assumption, str]]) -> list[tuple[Assumption, list[str]]]:
    """Each entry once, in the order of first use, with everyone who used it."""
    merged: dict[tuple[str, str, str], tuple[Assumption, list[str]]] = {}
    for assumption, who in found:
        _, users = merged.setdefault(_same(assumption), (assumption, []))
        if who and who not in users:
            users.append(who)
    return list(merged.values())


def _row(assumption: Assumption, users: list[str]) -> tuple[Cell, ...]:
    return (
        Cell(clean(assumption.name, 120)),
        Cell(clean(assumption.value, 200)),
        Cell(clean(assumption.source, 240)),
        Cell(clean(", ".join(users) or "all", 200), tone="quiet"),
    )


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """The estimators' assumptions, each once with its users, those of the drive as a whole, and every prior."""
    of_estimators = ((a, e.estimator) for e in results.estimates for a in e.assumptions)
    rows = [_row(*entry) for entry in _merged(chain(of_estimators, ((a, "") for a in results.assumptions)))]
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
        Column("Where from", weight=2.6),
        Column("Used by", weight=1.8),
    )
    note = f"{len(rows) - MOST} more are in results.json." if len(rows) > MOST else ""
    return (Table(columns, tuple(rows[:MOST]), note=note),)
