"""A multibody model as robotics simulators have them: a rigid body in space, and four hubs that slide along its pillars.

No small angles and no links: every force of a tyre reaches the body through its pillar, so that the roll axis lies in
the ground, wheels lean with the body, and nothing resists diving but springs. Generalised velocities: the body's own
(3), its turning (3), and the hubs' along the pillars (4); accelerations from the mass matrix at each step. The road is a
plane; grade and bank turn gravity. Tyres are springs with linear or saturating grip; brakes and motors push on the body.
"""

from __future__ import annotations

import numpy as np
from foreign_car import Array, Car, G
from foreign_course import Course
from foreign_parts import (
    BANK,
    BRAKE,
    DEFLECTION,
    DP,
    DRIVE,
    EVERY,
    FLAT_X,
    FX,
    NORMAL,
    PITCH,
    ROLL,
    SPEEDS,
    STEER,
    STEP_S,
    STRUT,
    WIDTH,
    Choices,
    Flat,
    P,
    T,
    V,
    at_steps,
    flat,
    grip,
    pedals,
    struts,
)  # fmt: skip

from parsers.jit import kernel, lean_kernel


@lean_kernel
def _cross(a: Array, b: Array, out: Array) -> None:
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@kernel
def _masses(f: Flat, places: Array, body: Array) -> Array:
    """(10, 10): body and hubs at their places (4, 3) from the body's CG."""
    m = np.zeros((10, 10))
    jac = np.zeros((3, 10))
    for i in range(3):
        m[i, i] = f.sprung
        m[3 + i, 3 + i] = body[i]
    for i in range(4):
        x, y, z = places[i]
        jac[:] = 0.0
        jac[0, 0] = jac[1, 1] = jac[2, 2] = jac[2, 6 + i] = 1.0
        jac[0, 4], jac[0, 5] = z, -y
        jac[1, 3], jac[1, 5] = -z, x
        jac[2, 3], jac[2, 4] = y, -x
        m += f.hub[i] * (jac.T @ jac)
    return m


@kernel
def _forces(f: Flat, u: Array, places: Array, outer: Array, gravity: Array, strut: Array) -> Array:
    """(10,) generalised forces. outer: (4, 3) N at the hubs in body axes; gravity: (3,) m/s² in body axes."""
    q = np.zeros(10)
    turning, moving = u[3:6].copy(), u[:3].copy()
    bend, swing, arm, couple = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    _cross(turning, moving, bend)
    q[:3] = f.sprung * (gravity - bend)
    for i in range(4):
        place = places[i]
        _cross(turning, place, arm)
        _cross(turning, arm, swing)
        swing += bend
        swing[0] += 2 * turning[1] * u[6 + i]
        swing[1] -= 2 * turning[0] * u[6 + i]
        net = outer[i] + f.hub[i] * (gravity - swing)
        _cross(place, net, couple)
        q[:3] += net
        q[3:6] += couple
        q[6 + i] += net[2] - strut[i]
    return q


@lean_kernel
def _tread(f: Flat, o: Choices, i: int, moving: Array, normal: Array, steer: float, load: float, spin: float, lag: Array, force: Array) -> float:  # fmt: skip
    """A tyre's force in body axes (3,); returns its part along the wheel. moving: the contact's velocity; normal: the road's."""
    cos, sin = np.cos(steer), np.sin(steer)
    along, across = moving[0] * cos + moving[1] * sin, moving[1] * cos - moving[0] * sin
    floor = max(abs(along), 0.7)
    sx, sy = grip(load, (spin * f.radius - along) / floor, -np.arctan(across / floor), o.magic)
    gain = min(STEP_S * max(abs(along), 2.0) / 0.4, 1.0)
    lag[i, 0] += gain * (sx - lag[i, 0])
    lag[i, 1] += gain * (sy - lag[i, 1])
    fx, fy = lag[i, 0] * cos - lag[i, 1] * sin, lag[i, 0] * sin + lag[i, 1] * cos
    # in the road's plane, which the body's axes lean against
    force[0], force[1] = fx + load * normal[0], fy + load * normal[1]
    force[2] = load * normal[2] - (fx * normal[0] + fy * normal[1]) / normal[2]
    return float(lag[i, 0])


@kernel
def _turned(turn: Array, rate: Array) -> Array:
    """The attitude (3, 3), body to road, a step later; orthogonal again."""
    skew = np.array([[0.0, -rate[2], rate[1]], [rate[2], 0.0, -rate[0]], [-rate[1], rate[0], 0.0]])
    new = turn + STEP_S * (turn @ skew)
    return np.asarray(1.5 * new - 0.5 * (new @ new.T @ new))


