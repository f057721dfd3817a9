"""How far an answer may be off, beyond a normal distribution's tails.

An answer's spread is mostly that of what no drive shows (links, springs' curvature, friction, where a load lies), and how far
vehicles depart from what is usual there is known as a spread over many of them: most depart by less, a few by much more. So each
answer is distributed as Student's, with the 95 % interval that a normal one of its spread has: half of the answers lie nearer.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
from scipy.special import gamma, gammaincinv, ndtri, stdtr, stdtrit

from pipelines.results import INNER, OUTER, FloatArray, ParameterEstimate

FREEDOM = 4.0
"""Degrees of freedom: see "Tails" in docs/calibration.md for the errors over simulators of many authors that it was taken from."""

FREEDOM_OF: Mapping[str, float] = {
    "cg_height_m": 2.75, "sprung_cg_height_m": 2.75, "roll_inertia_kgm2": 2.75,
    "roll_arm_m": 2.5, "pitch_arm_m": 2.5, "pitch_inertia_kgm2": 3.0,
    "roll_stiffness_nmprad": 5.0, **dict.fromkeys((f"corner_mass_{wheel}_kg" for wheel in ("fl", "fr", "rl", "rr")), 5.0),
}  # fmt: skip
"""The same of single parameters. Heights, arms and inertias hang on links, tyres, loads and missing pieces of physics that hardly any drive
shows: farther from a normal distribution. A stiffness and corners' masses are sums of many errors, and nearer to one."""

ALONE = 2.5
"""The same of what one estimator tells by itself, with no joint posterior behind it."""

_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


def freedom_of(name: str) -> float:
    """Degrees of freedom of a parameter of the joint posterior."""
    return FREEDOM_OF.get(name, FREEDOM)


@cache
def _narrower(freedom: float) -> float:
    return float(stdtrit(freedom, 0.5 + OUTER / 2) / ndtri(0.5 + OUTER / 2))


def share_below(z: FloatArray, freedom: float = FREEDOM) -> FloatArray:
    """What lies below z (any shape), standard deviations of the answer about its mean."""
    return np.asarray(stdtr(freedom, _narrower(freedom) * z))


def density(z: FloatArray, freedom: float = FREEDOM) -> FloatArray:
    """Probability density at z (any shape), a standard deviation."""
    narrower = _narrower(freedom)
    highest = gamma(0.5 * (freedom + 1)) / (gamma(0.5 * freedom) * math.sqrt(freedom * math.pi)) * narrower
    return np.asarray(highest * (1 + (narrower * z) ** 2 / freedom) ** (-0.5 * (freedom + 1)))


def stretched(ordered: FloatArray, middle: float, freedom: float = FREEDOM) -> FloatArray:
    """Draws (n,) in rising order with these tails about the middle, in rising order again; what is skew stays so.

    Student's distribution is a normal one whose spread is itself drawn, its inverse square from a gamma distribution. Neighbours
    get spreads from all over it, by the golden section.
    """
    place = (np.arange(len(ordered)) * _GOLDEN + 0.5) % 1.0
    rank = np.argsort(np.argsort(place))
    inverse = gammaincinv(0.5 * freedom, (rank + 0.5) / len(ordered)) / (0.5 * freedom)
    moved = (ordered - middle) / (np.sqrt(inverse) * _narrower(freedom))
    return np.sort(moved - float(np.mean(moved)) + float(np.mean(ordered)))


def told_with_tails(entry: ParameterEstimate) -> ParameterEstimate:
    """What one estimator told for itself, with the inner intervals that these tails leave of its own; the 95 % interval stays."""
    inner = []
    for level in INNER:
        interval = entry.interval(level)
        if interval is None or entry.value is None:
            return entry
        nearer = stdtrit(ALONE, 0.5 + level / 2) / stdtrit(ALONE, 0.5 + OUTER / 2)
        share = float(nearer * ndtri(0.5 + OUTER / 2) / ndtri(0.5 + level / 2))
        inner.append(tuple(entry.value + share * (end - entry.value) for end in interval))
    return replace(entry, inner=tuple((low, high) for low, high in inner))
