"""Roll of the sprung mass about its roll axis, as a body-mounted accelerometer sees it.

Berntorp et al., equations (1)-(4): (I + m h²) φ'' + D φ' + K φ = m h (a_y cos φ + g sin φ), with the sprung mass m, its
CG's height h above the roll axis, and its roll inertia I. The bracket is the specific force that an accelerometer on
the body reads at the roll axis. One that sits z above the axis reads z φ'' less, so that with its reading f

    c φ'' + b φ' + a φ = f,    a = K / (m h),   b = D / (m h),   c = I / (m h) + h - z

and no gravity appears: bank and grade drop out. Only a, b, c can be seen in f and φ.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from parsers.channels import IntArray
from parsers.jit import kernel
from pipelines.results import FloatArray

GRAVITY = 9.80665
DEGREES = 180 / math.pi


@kernel
def _times(left: FloatArray, right: FloatArray, over: float, product: FloatArray) -> None:
    """Fill `product` with left right / over, all (n, n)."""
    n = left.shape[0]
    for i in range(n):
        for j in range(n):
            total = 0.0
            for m in range(n):
                total += left[i, m] * right[m, j]
            product[i, j] = total / over


@kernel
def _exponential(matrix: FloatArray, result: FloatArray) -> None:
    """Fill `result`; see `exponential`."""
    n = matrix.shape[0]
    norm = 0.0
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += abs(matrix[i, j])
        norm = max(norm, total)
    halvings = 0
    while norm > 0.25 and halvings < 60:
        norm *= 0.5
        halvings += 1
    scaled, term, work = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    part = 2.0**halvings
    for i in range(n):
        for j in range(n):
            scaled[i, j] = matrix[i, j] / part
            term[i, j] = result[i, j] = 1.0 if i == j else 0.0
    for order in range(1, 14):
        _times(term, scaled, float(order), work)
        for i in range(n):
            for j in range(n):
                term[i, j] = work[i, j]
                result[i, j] += work[i, j]
    for _ in range(halvings):
        _times(result, result, 1.0, work)
        for i in range(n):
            for j in range(n):
                result[i, j] = work[i, j]


def exponential(matrix: FloatArray) -> FloatArray:
    """e to a small square matrix: Taylor's series on a scaled matrix, squared back.

    The library's routine costs milliseconds on a busy machine (its threads wait for each other), and a fit calls it
    thousands of times. Good to 1e-14 of the largest entry for the well-scaled matrices here.
    """
    result = np.empty_like(matrix, order="C")
    _exponential(np.ascontiguousarray(matrix), result)
    return result


@kernel
def _dry_friction(
    angle: FloatArray, starts: IntArray, stops: IntArray, slip: float, held: FloatArray
) -> None:
    """Fill `held`; see `dry_friction`."""
    for segment in range(len(starts)):
        state = 0.0
        for i in range(max(starts[segment], 0) + 1, min(stops[segment], len(angle))):
            way = angle[i] - angle[i - 1]
            side = 1.0 if way >= 0 else -1.0
            state = side + (state - side) * np.exp(-abs(way) / slip)
            held[i] = state


def dry_friction(angle: FloatArray, starts: IntArray, stops: IntArray, slip: float) -> FloatArray:
    """(n,) Dahl's friction from -1 to 1: after a turn of the motion it changes over within `slip` rad.

    Exact between samples. Follows the way, not the rate, so that slow and fast motion are held alike.
    """
    held = np.zeros(len(angle))
    _dry_friction(np.ascontiguousarray(angle, dtype=np.float64), starts, stops, float(slip), held)
    return held


@dataclass(frozen=True)
class RollCoefficients:
    """a in (m/s²)/rad, b in (m/s²)/(rad/s), c in (m/s²)/(rad/s²) = m."""

    a: float
    b: float
    c: float


def roll_gradient_degpg(a: FloatArray | float) -> FloatArray | float:
    """Steady roll angle in degrees per g of *sensed* lateral acceleration (which includes g sin φ)."""
    return GRAVITY * DEGREES / a


def undamped_frequency_hz(a: FloatArray, c: FloatArray, z: FloatArray | float) -> FloatArray:
    """sqrt(K / J) / 2π with J = I + m h² about the roll axis; z is the accelerometer's height above that axis."""
    return np.asarray(np.sqrt(a / (c + z)) / (2 * math.pi))


def damping_ratio(a: FloatArray, b: FloatArray, c: FloatArray, z: FloatArray | float) -> FloatArray:
    """D / (2 sqrt(K J)), with J about the roll axis."""
    return np.asarray(b / (2 * np.sqrt(a * (c + z))))


