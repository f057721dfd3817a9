"""Roll of a body on a damped suspension that stands on tyres in series: a third state.

In units of m h (sprung mass times its height above the roll axis), with the body's roll φ, the axles' roll s on their
tyres, ε = φ - s, the specific force f that the body feels, what springs and friction hold besides h(ε), and the axles' own
share γ of the lateral force's moment about the ground (roll centres, wheels):

    c φ'' = f - M,    k s = M + γ f,    M = a ε + b ε' + h

The axles' inertia is left out: their mode is ten times as quick. With κ = a/(a + k) the plain model is the limit κ = 0.
At low frequency the angle against the horizon obeys the plain equation with

    a' = a (1-κ)/(1+γκ),   b' = b (1-κ)²/(1+γκ)²,   c' = c/(1+γκ) - b² (1-κ)² κ (1+γ)/(a (1+γκ)³)

(Taylor's series of the transfer function), and ε with a, b and c (1+γκ)/(1-κ). What is beyond it takes 12 % off the
damping of ε at a car's roll mode.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.jit import kernel
from pipelines.models.roll import GRAVITY, RollCoefficients, exponential
from pipelines.results import FloatArray

LEAST_SHARE = 1e-4
"""κ below which the tyres count as rigid: the third state would be too quick to integrate."""

AXLES_MOMENT = 0.2
"""γ: roll centres 0.05-0.15 m and wheels 0.3 m above ground, over 0.55 m from the roll axis to the body's CG."""


NOWHERE = 1e-12
"""Determinant of a motion over the product of its rows' lengths, up to which it rests nowhere."""


@kernel
def _rest(matrix: FloatArray, feed: FloatArray, push: FloatArray, found: FloatArray) -> None:
    """Fill `found` (k, s) with x of matrix x + feed push = 0 by Gauss's elimination with pivots; leave it where there is none.

    The library's routines cost ten times as much for so few numbers, and a fit asks thousands of times.
    """
    states, inputs = feed.shape
    left, right = np.zeros((states, states)), np.zeros((states, inputs))
    size = determinant = 1.0
    for i in range(states):
        length = 0.0
        for j in range(states):
            left[i, j] = matrix[i, j]
            length += matrix[i, j] * matrix[i, j]
        for j in range(inputs):
            right[i, j] = -feed[i, j]
        size *= np.sqrt(length)
    for k in range(states):
        best = k
        for i in range(k + 1, states):
            if abs(left[i, k]) > abs(left[best, k]):
                best = i
        for j in range(states):
            left[k, j], left[best, j] = left[best, j], left[k, j]
        for j in range(inputs):
            right[k, j], right[best, j] = right[best, j], right[k, j]
        determinant *= left[k, k]
        if not abs(determinant) > 0.0:
            return
        for i in range(states):
            share = left[i, k] / left[k, k] if i != k else 0.0
            for j in range(states):
                left[i, j] -= share * left[k, j]
            for j in range(inputs):
                right[i, j] -= share * right[k, j]
    if not abs(determinant) > NOWHERE * size:
        return
    for row in range(push.shape[0]):
        for i in range(states):
            for j in range(inputs):
                found[row, i] += right[i, j] / left[i, i] * push[row, j]


@dataclass(frozen=True)
class LinearRoll:
    """x' = A x + B (f, h). matrix: (s, s). feed: (s, 2). angle, rate: (s,) what the sensors read of x. between: (s,) the body
    against what its springs stand on.
    """

    matrix: FloatArray
    feed: FloatArray
    angle: FloatArray
    rate: FloatArray
    between: FloatArray

    def steady(self, push: FloatArray) -> FloatArray:
        """(k, s) where the motion rests under constant inputs (k, 2); upright where it rests nowhere (springs softer than gravity)."""
        found = np.zeros((len(push), len(self.matrix)))
        _rest(self.matrix, self.feed, np.ascontiguousarray(push), found)
        return found

    def ramp(self, step: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Exact motion over `step` s (may be negative) under inputs that run straight: phi (s, s), level and slope (s, 2)."""
        states = len(self.matrix)
        block = np.zeros((states + 4, states + 4))
        block[:states, :states] = self.matrix
        block[:states, states : states + 2] = self.feed
        block[states, states + 2] = block[states + 1, states + 3] = 1.0
        moved = exponential(block * step)
        return (
            moved[:states, :states].copy(),
            moved[:states, states : states + 2].copy(),
            moved[:states, states + 2 :].copy(),
        )

    def held(self, step: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """First-order hold: x[k+1] = phi x[k] + before u[k] + after u[k+1]."""
        phi, level, slope = self.ramp(step)
        after = slope / step
        return phi, level - after, after


def plain_roll(roll: RollCoefficients, *, gravity: bool, gain: float = 1.0) -> LinearRoll:
    """Two states (φ, φ'). gain: of a gyro over the rate of the angle."""
    a = roll.a - (GRAVITY if gravity else 0.0)
    matrix = np.array([[0.0, 1.0], [-a / roll.c, -roll.b / roll.c]])
    feed = np.array([[0.0, 0.0], [1.0, -1.0]]) / roll.c
    return LinearRoll(matrix, feed, (angle := np.array([1.0, 0.0])), np.array([0.0, gain]), angle)


def suspension_alone(
    roll: RollCoefficients, share: float, moment: float, *, against_axles: bool
) -> RollCoefficients:
    """a, b, c of the equations above from the apparent ones of low frequency. share: κ. moment: γ."""
    lean = 1 + moment * share
    if against_axles:
        return RollCoefficients(roll.a, roll.b, roll.c * (1 - share) / lean)
    a = roll.a * lean / (1 - share)
    b = roll.b * (lean / (1 - share)) ** 2
    loss = b * b * (1 - share) ** 2 * share * (1 + moment) / (a * lean**3)
    return RollCoefficients(a, b, (roll.c + loss) * lean)


def series_roll(
    roll: RollCoefficients, share: float, moment: float, *, against_axles: bool, gravity: bool
) -> LinearRoll:
    """Three states (φ, φ', s) whose motion at low frequency is that of the apparent coefficients.

    against_axles: the angle is ε, else φ. The rate is the body's own, φ'. gravity: f is the path's acceleration, and g φ
    comes from the state. Raises ValueError for a share outside 0 to 1.
    """
    if not 0.0 < share < 1.0:
        raise ValueError(f"the tyres' share of the roll is between 0 and 1, not {share:g}")
    own = suspension_alone(roll, share, moment, against_axles=against_axles)
    k = own.a * (1 - share) / share
    leaned = (1 + moment) * (GRAVITY if gravity else 0.0)
    matrix = np.array(
        [
            [0.0, 1.0, 0.0],
            [leaned / own.c, 0.0, -k / own.c],
            [(own.a + moment * (GRAVITY if gravity else 0.0)) / own.b, 1.0, -(own.a + k) / own.b],
        ]
    )
    feed = np.array([[0.0, 0.0], [(1 + moment) / own.c, 0.0], [moment / own.b, 1.0 / own.b]])
    between = np.array([1.0, 0.0, -1.0])
    angle = between if against_axles else np.array([1.0, 0.0, 0.0])
    return LinearRoll(matrix, feed, angle, np.array([0.0, 1.0, 0.0]), between)
