"""The verdict: a line a parameter, with the reason in words."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass

from pipelines.drive_results import DriveResults
from pipelines.parameters import PARAMETERS
from pipelines.results import ParameterEstimate
from reports.blocks import Block, Cell, Column, Table, filled
from reports.sections.contract import Plots
from reports.sections.values import (
    STATUS_WORDS,
    bar_cell,
    decimals_of,
    deviation_text,
    has_result,
    interval_cell,
    interval_text,
    prior_text,
    status_cell,
    value_text,
)
from reports.text import DASH, NARROW, NO_BREAK, clean, count, gist, number, sentence, spec_of, with_unit

COLUMNS = (
    Column("Parameter", weight=2.5),
    Column("Value ± std", "right", 0),
    Column("95 % interval", "right", 0),
    Column("Prior, result", "center", 0),
    Column("Verdict", "left", 0),
    Column("Why, in short", weight=4.3),
    Column("Prior, no result", weight=1.6),
)
DETAIL_COLUMNS = (
    Column("Parameter", weight=2.0),
    Column("Value ± std", "right", 0),
    Column("95 % interval", "right", 0),
    Column("Verdict", "left", 0),
    Column("Why", weight=5.6),
    Column("Prior (known before, not a result)", weight=1.9),
)
DETAIL_INTRO = "The reasons, and every prior with its source. An interval in brackets is no result: it is the prior's, or what this drive's load leaves of it."
MOST_WHY = 420
"""Characters of a reason in the detailed table: more than any but a list of relations; results.json has all of it."""

BAR_COLUMN = 3
LEADING = "cg_height_m"
"""What a reader looks for first: the first line, and one of its own whatever the reason."""

SHORT_WHY, LEADING_WHY = 52, 104
"""Characters of a reason on the first screen; all of it stands in the detailed table."""
MOST_OPENING = 26
MANY = 4
"""Priors of one source from which on it is named once below the table."""


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


def _rank(estimate: ParameterEstimate) -> int:
    """The leading parameter, then results, then what has a prior only, then what has nothing."""
    if estimate.name == LEADING:
        return 0
    return 1 if has_result(estimate) else 3 if _empty(estimate) else 2


def _gathered(results: DriveResults, key: Callable[[ParameterEstimate], Hashable | None]) -> list[Line]:
    """Lines in order of rank; parameters with the same key (None = alone) share the line of the first."""
    groups: dict[Hashable, list[ParameterEstimate]] = {}
    for estimate in sorted(ordered(results.verdict.values()), key=_rank):
        shared = None if estimate.name == LEADING else key(estimate)
        groups.setdefault(("alone", estimate.name) if shared is None else shared, []).append(estimate)
    return [
        Line(_joined([spec_of(e.name).title for e in group]), group[0], tuple(e.name for e in group))
        for group in groups.values()
    ]


def lines(results: DriveResults) -> list[Line]:
    """The verdict's lines: what has a value or a prior has its own; the rest are joined where the reason is the same."""
    return _gathered(results, lambda e: e.reason if _empty(e) else None)


def short_lines(results: DriveResults) -> list[Line]:
    """The first screen's lines: all that is not identifiable for the same reason shares one."""
    return _gathered(results, lambda e: None if has_result(e) else (e.prior is None, e.reason))


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
    deviation = deviation_text(estimate)
    figures = value_text(estimate, unit=False) + ("" if deviation == DASH else f"{NO_BREAK}{deviation}")
    return Cell(with_unit(figures.replace(" ", NO_BREAK), spec_of(estimate.name).unit))


def _pointed(estimate: ParameterEstimate) -> str:
    """The reason without an opening that only says "not told", as the badge beside it does."""
    head, _, rest = clean(estimate.reason, 4000).partition(": ")
    return (
        rest
        if rest and not has_result(estimate) and len(head) <= MOST_OPENING
        else clean(estimate.reason, 4000)
    )


def _why(estimate: ParameterEstimate, told: dict[str, str], limit: int | None = None) -> str:
    """The reason; a long one that stands above already is not said twice. told: reason -> title, added to here."""
    if len(estimate.reason) > 60 and estimate.reason in told:
        return f"As for {told[estimate.reason]}."
    title = spec_of(estimate.name).title
    told[estimate.reason] = title if title[1:2].isupper() else title[:1].lower() + title[1:]
    return (
        sentence(gist(estimate.reason, MOST_WHY), 4000)
        if limit is None
        else sentence(gist(_pointed(estimate), limit))
    )


