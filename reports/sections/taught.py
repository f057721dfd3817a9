"""What the drive taught: before and after, which relation brought it, whether the relations agree, what would help next."""

from __future__ import annotations

import math
from dataclasses import replace

from pipelines.drive_results import DriveResults
from pipelines.joint.conflict import WIDEST
from pipelines.results import JointVerdict, Learned, RelationCheck, Share
from reports.blocks import Bar, Block, Bullets, Cell, Column, Folded, Heading, Item, Paragraph, Table, Tone
from reports.sections.contract import Plots
from reports.sections.joint_words import (
    RARE,
    bits_text,
    chance,
    conflict_text,
    conflicts,
    is_conflict,
    learned_in_order,
    next_text,
    spread_text,
    std_of,
    times,
)
from reports.sections.values import (
    SINGLE_WHEELS,
    STATUS_TONES,
    deviation_text,
    has_result,
    prior_text,
    spread_value_text,
    value_text,
)
from reports.text import DASH, NO_BREAK, clean, count, number, seconds, sentence, spec_of, with_unit

INTRO = (
    "The verdict is one joint posterior over the vehicle: what was known before the drive, and every physical relation that "
    "the log supports, each counted once. One bit = half the spread."
)
MOST_SHARES = 2
MOST_ALERTS = 2
WIDENED = "Intervals are widened to hold what either side says."
FULL_BITS = 1.0
"""Of a full bar, at the least: the longest of hundredths of a bit is no long one."""
LEAST_BITS = 0.05
"""A relation that brought less is not worth a line."""

LEARNED_COLUMNS = (
    Column("Parameter", weight=1.6),
    Column("Known before", "right", 0),
    Column("After the drive", "right", 0),
    Column("Bits", "right", 0),
    Column("Brought by: bits lost without it (spread without it; by it alone)", weight=3.6),
    Column("What would help most next", weight=2.5),
)
LEARNED_NOTE = (
    "Before, after: value ± one standard deviation. Bits compare these two (0.1 bit is 7 % of a spread); where distributions are not "
    "normal they are sampled, to some 0.05 bit. A relation is named only where the spread without it is wider. What several relations tell alike is lost with none of them, so that their bits "
    "need not add up."
)
RELATION_COLUMNS = (
    Column("Relation", weight=2.3),
    Column("Seen by", weight=1.1),
    Column("Figures", "right", 0),
    Column("Misfit chi²", "right", 0),
    Column("By chance", "right", 0),
    Column("", "left", 0),
    Column("To agree", "right", 0),
    Column("In words", weight=2.6),
)
RELATIONS_NOTE = (
    "Misfit: what the relation says against what all others and the priors predict, in units of both spreads (chi²); about one for each "
    "figure where they agree. By chance: how often a misfit as large comes about when nothing is wrong. "
    "To agree: how much wider its spread would have to be."
)


def _share_text(name: str, share: Share) -> str:
    relation = clean(share.relation, 100)
    without = spread_text(name, share.std_without, unit=False)
    alone = (
        f"; alone {spread_text(name, share.std_alone, unit=False)}" if math.isfinite(share.std_alone) else ""
    )
    return f"{relation} {bits_text(share.bits)} ({without}{alone})".replace("± ", f"±{NO_BREAK}")


def _brought(name: str, learned: Learned) -> Cell:
    """The relations that brought most; where none is missed alone, the one that tells most alone."""
    if learned.bits < LEAST_BITS:
        # what a relation brought, and a conflict or a doubt took away again, is nothing learned
        return Cell(DASH, tone="quiet")
    shares = [s for s in learned.shares if math.isfinite(s.bits)]
    worth = sorted((s for s in shares if s.bits >= LEAST_BITS), key=lambda s: -s.bits)
    if worth:
        told = [sentence(_share_text(name, share)).rstrip(".") for share in worth[:MOST_SHARES]]
        if len(worth) > MOST_SHARES:
            told.append(f"and {len(worth) - MOST_SHARES} more")
        return Cell(told[0], lines=tuple(told[1:]))
    known = [s for s in shares if math.isfinite(s.std_alone)]
    if not known:
        return Cell(DASH, tone="quiet")
    best = min(known, key=lambda s: s.std_alone)
    alone = spread_text(name, best.std_alone)
    return Cell(
        sentence(f"several relations, none missed alone; {clean(best.relation, 100)} by itself {alone}"),
        tone="quiet",
    )


