"""The body's vertical acceleration over a wheel whose hub's acceleration is known: Pence, Fathy & Stein, eqs. (1)-(2).

    m x'' = -k x - d(x') - c sign(x') - m z_u'',    z_s'' = x'' + z_u'',    x = z_s - z_u  (+ extension)

with a damper of two slopes that meet at rest. The hub's measured acceleration z_u'' is the input: the road, the tyre and
whether it touches the ground do not matter. At low frequency the body follows the hub, whatever the mass.
"""

from __future__ import annotations

import math

import numpy as np

from parsers.jit import kernel, lean_kernel
from pipelines.results import FloatArray

STICK_MPS = 0.01
"""Speed over which friction changes its sign."""


@lean_kernel
def _pull(spring: float, extension: float, compression: float, friction: float, x: float, v: float) -> float:
    """Suspension force per mass; all coefficients are per mass."""
    slope = extension if v > 0.0 else compression
    force = spring * x + slope * v
    if friction != 0.0:
        # four hyperbolic tangents a sample would cost more than all the rest
        force += friction * math.tanh(v / STICK_MPS)
    return force


@kernel
def _respond(u: FloatArray, middle: FloatArray, p: FloatArray, step: float, out: FloatArray) -> None:
    """Runge-Kutta of order 4 with one step a sample; p: spring, extension, compression, friction, all per mass."""
    spring, ext, com, fric = p[0], p[1], p[2], p[3]
    x = v = 0.0
    half = 0.5 * step
    for k in range(len(u)):
        f1 = _pull(spring, ext, com, fric, x, v)
        out[k] = -f1
        if k + 1 == len(u):
            break
        a1 = -f1 - u[k]
        x2, v2 = x + half * v, v + half * a1
        a2 = -_pull(spring, ext, com, fric, x2, v2) - middle[k]
        x3, v3 = x + half * v2, v + half * a2
        a3 = -_pull(spring, ext, com, fric, x3, v3) - middle[k]
        x4, v4 = x + step * v3, v + step * a3
        a4 = -_pull(spring, ext, com, fric, x4, v4) - u[k + 1]
        x += step / 6.0 * (v + 2.0 * (v2 + v3) + v4)
        v += step / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)


def between_samples(u: FloatArray) -> FloatArray:
    """Values half-way between even samples, (n,), by the cubic through four neighbours; the last one is not used."""
    wide = np.concatenate((2 * u[:1] - u[1:2], u, 2 * u[-1:] - u[-2:-1], u[-1:]))
    return np.asarray((9 * (wide[1:-2] + wide[2:-1]) - wide[:-3] - wide[3:]) / 16)


def body_response(
    u: FloatArray,
    step_s: float,
    mass_kg: float,
    spring_npm: float,
    damping_nspm: tuple[float, float],
    friction_n: float = 0.0,
    middle: FloatArray | None = None,
) -> FloatArray:
    """Body acceleration (n,) in m/s² that follows from the hub's, u (n,), from rest.

    damping_nspm: slopes in extension and in compression. middle: `between_samples(u)`, for callers that respond often.
    Raises ValueError for fewer than 4 samples or a mass not above 0.
    """
    if len(u) < 4 or mass_kg <= 0:
        raise ValueError("four samples and a mass above 0 are needed")
    u = np.ascontiguousarray(u)
    p = np.array([spring_npm, *damping_nspm, friction_n]) / mass_kg
    out = np.empty(len(u))
    _respond(u, between_samples(u) if middle is None else middle, p, step_s, out)
    return out


def response_gain(
    frequency_hz: FloatArray, mass_kg: float, spring_npm: float, damping_nspm: float
) -> np.ndarray[tuple[int], np.dtype[np.complex128]]:
    """G = (b s + k) / (m s² + b s + k) at s = 2 pi j f: body over hub acceleration for a linear damper. (n,) complex."""
    s = 2j * np.pi * frequency_hz
    through = damping_nspm * s + spring_npm
    return np.asarray(through / (mass_kg * s**2 + through))