def _short_priors(group: Iterable[ParameterEstimate]) -> Cell:
    """The priors' values, in the order of the names; where they are from stands in the detailed table."""
    texts = [prior_text(e.name, e.prior).replace("± ", f"±{NO_BREAK}") for e in group if e.prior is not None]
    return Cell("; ".join(texts) or DASH, tone="quiet")


def _short_row(results: DriveResults, line: Line, told: dict[str, str]) -> tuple[Cell, ...]:
    estimate = line.estimate
    return (
        Cell(line.title, tone="plain" if has_result(estimate) or estimate.name == LEADING else "quiet"),
        _value_cell(estimate),
        Cell(interval_text(estimate)),
        bar_cell(estimate) if len(line.names) == 1 else Cell(""),
        status_cell(estimate),
        Cell(_why(estimate, told, LEADING_WHY if estimate.name == LEADING else SHORT_WHY)),
        _short_priors(results.verdict[name] for name in line.names),
    )


def table(results: DriveResults) -> Table:
    """The verdict as the first screen has it: a line or two a parameter."""
    told: dict[str, str] = {}
    rows = tuple(_short_row(results, line, told) for line in short_lines(results))
    notes = []
    if any(row[BAR_COLUMN].bar is not None for row in rows):
        known = any(e.reference is not None for e in results.verdict.values())
        notes.append(
            "Bar: grey = 95 % range known before the log, coloured = 95 % interval after it"
            + (", orange mark = reference." if known else ".")
        )
    if rows:
        notes.append("Reasons and the priors' sources: Verdict in detail, below.")
    return filled(Table(COLUMNS, rows, note=" ".join(notes)))


def _rollover_lines(results: DriveResults) -> list[Line]:
    rollover = results.rollover
    named = (
        ("Static stability factor T/(2h)", rollover.static_stability_factor),
        ("Rollover threshold, quasi-static, in g", rollover.threshold_g),
    )
    return [Line(title, estimate, (estimate.name,)) for title, estimate in named if estimate is not None]


def _usual_source(estimates: Iterable[ParameterEstimate]) -> str | None:
    """A source that so many priors have that it is named once; None where there is no such one."""
    found = Counter(estimate.prior.source for estimate in estimates if estimate.prior is not None)
    source, times = found.most_common(1)[0] if found else ("", 0)
    return source if times >= MANY else None


def build_detail(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """The verdict with its reasons and every prior's source."""
    rows = []
    told: dict[str, str] = {}
    shown = (*lines(results), *_rollover_lines(results))
    usual = _usual_source([line.estimate for line in shown])
    for line in shown:
        estimate = line.estimate
        prior = estimate.prior
        source = clean(prior.source) if prior is not None and prior.source != usual else ""
        known = Cell(prior_text(estimate.name, prior), sub=source, tone="quiet")
        rows.append(
            (
                Cell(line.title),
                _value_cell(estimate),
                interval_cell(estimate),
                status_cell(estimate),
                Cell(_why(estimate, told)),
                known,
            )
        )
    note = f"Where a prior's source is not named, it is: {clean(usual)}." if usual else ""
    return (filled(Table(DETAIL_COLUMNS, tuple(rows), note=note, dense=True)),) if rows else ()


def summary(results: DriveResults) -> str:
    """How much the log told, in one or two sentences."""
    total = len(results.verdict)
    if total == 0:
        return "No parameter was asked for."
    number_of = {
        s: sum(e.status == s for e in results.verdict.values())
        for s in ("identified", "weak", "not_identifiable")
    }
    counts = (
        f"Of {count(total, 'parameter')}, this log identifies {number_of['identified']}, tells {number_of['weak']} weakly, "
        f"and cannot tell {number_of['not_identifiable']}."
    )
    cg = results.verdict.get(LEADING)
    if cg is None:
        return counts
    if not has_result(cg):
        why = re.split(r"; |: give ", _pointed(cg), maxsplit=1)[0]
        return f"{counts} It gives no CG height: {why.rstrip('.')}."
    low, high = (number(end, decimals_of(cg)) for end in (cg.low, cg.high))
    return f"CG height {value_text(cg)}, with 95{NARROW}% between {low} and {high} ({STATUS_WORDS[cg.status]}). {counts}"
