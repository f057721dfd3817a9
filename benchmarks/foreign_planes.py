"""The shortest simulator that one writes: a bicycle that turns, a roll plane and a pitch plane on springs, rigid tyres.

The car follows the wanted speed exactly; torques follow from the balance of forces; wheels neither spin up nor weigh on
the springs. The body rolls about the roll axis and pitches about an axis as high as the links' anti-dive says, and its
tyre loads are sums: spring forces, the hubs' weight, and what the links carry.
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
    struts,
)  # fmt: skip

from parsers.jit import kernel


@kernel
def _run(
    f: Flat, o: Choices, speed: Array, slope: Array, steer: Array, grade: Array, bank: Array, out: Array
) -> None:
    w, yaw = 0.0, 0.0
    at, rate, acc = np.zeros(3), np.zeros(3), np.zeros(3)
    squeeze, closing, force = np.zeros(4), np.zeros(4), np.zeros(4)
    share = f.ahead[0] / f.wheelbase
    arm = f.sprung_height - o.axis * ((1 - share) * f.centre[0] + share * f.centre[2])
    rear = f.mass * G * f.x / f.wheelbase
    for k in range(EVERY * len(out)):
        u = max(speed[k], 1.0)
        _, front_y = grip(f.mass * G - rear, 0.0, steer[k] - (w + f.x * yaw) / u, o.magic)
        _, rear_y = grip(rear, 0.0, -(w - f.rear_x * yaw) / u, o.magic)
        rolls = min(speed[k], 1.0)
        ay = (front_y + rear_y) / f.mass * rolls + G * bank[k] * (1 - rolls)
        turn = (f.x * front_y - f.rear_x * rear_y) / f.inertia[2] * rolls
        if speed[k] < 0.5:
            w, yaw = 0.98 * w, 0.98 * yaw
        else:
            w += STEP_S * (ay - G * bank[k] - yaw * speed[k])
            yaw += STEP_S * turn
        fx = slope[k] + G * grade[k]
        push = f.mass * fx + f.drag * speed[k] * speed[k]
        link = o.links * (f.dive if push < 0 else f.squat)
        for i in range(4):
            squeeze[i] = -(at[0] - f.ahead[i] * at[2] + f.left[i] * at[1])
            closing[i] = -(rate[0] - f.ahead[i] * rate[2] + f.left[i] * rate[1])
        struts(f, squeeze, closing, o.stiff, force)
        tip = f.sprung_height - link
        roll = f.sprung * arm * (ay + G * at[1])
        pitch = -f.sprung * fx * tip + f.sprung * G * (f.sprung_height - o.tips * f.height) * at[2]
        for i in range(4):
            roll += force[i] * f.left[i]
            pitch -= force[i] * f.ahead[i]
        acc[0] = np.sum(force) / f.sprung - G
        acc[1] = roll / (f.inertia[0] + f.sprung * arm * arm)
        acc[2] = pitch / f.inertia[1]
        if k % EVERY == 0:
            row = out[k // EVERY]
            torque = (push + f.rolling * f.mass * G * rolls) * f.radius
            row[T], row[V], row[STEER] = k * STEP_S, speed[k], steer[k]
            row[BANK] = bank[k]
            row[DRIVE], row[BRAKE] = max(torque, 0.0), max(-torque, 0.0)
            sway = ay - arm * acc[1]
            row[FLAT_X], row[FLAT_Y] = slope[k], sway - G * bank[k]
            row[FX], row[FY] = fx - G * at[2], sway + G * at[1]
            row[FZ] = G + acc[0] + fx * at[2] - ay * at[1]
            row[P], row[Q], row[R] = rate[1], rate[2], yaw
            row[DP], row[DQ], row[DR] = acc[1], acc[2], turn
            row[ROLL], row[PITCH] = at[1] + bank[k], at[2] - grade[k]
            past = (push * link + (f.mass - f.sprung) * fx * f.radius) / (2 * f.wheelbase)
            for i in range(4):
                side = (front_y if i < 2 else rear_y) * o.axis * f.centre[i] / f.track[i]
                carried = (-side if i % 2 == 0 else side) + (-past if i < 2 else past)
                row[DEFLECTION + i], row[STRUT + i] = squeeze[i], force[i]
                row[NORMAL + i] = force[i] + f.hub[i] * G + carried
                row[SPEEDS + i] = max(speed[k] + (-yaw if i % 2 == 0 else yaw) * f.track[i] / 2, 0.0)
        for j in range(3):
            rate[j] += STEP_S * acc[j]
            at[j] += STEP_S * rate[j]


def run(car: Car, course: Course, choices: Choices) -> Array:
    """Drive the course: (n, WIDTH) rows of `foreign_parts`."""
    speed, steer, grade, bank = at_steps(course)
    window = np.ones(201) / 201
    speed = np.convolve(np.pad(speed, 100, mode="edge"), window, mode="valid")
    out = np.zeros((len(speed) // EVERY, WIDTH))
    _run(flat(car), choices, speed, np.gradient(speed, STEP_S), steer, grade, bank, out)
    return out
