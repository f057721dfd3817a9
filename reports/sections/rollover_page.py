"""The chapter on rollover: limits to both sides, margins, wheel lift, probability, and what it all rests on."""

from __future__ import annotations

from pipelines.drive_results import DriveResults
from pipelines.results import ParameterEstimate
from pipelines.rollover_results import Rollover, TurnMargin, WheelLift
from reports.blocks import Block, Bullets, Cell, Column, Heading, Item, Paragraph, Table, Tone
from reports.sections.contract import Plots
from reports.sections.values import NORMAL_95, has_result
from reports.text import DASH, NARROW, clean, count, decimals_for, number, seconds, sentence, span, with_unit

INTRO = (
    "How hard this vehicle, loaded as it was, may be turned before the wheels of one side carry nothing, and how near the drive came. "
    "In a left turn the left wheels lift. Quasi-static: no curb, no trip, no soft ground."
)
LIMITS_NOTE = "Below each value its 95 % interval, which follows from those of the CG height, the track, the CG's lateral offset and the body's roll."
TURNS_NOTE = (
    "Least margin: the limit at that moment's body roll less the lateral acceleration (turned harder the body rolls on, and the limit falls to the threshold); "
    "below zero, the wheels of that side carried nothing. "
    "Share moved across: 1 = all weight on the outer wheels. Reached: probability that it got there at any time."
)
MOST_EVENTS = 30
KINDS = {
    "side": "both wheels of a side, in a turn",
    "wheel": "one wheel, in a turn",
    "bounce": "bounce on the road",
}
TONES: dict[str, Tone] = {"side": "bad", "wheel": "warn", "bounce": "quiet"}


def _decimals(estimate: ParameterEstimate) -> int:
    half = None if estimate.low is None or estimate.high is None else 0.5 * (estimate.high - estimate.low)
    if half is None and estimate.std is not None:
        half = NORMAL_95 * estimate.std
    return min(3, max(2, decimals_for(half, 2)))


def figure_cell(estimate: ParameterEstimate, unit: str = "") -> Cell:
    """A value with its interval below; what is no result, as the CG height is none, in brackets."""
    if estimate.value is None:
        return Cell(DASH, tone="quiet")
    decimals = _decimals(estimate)
    value = with_unit(number(estimate.value, decimals), unit)
    interval = span(estimate.low, estimate.high, decimals)
    if not has_result(estimate):
        return Cell(f"({value})", sub=f"no result: {interval}", tone="quiet")
    return Cell(value, sub=interval)


def _limits(rollover: Rollover) -> Table:
    rows = tuple(
        (
            Cell(clean(limit.title, 80), sub=clean(limit.left.reason)),
            Cell(clean(limit.equation, 30), tone="quiet"),
            figure_cell(limit.left, "g"),
            figure_cell(limit.right, "g"),
        )
        for limit in rollover.limits
    )
    head = (
        Column("Limit of the lateral acceleration", weight=3.2),
        Column("Equation", weight=0.8),
        Column("Left turn", "right", 0),
        Column("Right turn", "right", 0),
    )
    return Table(head, rows)


def _chance(probability: float) -> str:
    if probability < 0.01:
        return f"< 1{NARROW}%"
    if probability > 0.99:
        return f"> 99{NARROW}%"
    return f"{number(100 * probability, 0)}{NARROW}%"


def _turns(turns: tuple[TurnMargin, ...]) -> Table:
    rows = tuple(
        (
            Cell(f"{turn.turn.capitalize()} turns", sub=f"{turn.turn} wheels lift"),
            figure_cell(turn.threshold_g, "g"),
            Cell(
                with_unit(number(abs(turn.lateral_acceleration_g), 2), "g"), sub=f"at {seconds(turn.time_s)}"
            ),
            figure_cell(turn.least_margin_g, "g"),
            figure_cell(turn.peak_coefficient),
            Cell(_chance(turn.probability)),
        )
        for turn in turns
    )
    head = (
        Column("", weight=1.4), Column("Threshold", "right", 0), Column("Drive, nearest", "right", 0), Column("Least margin", "right", 0),
        Column("Share moved across", "right", 0), Column("Reached?", "right", 0),
    )  # fmt: skip
    return Table(head, rows)


def _event(event: WheelLift) -> tuple[Cell, ...]:
    wheel = f"{event.wheel} wheels" if event.wheel in ("left", "right") else clean(event.wheel, 8).upper()
    force = DASH if event.least_force_n is None else with_unit(number(event.least_force_n, 0), "N")
    turn = (
        DASH
        if event.lateral_acceleration_g is None
        else with_unit(number(event.lateral_acceleration_g, 2), "g")
    )
    return (
        Cell(wheel), Cell(KINDS[event.kind], kind="badge", tone=TONES[event.kind]), Cell(seconds(event.start_s)),
        Cell(seconds(event.duration_s)), Cell(force), Cell(turn), Cell(_chance(event.probability)),
    )  # fmt: skip


