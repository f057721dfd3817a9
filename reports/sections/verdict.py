"""The verdict: a line a parameter, with the reason in words."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeVar

from pipelines.parameters import PARAMETERS
from pipelines.results import DriveResults, ParameterEstimate
from reports.blocks import Cell, Column, Fact, Table
from reports.sections.values import (
    STATUS_WORDS,
    bar_cell,
    decimals_of,
    deviation_text,
    has_result,
    interval_cell,
    prior_text,
    status_cell,
    value_text,
)
from reports.text import DASH, clean, count, gist, number, sentence, spec_of

COLUMNS = (
    Column("Parameter", weight=2.0),
    Column("Value ± std", "right", 0),
    Column("95 % interval", "right", 0),
    Column("Prior and result", "center", 0),
    Column("Verdict", "left", 0),
    Column("Why", weight=4.2),
    Column("Prior (known before, not a result)", weight=2.1),
)


BAR_COLUMN = 3
LEADING = "cg_height_m"
"""What a reader looks for first: a line of its own, whatever the reason."""


T = TypeVar("T")


@dataclass(frozen=True)
class Line:
    """One line of the verdict: a parameter, or several that failed for the same reason."""

    title: str
    estimate: ParameterEstimate
    names: tuple[str, ...]


def ordered(verdict: Iterable[ParameterEstimate]) -> list[ParameterEstimate]:
    """Parameters in the table's order; others behind, as they came."""
    place = {name: index for index, name in enumerate(PARAMETERS)}
    return sorted(verdict, key=lambda e: place.get(e.name, len(place)))


def _empty(estimate: ParameterEstimate) -> bool:
    return not has_result(estimate) and estimate.prior is None and estimate.reference is None


def lines(results: DriveResults) -> list[Line]:
    """The verdict's lines: first what has a value or a prior, then the rest, joined where the reason is the same."""
    found: list[Line] = []
    by_reason: dict[str, list[ParameterEstimate]] = {}
    for estimate in ordered(results.verdict.values()):
        if _empty(estimate) and estimate.name != LEADING:
            by_reason.setdefault(estimate.reason, []).append(estimate)
        else:
            found.append(Line(spec_of(estimate.name).title, estimate, (estimate.name,)))
    for group in by_reason.values():
        found.append(
            Line(_joined([spec_of(e.name).title for e in group]), group[0], tuple(e.name for e in group))
        )
    return found


def _joined(titles: list[str]) -> str:
    """Join titles that differ in the last word only, as in "Corner mass fl, fr, rl, rr"."""
    groups: dict[str, list[str]] = {}
    for title in titles:
        stem, _, last = title.rpartition(" ")
        if last in ("fl", "fr", "rl", "rr"):
            groups.setdefault(stem, []).append(last)
        else:
            groups.setdefault(title, [])
    return "; ".join(f"{stem} {', '.join(ends)}" if ends else stem for stem, ends in groups.items())


def _value_cell(estimate: ParameterEstimate) -> Cell:
    if not has_result(estimate):
        return Cell(DASH, tone="quiet")
    return Cell(value_text(estimate), sub=deviation_text(estimate))


def _why(estimate: ParameterEstimate, told: dict[str, str]) -> str:
    """The reason; a long one that stands above already is not said twice. told: reason -> title, added to here."""
    if len(estimate.reason) > 60 and estimate.reason in told:
        return f"As for {told[estimate.reason]}."
    title = spec_of(estimate.name).title
    told[estimate.reason] = title if title[1:2].isupper() else title[:1].lower() + title[1:]
    return sentence(gist(estimate.reason))


def reasons_in_full(results: DriveResults) -> tuple[Fact, ...]:
    """The reasons that the table had to shorten, each once."""
    titles: dict[str, list[str]] = {}
    for line in lines(results):
        reason = line.estimate.reason
        if gist(reason) != clean(reason, 4000):
            titles.setdefault(reason, []).append(line.title)
    return tuple(Fact("; ".join(names), sentence(reason, 4000)) for reason, names in titles.items())


def _without(row: tuple[T, ...], place: int) -> tuple[T, ...]:
    return (*row[:place], *row[place + 1 :])


def table(results: DriveResults) -> Table:
    """The verdict as a table."""
    rows = []
    told: dict[str, str] = {}
    for line in lines(results):
        estimate = line.estimate
        prior = estimate.prior
        rows.append(
            (
                Cell(line.title),
                _value_cell(estimate),
                interval_cell(estimate),
                bar_cell(estimate),
                status_cell(estimate),
                Cell(_why(estimate, told)),
                Cell(
                    prior_text(estimate.name, prior),
                    sub=clean(prior.source, 120) if prior else "",
                    tone="quiet",
                )
                if prior
                else Cell(DASH, tone="quiet"),
            )
        )
    if all(row[BAR_COLUMN].bar is None for row in rows):
        return Table(_without(COLUMNS, BAR_COLUMN), tuple(_without(row, BAR_COLUMN) for row in rows))
    return Table(
        COLUMNS,
        tuple(rows),
        note="Bar: grey = 95 % range known before the log, coloured = 95 % interval after it, | = reference.",
    )


def summary(results: DriveResults) -> str:
    """How much the log told, in one or two sentences."""
    total = len(results.verdict)
    if total == 0:
        return "No parameter was asked for."
    number_of = {
        s: sum(e.status == s for e in results.verdict.values())
        for s in ("identified", "weak", "not_identifiable")
    }
    first = (
        f"Of {count(total, 'parameter')}, this log identifies {number_of['identified']}, tells {number_of['weak']} weakly, "
        f"and cannot tell {number_of['not_identifiable']}."
    )
    cg = results.verdict.get("cg_height_m")
    if cg is None:
        return first
    if not has_result(cg):
        why = re.split(r"; |: give ", clean(cg.reason), maxsplit=1)[0]
        return f"{first} It gives no CG height: {why.rstrip('.')}."
    low, high = (number(end, decimals_of(cg)) for end in (cg.low, cg.high))
    return (
        f"{first} CG height {value_text(cg)}, with 95 % between {low} and {high} ({STATUS_WORDS[cg.status]})."
    )
