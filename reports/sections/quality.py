"""Data quality: what was read, what was not, and what the checks against physics found and did."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from parsers.drive import Decision, Gap, ImportRecord
from pipelines.drive_results import DriveResults
from reports.blocks import Block, Bullets, Cell, Column, Fact, Facts, Heading, Item, Paragraph, Table, Tone
from reports.gap_text import LOST
from reports.sections.contract import Plots
from reports.text import clean, count, gist, number, seconds, sentence

STATUS_TONES: dict[str, Tone] = {"complete": "good", "truncated": "warn", "malformed": "bad"}
STATUS_WORDS = {
    "complete": "read to the end",
    "truncated": "the log breaks off; all that is whole was read",
    "malformed": "the log is damaged; what is whole was read",
}
MOST_ON_CARD = 4
SHORT_EVIDENCE = 44
UNCHECKED = "not checked against physics: "
"""How a note of the import begins that names the checks which had too little to go by."""
MOST_DECISIONS = 100
MOST_GAPS = 40
MOST_REASONS = 30
LEFT_OUT = "left out"
"""How an action begins that leaves a signal out."""


def decision_item(decision: Decision) -> Item:
    """A decision as a sentence with its evidence, and whether it was carried out."""
    found = clean(decision.found).rstrip(".")
    action = clean(decision.action).rstrip(".")
    evidence = f" ({clean(decision.evidence).rstrip('.')})" if decision.evidence else ""
    signal = clean(decision.signal, 60)
    if not signal:
        # of the drive as a whole, not of one signal
        found = sentence(found).rstrip(".")
    lead = "" if not signal or signal.lower() in found.lower() else f"{signal}: "
    text = f"{lead}{found}{evidence}: {action}." if action else f"{lead}{found}{evidence}."
    if not decision.applied:
        return Item(text, "only reported", "warn")
    left = action.startswith(LEFT_OUT)
    return Item(text, LEFT_OUT, "warn") if left else Item(text, "corrected", "good")


def _place_on_card(decision: Decision) -> int:
    """What needs a reader first: doubts left open, then signs and units, then the rest; offsets are everyday."""
    if decision.kind == "offset":
        return 3
    return 0 if not decision.applied else 1 if decision.kind in ("sign", "unit") else 2


def _card_items(decisions: Sequence[Decision]) -> list[Item]:
    """The decisions in short, the weightiest first; offsets that were treated alike share a line."""
    offsets: dict[tuple[str, bool], list[Decision]] = {}
    items = []
    for decision in sorted(decisions, key=_place_on_card):
        if decision.kind == "offset":
            offsets.setdefault((decision.action, decision.applied), []).append(decision)
        else:
            items.append(decision_item(replace(decision, evidence=gist(decision.evidence, SHORT_EVIDENCE))))
    for alike in offsets.values():
        found = "; ".join(clean(d.found).rstrip(".") for d in alike)
        merged = replace(alike[0], found=found, evidence=alike[0].evidence if len(alike) == 1 else "")
        item = decision_item(merged)
        items.append(item if merged.applied else replace(item, tone="quiet"))
    return items


def total_gap_s(gaps: Sequence[Gap], signal: str | None = None) -> float:
    """Seconds in gaps of the whole drive, or of one sort, overlaps counted once."""
    total, reach = 0.0, float("-inf")
    for gap in sorted((g for g in gaps if g.signal == signal), key=lambda g: g.start_s):
        total += max(0.0, gap.end_s - max(gap.start_s, reach))
        reach = max(reach, gap.end_s)
    return total


def _gap_fact(record: ImportRecord) -> Fact:
    whole = [g for g in record.gaps if g.signal is None]
    lost = [g for g in record.gaps if g.signal == LOST]
    single = len(record.gaps) - len(whole) - len(lost)
    if lost:
        rest = [f"{count(len(whole), 'gap')} besides"] if whole else []
        rest += [f"{count(single, 'gap')} in single signals"] if single else []
        return Fact("Lost to damage", seconds(total_gap_s(lost, LOST)), "; ".join(rest), tone="warn")
    text = count(len(whole), "gap") if whole else "none"
    if whole:
        text += f", {seconds(total_gap_s(whole))} in all"
    return Fact(
        "Gaps",
        text,
        f"{count(single, 'more gap' if whole else 'gap')} in single signals" if single else "",
        tone="warn" if whole else "plain",
    )


def facts(record: ImportRecord) -> Facts:
    """The record's figures."""
    rejected = sum(record.rejected.values())
    reasons = "; ".join(
        f"{number(float(n), 0)} × {clean(why, 80)}" for why, n in list(record.rejected.items())[:3]
    )
    return Facts(
        (
            Fact("Log", record.status, STATUS_WORDS[record.status], tone=STATUS_TONES[record.status]),
            Fact("Read", count(record.messages, "message or row", "messages or rows"), f"{seconds(record.duration_s)} as {clean(record.format, 40)}"),
            Fact("Rejected", number(float(rejected), 0) if rejected else "none", reasons, tone="warn" if rejected else "plain"),
            _gap_fact(record),
            Fact("Clock", clean(record.clock, 120), ", ".join(record.disorder)),
        )
    )  # fmt: skip