def _lifts(rollover: Rollover) -> tuple[Block, ...]:
    """The events, the turns' first, then the longest bounces; or that there are none, and why that is known."""
    if not rollover.lifts:
        known = rollover.lift_source and not rollover.lift_source.startswith("not known")
        text = (
            f"No wheel lift found. Forces: {rollover.lift_source}"
            if known
            else f"Wheel lift is {rollover.lift_source or 'not known'}"
        )
        return (Paragraph(sentence(clean(text))),)
    chosen = sorted(rollover.lifts, key=lambda e: (e.kind == "bounce", -e.duration_s))[:MOST_EVENTS]
    rows = tuple(_event(e) for e in sorted(chosen, key=lambda e: e.start_s))
    head = (
        Column("Wheel", weight=0.8), Column("Kind", weight=1.6), Column("From", "right", 0), Column("For", "right", 0),
        Column("Least force", "right", 0), Column("Lateral", "right", 0), Column("Sure", "right", 0),
    )  # fmt: skip
    more = len(rollover.lifts) - len(rows)
    left = f" {count(more, 'shorter unloading')} not listed; all are in results.json." if more else ""
    return (Table(head, rows, note=sentence(f"Forces: {clean(rollover.lift_source)}") + left),)


def _headline(rollover: Rollover) -> Paragraph:
    """The answer in one or two sentences."""
    if not rollover.turns:
        told = rollover.exceedance
        why = (
            told.text
            if told is not None
            else "not known: this archive was stored before the margin was computed"
        )
        text = sentence(f"How near the drive came to its rollover threshold is {clean(why)}")
        if rollover.peak_lateral_acceleration_g is not None:
            peak = with_unit(number(rollover.peak_lateral_acceleration_g, 2), "g")
            text += f" Its largest lateral acceleration was {peak}, at {seconds(rollover.peak_time_s)}."
        if not rollover.limits:
            text += " It takes the CG height (a log with braking or lively roll, and what the vehicle file knows) and track_front_m, track_rear_m."
        return Paragraph(text)
    nearest = min(
        rollover.turns, key=lambda t: t.least_margin_g.value if t.least_margin_g.value is not None else 9.0
    )
    margin = nearest.least_margin_g
    decimals = _decimals(margin)
    gap = margin.value or 0.0
    came = (
        f"within {number(gap, decimals)}{NARROW}g of"
        if gap >= 0
        else f"{number(-gap, decimals)}{NARROW}g beyond"
    )
    text = (
        f"The drive came {came} the limit, at its body's roll then, in a {nearest.turn} turn at {seconds(nearest.time_s)} "
        f"(95{NARROW}% between {number(margin.low, decimals)} and {number(margin.high, decimals)}{NARROW}g of margin)."
    )
    if rollover.exceedance is not None and rollover.exceedance.probability is not None:
        text += f" Probability that a side's wheels carried nothing at any time: {clean(rollover.exceedance.text, 60)}."
    if not has_result(margin):
        text += " These figures rest on what was known before the log, not on this drive's CG height."
    return Paragraph(text)


def _basis(rollover: Rollover) -> tuple[Block, ...]:
    """What the figures rest on."""
    items = [Item(sentence(clean(note))) for note in rollover.notes]
    if rollover.exceedance is not None:
        items += [Item(sentence(clean(text))) for text in rollover.exceedance.assumptions]
    items += [
        Item(sentence(f"{clean(a.name.removeprefix('rollover: '))}: {clean(a.value)} ({clean(a.source)})"))
        for a in rollover.assumptions
    ]
    return (Heading("What this rests on"), Bullets(tuple(items))) if items else ()


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """The chapter's blocks."""
    rollover = results.rollover
    figures = {plot.name: plot for plot in plots.get("rollover", ())}
    blocks: list[Block] = [_headline(rollover)]
    if rollover.limits:
        blocks += [
            _limits(rollover),
            Paragraph(LIMITS_NOTE, "quiet"),
            *(figures[n] for n in ("rollover_limits",) if n in figures),
        ]
    if rollover.turns:
        blocks += [Heading("How near the drive came"), _turns(rollover.turns), Paragraph(TURNS_NOTE, "quiet")]
    if rollover.traces:
        blocks += [figures[n] for n in ("rollover_margin", "rollover_coefficient") if n in figures]
    if rollover.check is not None:
        tone: Tone = "plain" if rollover.check.consistent else "warn"
        blocks += [
            Heading("Tyre forces against the verdict"),
            Paragraph(sentence(clean(rollover.check.text)), tone),
        ]
    blocks += [Heading("Wheel lift"), *_lifts(rollover), *_basis(rollover)]
    return tuple(blocks)