def _bits_cell(learned: Learned, most: float, tone: Tone) -> Cell:
    bits = learned.bits
    if not math.isfinite(bits):
        return Cell(DASH, tone="quiet")
    share = min(1.0, max(0.0, bits / max(most, FULL_BITS)))
    return Cell(bits_text(bits), kind="meter", bar=Bar(0.0, 100.0, 0.0, round(100 * share, 1), tone=tone))


def _learned_row(results: DriveResults, name: str, learned: Learned, most: float) -> tuple[Cell, ...]:
    estimate = results.verdict.get(name)
    std = std_of(results, name)
    following = learned.next
    if estimate is None:
        after = Cell(DASH, tone="quiet")
    elif has_result(estimate):
        value, deviation = value_text(estimate, unit=False), deviation_text(estimate)
        after = Cell(with_unit(f"{value}{NO_BREAK}{deviation}".replace(" ", NO_BREAK), spec_of(name).unit))
    else:
        after = Cell(f"({spread_value_text(estimate)})", sub="no result", tone="quiet")
    tone: Tone = "plain" if estimate is None else STATUS_TONES[estimate.status]
    return (
        Cell(spec_of(name).title),
        Cell(prior_text(name, learned.prior).replace(" ", NO_BREAK), tone="quiet"),
        after,
        _bits_cell(learned, most, tone),
        _brought(name, learned),
        Cell(next_text(name, following[0], std)) if following else Cell(DASH, tone="quiet"),
    )


def _learned_tables(results: DriveResults) -> list[Block]:
    """What was learned; single wheels, and every measurement that would help, behind a fold."""
    found = learned_in_order(results)
    most = max((entry.bits for _, entry in found if math.isfinite(entry.bits)), default=0.0)
    rows = [(name, _learned_row(results, name, entry, most)) for name, entry in found]
    blocks: list[Block] = []
    for wheels in (False, True):
        chosen = tuple(row for name, row in rows if name.startswith(SINGLE_WHEELS) == wheels)
        if not chosen:
            continue
        table = Table(LEARNED_COLUMNS, chosen, note="" if wheels else LEARNED_NOTE, dense=True)
        blocks.append(Folded("The same for single wheels", (table,)) if wheels else table)
    helpful = [
        (
            Cell(spec_of(name).title if place == 0 else ""),
            Cell(sentence(next_text(name, measurement, std_of(results, name)))),
        )
        for name, entry in found
        for place, measurement in enumerate(entry.next)
        if len(entry.next) > 1
    ]
    if helpful:
        columns = (
            Column("Parameter", weight=1),
            Column("Measurement, and the spread that it would leave", weight=3),
        )
        blocks.append(
            Folded("All measurements that would help", (Table(columns, tuple(helpful), dense=True),))
        )
    return blocks


def _verdict_of(check: RelationCheck) -> Cell:
    if is_conflict(check):
        return Cell("conflict", kind="badge", tone="bad")
    if not (math.isfinite(check.chi2) and math.isfinite(check.probability)):
        return Cell("not checked", kind="badge", tone="quiet")
    if check.probability < RARE:
        return Cell("strained", kind="badge", tone="warn")
    return Cell("agrees", kind="badge", tone="good")


def _wider(check: RelationCheck) -> str:
    return "no spread would do" if check.widened >= WIDEST else f"{times(check.widened)} as wide"


