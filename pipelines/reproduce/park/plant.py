"""The car of Park & Choi's Table I as a plant: speed, wheel spin, slip, pitch, single-track lateral motion and roll.

Richer than the observer where the real car was: wheels have spin and slip, the load moves over a pitching body, the
accelerometer leans with the body, v_y' is not zero, and tyres may bend. Figures that the paper does not print (brake
gains, C_d A, lateral tyres, pitch) are usual ones for a small SUV and are listed in `ParkCar`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from parsers.jit import kernel
from pipelines.models.braking import LongitudinalCar
from pipelines.results import FloatArray

DEGREES = 180 / np.pi
STEP_S = 0.001
SETTLE_S = 4.0
"""Driven at the first demand and cut off: drive slip and speed control have to settle."""

EVERY = 10
"""Steps of the integration in one sample of 10 ms."""


@dataclass(frozen=True)
class ParkCar:
    """Table I and what it leaves open. SI.

    roll_stiffness, roll_damping: 1950 N·m/deg and 245 N·m·s/deg. slip_stiffness: C_x,n; slip_bend: b in
    mu = Cλ/(1 + b Cλ), 0 = straight. brake_gain: both axles' torque per Pa. pitch_gradient: rad of nose-down pitch per
    m/s² of braking, 0 = a body that does not lean.
    """

    nominal_kg: float = 1610.0
    added_kg: float = 145.0
    front_m: float = 1.104
    rear_m: float = 1.469
    roll_inertia: float = 1008.0
    wheel_radius: float = 0.322
    wheel_inertia: float = 0.7
    height: float = 0.637
    roll_centre: float = 0.08572
    roll_stiffness: float = 1950 * DEGREES
    roll_damping: float = 245 * DEGREES
    slip_stiffness: float = 15.0
    slip_bend: float = 0.0
    brake_gain: float = 4.2e-4
    brake_front: float = 0.74
    drag_area: float = 0.85
    cornering: float = 14.0
    friction: float = 0.9
    yaw_inertia: float = 2600.0
    pitch_gradient: float = 0.0
    pitch_hz: float = 1.6
    pitch_damping: float = 0.4

    @property
    def mass(self) -> float:
        """Loaded."""
        return self.nominal_kg + self.added_kg

    @property
    def arm(self) -> float:
        """h_lat."""
        return self.height - self.roll_centre

    def known(self, nominal_kg: float | None = None) -> LongitudinalCar:
        """What the longitudinal part is told of the car: Table I, the load not."""
        mass = self.nominal_kg if nominal_kg is None else nominal_kg
        return LongitudinalCar(
            mass, self.front_m, self.rear_m, self.wheel_radius, self.wheel_inertia, self.drag_area
        )

    def shifted(self, metres: float) -> ParkCar:
        """The CG moved back by so much, its height unchanged."""
        return replace(self, front_m=self.front_m + metres, rear_m=self.rear_m - metres)


@dataclass(frozen=True)
class ParkDemand:
    """What the driver does at steps of 1 ms, each (n,): curvature 1/m (+ left), target speed m/s (NaN: none), grade
    rad, friction, and brake pressure in Pa (while above 0 the speed control rests)."""

    curvature: FloatArray
    speed: FloatArray
    grade: FloatArray
    pressure: FloatArray
    start_mps: float


@dataclass(frozen=True)
class ParkRun:
    """The true motion at 100 Hz, each (n,), SI. f_x, f_y: specific force in body axes. front, rear: wheel speeds."""

    time: FloatArray
    v: FloatArray
    f_x: FloatArray
    f_y: FloatArray
    roll: FloatArray
    roll_rate: FloatArray
    yaw_rate: FloatArray
    front: FloatArray
    rear: FloatArray
    pressure: FloatArray
    curvature: FloatArray
    drive_force: FloatArray
    grade: FloatArray


@kernel
def _slip_force(load: float, stiffness: float, bend: float, v: float, wheel: float) -> float:
    """Secant of the braking force over (v - wheel)/v at the present slip, times the slip's denominator: N."""
    slip = (v - wheel) / v
    return load * stiffness / (1.0 + bend * stiffness * abs(slip))


@kernel
def _wanted(slower: float) -> float:
    """Acceleration in m/s² with which the driver takes away a speed error in m/s."""
    return min(max(1.2 * slower, -3.5), 2.5)


@kernel
def _pedals(force: float, pressure: float, radius: float, gain: float) -> tuple[float, float]:
    """Drive force in N and brake pressure in Pa that give a force; what the engine's drag gives takes neither."""
    if force >= -300.0:
        return max(force, 0.0), pressure
    return 0.0, -force * radius / gain


