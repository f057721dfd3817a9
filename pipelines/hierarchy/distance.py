"""Spread of a few figures of which some may be far off, and the distance of one figure from the others in it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipelines.results import FloatArray

QN = 2.2219
"""Makes Qn the standard deviation of normal figures (Rousseeuw & Croux 1993, eq. 3.2)."""

FEW = {2: 0.399, 3: 0.994, 4: 0.512, 5: 0.844, 6: 0.611, 7: 0.857, 8: 0.669, 9: 0.872}
"""Factors on Qn of 2 to 9 figures, which is biased there (Croux & Rousseeuw 1992)."""

EFFICIENCY, LOST = 0.82, 1.5
"""Of Qn beside the standard deviation: as good as one of 0.82 as many degrees of freedom, and of few figures one and a half
less (so that 1 % is no more than 1 % for 6 to 19 normal figures)."""

PLAIN = 5
"""Others up to which the standard deviation is taken: Qn of so few rests on one gap or two and may be next to nought."""

MANY = 200
"""Others from which on the quartiles are taken: Qn looks at every pair."""

MEDIAN_VARIANCE = 0.5 * math.pi
"""Variance of the median of normal figures over that of their mean."""


@dataclass(frozen=True)
class Distance:
    """How far one figure is from others. score: in joint standard deviations, signed; probability: of one as far by chance.

    centre: of the others; spread: standard deviation of what is compared: its own and that between the others.
    """

    score: float
    probability: float
    centre: float
    spread: float


def qn(values: FloatArray) -> float:
    """Spread of (n,) figures: the quarter quantile of their pairwise distances; up to half of them may be far off.

    Raises ValueError for fewer than two.
    """
    n = len(values)
    if n < 2:
        raise ValueError("a spread needs two figures")
    rows, columns = np.triu_indices(n, 1)
    half = n // 2 + 1
    kth = half * (half - 1) // 2
    gap = float(np.partition(np.abs(values[rows] - values[columns]), kth - 1)[kth - 1])
    factor = FEW.get(n, n / (n + (1.4 if n % 2 else 3.8)))
    return QN * factor * gap


def quartiles(values: FloatArray) -> float:
    """Spread of many (n,) figures from their quartiles; up to a quarter of them may be far off."""
    low, high = np.quantile(values, (0.25, 0.75))
    return float(high - low) / 1.349


@dataclass(frozen=True)
class Crowd:
    """What others are like. scatter: their variance, of which usual is that of their own intervals; freedom: its degrees.

    error: variance of the centre.
    """

    centre: float
    error: float
    scatter: float
    usual: float
    freedom: float


def crowd(values: FloatArray, stds: FloatArray) -> Crowd:
    """Of (m,) figures, m >= 3, each with the standard deviation of its own interval; some may be far off."""
    m, usual = len(values), float(np.median(stds)) ** 2
    if m <= PLAIN:
        scatter, freedom = float(np.var(values, ddof=1)), m - 1.0
        centre, error = float(np.mean(values)), 1.0 / m
    else:
        scatter, freedom = (qn(values) if m <= MANY else quartiles(values)) ** 2, EFFICIENCY * (m - 1) - LOST
        centre, error = float(np.median(values)), MEDIAN_VARIANCE / m
    return Crowd(centre, error * max(scatter, usual), scatter, usual, freedom)


def distance(value: float, std: float, others: Crowd) -> Distance:
    """A figure, with the standard deviation of its own interval, against others.

    The spread between vehicles is what the others' scatter has beyond their intervals. Student's t as the scatter of a few
    is itself uncertain; where the own interval is most of the spread, it is nearly normal.
    """
    from scipy.stats import t as law

    own = std**2 + max(others.scatter - others.usual, 0.0)
    total = own + others.error
    score = (value - others.centre) / math.sqrt(max(total, 1e-300))
    # what of the variance stands on the scatter has its few degrees of freedom (Satterthwaite); a scatter that is by chance
    # less than the intervals is no proof that the vehicles are alike
    freedom = others.freedom * max(own / max(others.scatter, others.usual, 1e-300), 1.0) ** 2
    probability = 2 * float(law.sf(abs(score), min(freedom, 1e6)))
    return Distance(score, probability, others.centre, math.sqrt(total))
