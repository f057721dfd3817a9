"""One parameter's figures as they are printed: the interval decides the digits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipelines.results import ParameterEstimate, Prior
from reports.blocks import Bar, Cell, Tone
from reports.text import DASH, decimals_for, number, span, spec_of, with_unit

STATUS_WORDS = {"identified": "identified", "weak": "weak", "not_identifiable": "not identifiable"}
STATUS_TONES: dict[str, Tone] = {"identified": "good", "weak": "warn", "not_identifiable": "quiet"}
NORMAL_95 = 1.959964
SINGLE_WHEELS = ("corner_mass_", "tire_normal_force_")
"""How the names of parameters of one wheel begin: long lists of them stand behind those of the vehicle."""


def has_result(estimate: ParameterEstimate) -> bool:
    """Whether there is a value to print as a result: what only repeats the prior is none."""
    return estimate.value is not None and estimate.status != "not_identifiable"


def half_width(estimate: ParameterEstimate) -> float | None:
    """Half of the 95 % interval, from the interval or else from the standard deviation."""
    if estimate.low is not None and estimate.high is not None:
        return 0.5 * (estimate.high - estimate.low)
    return None if estimate.std is None else NORMAL_95 * estimate.std


def decimals_of(estimate: ParameterEstimate) -> int:
    """Digits after the point for a parameter's figures; negative for tens and hundreds."""
    digits = spec_of(estimate.name).digits
    return min(decimals_for(half_width(estimate), digits), digits + 1)


def value_text(estimate: ParameterEstimate, *, unit: bool = True) -> str:
    """The value with its unit, or —."""
    if not has_result(estimate):
        return DASH
    text = number(estimate.value, decimals_of(estimate))
    return with_unit(text, spec_of(estimate.name).unit) if unit else text


def deviation_text(estimate: ParameterEstimate) -> str:
    """One standard deviation, as in "± 0.028"; — without a value."""
    if not has_result(estimate) or estimate.std is None or not np.isfinite(estimate.std):
        return DASH
    return f"± {number(estimate.std, max(decimals_of(estimate), decimals_for(estimate.std, 0) - 1))}"


def spread_value_text(estimate: ParameterEstimate) -> str:
    """Value ± standard deviation whatever the status; — where either is missing."""
    if estimate.value is None or estimate.std is None or not np.isfinite(estimate.std):
        return DASH
    decimals = min(
        decimals_for(estimate.std, spec_of(estimate.name).digits), spec_of(estimate.name).digits + 1
    )
    return f"{number(estimate.value, decimals)} ± {number(estimate.std, decimals)}"


def interval_text(estimate: ParameterEstimate) -> str:
    """The 95 % interval, or —."""
    if not has_result(estimate):
        return DASH
    return span(estimate.low, estimate.high, decimals_of(estimate))


def bracketed_text(estimate: ParameterEstimate) -> str:
    """The interval of what is not identifiable, in brackets: it is no result. Or empty."""
    if has_result(estimate) or estimate.value is None:
        return ""
    shown = span(estimate.low, estimate.high, decimals_of(estimate))
    return f"({shown})" if shown != DASH else ""


def repeats_prior(estimate: ParameterEstimate) -> bool:
    """Whether value and 95 % interval are the prior's, to one unit of the last digit that is printed."""
    prior, figures = estimate.prior, (estimate.value, estimate.low, estimate.high)
    if prior is None:
        return False
    before = (prior.value, prior.value - NORMAL_95 * prior.std, prior.value + NORMAL_95 * prior.std)
    unit = 10.0 ** -decimals_of(estimate)
    return all(a is not None and abs(a - b) < unit for a, b in zip(figures, before, strict=True))


def interval_cell(estimate: ParameterEstimate) -> Cell:
    """The interval; for what is not identifiable in brackets, marked as known before if it is, else as no result.

    A method that tells too little may still have moved, or lost, what was known: its interval is not the prior's then.
    """
    shown = bracketed_text(estimate)
    if not shown:
        return Cell(interval_text(estimate))
    return Cell(shown, sub="prior only" if repeats_prior(estimate) else "no result", tone="quiet")


def prior_text(name: str, prior: Prior | None) -> str:
    """What was known before the log, as in "0.551 ± 0.034 m"; — where nothing was."""
    if prior is None:
        return DASH
    spec = spec_of(name)
    decimals = min(decimals_for(prior.std, spec.digits), spec.digits + 1)
    return with_unit(f"{number(prior.value, decimals)} ± {number(prior.std, decimals)}", spec.unit)


def status_cell(estimate: ParameterEstimate) -> Cell:
    """The badge in words."""
    return Cell(STATUS_WORDS[estimate.status], kind="badge", tone=STATUS_TONES[estimate.status])


def bar_of(estimate: ParameterEstimate) -> Bar | None:
    """The prior's 95 % range and the interval on one scale; None without a prior or a reference to compare with."""
    if estimate.prior is None and (estimate.reference is None or not has_result(estimate)):
        return None
    prior = estimate.prior
    has_value = has_result(estimate) and estimate.low is not None and estimate.high is not None
    ends: list[float] = []
    if prior is not None:
        ends += [prior.value - NORMAL_95 * prior.std, prior.value + NORMAL_95 * prior.std]
    if has_value:
        ends += [x for x in (estimate.low, estimate.high, estimate.value) if x is not None]
    ends = [x for x in ends if np.isfinite(x)]
    if not ends or max(ends) <= min(ends):
        return None
    low, high = min(ends), max(ends)
    if estimate.reference is not None:
        # A truth far outside must not squeeze the bars: it stands at the edge then.
        low, high = (
            min(low, max(estimate.reference, low - 0.3 * (high - low))),
            max(high, min(estimate.reference, high + 0.3 * (high - low))),
        )
    before = (
        (prior.value - NORMAL_95 * prior.std, prior.value + NORMAL_95 * prior.std) if prior else (None, None)
    )
    after = (estimate.low, estimate.high, estimate.value) if has_value else (None, None, None)
    places = _scaled((*before, *after, estimate.reference), low, high)
    return Bar(
        places[0], places[1], places[2], places[3], places[4], places[5], STATUS_TONES[estimate.status]
    )


def _scaled(values: Sequence[float | None], low: float, high: float) -> list[float | None]:
    """Put values on 3-97, so that a mark at the end is seen whole."""
    out: list[float | None] = []
    for value in values:
        inside = value is not None and np.isfinite(value)
        out.append(
            round(3 + 94 * min(1.0, max(0.0, (value - low) / (high - low))), 2)
            if inside and value is not None
            else None
        )
    return out


def bar_cell(estimate: ParameterEstimate) -> Cell:
    """The bar with words for who cannot see it."""
    bar = bar_of(estimate)
    words = f"prior {prior_text(estimate.name, estimate.prior)}; 95 % interval {interval_text(estimate)}"
    return Cell(words if bar else "", kind="bar" if bar else "text", bar=bar)