def state_matrix(roll: RollCoefficients) -> tuple[FloatArray, FloatArray]:
    """A (2, 2) and B (2,) of d/dt (φ, φ') = A (φ, φ') + B f."""
    a = np.array([[0.0, 1.0], [-roll.a / roll.c, -roll.b / roll.c]])
    return a, np.array([0.0, 1.0 / roll.c])


def ramp_response(roll: RollCoefficients, step: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Exact motion over `step` seconds (which may be negative) under an input that runs straight.

    x(t + step) = phi x(t) + level f(t) + slope f'(t). Returns phi (2, 2), level (2,), slope (2,).
    """
    a, b = state_matrix(roll)
    block = np.zeros((4, 4))
    block[:2, :2] = a
    block[:2, 2] = b
    block[2, 3] = 1.0
    moved = exponential(block * step)
    return moved[:2, :2].copy(), moved[:2, 2].copy(), moved[:2, 3].copy()


def discretise(roll: RollCoefficients, step: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """First-order hold: x[k+1] = phi x[k] + before f[k] + after f[k+1]."""
    phi, level, slope = ramp_response(roll, step)
    after = slope / step
    return phi, level - after, after


@kernel
def _process_noise(a: float, b: float, c: float, intensity: float, step: float, noise: FloatArray) -> None:
    """Fill `noise`; see `process_noise`."""
    largest = max(1.0, (abs(a) + abs(b)) / abs(c))
    halvings = max(0, int(np.ceil(np.log2(max(largest * step, 1e-9)))))
    part = step / 2.0**halvings
    block, moved, work = np.zeros((4, 4)), np.zeros((4, 4)), np.zeros((2, 2))
    phi, turned, first = np.zeros((2, 2)), np.zeros((2, 2)), np.zeros((2, 2))
    block[0, 1], block[3, 2] = -part, part
    block[1, 0], block[2, 3] = a / c * part, -a / c * part
    block[1, 1], block[3, 3] = b / c * part, -b / c * part
    block[1, 3] = intensity / (c * c) * part
    _exponential(block, moved)
    for i in range(2):
        for j in range(2):
            phi[i, j], turned[j, i], work[i, j] = moved[2 + j, 2 + i], moved[2 + j, 2 + i], moved[i, 2 + j]
    _times(phi, work, 1.0, first)
    for _ in range(halvings):
        _times(phi, first, 1.0, work)
        _times(work, turned, 1.0, noise)
        for i in range(2):
            for j in range(2):
                first[i, j] += noise[i, j]
        _times(phi, phi, 1.0, work)
        for i in range(2):
            for j in range(2):
                phi[i, j], turned[j, i] = work[i, j], work[i, j]
    for i in range(2):
        for j in range(2):
            noise[i, j] = 0.5 * (first[i, j] + first[j, i])


def process_noise(roll: RollCoefficients, intensity: float, step: float) -> FloatArray:
    """Covariance (2, 2) that white noise on f gathers over a step; `intensity` in (m/s²)²/Hz.

    Van Loan's over a part of the step, doubled until it is the whole: his matrix holds the motion backwards in time, which
    grows without end where the damping is strong, and takes the covariance with it (it came out negative).
    """
    noise = np.empty((2, 2))
    _process_noise(float(roll.a), float(roll.b), float(roll.c), float(intensity), float(step), noise)
    return noise


def mirror_height(height: float, mass: float, inertia: float) -> float:
    """I/(m h): the other height above the roll axis that gives the same motion, with K and D in proportion to it."""
    return inertia / (mass * height)


def height_sensitivity(height: float, mass: float, inertia: float) -> float:
    """dc/dh = 1 - I/(m h²): nought on the flat line h = sqrt(I/m), where the motion does not tell the height."""
    return 1 - inertia / (mass * height * height)


def suspension_of(
    roll: RollCoefficients, mass: float, inertia: float, *, upper: bool = True
) -> tuple[float, float, float]:
    """K in N·m/rad, D in N·m·s/rad and h in m from a, b, c (accelerometer on the roll axis), with m and I_x given.

    c = I/(m h) + h has two heights: the upper one is above sqrt(I/m), the other is its mirror. Below the least
    c that any height gives, 2 sqrt(I/m), the flat line's height is the nearest.
    """
    half = 0.5 * roll.c
    root = math.sqrt(max(half * half - inertia / mass, 0.0))
    height = half + root if upper else half - root
    return roll.a * mass * height, roll.b * mass * height, height
