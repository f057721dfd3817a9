"""Which channel became which signal, in which unit, and why."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby

from parsers.drive import MappedChannel
from parsers.signals import SIGNALS, WHEELS
from pipelines.drive_results import DriveResults
from reports.blocks import (
    Block,
    Bullets,
    Cell,
    Column,
    Fact,
    Facts,
    Folded,
    Heading,
    Item,
    Paragraph,
    Table,
    filled,
)
from reports.sections.contract import Plots
from reports.text import clean, number, sentence, significant, with_unit

MOST = 200
CANONICAL = "canonical"
"""How the rule begins where a column has the signal's own name, unit and all."""
COLUMNS = (
    Column("Signal", weight=1.5),
    Column("Channel", weight=2),
    Column("Unit", weight=1.1),
    Column("Rule", weight=1.1),
    Column("Samples", "right", 0),
    Column("Rate", "right", 0),
    Column("Scale, offset", "right", 0),
    Column("Could have been", weight=1.5),
)


_WHEEL = re.compile(r", wheel (fl|fr|rl|rr)$")


def _conversion(mapped: MappedChannel) -> Cell:
    parts = []
    if mapped.scale != 1.0:
        parts.append(f"× {significant(mapped.scale, 5)}")
    if mapped.offset != 0.0:
        parts.append(f"{'+' if mapped.offset > 0 else ''}{significant(mapped.offset)}")
    return Cell(", ".join(parts) or "as it is", sub="inverted" if mapped.inverted else "")


def _others(mapped: MappedChannel) -> str:
    others = ", ".join(clean(a, 80) for a in mapped.alternatives[:4])
    return others + (f" and {len(mapped.alternatives) - 4} more" if len(mapped.alternatives) > 4 else "")


def _row(mapped: MappedChannel) -> tuple[Cell, ...]:
    source = clean(mapped.unit_from, 80)
    rule = clean(mapped.rule.replace(f" {mapped.channel!r}", ""), 80)
    return (
        Cell(clean(mapped.signal, 60)),
        Cell(clean(mapped.channel, 160), kind="code"),
        Cell(clean(mapped.unit, 30) or "none", sub="" if rule.startswith(CANONICAL) else f"from: {source}"),
        Cell(rule),
        Cell(number(float(mapped.samples), 0)),
        Cell(with_unit(significant(mapped.rate_hz), "Hz")),
        _conversion(mapped),
        Cell(_others(mapped) or "—", tone="quiet"),
    )


def _alike(mapped: MappedChannel) -> object:
    """What columns with their signals' own names at the four wheels have in common; others are alike to none."""
    stem, _, wheel = mapped.signal.rpartition("_")
    if wheel not in WHEELS or not mapped.rule.startswith(CANONICAL) or mapped.alternatives:
        return mapped
    return (
        stem, mapped.unit, mapped.samples, mapped.rate_hz, mapped.scale, mapped.offset, mapped.inverted, mapped.used,
        mapped.channel.replace(f"_{wheel}", ""),
    )  # fmt: skip


def _rows(mapped: Sequence[MappedChannel]) -> tuple[tuple[Cell, ...], ...]:
    """A row a signal; the four wheels share one where nothing but the name differs."""
    rows = []
    for _, run in groupby(mapped, _alike):
        group = list(run)
        first, *rest = _row(group[0])
        more = "".join(f", {m.signal.rpartition('_')[2]}" for m in group[1:])
        rows.append((replace(first, text=first.text + more), *rest))
    return tuple(rows)


def _described(mapped: Sequence[MappedChannel]) -> tuple[Fact, ...]:
    """What each signal is, once for all wheels."""
    found: dict[str, list[str]] = {}
    for channel in mapped:
        spec = SIGNALS.get(channel.signal)
        if spec is not None and spec.description:
            found.setdefault(_WHEEL.sub("", spec.description), []).append(channel.signal)
    return tuple(
        Fact(names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more", sentence(text))
        for text, names in found.items()
    )


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """The mapping table."""
    mapped = results.record.mapped
    if not mapped:
        text = "no channel of the log became a signal; `cogest inspect --write-map` writes a starter mapping file"
        return (Paragraph(sentence(text), "warn"),)
    blocks: list[Block] = []
    measured = {m.signal for m in mapped}
    derived = [t for t in results.signals if t.name in SIGNALS and t.name not in measured]
    if derived:
        items = [
            Item(f"{t.name}: {clean(t.note) or 'derived from other signals'}", "derived", "quiet")
            for t in derived
        ]
        blocks += [Heading("Signals made from others"), Bullets(tuple(items))]
    note = f"{len(mapped) - MOST} more are in results.json." if len(mapped) > MOST else ""
    facts = _described(mapped[:MOST])
    if facts:
        blocks.append(Folded("What these signals are", (Facts(facts, prose=True),), elsewhere="report.html"))
    return (filled(Table(COLUMNS, _rows(mapped[:MOST]), note=note, dense=True)), *blocks)
