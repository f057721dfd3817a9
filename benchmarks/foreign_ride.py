"""Fourteen degrees of freedom with massless links: a body that heaves, rolls and pitches, hubs on tyres, spinning wheels.

Roll about an axis through the roll centres or in the ground; anti-dive as a height, or none; the hubs' inertia in
turning and braking goes into the body through their links, or past it into the tyres; all by `Choices`. Small angles.
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
    DQ,
    DR,
    DRIVE,
    EVERY,
    FLAT_X,
    FLAT_Y,
    FX,
    FY,
    FZ,
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
    Q,
    R,
    T,
    V,
    at_steps,
    flat,
    grip,
    pedals,
    struts,
)  # fmt: skip

from parsers.jit import kernel, lean_kernel

# the car's state: plane (ahead, left, yaw rate), body (heave, roll, pitch) and its rates, sums of forces on the way
(U, W, YAW, Z, PHI, THETA, DZ, DPHI, DTHETA) = range(9)


@lean_kernel
def _wheel(
    f: Flat, o: Choices, s: Array, i: int, steer: float, torque: float, brake: float, load: float, spin: Array, fx: Array, fy: Array
) -> None:  # fmt: skip
    """Forces at the road in the car's axes (lagging by the tyre's length) and the wheel's turning."""
    cos, sin = np.cos(steer), np.sin(steer)
    ahead = f.x if i < 2 else -f.rear_x
    side = 0.5 * f.track[i] if i % 2 == 0 else -0.5 * f.track[i]
    u, w = s[U] - s[YAW] * side, s[W] + s[YAW] * ahead
    along, across = u * cos + w * sin, w * cos - u * sin
    floor = max(abs(along), 0.7)
    sx, sy = grip(load, (spin[i] * f.radius - along) / floor, -np.arctan(across / floor), o.magic)
    gain = min(STEP_S * max(abs(along), 2.0) / 0.4, 1.0)
    ex, ey = sx * cos - sy * sin, sx * sin + sy * cos
    fx[i] += gain * (ex - fx[i])
    fy[i] += gain * (ey - fy[i])
    tread = (fx[i] * cos + fy[i] * sin) * f.radius
    resist = o.turned * f.rolling * load * f.radius * np.tanh(spin[i] * 4)
    slope = (torque - brake * np.tanh(spin[i] * 8) - resist - tread) / f.wheel_inertia
    spin[i] = max(spin[i] + STEP_S * slope, 0.0)


@lean_kernel
def _direct(f: Flat, o: Choices, i: int, fx: float, fy: Array, ax: float, ay: float, link: float) -> float:
    """Load on a tyre that the links carry past the spring, N."""
    j = i + 1 if i % 2 == 0 else i - 1
    centre = o.axis * f.centre[i]
    across = (fy[i] + fy[j]) * centre + (1 - o.lean) * 2 * f.hub[i] * ay * (f.radius - centre)
    along = fx * link + (1 - o.nose) * 2 * (f.hub[0] + f.hub[2]) * ax * (f.radius - link)
    over = float(across / f.track[i])
    ahead = float(along / (2 * f.wheelbase))
    return (-over if i % 2 == 0 else over) + (-ahead if i < 2 else ahead)


@lean_kernel
def _body(f: Flat, o: Choices, s: Array, force: Array, ax: float, ay: float, push: float, link: float, spun: float, out: Array) -> None:  # fmt: skip
    """Heave, roll and pitch accelerations. push: sum of tyre forces ahead; spun: couple of the wheels' spinning up."""
    share = f.ahead[0] / f.wheelbase
    axis = o.axis * ((1 - share) * f.centre[0] + share * f.centre[2])
    arm = f.sprung_height - axis
    lift, roll, pitch = 0.0, 0.0, 0.0
    for i in range(4):
        lift += force[i]
        roll += force[i] * f.left[i]
        pitch -= force[i] * f.ahead[i]
        roll += o.lean * f.hub[i] * ay * (f.radius - o.axis * f.centre[i])
    hubs = f.mass - f.sprung
    pitch -= f.mass * f.height * ax - push * link + spun
    pitch += (1 - o.nose) * hubs * ax * (f.radius - link)
    pitch -= f.drag * s[U] * s[U] * f.sprung_height
    pitch += f.sprung * G * (f.sprung_height - o.tips * f.height) * s[THETA]
    coupled = f.sprung * arm * (1 - f.sprung / f.mass) * arm
    roll += f.sprung * arm * (ay + G * s[PHI])
    out[0], out[1], out[2] = lift / f.sprung - G, roll / (f.inertia[0] + coupled), pitch / f.inertia[1]


