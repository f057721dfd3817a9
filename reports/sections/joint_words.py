"""The joint posterior in words: conflicts, what would help most, and the figures that stand beside them."""

from __future__ import annotations

import math
from dataclasses import replace

from pipelines.drive_results import DriveResults
from pipelines.joint.conflict import WIDEST
from pipelines.results import JointVerdict, Learned, NextMeasurement, RelationCheck
from reports.sections.values import NORMAL_95, half_width
from reports.sections.verdict import LEADING, ordered
from reports.text import (
    DASH,
    MINUS,
    NARROW,
    clean,
    count,
    decimals_for,
    number,
    percent,
    sentence,
    spec_of,
    with_unit,
)

RESOLVED = 0.05
"""Bits that sampled distributions cannot tell from none: 3.5 % of a spread."""

RARE = 0.01
"""Probability below which a misfit is called strained although nothing was widened for it."""


def is_conflict(check: RelationCheck) -> bool:
    """Whether a relation contradicts the others: its standard deviations had to be widened."""
    return math.isfinite(check.widened) and check.widened > 1.0005


def conflicts(joint: JointVerdict | None) -> list[RelationCheck]:
    """Relations that contradict the others, the worst first."""
    found = [] if joint is None else [check for check in joint.relations if is_conflict(check)]
    return sorted(found, key=lambda check: -check.widened)


def chance(probability: float) -> str:
    """Print a probability: 0.23 as 23 %, what is next to never as 1 in 20 000 or rarer."""
    if not math.isfinite(probability):
        return DASH
    if probability >= 0.001:
        return percent(min(1.0, probability))
    if probability < 1e-6:
        return "below 1 in a million"
    size = 10.0 ** math.floor(math.log10(1.0 / probability))
    return f"1 in {number(math.floor(1.0 / probability / size) * size, 0)}"


def times(factor: float) -> str:
    """Print a factor, as in "3.2 times"."""
    return f"{number(factor, 1 if factor >= 1.05 else 2)} times"


def agreeing(check: RelationCheck) -> str:
    """How much wider a relation would have to be to agree with the rest."""
    if check.widened >= WIDEST:
        return "no spread of it would hold both"
    return f"to agree, its spread would have to be {times(check.widened)} as wide"


def conflict_text(check: RelationCheck) -> str:
    """One conflict as a sentence."""
    source = f" ({clean(check.source, 60)})" if check.source else ""
    return sentence(
        f"{clean(check.relation, 120)}{source} contradicts the rest: chi² {number(check.chi2, 1)} for "
        f"{count(check.numbers, 'figure')}, by chance {chance(check.probability)}; {agreeing(check)}",
        600,
    )


def spread_text(name: str, std: float, *, unit: bool = True) -> str:
    """A standard deviation, as in "± 0.004 m"."""
    if not math.isfinite(std):
        return DASH
    spec = spec_of(name)
    text = f"± {number(std, min(decimals_for(std, spec.digits), spec.digits + 2))}"
    return with_unit(text, spec.unit) if unit else text


def bits_text(bits: float) -> str:
    """Bits with one digit after the point; what rounds to nought is nought."""
    text = number(bits, 1)
    return "0.0" if text == f"{MINUS}0.0" else text


def narrowing(ratio: float) -> str:
    """What a ratio of spreads means for the interval; empty where it can hardly be seen."""
    if not math.isfinite(ratio) or ratio <= 0 or ratio > 0.97:
        return ""
    if 0.45 <= ratio <= 0.55:
        return "half as wide"
    if ratio < 0.45:
        return f"{number(1 / ratio, 1 if ratio > 0.1 else 0)} times narrower"
    return f"{number(100 * (1 - ratio), 0)}{NARROW}% narrower"


def next_text(name: str, measurement: NextMeasurement, std: float | None) -> str:
    """A measurement and the spread that it would leave, as in "0.1 g more braking: ± 0.004 m, half as wide"."""
    after = spread_text(name, measurement.std_after)
    words = narrowing(measurement.std_after / std) if std else ""
    action = clean(measurement.action, 200).rstrip(".")
    return sentence(f"{action}: {after}{', ' + words if words else ''}", 400).rstrip(".")


def std_of(results: DriveResults, name: str) -> float | None:
    """The verdict's standard deviation of a parameter, from its interval where it has none."""
    estimate = results.verdict.get(name)
    if estimate is None:
        return None
    std = estimate.std if estimate.std is not None else (half_width(estimate) or math.nan) / NORMAL_95
    return std if math.isfinite(std) and std > 0 else None


def as_told(results: DriveResults, name: str, learned: Learned) -> Learned:
    """What was learned of a parameter as far as the verdict's spread says so.

    The verdict may be wider than the posterior that relations were weighed in (doubts, a parameter that is not identifiable):
    bits are those of the spreads that are printed, and a relation without which the spread would be narrower brought nothing.
    """
    std = std_of(results, name)
    if std is None:
        return learned
    printed = max(0.0, math.log2(learned.prior.std / std)) if learned.prior.std > 0 else 0.0
    shares = tuple(
        replace(share, std_alone=share.std_alone if share.std_alone >= std else math.nan)
        for share in learned.shares
        if not share.std_without < std
    )
    if printed < learned.bits - RESOLVED:
        learned = replace(learned, bits=printed)
        shares = shares if printed >= RESOLVED else ()
    return replace(learned, shares=shares)


def learned_in_order(results: DriveResults) -> list[tuple[str, Learned]]:
    """What the joint posterior holds, as the verdict tells it, in the order of the verdict's table; others behind."""
    joint = results.joint
    if joint is None:
        return []
    names = [
        estimate.name for estimate in ordered(results.verdict.values()) if estimate.name in joint.learned
    ]
    names += [name for name in joint.learned if name not in results.verdict]
    return [(name, as_told(results, name, joint.learned[name])) for name in names]


def most_useful(results: DriveResults) -> tuple[str, NextMeasurement] | None:
    """The measurement that would help most: for the CG height, or else where it would narrow an interval most.

    One that is no drive (scales, a tilt table) only where nothing else helps: it is what one drives to be spared.
    """
    best: tuple[str, NextMeasurement] | None = None
    least = 1.0
    for name, learned in learned_in_order(results):
        std = std_of(results, name)
        if not learned.next or std is None:
            continue
        first = learned.next[0]
        ratio = first.std_after / std
        if name == LEADING and ratio <= 0.97:
            return name, first
        if ratio < least:
            best, least = (name, first), ratio
    return best if least <= 0.97 else None


def lower_title(name: str) -> str:
    """A parameter's title inside a sentence; abbreviations keep their capitals."""
    title = spec_of(name).title
    return title if title[1:2].isupper() else title[:1].lower() + title[1:]


def next_line(results: DriveResults) -> str:
    """The most useful next measurement as a sentence; empty where none is known."""
    found = most_useful(results)
    if found is None:
        return ""
    name, measurement = found
    action = sentence(clean(measurement.action, 200)).rstrip(".")
    std = std_of(results, name)
    now = f" instead of {spread_text(name, std)}" if std is not None else ""
    return f"{action}. It would bring {lower_title(name)} to {spread_text(name, measurement.std_after)}{now}."
