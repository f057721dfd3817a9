"""Everything that was taken as given, and where it came from."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import chain

from pipelines.drive_results import DriveResults
from pipelines.results import Assumption
from reports.blocks import Block, Cell, Column, Folded, Heading, Paragraph, Table
from reports.sections.contract import Plots
from reports.sections.given_words import capital, file_key, given
from reports.text import clean

INTRO = (
    "A result is no better than these. Put better figures in the vehicle file and run again. What was known before of the verdict's own "
    "parameters stands under Verdict in detail."
)
MOST = 150
MOST_USERS = 200
"""Characters of the list of who used an entry."""


@dataclass
class Entry:
    """A quantity or choice as it is printed: once, whatever names, digits and methods it comes with."""

    words: str
    measured: bool
    values: list[str] = field(default_factory=list)
    sources: list[str] = field(default_factory=list)
    users: list[str] = field(default_factory=list)
    key: str = ""


def _add(texts: list[str], text: str) -> None:
    if text and text not in texts:
        texts.append(text)


def _merged(found: Iterable[tuple[Assumption, str]]) -> list[Entry]:
    """Each quantity once, in the order of first use, with all that differs in it."""
    merged: dict[tuple[str, bool], Entry] = {}
    for assumption, who in found:
        told = given(assumption.name, assumption.value)
        entry = merged.setdefault((told.words, told.measured), Entry(told.words, told.measured))
        _add(entry.values, told.value)
        _add(entry.sources, clean(assumption.source, 240))
        _add(entry.users, who)
        entry.key = entry.key or file_key(assumption.name)
    return list(merged.values())


def _more(found: int, most: int) -> str:
    return f"{found - most} more are in results.json." if found > most else ""


def _table(entries: list[Entry], heading: str) -> Table:
    rows = tuple(
        (
            Cell(entry.words),
            Cell("; ".join(entry.values)),
            Cell(capital("; ".join(entry.sources)), tone="quiet"),
        )
        for entry in entries[:MOST]
    )
    columns = (Column(heading, weight=2.2), Column("Taken as", weight=2.6), Column("Where from", weight=2.8))
    return Table(columns, rows, note=_more(len(entries), MOST), dense=True)


def _users(entries: list[Entry]) -> Table:
    """Who used what, and by which key the vehicle file changes it."""
    rows = tuple(
        (
            Cell(entry.words),
            Cell(entry.key, kind="code") if entry.key else Cell(""),
            Cell(clean(", ".join(entry.users) or "all", MOST_USERS), tone="quiet"),
        )
        for entry in entries[:MOST]
    )
    columns = (
        Column("Quantity or choice", weight=2.2),
        Column("In the vehicle file", weight=2),
        Column("Used by", weight=3),
    )
    return Table(columns, rows, note=_more(len(entries), MOST), dense=True)


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """Figures, then choices, each once; behind a fold who used them, and the vehicle file's keys."""
    of_estimators = ((a, e.estimator) for e in results.estimates for a in e.assumptions)
    entries = _merged(chain(of_estimators, ((a, "") for a in results.assumptions)))
    if not entries:
        return (Paragraph("Nothing: no estimator that ran took anything as given.", "quiet"),)
    blocks: list[Block] = []
    for title, heading, measured in (
        ("Figures", "Quantity", True),
        ("Choices, models and sensors", "Of what", False),
    ):
        chosen = [entry for entry in entries if entry.measured == measured]
        if chosen:
            blocks += [Heading(title), _table(chosen, heading)]
    blocks.append(Folded("Who used what, and its key in the vehicle file", (_users(entries),)))
    return tuple(blocks)
