"""A mass on a spring and a damper, richer than the filter's model: finer steps, a mass that changes, friction, a stiffening spring."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from parsers.jit import kernel, lean_kernel
from pipelines.results import FloatArray

FINER = 20
"""Steps of the plant to one of a sensor."""

STICK_MPS = 0.01
"""Speed over which friction changes its sign."""


@dataclass(frozen=True)
class MassSpringPlant:
    """m x'' = f - k x - k3 x³ - c x' - F sign(x'). SI.

    later_mass_kg: the mass from change_s on, None: no change.
    """

    mass_kg: float = 100.0
    stiffness_npm: float = 400.0
    damping_nspm: float = 0.0
    cubic_npm3: float = 0.0
    friction_n: float = 0.0
    later_mass_kg: float | None = None
    change_s: float = 40.0


@dataclass(frozen=True)
class MassSpringDrive:
    """time_s, force, position, velocity: (n,), at the sensors' rate, without noise."""

    time_s: FloatArray
    force: FloatArray
    position: FloatArray
    velocity: FloatArray


@lean_kernel
def _slope(p: FloatArray, inverse: float, force: float, x: float, v: float) -> float:
    total: float = force - p[0] * x - p[1] * x * x * x - p[2] * v
    if p[3] != 0.0:
        total -= p[3] * math.tanh(v / STICK_MPS)
    return total * inverse


@kernel
def _simulate(
    force: FloatArray,
    p: FloatArray,
    inverses: FloatArray,
    step: float,
    start: tuple[float, float],
    out: FloatArray,
) -> None:
    """Runge-Kutta of order 4, two values of force a step; p: k, k3, c, F; inverses: 1/m of each step; out (steps + 1, 2)."""
    x, v = start
    half = 0.5 * step
    out[0, 0], out[0, 1] = x, v
    for k in range(len(inverses)):
        w = inverses[k]
        a1 = _slope(p, w, force[2 * k], x, v)
        v2 = v + half * a1
        a2 = _slope(p, w, force[2 * k + 1], x + half * v, v2)
        v3 = v + half * a2
        a3 = _slope(p, w, force[2 * k + 1], x + half * v2, v3)
        v4 = v + step * a3
        a4 = _slope(p, w, force[2 * k + 2], x + step * v3, v4)
        x, v = (
            x + step / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4),
            v + step / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4),
        )
        out[k + 1, 0], out[k + 1, 1] = x, v


def fine_times(duration_s: float, step_s: float) -> FloatArray:
    """Times at which `simulate_mass_spring` wants the force: two to each of the plant's steps, and the end."""
    return np.asarray(np.arange(2 * FINER * round(duration_s / step_s) + 1) * (step_s / (2 * FINER)))


def simulate_mass_spring(
    plant: MassSpringPlant, force: FloatArray, step_s: float, start: tuple[float, float] = (0.0, 0.0)
) -> MassSpringDrive:
    """The plant's motion. force: at `fine_times`. start: position and velocity. Raises ValueError for another length."""
    steps, rest = divmod(len(force) - 1, 2 * FINER)
    if rest or steps < 1:
        raise ValueError("the force is given at fine_times(duration, step)")
    fine = step_s / FINER
    mass = np.full(steps * FINER, plant.mass_kg)
    if plant.later_mass_kg is not None:
        mass[np.arange(len(mass)) * fine >= plant.change_s] = plant.later_mass_kg
    p = np.array([plant.stiffness_npm, plant.cubic_npm3, plant.damping_nspm, plant.friction_n])
    out = np.empty((len(mass) + 1, 2))
    _simulate(np.ascontiguousarray(force, dtype=np.float64), p, 1.0 / mass, fine, start, out)
    return MassSpringDrive(
        np.asarray(np.arange(steps + 1) * step_s),
        force[:: 2 * FINER].copy(),
        out[::FINER, 0].copy(),
        out[::FINER, 1].copy(),
    )


def band_limited_noise(
    rng: np.random.Generator, times: FloatArray, low_hz: float, high_hz: float, deviation: float
) -> FloatArray:
    """Noise of equal power between two frequencies and none elsewhere, at evenly spaced times, (n,)."""
    count = len(times)
    frequency = np.fft.rfftfreq(count, times[1] - times[0])
    inside = (frequency >= low_hz) & (frequency <= high_hz) & (frequency > 0)
    if not inside.any():
        raise ValueError("no frequency of so short a record lies in the band")
    spectrum = np.zeros(len(frequency), dtype=complex)
    parts = rng.standard_normal((2, int(inside.sum())))
    spectrum[inside] = parts[0] + 1j * parts[1]
    found = np.fft.irfft(spectrum, count)
    return np.asarray(found * (deviation / np.sqrt(np.mean(found**2))))