@lean_kernel
def _write(f: Flat, o: Choices, s: Array, acc: Array, ax: float, ay: float, yaw: float, grade: float, bank: float, row: Array) -> None:  # fmt: skip
    """What the sprung CG feels, and the angles against the horizon."""
    share = f.ahead[0] / f.wheelbase
    arm = f.sprung_height - o.axis * ((1 - share) * f.centre[0] + share * f.centre[2])
    sway = ay - arm * acc[1] * (1 - f.sprung / f.mass)
    row[V], row[P], row[Q], row[R] = s[U], s[DPHI], s[DTHETA], s[YAW]
    row[FX], row[FY] = ax - G * s[THETA], sway + G * s[PHI]
    row[FZ] = G + acc[0] + ax * s[THETA] - ay * s[PHI]
    row[DP], row[DQ], row[DR] = acc[1], acc[2], yaw
    row[ROLL], row[PITCH] = s[PHI] + bank, s[THETA] - grade
    row[FLAT_X], row[FLAT_Y] = ax - G * grade, sway - G * bank


@kernel
def _run(f: Flat, o: Choices, speed: Array, steer: Array, grade: Array, bank: Array, out: Array) -> None:
    s, acc, foot = np.zeros(9), np.zeros(3), np.zeros(3)
    hub, hub_rate, spin = np.zeros(4), np.zeros(4), np.zeros(4)
    fx, fy, load, force, squeeze, rate = (
        np.zeros(4),
        np.zeros(4),
        np.zeros(4),
        np.zeros(4),
        np.zeros(4),
        np.zeros(4),
    )
    s[U] = speed[0]
    spin[:] = s[U] / f.radius
    before = spin.copy()
    for k in range(EVERY * len(out)):
        at = min(k + 50, len(speed) - 51)
        slope = (speed[at + 50] - speed[at - 50]) / (100 * STEP_S)
        drive, brake = pedals(f, speed[k], slope + G * grade[k], s[U], foot)
        push, side, turn, resist = 0.0, 0.0, 0.0, 0.0
        before[:] = spin
        for i in range(4):
            load[i] = max(f.resting[i] + f.hub[i] * G - f.tyre_rate * hub[i], 0.0)
            _wheel(
                f,
                o,
                s,
                i,
                steer[k] if i < 2 else 0.0,
                drive * f.driven[i],
                brake * f.braked[i],
                load[i],
                spin,
                fx,
                fy,
            )
            push += fx[i]
            side += fy[i]
            resist += (1 - o.turned) * f.rolling * load[i] * np.tanh(4 * s[U])
            turn += fy[i] * (f.x if i < 2 else -f.rear_x) - fx[i] * (0.5 if i % 2 == 0 else -0.5) * f.track[i]
        spun = f.wheel_inertia * o.spin * np.sum(spin - before) / STEP_S
        ax, ay = (push - resist - f.drag * s[U] * s[U]) / f.mass, side / f.mass
        parked = s[U] < 0.3 and speed[k] < 0.2
        if parked:
            ax, ay = G * grade[k], G * bank[k]
        link = o.links * (f.dive if push < 0 else f.squat)
        yaw = turn / f.inertia[2]
        for i in range(4):
            squeeze[i] = hub[i] - (s[Z] - f.ahead[i] * s[THETA] + f.left[i] * s[PHI])
            rate[i] = hub_rate[i] - (s[DZ] - f.ahead[i] * s[DTHETA] + f.left[i] * s[DPHI])
        struts(f, squeeze, rate, o.stiff, force)
        _body(f, o, s, force, ax, ay, push - resist, link, spun, acc)
        for i in range(4):
            direct = _direct(f, o, i, push - resist, fy, ax, ay, link)
            hub_rate[i] += STEP_S * (load[i] - force[i] - f.hub[i] * G - direct) / f.hub[i]
            hub[i] += STEP_S * hub_rate[i]
        if k % EVERY == 0:
            row = out[k // EVERY]
            _write(f, o, s, acc, ax, ay, yaw, grade[k], bank[k], row)
            row[T], row[BRAKE], row[DRIVE], row[STEER] = k * STEP_S, brake, drive, steer[k]
            row[BANK] = bank[k]
            for i in range(4):
                row[DEFLECTION + i], row[STRUT + i], row[NORMAL + i] = squeeze[i], force[i], load[i]
                row[SPEEDS + i] = spin[i] * f.radius
        for j in range(3):
            s[DZ + j] += STEP_S * acc[j]
            s[Z + j] += STEP_S * s[DZ + j]
        if parked:
            s[U], s[W], s[YAW] = s[U] * 0.98, s[W] * 0.98, s[YAW] * 0.98
        else:
            ahead = ax - G * grade[k] + s[YAW] * s[W]
            s[W] += STEP_S * (ay - G * bank[k] - s[YAW] * s[U])
            s[U] = max(s[U] + STEP_S * ahead, 0.0)
            s[YAW] += STEP_S * yaw


def run(car: Car, course: Course, choices: Choices) -> Array:
    """Drive the course: (n, WIDTH) rows of `foreign_parts`."""
    steps = at_steps(course)
    out = np.zeros((len(steps[0]) // EVERY, WIDTH))
    _run(flat(car), choices, *steps, out)
    return out
