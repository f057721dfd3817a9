"""What the foreign simulators have in common: a car as kernels take it, tyres, springs, the driver's foot, and the record.

Rows of the record, one every 5 ms: columns by the names below. Specific forces are those of the sprung CG in body axes;
`flat_*` are in the road's plane without gravity's share, as simulators like to print them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from foreign_car import Array, Car, G
from foreign_course import RATE_HZ, Course

from parsers.jit import lean_kernel

STEP_S = 0.001
EVERY = 5
LOG_HZ = 200.0

(T, V, FX, FY, FZ, P, Q, R, DP, DQ, DR, ROLL, PITCH, DEFLECTION) = range(14)
STRUT, NORMAL, SPEEDS = DEFLECTION + 4, DEFLECTION + 8, DEFLECTION + 12
BRAKE, DRIVE, STEER, FLAT_X, FLAT_Y, BANK = (DEFLECTION + 16 + i for i in range(6))
WIDTH = DEFLECTION + 22


class Choices(NamedTuple):
    """What authors of simulators choose differently. axis: roll axis at the roll centres (1) or in the ground (0);
    lean, nose: share of the hubs' couples in turning and braking that goes into the springs (else past them);
    links: share of the car's anti-dive and anti-squat that is modelled; tips: height about which gravity tips a
    pitched body, over the CG's (1: not at all); magic: tyres that saturate; turned: rolling resistance as a torque
    on the wheels (1) or a force on the car (0); spin: wheels have inertia; stiff: dampers' rebound over bump."""

    axis: float = 1.0
    lean: float = 1.0
    nose: float = 1.0
    links: float = 1.0
    tips: float = 0.3
    magic: float = 1.0
    turned: float = 1.0
    spin: float = 1.0
    stiff: float = 1.0


class Flat(NamedTuple):
    """A car in numbers and arrays of four (wheels fl, fr, rl, rr); ahead, left: from the sprung CG; pulls: axles."""

    mass: float
    sprung: float
    sprung_height: float
    height: float
    inertia: Array
    wheelbase: float
    x: float
    rear_x: float
    track: Array
    ahead: Array
    left: Array
    spring: Array
    bar: Array
    damper: Array
    resting: Array
    hub: Array
    centre: Array
    dive: float
    squat: float
    radius: float
    tyre_rate: float
    wheel_inertia: float
    drag: float
    rolling: float
    braked: Array
    driven: Array
    friction: float


def flat(car: Car) -> Flat:
    """The car for a kernel."""

    def wheels(front: float, rear: float) -> Array:
        return np.array([front, front, rear, rear])

    half = wheels(car.track[0] / 2, car.track[1] / 2)
    return Flat(
        car.mass, car.sprung, car.sprung_height, car.height, np.array([*car.sprung_inertia, car.inertia[2]]),
        car.wheelbase, car.x, car.wheelbase - car.x, wheels(*car.track),
        car.sprung_x - wheels(0, car.wheelbase), np.array([1, -1, 1, -1]) * half - car.sprung_y, wheels(*car.spring),
        wheels(*car.bar), wheels(*car.damper), car.resting, wheels(*car.unsprung) / 2, wheels(*car.centre),
        car.dive * car.height, car.squat * car.height, car.radius, car.tyre_rate, car.wheel_inertia,
        0.6 * car.drag_area, car.rolling, wheels(car.brake_front, 1 - car.brake_front) / 2,
        wheels(car.drive_front, 1 - car.drive_front) / 2, car.friction,
    )  # fmt: skip


def at_steps(course: Course) -> tuple[Array, Array, Array, Array]:
    """The course at the simulators' steps."""
    count = len(course.speed)
    fine = np.arange(int(count / RATE_HZ / STEP_S)) * STEP_S
    at = np.arange(count) / RATE_HZ
    speed, steer, grade, bank = (
        np.interp(fine, at, c) for c in (course.speed, course.steer, course.grade, course.bank)
    )
    return speed, steer, grade, bank


@lean_kernel
def grip(load: float, along: float, across: float, magic: float) -> tuple[float, float]:
    """Tyre force along and across for a slip ratio and a slip angle: linear, or a magic formula with combined slip."""
    sx, sy = along / 0.08, across / 0.09
    if magic == 0.0:
        return load * sx, load * sy
    size = np.sqrt(sx * sx + sy * sy) + 1e-12
    force = 1.05 * load * np.sin(1.5 * np.arctan(0.75 * size))
    return force * sx / size, force * sy / size


@lean_kernel
def struts(f: Flat, squeeze: Array, rate: Array, stiff: float, out: Array) -> None:
    """Springs, bars and dampers: force on the body at each wheel. squeeze, rate: + in compression."""
    for i in range(4):
        j = i + 1 if i % 2 == 0 else i - 1
        bar = f.bar[i] / f.track[i] ** 2 * (squeeze[i] - squeeze[j])
        way = 2 / (1 + stiff) if rate[i] > 0 else 2 * stiff / (1 + stiff)
        rub = f.friction * np.tanh(rate[i] / 0.005)
        out[i] = f.resting[i] + f.spring[i] * squeeze[i] + bar + f.damper[i] * way * rate[i] + rub


@lean_kernel
def pedals(f: Flat, wanted: float, slope: float, v: float, state: Array) -> tuple[float, float]:
    """Drive and brake torque of all wheels, N·m, by a driver who knows the wanted acceleration and errs a little.

    state (3,): sum of the speed's errors, and both torques, which follow in a tenth of a second.
    """
    error = wanted - v
    state[0] = min(max(state[0] + STEP_S * 0.2 * error, -1.0), 1.0)
    need = f.mass * (slope + 0.8 * error + state[0]) + f.drag * v * v + f.rolling * f.mass * G * (v > 0.2)
    if v < 0.3 and wanted < 0.2:
        need = -2.0 * f.mass
    state[1] += STEP_S / 0.1 * (max(need, 0.0) * f.radius - state[1])
    state[2] += STEP_S / 0.1 * (max(-need, 0.0) * f.radius - state[2])
    return state[1], state[2]
