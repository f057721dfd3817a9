"""Static rollover measures, how near the drive came, and what NHTSA's old rating said of such a factor."""

from __future__ import annotations

import math
from dataclasses import replace

from pipelines.drive_results import DriveResults
from pipelines.results import ParameterEstimate
from reports.blocks import Block, Bullets, Fact, Facts, Item, Paragraph
from reports.sections.values import STATUS_TONES, STATUS_WORDS, has_result
from reports.text import DASH, clean, count, decimals_for, number, seconds, sentence, span, with_unit

BANDS: tuple[tuple[float, int, str], ...] = (
    (1.45, 5, "less than 10 %"),
    (1.25, 4, "10 to 20 %"),
    (1.13, 3, "20 to 30 %"),
    (1.04, 2, "30 to 40 %"),
    (-math.inf, 1, "40 % or more"),
)
"""NHTSA's rating of model years 2001-2003 by the static stability factor alone: least factor, stars, share of
single-vehicle crashes with a rollover (66 FR 3388, 12 January 2001; bands in hundredths, so 1.04 means 1.035 up)."""


def band_of(factor: float) -> tuple[int, str]:
    """Stars and risk of a factor under the rating of 2001-2003, which read two decimals."""
    rounded = round(factor, 2)
    return next((stars, risk) for least, stars, risk in BANDS if rounded >= least)


def nhtsa_context(factor: ParameterEstimate) -> str:
    """Careful words on what the old rating would have said; the interval, not only the value, is placed."""
    if factor.value is None or not has_result(factor):
        return ""
    stars, risk = band_of(factor.value)
    text = (
        f"For scale: NHTSA's rating of cars and light trucks of model years 2001–2003 gave such a factor {stars} of 5 stars "
        f"(a rollover in {risk} of single-vehicle crashes)"
    )
    if factor.low is not None and factor.high is not None:
        worst, best = band_of(factor.low)[0], band_of(factor.high)[0]
        if worst != best:
            text += f"; the 95 % interval reaches from {worst} to {best} stars"
    return (
        text + ". Since 2004 a driving test counts too; this is no rating of this vehicle, loaded as it was."
    )


def _fact(label: str, estimate: ParameterEstimate | None, unit: str) -> Fact:
    if estimate is None or estimate.value is None or not has_result(estimate):
        reason = clean(estimate.reason) if estimate is not None else "needs the CG height and the track"
        if estimate is not None and estimate.value is not None and estimate.low is not None:
            reason = f"no result: {span(estimate.low, estimate.high, 2)}"
        return Fact(label, DASH, reason, tone="quiet")
    half = None if estimate.low is None or estimate.high is None else 0.5 * (estimate.high - estimate.low)
    decimals = min(3, max(1, decimals_for(half, 2)))
    parts = [f"95 %: {span(estimate.low, estimate.high, decimals)}"] if half is not None else []
    parts.append(STATUS_WORDS[estimate.status])
    return Fact(
        label,
        with_unit(number(estimate.value, decimals), unit),
        " · ".join(parts),
        tone=STATUS_TONES[estimate.status],
    )


def _margin(results: DriveResults) -> Fact | None:
    """The nearer side's least margin; None where no margin is known."""
    known = [t for t in results.rollover.turns if t.least_margin_g.value is not None]
    if not known:
        return None
    nearest = min(known, key=lambda t: t.least_margin_g.value or 0.0)
    fact = _fact("Least margin", nearest.least_margin_g, "g")
    return replace(
        fact, sub=f"{nearest.turn} turn at {seconds(nearest.time_s)}, at the body's roll then · {fact.sub}"
    )


def _lifted(results: DriveResults) -> Fact | None:
    """How often wheels lifted in turns, where tyre forces or load transfer tell."""
    rollover = results.rollover
    if not rollover.lift_source or rollover.lift_source.startswith("not known"):
        return None
    turning = [e for e in rollover.lifts if e.kind != "bounce"]
    if not turning:
        return Fact("Wheel lift in turns", "none found", "")
    both = sum(e.kind == "side" for e in turning)
    words = "both wheels of a side among them" if both else "single wheels only"
    return Fact("Wheel lift in turns", count(len(turning), "event"), words, tone="bad" if both else "warn")


def build(results: DriveResults) -> tuple[Block, ...]:
    """The card's blocks."""
    rollover = results.rollover
    facts: list[Fact | None] = [
        _fact("Static stability factor T/(2h)", rollover.static_stability_factor, ""),
        _fact("Rollover threshold, quasi-static", rollover.threshold_g, "g"),
    ]
    if rollover.peak_lateral_acceleration_g is not None:
        when = f"at {seconds(rollover.peak_time_s)}" if rollover.peak_time_s is not None else ""
        peak = with_unit(number(rollover.peak_lateral_acceleration_g, 2), "g")
        facts.append(Fact("Peak lateral acceleration", peak, when))
    if rollover.peak_rollover_coefficient is not None and (
        rollover.peak_coefficient is None or has_result(rollover.peak_coefficient)
    ):
        text = number(rollover.peak_rollover_coefficient, 2)
        facts.append(Fact("Peak rollover coefficient", text, "1 = the inner wheels lift"))
    facts += [_margin(results), _lifted(results)]
    if rollover.exceedance is not None and rollover.limits:
        facts.append(
            Fact(
                "Threshold exceeded?", clean(rollover.exceedance.text, 60), "probability, see Rollover below"
            )
        )
    blocks: list[Block] = [Facts(tuple(fact for fact in facts if fact is not None))]
    context = nhtsa_context(rollover.static_stability_factor) if rollover.static_stability_factor else ""
    if context:
        blocks.append(Paragraph(context, "quiet"))
    if rollover.notes and not rollover.limits:
        blocks.append(Bullets(tuple(Item(sentence(note)) for note in rollover.notes[:3])))
    return tuple(blocks)
