"""What if something that was taken for known is otherwise? Each such doubt by its own chance, as the log makes it.

A doubt replaces the prior of a few unknowns R, N(0, I) in prior standard deviations, by N(m, V): a stated figure that is wrong (V
wide), or a kind of physics that the log does not have (m elsewhere, V narrow). With the posterior's own mode u and covariance S,

    P = S_RR⁻¹ - I + V⁻¹,     v = P⁻¹ (S_RR⁻¹ u_R + V⁻¹ m)
    2 ln B = v' P v - u_R' S_RR⁻¹ u_R - m' V⁻¹ m - ln |P| - ln |S_RR| + ln |V⁻¹|

B is the log's odds for it over what was known, and B times its odds beforehand its weight w beside all others. A parameter
with gradient g, c = S_RR⁻¹ S_R: g, moves by c' (v - u_R) under it, its variance by c' (P⁻¹ - S_RR) c: it is told with the mean and
the variance over all of them. A doubt that the log does not see moves a parameter by its small odds; one that it speaks for,
by all it is worth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from pipelines.evidence import Evidence
from pipelines.joint.vehicle.unknowns import Known
from pipelines.results import FloatArray

WRONG_FILE = 0.015
"""Chance beforehand that a stated figure (or a pair that belongs together), or a channel's scale, is wrong by several of its own spreads."""

WIDER = 5.0
"""A wrong figure's spread over the stated one."""

Figures = Mapping[str, tuple[float, float]]
"""Unknowns by name: where they are, and how surely; SI."""

HEARD = 1e-6
"""Weight up to which a doubt moves nothing."""


class Place(Protocol):
    """A posterior: its unknowns, u (k,) in prior standard deviations with covariance (k, k), and the relations behind it."""

    @property
    def known(self) -> Known:
        """The unknowns."""

    @property
    def u(self) -> FloatArray:
        """The mode."""

    @property
    def covariance(self) -> FloatArray:
        """Of u."""

    @property
    def evidence(self) -> Sequence[Evidence]:
        """The relations; empty where they have no unknowns of their own."""


@dataclass(frozen=True)
class Doubt:
    """Another prior of the unknowns `names`. mean: (r,); precision: (r, r); both in prior standard deviations."""

    text: str
    names: tuple[str, ...]
    mean: FloatArray
    precision: FloatArray
    chance: float


@dataclass(frozen=True)
class Weighed:
    """A doubt after the log. weight: its share of all; rows: of its unknowns; gain: (r, k), S_RR⁻¹ S_R:; moved: (r,), v - u_R;
    spread: (r, r), P⁻¹ - S_RR."""

    doubt: Doubt
    weight: float
    rows: tuple[int, ...]
    gain: FloatArray
    moved: FloatArray
    spread: FloatArray

    def on(self, gradient: FloatArray) -> tuple[float, float]:
        """Shift and change of the variance of a parameter with gradient (k,)."""
        c = self.gain @ gradient
        return float(c @ self.moved), float(c @ self.spread @ c)


NOTHING = Doubt("", (), np.zeros(0), np.zeros((0, 0)), 1.0)
"""No doubt; no place."""


def wider(text: str, names: tuple[str, ...], chance: float) -> list[Doubt]:
    """Unknowns that lie wider about what was known: all alike, or each by itself."""
    size = len(names)
    alike = np.full((size, size), 1 / size)
    ways = [np.eye(size) - (1 - WIDER**-2) * alike]
    if size > 1:
        ways.append(np.eye(size) * WIDER**-2)
    return [Doubt(text, names, np.zeros(size), precision, chance / len(ways)) for precision in ways]


def elsewhere(text: str, known: Known, figures: Figures, chance: float) -> Doubt:
    """Unknowns that are elsewhere."""
    rows = [known.index(name) for name in figures]
    value = np.array([figures[name][0] for name in figures])
    spread = np.array([figures[name][1] for name in figures])
    mean = (value - known.mean[rows]) / known.std[rows]
    return Doubt(text, tuple(figures), mean, np.diag((known.std[rows] / spread) ** 2), chance)


def _beside(doubt: Doubt, place: Doubt) -> Doubt:
    """Both at once, of unknowns that they do not share."""
    size = len(doubt.names), len(place.names)
    precision = np.zeros((sum(size), sum(size)))
    precision[: size[0], : size[0]] = doubt.precision
    precision[size[0] :, size[0] :] = place.precision
    mean = np.concatenate([doubt.mean, place.mean])
    return Doubt(doubt.text, (*doubt.names, *place.names), mean, precision, doubt.chance * place.chance)


def weigh(joint: Place, doubt: Doubt, place: Doubt) -> tuple[float, Weighed]:
    """ln B, with the load's place beside it, and the doubt's effect, its weight not yet known."""
    both = _beside(doubt, place)
    rows = [joint.known.index(name) for name in both.names]
    spread, mode = joint.covariance[np.ix_(rows, rows)], joint.u[rows]
    inner = np.linalg.inv(spread)
    precision = inner - np.eye(len(rows)) + both.precision
    pull = both.precision @ both.mean
    after = np.linalg.inv(precision)
    moved = after @ (inner @ mode + pull)
    quadratic = moved @ precision @ moved - mode @ inner @ mode - both.mean @ pull
    sizes = [float(np.linalg.slogdet(m)[1]) for m in (both.precision, precision, spread)]
    gain = inner @ joint.covariance[rows]
    weighed = Weighed(
        replace(doubt, chance=both.chance), 0.0, tuple(rows), gain, moved - mode, after - spread
    )
    return 0.5 * float(quadratic + sizes[0] - sizes[1] - sizes[2]), weighed
