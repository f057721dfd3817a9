"""The textbooks' single track with roll: linear tyres, a sprung mass on a roll axis, one spring and one damper.

States: side speed, yaw rate, roll angle, roll rate. Pitch is a second spring and damper under m h a_x. Loads on the tyres
are sums of levers. No hubs' own couples, no anti-dive, no wheel spin; the speed is what the course says.
"""

from __future__ import annotations

import numpy as np
from foreign_algebra import followed, slope_of, torques
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
    FLAT_X,
    FLAT_Y,
    FX,
    FY,
    FZ,
    LOG_HZ,
    NORMAL,
    PITCH,
    ROLL,
    SPEEDS,
    STEER,
    STRUT,
    WIDTH,
    Choices,
    P,
    Q,
    R,
    T,
    V,
)  # fmt: skip

from parsers.jit import kernel

FINE = 10


@kernel
def _motion(k: Array, speed: Array, steer: Array, bank: Array, ahead: Array, out: Array) -> None:
    """k: mass, yaw inertia, a, b, both cornering stiffnesses, sprung mass x arm, roll inertia about the axis, roll spring
    less gravity, roll damper, pitch inertia, spring, damper, m h. out (n, 8): side force over mass, yaw acceleration,
    yaw rate, roll and its two derivatives, pitch, pitch rate."""
    w, r, phi, p, theta, q = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    h = 1.0 / (LOG_HZ * FINE)
    for i in range(len(speed)):
        v = max(speed[i], 1.0)
        moving = 1.0 if speed[i] > 1.0 else 0.0
        for _ in range(FINE):
            front = -k[4] * ((w + k[2] * r) / v - steer[i]) * moving
            rear = -k[5] * (w - k[3] * r) / v * moving
            side = (front + rear) / k[0]
            if moving == 0.0:
                side = G * bank[i]
            # the body's swing takes part in the side force: two equations in w' and p'
            roll = (k[6] * side - k[8] * phi - k[9] * p) / (k[7] - k[6] * k[6] / k[0])
            turn = (k[2] * front - k[3] * rear) / k[1]
            w += h * (side - G * bank[i] - v * r) * moving - h * 5.0 * w * (1.0 - moving)
            r += h * turn - h * 5.0 * r * (1.0 - moving)
            p += h * roll
            phi += h * p
            q += h * (-k[13] * ahead[i] - k[11] * theta - k[12] * q) / k[10]
            theta += h * q
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = side, turn, r, phi
        out[i, 4], out[i, 5], out[i, 6], out[i, 7] = p, roll, theta, q


def run(car: Car, course: Course, choices: Choices) -> Array:
    """Drive the course: (n, WIDTH) rows of `foreign_parts`. choices.axis 0: the body rolls about a line in the ground."""
    time, speed, ahead, _, _, steer, grade, bank = followed(car, course)
    felt_x = ahead + G * grade
    axis, back = choices.axis * car.axis, car.wheelbase - car.x
    arm = car.sprung_height - axis
    swung = car.sprung * arm
    springs = [2 * c for c in car.spring]
    nodding = springs[0] * car.x**2 + springs[1] * back**2
    damped = [2 * d for d in car.damper]
    rolled = sum(0.25 * d * t * t for d, t in zip(damped, car.track, strict=True))
    constants = np.array([
        car.mass, car.inertia[2], car.x, back, 9.0 * car.mass * G * back / car.wheelbase, 10.5 * car.mass * G * car.x / car.wheelbase,
        swung, car.sprung_inertia[0] + swung * arm, car.roll_stiffness - swung * G, rolled,
        car.inertia[1], nodding, damped[0] * car.x**2 + damped[1] * back**2, car.mass * car.height,
    ])  # fmt: skip
    body = np.zeros((len(time), 8))
    _motion(constants, speed, steer, bank, felt_x, body)
    side, turn, yaw, roll, rate, quick, pitch, nod = body.T
    rows = np.zeros((len(time), WIDTH))
    rows[:, T], rows[:, V], rows[:, STEER], rows[:, BANK] = time, speed, steer, bank
    rows[:, P], rows[:, Q], rows[:, R] = rate, nod, yaw
    rows[:, DP], rows[:, DQ], rows[:, DR] = quick, slope_of(nod), turn
    # the sprung CG swings about the axis, whose own path the tyres' forces make
    sway = side - arm * quick * (1 - car.sprung / car.mass)
    rows[:, FX], rows[:, FY] = felt_x - G * pitch, sway + G * roll
    rows[:, FZ] = G + felt_x * pitch - side * roll
    rows[:, ROLL], rows[:, PITCH] = roll + bank, pitch - grade
    rows[:, FLAT_X], rows[:, FLAT_Y] = ahead, side - G * bank
    rows[:, DRIVE], rows[:, BRAKE] = torques(car, speed, felt_x)
    moved = car.mass * car.height * felt_x / (2 * car.wheelbase)
    shares = [0.5 * k * t * t + b for k, t, b in zip(car.spring, car.track, car.bar, strict=True)]
    centres = [choices.axis * c for c in car.centre]
    parts = [back / car.wheelbase, car.x / car.wheelbase]
    for i in range(4):
        axle, sign = i // 2, 1.0 if i % 2 == 0 else -1.0
        sprung = (car.roll_stiffness * roll + rolled * rate) * shares[axle] / sum(shares)
        links = parts[axle] * car.mass * side * centres[axle]
        hubs = car.unsprung[axle] * side * (car.radius - centres[axle])
        over = sign * (sprung + links + hubs) / car.track[axle]
        level = (car.x if axle == 0 else -back) * pitch
        rows[:, NORMAL + i] = (
            car.resting[i] + 0.5 * car.unsprung[axle] * G + (moved if axle else -moved) - over
        )
        rows[:, DEFLECTION + i] = level - sign * 0.5 * car.track[axle] * roll
        rows[:, STRUT + i] = car.resting[i] + (moved if axle else -moved) - sign * sprung / car.track[axle]
        rows[:, SPEEDS + i] = speed - sign * 0.5 * car.track[axle] * yaw
    return rows