@kernel
def _run(
    f: Flat, o: Choices, start: Array, speed: Array, steer: Array, grade: Array, bank: Array, out: Array
) -> None:
    u, turn, height = np.zeros(10), np.eye(3), f.sprung_height
    squeeze, spin, strut, load, foot = np.zeros(4), np.zeros(4), np.zeros(4), np.zeros(4), np.zeros(3)
    lag, outer, places = np.zeros((4, 2)), np.zeros((4, 3)), start.copy()
    moving, arm, gyro, closing = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(4)
    body = np.array([f.inertia[0], f.inertia[1], 0.97 * f.inertia[2]])
    u[0] = speed[0]
    spin[:] = speed[0] / f.radius
    for k in range(EVERY * len(out)):
        at = min(k + 50, len(speed) - 51)
        slope = (speed[at + 50] - speed[at - 50]) / (100 * STEP_S)
        drive, brake = pedals(f, speed[k], slope + G * grade[k], u[0], foot)
        normal = turn[2].copy()
        # ahead is along the body's own direction: gravity follows the course's slopes
        along = np.array([normal[2], 0.0, -normal[0]])
        left = np.array([-normal[0] * normal[1], 1 - normal[1] ** 2, -normal[1] * normal[2]])
        gravity = -G * (normal + grade[k] * along + bank[k] * left)
        torque = np.zeros(3)
        closing[:] = u[6:]
        struts(f, squeeze, closing, o.stiff, strut)
        for i in range(4):
            places[i, 2] = start[i, 2] + squeeze[i]
            hub = height + np.sum(normal * places[i])
            load[i] = max(f.resting[i] + f.hub[i] * G + f.tyre_rate * (f.radius - hub), 0.0)
            # wheels are thin discs: their lowest points lie in their own planes
            inside = np.array([normal[0], 0.0, normal[2]])
            down = -hub / np.sum(normal * inside) * inside
            _cross(u[3:6], places[i] + down, arm)
            moving[:] = u[:3] + arm
            moving[2] = 0.0
            road = _tread(
                f, o, i, moving, normal, steer[k] if i < 2 else 0.0, load[i], spin[i], lag, outer[i]
            )
            _cross(down, outer[i], arm)
            resist = f.rolling * load[i] * f.radius * np.tanh(4 * spin[i])
            given = drive * f.driven[i] - brake * f.braked[i] * np.tanh(8 * spin[i])
            before = spin[i]
            spin[i] = max(spin[i] + STEP_S * (given - road * f.radius - resist) / f.wheel_inertia, 0.0)
            # the wheel takes its own couple about its axle; the body gets what accelerates it, and the gyroscope
            torque[0] += arm[0] + f.wheel_inertia * spin[i] * u[5]
            torque[1] += arm[1] - f.wheel_inertia * (spin[i] - before) / STEP_S - resist
            torque[2] += arm[2] - f.wheel_inertia * spin[i] * u[3]
        q = _forces(f, u, places, outer, gravity, strut)
        _cross(u[3:6], body * u[3:6], gyro)
        q[3:6] += torque - gyro
        q[0] -= f.drag * u[0] * abs(u[0])
        acc = np.linalg.solve(_masses(f, places, body), q)
        _cross(u[3:6], u[:3], arm)
        if k % EVERY == 0:
            row = out[k // EVERY]
            row[T], row[V], row[BRAKE], row[DRIVE], row[STEER] = k * STEP_S, u[0], brake, drive, steer[k]
            row[BANK] = bank[k]
            row[FX : FX + 3] = acc[:3] + arm - gravity
            row[P : P + 3], row[DP : DP + 3] = u[3:6], acc[3:6]
            row[ROLL], row[PITCH] = (
                np.arctan2(normal[1], normal[2]) + bank[k],
                -np.arcsin(normal[0]) - grade[k],
            )
            row[FLAT_X : FLAT_X + 2] = (acc[:3] + arm)[:2]
            for i in range(4):
                row[DEFLECTION + i], row[STRUT + i], row[NORMAL + i] = squeeze[i], strut[i], load[i]
                row[SPEEDS + i] = spin[i] * f.radius
        u += STEP_S * acc
        if u[0] < 0.3 and speed[k] < 0.2:
            u[0], u[1], u[5] = 0.98 * u[0], 0.98 * u[1], 0.98 * u[5]
        squeeze += STEP_S * u[6:]
        height += STEP_S * np.sum(normal * u[:3])
        turn = _turned(turn, u[3:6])


def run(car: Car, course: Course, choices: Choices) -> Array:
    """Drive the course: (n, WIDTH) rows of `foreign_parts`."""
    steps = at_steps(course)
    f = flat(car)
    out = np.zeros((len(steps[0]) // EVERY, WIDTH))
    start = np.column_stack([f.ahead, f.left, np.full(4, f.radius - f.sprung_height)])
    _run(f, choices, start, *steps, out)
    return out