def card(results: DriveResults) -> tuple[Block, ...]:
    """The first screen's card with the figures of the import."""
    return (facts(results.record),)


def checks_card(results: DriveResults) -> tuple[Block, ...]:
    """The first screen's card with the decisions in short; all of each stands under Data quality."""
    found = _card_items(results.record.decisions)
    items = found[:MOST_ON_CARD]
    if len(found) > MOST_ON_CARD:
        items.append(Item(f"{len(found) - MOST_ON_CARD} more under Data quality.", tone="quiet"))
    items += [
        Item(gist(note.removeprefix(UNCHECKED), 110), "not checked", "quiet")
        for note in _unchecked(results.record)
    ]
    if not results.record.mapped:
        return (Paragraph("No signal to check.", "quiet"),)
    if not found:
        words = (
            "Nothing found in what could be checked."
            if items
            else "Nothing found: signs, units and ranges agree."
        )
        return (Paragraph(words, "quiet"), Bullets(tuple(items))) if items else (Paragraph(words, "quiet"),)
    return (Bullets(tuple(items)),)


def _unchecked(record: ImportRecord) -> list[str]:
    return [note for note in record.notes if note.startswith(UNCHECKED)]


def _gap_table(record: ImportRecord) -> Table:
    longest = sorted(record.gaps, key=lambda g: g.start_s - g.end_s)[:MOST_GAPS]
    rows = tuple(
        (
            Cell(clean(g.signal, 60) if g.signal else "all signals"),
            Cell(seconds(g.start_s)),
            Cell(seconds(g.end_s)),
            Cell(seconds(g.end_s - g.start_s)),
        )
        for g in sorted(longest, key=lambda g: g.start_s)
    )
    note = (
        f"The {MOST_GAPS} longest of {len(record.gaps)}; all are in results.json."
        if len(record.gaps) > MOST_GAPS
        else ""
    )
    columns = (
        Column("Gap in"),
        Column("From", "right", 0),
        Column("To", "right", 0),
        Column("Length", "right", 0),
    )
    return Table(columns, rows, note=note)


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """The chapter: every decision, every reason for a rejection, gaps and notes."""
    record = results.record
    blocks: list[Block] = []
    if record.decisions:
        items = [decision_item(d) for d in record.decisions[:MOST_DECISIONS]]
        if len(record.decisions) > MOST_DECISIONS:
            items.append(
                Item(f"{len(record.decisions) - MOST_DECISIONS} more are in results.json.", tone="quiet")
            )
        blocks += [Heading("What the checks found"), Bullets(tuple(items))]
    if record.rejected:
        pairs = sorted(record.rejected.items(), key=lambda p: -p[1])[:MOST_REASONS]
        rows = tuple((Cell(clean(why)), Cell(number(float(n), 0))) for why, n in pairs)
        blocks += [
            Heading("What was rejected"),
            Table((Column("Reason"), Column("Rows or messages", "right", 0)), rows),
        ]
    if record.gaps:
        blocks += [Heading("Gaps"), _gap_table(record)]
    notes = dict.fromkeys((*record.notes, *results.notes))
    if notes:
        shown = [Item(sentence(note)) for note in list(notes)[:MOST_DECISIONS]]
        blocks += [Heading("Notes"), Bullets(tuple(shown))]
    return tuple(blocks) or (Paragraph("Nothing was rejected, missing, corrected or worth a note.", "quiet"),)
