"""Everything that was taken as given, and where it came from."""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import chain

from pipelines.results import Assumption, DriveResults
from reports.blocks import Block, Cell, Column, Folded, Paragraph, Table
from reports.sections.contract import Plots
from reports.sections.values import prior_text
from reports.sections.verdict import ordered
from reports.text import clean, sentence, spec_of

INTRO = "A result is no better than these. Put better figures in the vehicle file and run again."
MOST = 150
MOST_SOURCES = 60


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


def _row(name: str, value: str, source: str, users: str) -> tuple[Cell, ...]:
    return (
        Cell(clean(name, 120)),
        Cell(clean(value, 200)),
        Cell(clean(source, 240)),
        Cell(clean(users, 200), tone="quiet"),
    )


def _priors(results: DriveResults) -> list[tuple[str, str, str]]:
    """Name, value and source of every prior of the verdict."""
    return [
        (
            f"prior: {spec_of(parameter.name).title}",
            prior_text(parameter.name, parameter.prior),
            parameter.prior.source,
        )
        for parameter in ordered(results.verdict.values())
        if parameter.prior is not None
    ]


def _by_source(entries: Iterable[tuple[str, str, str]]) -> Table:
    """Where something is from, and all that is from there: what a reader needs on paper."""
    found: dict[str, list[str]] = {}
    for name, value, source in entries:
        text = f"{clean(name, 120)} {clean(value, 200)}"
        told = found.setdefault(clean(source, 240), [])
        if text not in told:
            told.append(text)
    rows = tuple(
        (Cell(sentence(source).rstrip(".")), Cell("; ".join(texts)))
        for source, texts in sorted(found.items(), key=lambda pair: -len(pair[1]))
    )
    columns = (Column("Where from", weight=1.3), Column("What", weight=4))
    return Table(columns, rows[:MOST_SOURCES], note=_more(len(rows), MOST_SOURCES), dense=True)


def _more(found: int, most: int) -> str:
    return f"{found - most} more are in results.json." if found > most else ""


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """All by its source; behind a fold each entry once with its users, and every prior."""
    of_estimators = ((a, e.estimator) for e in results.estimates for a in e.assumptions)
    merged = _merged(chain(of_estimators, ((a, "") for a in results.assumptions)))
    priors = _priors(results)
    if not merged and not priors:
        return (Paragraph("Nothing: no estimator ran and no prior was used.", "quiet"),)
    entries = [(a.name, a.value, a.source) for a, _ in merged] + priors
    rows = [_row(a.name, a.value, a.source, ", ".join(users) or "all") for a, users in merged]
    rows += [_row(*prior, "verdict") for prior in priors]
    columns = (
        Column("What", weight=2),
        Column("Value", weight=2),
        Column("Where from", weight=2.6),
        Column("Used by", weight=1.8),
    )
    single = Table(columns, tuple(rows[:MOST]), note=_more(len(rows), MOST), dense=True)
    return (_by_source(entries), Folded("Each by itself, and who used it", (single,)))