def _relation_row(check: RelationCheck) -> tuple[Cell, ...]:
    return (
        Cell(sentence(clean(check.relation, 120)).rstrip(".")),
        Cell(clean(check.source, 80), tone="quiet"),
        Cell(str(check.numbers)),
        Cell(number(check.chi2, 1)),
        Cell(chance(check.probability)),
        _verdict_of(check),
        Cell(_wider(check) if is_conflict(check) else DASH),
        Cell(sentence(check.text, 500)),
    )


def _relations(joint: JointVerdict) -> list[Block]:
    """The relations, those in conflict first; then those that were left out, and why."""
    blocks: list[Block] = []
    if joint.relations:
        rows = tuple(_relation_row(c) for c in sorted(joint.relations, key=lambda c: not is_conflict(c)))
        blocks += [
            Heading("Do the relations agree?"),
            Table(RELATION_COLUMNS, rows, note=RELATIONS_NOTE, dense=True),
        ]
    if joint.not_counted:
        left_out = tuple(
            (Cell(sentence(name, 160).rstrip(".")), Cell(sentence(why, 400)))
            for name, why in joint.not_counted
        )
        columns = (Column("Relation", weight=1.2), Column("Why it was not counted", weight=1.6))
        blocks += [Heading("Relations that were not counted"), Table(columns, left_out, dense=True)]
    return blocks


def _method(joint: JointVerdict) -> Paragraph:
    words = [f"Posterior: {clean(joint.method, 500)}" if joint.method else "Posterior: joint"]
    if math.isfinite(joint.inflation) and abs(joint.inflation - 1.0) > 0.005:
        words.append(
            f"all spreads multiplied by {number(joint.inflation, 2)} as the relations fit worse than their spreads allow"
        )
    if joint.runtime_s > 0:
        words.append(f"found in {seconds(joint.runtime_s)}")
    return Paragraph(sentence("; ".join(words), 900), "quiet")


def alerts(results: DriveResults) -> tuple[Item, ...]:
    """What stands above the verdict: conflicts between relations, what the drive speaks for, and unknowns far from what was known."""
    found = [Item(conflict_text(check), "conflict", "bad") for check in conflicts(results.joint)]
    more = len(found) - MOST_ALERTS
    if more > 0:
        found[MOST_ALERTS:] = [
            Item(f"{count(more, 'more relation')} in conflict: see What the drive taught.", "conflict", "bad")
        ]
    if found:
        found[-1] = replace(found[-1], text=f"{found[-1].text} {WIDENED}")
    spoke_for, far = ((), ()) if results.joint is None else (results.joint.spoke_for, results.joint.far)
    found += [Item(sentence(text, 300), "unusual", "warn") for text in spoke_for]
    if far:
        text = "; ".join(clean(entry, 120) for entry in far[:MOST_ALERTS])
        found.append(Item(sentence(f"ended far from what was known: {text}", 500), "unusual", "warn"))
    return tuple(found)


ODDS = (
    "Odds are shares among the causes that cogest weighs (docs/verdict.md lists them). Where the true cause is none of these, "
    "the nearest one gets its share: read them as where to look first."
)


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """The chapter; nothing where no joint posterior was made."""
    joint = results.joint
    if joint is None:
        return ()
    figures = {plot.name: plot for plot in plots.get("taught", ())}
    blocks: list[Block] = []
    if not joint.learned:
        blocks.append(
            Paragraph(
                "The log supports no relation that tells anything of the vehicle: all stays as it was known."
            )
        )
    blocks += _learned_tables(results)
    blocks += figures.values()
    blocks += _relations(joint)
    for title, texts in (
        ("What the drive speaks for", joint.spoke_for),
        ("What ended far from what was known", joint.far),
    ):
        if texts:
            items = tuple(Item(sentence(text, 500), "unusual", "warn") for text in texts)
            blocks += [Heading(title), Bullets(items)]
    if any("(odds " in text for text in (*joint.spoke_for, *joint.far)):
        blocks.append(Paragraph(ODDS))
    blocks.append(_method(joint))
    return tuple(blocks)
