"""The truck of Wu et al. on a straight road: wheels that slip, axle loads, and optionally what the method leaves out.

Two levels of truth. "as modelled": axle loads follow (1)-(2) at once. "richer": load transfer goes through the body's
pitch mode, wheels have spin inertia, drag acts above ground, the body's pitch moves the CG, and crests and dips change the
weight that presses on the road.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from parsers.jit import kernel
from pipelines.results import FloatArray

SUBSTEPS = 40
DT = 0.02
DURATION_S = 25.0
HILL_M, HILL_HEIGHT_M = 239.0, 8.0
"""A hill h = 8 sin²(pi x / 239): 8 m high, at most 6 degrees steep, as section 3.1.1 (2) says."""

KNOTS: tuple[tuple[float, float], ...] = (
    (0, 0), (0.4, 2.1), (3.5, 2.1), (4.3, -1.7), (7, -1.7), (7.8, 2.0), (11.5, 2.0), (12.3, -1.7), (15.5, -1.7),
    (16.3, 1.8), (23, 1.4), (25, 1.2),
)  # fmt: skip
"""Demanded acceleration over time: three accelerations and two decelerations within -1.7 and 2.1 m/s²."""


@dataclass(frozen=True)
class Truck:
    """Table 2, and what it does not print (rolling_resistance, slip_stiffness, drag, pitch mode, torque shares)."""

    mass: float = 5762.0
    height: float = 1.03
    axle: float = 1.5
    wheelbase: float = 5.0
    radius_front: float = 0.51
    radius_rear: float = 0.528
    inertia_front: float = 10.0
    inertia_rear: float = 20.0
    rolling_resistance: float = 0.008
    friction: float = 0.85
    slip_stiffness: float = 13.0
    drag_area: float = 6.8 * 0.6
    drag_height: float = 1.2
    power: float = 225e3
    rear_drive_share: float = 0.42
    rear_brake_share: float = 0.30
    pitch_hz: float = 1.5
    pitch_damping: float = 0.35
    pitch_gain: float = 0.015

    @property
    def rolling_arm(self) -> float:
        """r f in m, with the mean radius."""
        return self.rolling_resistance * 0.5 * (self.radius_front + self.radius_rear)


@dataclass(frozen=True)
class Run:
    """Truth at DT. All (n,): speed, acceleration, wheel spins (rad/s), slips, axle loads (N), torques (N·m), grade."""

    time_s: FloatArray
    speed: FloatArray
    acceleration: FloatArray
    spin_front: FloatArray
    spin_rear: FloatArray
    slip_front: FloatArray
    slip_rear: FloatArray
    front: FloatArray
    rear: FloatArray
    torque_front: FloatArray
    torque_rear: FloatArray
    drag: FloatArray
    grade: FloatArray


@kernel
def _tyre(slip: float, load: float, friction: float, stiffness: float) -> float:
    """Longitudinal force: a magic formula with shape 1.5."""
    return friction * load * math.sin(1.5 * math.atan(stiffness / (1.5 * friction) * slip))


@kernel
def _drive(
    demand: FloatArray, k: FloatArray, rear_drive: float, hill_m: float, hill_height: float, rich: bool,
    substeps: int, dt: float, v0: float, out: FloatArray,
) -> None:  # fmt: skip
    """out (n, 12). k: the truck's numbers in the order of Truck's fields."""
    m, h, a, L, rf, rr, jf, jr, f, mu, c = k[0], k[1], k[2], k[3], k[4], k[5], k[6], k[7], k[8], k[9], k[10]
    area, drag_height, power, rear_brake = k[11], k[12], k[13], k[15]
    omega, damping, gain = 2 * np.pi * k[16], k[17], k[18]
    g, step = 9.80665, dt / substeps
    v, x, wf, wr = v0, 0.0, v0 / rf, v0 / rr
    hill = np.pi * hill_height / hill_m
    transfer, transfer_rate, dv = 0.0, 0.0, 0.0
    arm = f * 0.5 * (rf + rr)
    for i in range(demand.shape[0]):
        for sub in range(substeps):
            asked = demand[i] + (demand[min(i + 1, demand.shape[0] - 1)] - demand[i]) * sub / substeps
            theta = np.arctan(hill * np.sin(2 * np.pi * x / hill_m)) if x < hill_m else 0.0
            sin, cos = np.sin(theta), np.cos(theta)
            air = 0.6 * area * v * v if rich else 0.0
            # the driver makes up for half of the slope: "the acceleration effect on the uphill is not as obvious"
            wish = (m + jf / rf**2 + jr / rr**2) * asked + 0.5 * m * g * sin + air + f * m * g * cos
            wish = min(wish, power / max(v, 1.0))
            share = rear_drive if wish > 0 else rear_brake
            tf, tr = wish * (1 - share) * rf, wish * share * rr
            # axle loads
            force = dv + g * sin
            moment = m * h * force + m * g * arm * cos
            if rich:
                spin = (jf / rf + jr / rr) * dv
                want = m * h * (1.0 + gain) * force + spin + air * drag_height
                acceleration = omega * omega * (want - transfer) - 2 * damping * omega * transfer_rate
                transfer_rate += step * acceleration
                transfer += step * transfer_rate
                moment = transfer + m * g * arm * cos
            down = g * cos
            if rich and x < hill_m:
                down += v * v * cos**3 * hill * 2 * np.pi / hill_m * np.cos(2 * np.pi * x / hill_m)
            rear = (m * down * a + moment) / L
            front = m * down - rear
            sf = (rf * wf - v) / max(rf * wf, v, 0.5)
            sr = (rr * wr - v) / max(rr * wr, v, 0.5)
            ff, fr = _tyre(sf, front, mu, c), _tyre(sr, rear, mu, c)
            if sub == 0:
                out[i, 0], out[i, 2], out[i, 3], out[i, 4], out[i, 5] = v, wf, wr, sf, sr
                out[i, 6], out[i, 7], out[i, 8], out[i, 9] = front, rear, tf, tr
                out[i, 10], out[i, 11] = theta, air
            dv = (ff + fr - air) / m - g * sin
            if sub == 0:
                out[i, 1] = dv
            # rolling resistance acts as a moment on the wheels
            wf += step * (tf - ff * rf - f * front * rf) / jf
            wr += step * (tr - fr * rr - f * rear * rr) / jr
            v += step * dv
            x += step * v


def drive(truck: Truck, *, rear_wheel_drive: bool, slope: bool, rich: bool) -> Run:
    """25 s from 15 km/h: sections 3.1.1 and 3.1.2, flat or over the hill."""
    time_s = np.asarray(np.arange(round(DURATION_S / DT) + 1) * DT, dtype=np.float64)
    demand = np.interp(time_s, *np.array(KNOTS).T)
    numbers = np.array([float(v) for v in vars(truck).values()])
    out = np.zeros((len(time_s), 12))
    share = 1.0 if rear_wheel_drive else truck.rear_drive_share
    _drive(demand, numbers, share, HILL_M, HILL_HEIGHT_M if slope else 0.0, rich, SUBSTEPS, DT, 15 / 3.6, out)
    columns = [np.ascontiguousarray(out[:, i]) for i in range(12)]
    speed, acceleration, wf, wr, sf, sr, front, rear, tf, tr, grade, air = columns
    return Run(time_s, speed, acceleration, wf, wr, sf, sr, front, rear, tf, tr, air, grade)


def mixture(n: int, share: float, rng: np.random.Generator) -> FloatArray:
    """Noise of (17): standard normal with probability 1 - share, else Laplace with b = 5/sqrt(2); (n,)."""
    wild = rng.random(n) < share
    return np.where(wild, rng.laplace(0.0, 5 / np.sqrt(2), n), rng.standard_normal(n))


def mixture_variance(share: float) -> float:
    """Variance of (17): 13 for a share of one half."""
    return (1 - share) + share * 25.0


def mixture_information(share: float) -> float:
    """Fisher information of (17) about its location: the best that any estimator can draw from one sample."""
    # beyond 30 the normal part underflows
    z = np.linspace(-30.0, 30.0, 120001)
    b = 5 / np.sqrt(2)
    normal = (1 - share) / np.sqrt(2 * np.pi) * np.exp(-(z**2) / 2)
    laplace = share / (2 * b) * np.exp(-np.abs(z) / b)
    slope = -z * normal - np.sign(z) / b * laplace
    return float(np.sum(slope**2 / (normal + laplace)) * (z[1] - z[0]))
