"""How far an answer may be off, beyond a normal distribution's tails.

An answer's spread is mostly that of what no drive shows (links, springs' curvature, friction, where a load lies), and how far
vehicles depart from what is usual there is known as a spread over many of them: most depart by less, a few by much more. So each
answer is distributed as Student's, with the 95 % interval that a normal one of its spread has: half of the answers lie nearer.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
from scipy.special import gamma, gammaincinv, ndtri, stdtr, stdtrit

from pipelines.results import INNER, OUTER, FloatArray, ParameterEstimate

FREEDOM = 4.0
"""Degrees of freedom: see "Tails" in docs/calibration.md for the errors over simulators of many authors that it was taken from."""

CORNERS = 5.0
"""The same of a corner's mass, in which errors of the mass and of both places add up: nearer to a normal one."""

LINKED = 3.0
LINKED_NAMES = frozenset(
    {"cg_height_m", "sprung_cg_height_m", "pitch_arm_m", "roll_inertia_kgm2", "pitch_inertia_kgm2"}
)
"""The same of what hangs on links, tyres and loads that hardly any drive shows: farther from one."""

ARM = 2.75
"""The same of the roll arm, on which roll centres, their sinking and the springs' base are added to these."""

ALONE = 2.5
"""The same of what one estimator tells by itself, with no joint posterior behind it."""

_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


def freedom_of(name: str) -> float:
    """Degrees of freedom of a parameter of the joint posterior."""
    if name == "roll_arm_m":
        return ARM
    if name in LINKED_NAMES:
        return LINKED
    return CORNERS if name.startswith("corner_mass") else FREEDOM


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
