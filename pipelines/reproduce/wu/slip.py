"""The slip-based baseline that Wu et al. compare with ("Huang model"), as far as it can be derived.

Both axles are taken to have the same slip stiffness per load: F_xf / (F_zf s_f) = F_xr / (F_zr s_r). With the axle
forces from torques and wheel spin and F_zr linear in a and h (2), each sample under drive torque gives one equation
linear in (a, h). Its adaptive filter of the state variables is taken as a tracking filter of value and rate; its
tuning, gates and starting values are not printed in Wu's paper.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.jit import kernel
from pipelines.models.axle_load import GRAVITY
from pipelines.reproduce.wu.plant import DT, Run, Truck
from pipelines.results import FloatArray

LEAST_FORCE = 1.0
LEAST_SLIP = 0.003
START = (1.3, 0.8)
"""LEAST_FORCE: m/s² of f from which a sample is used. START: a and h in m."""


@dataclass(frozen=True)
class SlipTrack:
    """Position and height over time, (n,), and how many samples were used."""

    axle: FloatArray
    height: FloatArray
    used: int


@kernel
def _track(y: FloatArray, dt: float, jerk: float, r: float, value: FloatArray, rate: FloatArray) -> None:
    """Kalman filter of value and rate; jerk: spectral density of the rate's change, r: variance of y."""
    x, s = y[0], 0.0
    p, c, q = r, 0.0, 4.0
    for i in range(y.shape[0]):
        if i > 0:
            x += dt * s
            p += 2 * dt * c + dt * dt * q + jerk * dt**3 / 3
            c += dt * q + jerk * dt * dt / 2
            q += jerk * dt
        total = p + r
        a, b = p / total, c / total
        e = y[i] - x
        x += a * e
        s += b * e
        q -= b * c
        c -= a * c
        p -= a * p
        value[i] = x
        rate[i] = s


def _smooth(y: FloatArray, std: float, jerk: float) -> tuple[FloatArray, FloatArray]:
    value, rate = np.empty(len(y)), np.empty(len(y))
    _track(y, DT, jerk, max(std, 1e-4) ** 2, value, rate)
    return value, rate


@kernel
def _recursive(
    phi: FloatArray, y: FloatArray, used: FloatArray, r: float, start: FloatArray, out: FloatArray
) -> None:
    """Recursive least squares of two constants; out (n, 2)."""
    a, h = start[0], start[1]
    p, c, q = 0.1, 0.0, 0.1
    for i in range(y.shape[0]):
        if used[i] > 0.5:
            u, w = phi[i, 0], phi[i, 1]
            left, right = p * u + c * w, c * u + q * w
            total = u * left + w * right + r
            e = y[i] - u * a - w * h
            a += left / total * e
            h += right / total * e
            p -= left * left / total
            c -= left * right / total
            q -= right * right / total
        out[i, 0], out[i, 1] = a, h


def slip_baseline(
    run: Run, speed: FloatArray, spin_front: FloatArray, spin_rear: FloatArray, truck: Truck, speed_std: float,
    spin_std: float,
) -> SlipTrack:  # fmt: skip
    """a and h by the equal-slip-stiffness balance from measured speed (m/s), spins (rad/s) and known axle torques."""
    v, dv = _smooth(speed, speed_std, 4.0)
    wf, af = _smooth(spin_front, spin_std, 16.0)
    wr, ar = _smooth(spin_rear, spin_std, 16.0)
    rf, rr = truck.radius_front, truck.radius_rear
    slip_front = (rf * wf - v) / np.maximum(np.maximum(rf * wf, v), 0.5)
    slip_rear = (rr * wr - v) / np.maximum(np.maximum(rr * wr, v), 0.5)
    weight = truck.mass * GRAVITY * np.cos(run.grade)
    roll = truck.rolling_resistance * weight
    share = (truck.wheelbase - truck.axle) / truck.wheelbase
    force_front = (run.torque_front - truck.inertia_front * af) / rf - roll * share
    force_rear = (run.torque_rear - truck.inertia_rear * ar) / rr - roll * (1 - share)
    f = dv + GRAVITY * np.sin(run.grade)
    driven = (run.torque_rear > 0) & (f > LEAST_FORCE)
    seen = np.maximum(np.abs(slip_front), np.abs(slip_rear)) > LEAST_SLIP
    size = truck.mass * GRAVITY
    both = (force_front * slip_rear + force_rear * slip_front) / size
    columns = np.column_stack((both * (np.cos(run.grade)), both * f / GRAVITY)) / truck.wheelbase
    target = force_rear * slip_front / size * np.cos(run.grade)
    target = target - both * truck.rolling_arm / truck.wheelbase
    out = np.empty((len(v), 2))
    noise = (0.3 * 0.002) ** 2
    used = (driven & seen).astype(np.float64)
    _recursive(columns, target, used, noise, np.array(START), out)
    return SlipTrack(out[:, 0].copy(), out[:, 1].copy(), int(used.sum()))
