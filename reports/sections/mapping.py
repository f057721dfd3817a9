"""Which channel became which signal, in which unit, and why."""

from __future__ import annotations

from parsers.drive import MappedChannel
from parsers.signals import SIGNALS
from pipelines.results import DriveResults
from reports.blocks import Block, Bullets, Cell, Column, Heading, Item, Paragraph, Table
from reports.sections.contract import Plots
from reports.text import clean, number, sentence, significant, with_unit

MOST = 200
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


def _conversion(mapped: MappedChannel) -> Cell:
    parts = []
    if mapped.scale != 1.0:
        parts.append(f"× {significant(mapped.scale, 5)}")
    if mapped.offset != 0.0:
        parts.append(f"{'+' if mapped.offset > 0 else ''}{significant(mapped.offset)}")
    return Cell(", ".join(parts) or "as it is", sub="inverted" if mapped.inverted else "")


def _row(mapped: MappedChannel) -> tuple[Cell, ...]:
    spec = SIGNALS.get(mapped.signal)
    others = ", ".join(clean(a, 80) for a in mapped.alternatives[:4])
    more = f" and {len(mapped.alternatives) - 4} more" if len(mapped.alternatives) > 4 else ""
    return (
        Cell(clean(mapped.signal, 60), sub=spec.description if spec else ""),
        Cell(clean(mapped.channel, 160), kind="code"),
        Cell(clean(mapped.unit, 30) or "none", sub=f"from: {clean(mapped.unit_from, 80)}"),
        Cell(clean(mapped.rule, 80)),
        Cell(number(float(mapped.samples), 0)),
        Cell(with_unit(significant(mapped.rate_hz), "Hz")),
        _conversion(mapped),
        Cell(others + more or "—", tone="quiet"),
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
    return (Table(COLUMNS, tuple(_row(m) for m in mapped[:MOST]), note=note), *blocks)