@kernel
def _drive(demand: FloatArray, p: FloatArray, start: float, dt: float, every: int, out: FloatArray) -> None:
    """demand (n, 4): curvature, target speed, grade, pressure. p: the car. out (n // every, 12)."""
    m, lf, lr, inertia, R, J, h, h0, kr, cr, C, bend, gain, share, area, cy, mu, iz, pg, wp, zp = p
    g = 9.80665
    base = lf + lr
    v, front, rear = start, start, start
    vy, r, roll, rate, pitch, pitch_rate = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    ax, ay, held = 0.0, 0.0, 0.0
    spin = 2 * J / R**2
    for k in range(demand.shape[0]):
        curvature, target, grade, pressure = demand[k, 0], demand[k, 1], demand[k, 2], demand[k, 3]
        air = 0.5 * 1.204 * area * v * v
        push = 0.0
        if pressure <= 0.0 and target == target:
            held = min(max(held + dt * 0.1 * (target - v), -0.5), 0.5)
            push, pressure = _pedals(
                m * (_wanted(target - v) + held) + air + m * g * grade, pressure, R, gain
            )
        pressure *= min(1.0, v / 1.0)
        # the load moves with the pitching body: a quasi-steady share plus a lag of the second order
        moved = -(m * h * (ax + g * grade) + h * air + 2 * spin * R * ax) / base
        lagged = moved if pg == 0.0 else pitch * m * h / (pg * base)
        zf = m * g * lr / base + lagged
        zr = m * g - zf
        vx = max(v, 0.5)
        tf = share * gain * pressure / R - push
        tr = (1 - share) * gain * pressure / R
        kf = _slip_force(zf, C, bend, vx, front)
        kb = _slip_force(zr, C, bend, vx, rear)
        front = (front + dt / spin * (kf * v / vx - tf)) / (1 + dt * kf / (spin * vx))
        rear = (rear + dt / spin * (kb * v / vx - tr)) / (1 + dt * kb / (spin * vx))
        ff = kf * (v - front) / vx
        fr = kb * (v - rear) / vx
        steer = curvature * base
        af = steer - (vy + lf * r) / vx
        ar = -(vy - lr * r) / vx
        yf = mu * zf * np.tanh(cy * af / mu)
        yr = mu * zr * np.tanh(cy * ar / mu)
        ax = (-ff - fr - air) / m - g * grade
        ay = (yf + yr) / m
        fy = ay + g * roll
        v = max(v + dt * (ax + r * vy), 0.0)
        vy += dt * (ay - r * v)
        r += dt * (lf * yf - lr * yr) / iz
        rate += dt * (m * (h - h0) * fy - kr * roll - cr * rate) / inertia
        roll += dt * rate
        if pg != 0.0:
            pitch_rate += dt * (wp * wp * (-pg * (ax + g * grade) - pitch) - 2 * zp * wp * pitch_rate)
            pitch += dt * pitch_rate
        if k % every == 0:
            i = k // every
            out[i, 0], out[i, 1], out[i, 2] = v, ax + g * grade - g * pitch, fy
            out[i, 3], out[i, 4], out[i, 5] = roll, rate, r
            out[i, 6], out[i, 7], out[i, 8] = front, rear, pressure
            out[i, 9], out[i, 10], out[i, 11] = curvature, push, grade


def drive_park(car: ParkCar, demand: ParkDemand) -> ParkRun:
    """The car's motion under a demand, at 100 Hz."""
    table = np.stack([demand.curvature, demand.speed, demand.grade, demand.pressure], axis=1)
    settle = round(SETTLE_S / STEP_S)
    table = np.concatenate((np.repeat(table[:1], settle, axis=0), table))
    numbers = np.array(
        [
            car.mass, car.front_m, car.rear_m, car.roll_inertia, car.wheel_radius, car.wheel_inertia, car.height,
            car.roll_centre, car.roll_stiffness, car.roll_damping, car.slip_stiffness, car.slip_bend, car.brake_gain,
            car.brake_front, car.drag_area, car.cornering, car.friction, car.yaw_inertia, car.pitch_gradient,
            2 * np.pi * car.pitch_hz, car.pitch_damping,
        ]
    )  # fmt: skip
    rows = (len(table) + EVERY - 1) // EVERY
    out = np.zeros((rows, 12))
    _drive(np.ascontiguousarray(table), numbers, demand.start_mps, STEP_S, EVERY, out)
    out = out[settle // EVERY :]
    rows = len(out)
    columns = [np.ascontiguousarray(column, dtype=np.float64) for column in out.T]
    return ParkRun(np.arange(rows, dtype=np.float64) * STEP_S * EVERY, *columns)
