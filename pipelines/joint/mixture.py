"""A parameter over all doubts, and over other posteriors where the drive leaves them open: the mean, spread and interval of the mixture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from pipelines.joint.answers import Told
from pipelines.joint.doubts.weighed import HEARD, Weighed
from pipelines.joint.tails import FREEDOM, share_below, stretched
from pipelines.results import INNER, OUTER, FloatArray

HALVINGS = 48
"""Of the span in which a quantile is searched."""


@dataclass(frozen=True)
class Apart:
    """A parameter by another posterior, that no change of the prior's mean and spread leads to. weight: its chance.

    gradient: (k,), and doubts: of that posterior.
    """

    weight: float
    value: float
    std: float
    gradient: FloatArray
    doubts: Sequence[Weighed]


def _copies(
    std: float, gradient: FloatArray, doubts: Sequence[Weighed]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Weights, shifts and spreads (d,) of an answer: as it stands, and under each doubt."""
    heard = [d for d in doubts if d.weight > HEARD]
    weights = np.array([1.0 - sum(d.weight for d in heard), *(d.weight for d in heard)])
    effects = np.array([(0.0, 0.0), *(d.on(gradient) for d in heard)])
    return weights, effects[:, 0], np.sqrt(np.maximum(std**2 + effects[:, 1], (0.25 * std) ** 2))


def _mixed(first: Apart, apart: Sequence[Apart]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Weights, shifts from the first one's value and spreads of an answer over all its doubts and over other posteriors with theirs."""
    weights, shifts, stds = _copies(first.std, first.gradient, first.doubts)
    weights = (1 - sum(other.weight for other in apart)) * weights
    for other in apart:
        share, moved, spreads = _copies(other.std, other.gradient, other.doubts)
        weights = np.concatenate([weights, other.weight * share])
        shifts = np.concatenate([shifts, other.value - first.value + moved])
        stds = np.concatenate([stds, spreads])
    return weights, shifts, stds


def _mean_of(weights: FloatArray, shifts: FloatArray, stds: FloatArray) -> tuple[float, float]:
    """Shift of the mean, and standard deviation, of a mixture."""
    shift = float(weights @ shifts)
    return shift, math.sqrt(float(weights @ (stds**2 + (shifts - shift) ** 2)))


def moments(first: Apart, apart: Sequence[Apart] = ()) -> tuple[float, float]:
    """Mean and standard deviation of an answer over all doubts, and over other posteriors. The first one's weight is what they leave."""
    shift, std = _mean_of(*_mixed(first, apart))
    return first.value + shift, std


def doubted(
    answer: Told,
    gradient: FloatArray,
    doubts: Sequence[Weighed],
    apart: Sequence[Apart] = (),
    freedom: float = FREEDOM,
) -> Told:
    """The answer over all doubts: its mean moved, its spread widened, its interval that of the mixture. freedom: of `tails`.

    The spread holds what hardly ever is otherwise, by much; so the interval is not 1.96 times it.
    """
    weights, shifts, stds = _mixed(Apart(1.0, answer.value, answer.std, gradient, doubts), apart)
    shift, std = _mean_of(weights, shifts, stds)
    draws = answer.draws
    levels = np.array([*INNER, OUTER])
    below, above = np.split(
        _quantiles(
            answer,
            weights,
            shifts,
            stds / max(answer.std, 1e-300),
            0.5 * np.concatenate([1 - levels, 1 + levels]),
            freedom,
        ),
        2,
    )
    *inner, (low, high) = zip(below.tolist(), above.tolist(), strict=True)
    if draws is not None:
        draws = answer.value + shift + std / max(answer.std, 1e-300) * (draws - answer.value)
    return Told(answer.value + shift, std, low, high, draws, tuple(inner))


def _quantiles(
    answer: Told,
    weights: FloatArray,
    shifts: FloatArray,
    wider: FloatArray,
    shares: FloatArray,
    freedom: float,
) -> FloatArray:
    """(q,) quantiles of copies of the answer's distribution, each moved and stretched about its mean.

    weights, shifts, wider: (d,). shares: (q,), how much lies below each. The answer's tails are those of `tails`.
    """
    if answer.draws is None:
        reach = 6 * answer.std
        rising = partial(_share_below, answer.value, answer.std, freedom)
    else:
        ordered = stretched(np.sort(answer.draws), answer.value, freedom)
        reach = float(max(ordered[-1] - answer.value, answer.value - ordered[0]))
        rising = partial(np.interp, xp=ordered, fp=(np.arange(len(ordered)) + 0.5) / len(ordered))
    low = np.full(len(shares), answer.value + float(np.min(shifts - reach * wider)))
    high = np.full(len(shares), answer.value + float(np.max(shifts + reach * wider)))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        at = answer.value + (middle[:, None] - answer.value - shifts) / wider
        more = rising(at) @ weights > shares
        low, high = np.where(more, low, middle), np.where(more, middle, high)
    return np.asarray(0.5 * (low + high))


def _share_below(mean: float, std: float, freedom: float, x: FloatArray) -> FloatArray:
    return share_below((x - mean) / max(std, 1e-300), freedom)
