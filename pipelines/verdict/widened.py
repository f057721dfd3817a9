"""An answer that a doubt widens: at best weak, and not told at all once it says hardly more than was known without the drive.

Doubts come after an answer was called weak (a contradiction, a scale that is wrong, a load that changed), so that it is asked again here:

    with a prior       up to FAIR (ALONE for what one estimator gives) of the prior's spread
    without            up to SHARE of its value; lengths about nought up to the limit that they have in metres
    positive by nature no interval that reaches nought
"""

from __future__ import annotations

import math
from dataclasses import replace

from pipelines.joint.answers import FAIR, GOOD_ALONE, MOVED, OPENED
from pipelines.parameters import is_positive
from pipelines.results import ParameterEstimate, Prior

QUANTILE = 1.96
ALONE, SHARE = 0.9, 0.3


def says_little(name: str, value: float, std: float, prior: Prior | None, fair: float = FAIR) -> bool:
    """Whether an answer of this value and spread (its own unit) says hardly more than was known. fair: share of the prior's spread."""
    if is_positive(name) and value - QUANTILE * std <= 0:
        return True
    if name in GOOD_ALONE and std > GOOD_ALONE[name][1]:
        return True
    if prior is not None:
        return std > fair * prior.std
    return name not in GOOD_ALONE and std > SHARE * abs(value)


def widened(
    entry: ParameterEstimate, std: float, words: str, *, fair: float = FAIR, opens: bool = False
) -> ParameterEstimate:
    """The answer with a larger spread, weak or not told; one without figures, or not told before, as it is.

    words: why, before the answer's own reason. opens: whether the doubt is about the vehicle itself (another load), so that what was
    known before does not hold the truth where the drive shows more than it.
    """
    if entry.value is None or entry.std is None or entry.status == "not_identifiable":
        return entry
    half = QUANTILE * std
    wide = replace(
        entry, std=std, low=entry.value - half, high=entry.value + half, inner=(), status="weak",
        reason=f"{words}; {entry.reason}",
    )  # fmt: skip
    if not says_little(entry.name, entry.value, std, entry.prior, fair):
        return wide
    return _not_told(wide, words, entry.reason, opens=opens)


def by_share(entry: ParameterEstimate, share: float, words: str) -> ParameterEstimate:
    """The answer with that share of its value in its spread, as of a scale that may be wrong by so much; one without figures as it is."""
    if entry.value is None or entry.std is None:
        return entry
    return widened(entry, math.hypot(entry.std, share * entry.value), words)


def _not_told(wide: ParameterEstimate, words: str, reason: str, *, opens: bool) -> ParameterEstimate:
    """The figures that are left: what was known before, the wide ones where the drive opened that, or none."""
    prior, value, std, high = wide.prior, wide.value, wide.std, wide.high
    if prior is None or value is None or std is None or high is None:
        return replace(
            wide, value=None, std=None, low=None, high=None, status="not_identifiable", sources=(),
            reason=f"{words}: too wide to tell anything; {reason}",
        )  # fmt: skip
    said = "this leaves no more than what was known before, which the figures are"
    if opens and (std > OPENED * prior.std or abs(value - prior.value) > MOVED * prior.std):
        said = "this leaves it more open than what was known before"
    else:
        value, std, high = prior.value, prior.std, prior.value + QUANTILE * prior.std
    low = value - QUANTILE * std
    return replace(
        wide, value=value, std=std, low=max(low, 0.0) if is_positive(wide.name) else low, high=high,
        status="not_identifiable", sources=("prior",), reason=f"{words}: {said}; {reason}",
    )  # fmt: skip


def not_told(entry: ParameterEstimate, words: str) -> ParameterEstimate:
    """The answer where no spread would hold what contradicts it: what was known before, or no figures."""
    return _not_told(replace(entry, std=math.inf, high=math.inf, inner=()), words, entry.reason, opens=False)
