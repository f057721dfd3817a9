"""Seven degrees of freedom on a rough road: a body on four springs, four wheels on tyres, pushed by m a h.

As a ride engineer writes it who needs some braking and cornering too: accelerations follow from the course, moments are
put on the body, roll centres sink as the wheels rise, springs stiffen, dampers have a knee. With leaf springs (rub) dry
friction follows the travel with memory and holds much of what the springs carry.
"""

from __future__ import annotations

from typing import NamedTuple

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
    Flat,
    P,
    Q,
    R,
    T,
    V,
    flat,
)  # fmt: skip

from parsers.jit import kernel

FINE = 10
ROUGH = 16e-6
"""m³ at 0.1 cycles/m: a road of class A."""


class Rig(NamedTuple):
    """What this author puts in: dry friction over what a spring carries, stiffening at 50 mm, roll centres' sinking over the
    wheels' rising, share of anti-dive."""

    rub: float
    stiffer: float
    sinks: float
    links: float


def _profile(speed: Array, length: float, rng: np.random.Generator) -> Array:
    """(n, 4) m, the road under the wheels: brown noise with the way driven, rear wheels in the front ones' tracks."""
    way = np.cumsum(speed) / LOG_HZ
    step = 0.05
    count = int((way[-1] + length) / step) + 10
    tracks = np.empty((count, 2))
    slopes = rng.standard_normal((count, 2)) * np.sqrt(ROUGH * 0.01 * (2 * np.pi) ** 2 / (2 * step))
    level = np.zeros(2)
    for i in range(count):
        level = level * (1 - 0.15 * step) + slopes[i] * step
        tracks[i] = level
    grid = np.arange(count) * step
    return np.column_stack(
        [np.interp(way + (length if i < 2 else 0.0), grid, tracks[:, i % 2]) for i in range(4)]
    )


@kernel
def _ride(f: Flat, o: Rig, ax: Array, ay: Array, pushed: Array, road: Array, out: Array) -> None:
    """out (n, 21): heave, roll, pitch, their rates, their accelerations; squeeze, strut and load of the four wheels."""
    z, phi, theta, dz, dphi, dtheta = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    az, aphi, atheta = 0.0, 0.0, 0.0
    hub, speed, held = road[0].copy(), np.zeros(4), np.zeros(4)
    squeeze, force, load = np.zeros(4), np.zeros(4), np.zeros(4)
    before = np.zeros(4)
    h = 1.0 / (LOG_HZ * FINE)
    hubs = f.mass - f.sprung
    for n in range(len(ax)):
        link = o.links * (f.dive if pushed[n] < 0 else f.squat)
        for k in range(FINE):
            part = k / FINE
            after = min(n + 1, len(ax) - 1)
            for i in range(4):
                before[i] = squeeze[i]
                squeeze[i] = hub[i] - (z - f.ahead[i] * theta + f.left[i] * phi)
                rate = speed[i] - (dz - f.ahead[i] * dtheta + f.left[i] * dphi)
                # dry friction creeps to its limit within some mm of travel, the other way at every turn
                limit = o.rub * f.resting[i] + f.friction
                moved = squeeze[i] - before[i]
                held[i] += (limit * np.sign(moved) - held[i]) * min(abs(moved) / 0.002, 1.0)
            for i in range(4):
                j = i + 1 if i % 2 == 0 else i - 1
                rate = speed[i] - (dz - f.ahead[i] * dtheta + f.left[i] * dphi)
                bar = f.bar[i] / f.track[i] ** 2 * (squeeze[i] - squeeze[j])
                damp = f.damper[i] * (
                    rate if abs(rate) < 0.15 else np.sign(rate) * (0.15 + 0.5 * (abs(rate) - 0.15))
                )
                spring = f.spring[i] * squeeze[i] * (1 + o.stiffer * squeeze[i] / 0.05)
                force[i] = f.resting[i] + spring + bar + damp + held[i]
                load[i] = max(
                    f.resting[i]
                    + f.hub[i] * G
                    + f.tyre_rate * ((1 - part) * road[n, i] + part * road[after, i] - hub[i]),
                    0.0,
                )
            roll, pitch, lift = 0.0, 0.0, 0.0
            carried = 0.0
            for i in range(4):
                lift += force[i]
                roll += force[i] * f.left[i]
                pitch -= force[i] * f.ahead[i]
                j = i + 1 if i % 2 == 0 else i - 1
                share = (f.rear_x if i < 2 else f.x) / f.wheelbase
                centre = f.centre[i] - o.sinks * 0.5 * (squeeze[i] + squeeze[j])
                side = share * f.mass * ay[n]
                couple = side * centre + 2 * f.hub[i] * ay[n] * (f.radius - centre)
                over = couple / f.track[i]
                carried += 0.5 * side * centre + f.hub[i] * ay[n] * (f.radius - centre)
                along = (f.mass * link + hubs * (f.radius - link)) * ax[n] / (2 * f.wheelbase)
                direct = (-over if i % 2 == 0 else over) + (-along if i < 2 else along)
                speed[i] += h * (load[i] - force[i] - f.hub[i] * G - direct) / f.hub[i]
            roll += (f.mass * f.height * ay[n] - carried) + f.sprung * G * f.sprung_height * phi * 0.8
            pitch -= (f.mass * f.height - f.mass * link - hubs * (f.radius - link)) * ax[n]
            az, aphi, atheta = lift / f.sprung - G, roll / f.inertia[0], pitch / f.inertia[1]
            for i in range(4):
                hub[i] += h * speed[i]
            dz, dphi, dtheta = dz + h * az, dphi + h * aphi, dtheta + h * atheta
            z, phi, theta = z + h * dz, phi + h * dphi, theta + h * dtheta
        out[n, 0], out[n, 1], out[n, 2], out[n, 3], out[n, 4] = z, phi, theta, dz, dphi
        out[n, 5], out[n, 6], out[n, 7], out[n, 8] = dtheta, az, aphi, atheta
        for i in range(4):
            out[n, 9 + i], out[n, 13 + i], out[n, 17 + i] = squeeze[i], force[i], load[i]


def run(car: Car, course: Course, choices: Choices) -> Array:
    """Drive the course: (n, WIDTH) rows of `foreign_parts`. choices.stiff above 1: leaf springs."""
    time, speed, ahead, across, yaw, steer, grade, bank = followed(car, course)
    felt_x, felt_y = ahead + G * grade, across + G * bank
    rig = Rig(0.06 if choices.stiff > 1 else 0.0, 0.05, 0.6, choices.links)
    drive, brake = torques(car, speed, felt_x)
    road = _profile(speed, car.wheelbase, np.random.default_rng(int(1e3 * car.mass)))
    body = np.zeros((len(time), 21))
    _ride(flat(car), rig, felt_x, felt_y, drive - brake, road, body)
    _, roll, pitch, _, p, q, az, dp, dq = body[:, :9].T
    rows = np.zeros((len(time), WIDTH))
    rows[:, T], rows[:, V], rows[:, STEER], rows[:, BANK] = time, speed, steer, bank
    rows[:, P], rows[:, Q], rows[:, R] = p, q, yaw
    rows[:, DP], rows[:, DQ], rows[:, DR] = dp, dq, slope_of(yaw)
    arm = car.sprung_height - car.axis
    sway = felt_y - arm * dp * (1 - car.sprung / car.mass)
    rows[:, FX], rows[:, FY] = felt_x - G * pitch, sway + G * roll
    rows[:, FZ] = G + az + felt_x * pitch - felt_y * roll
    rows[:, ROLL], rows[:, PITCH] = roll + bank, pitch - grade
    rows[:, FLAT_X], rows[:, FLAT_Y], rows[:, DRIVE], rows[:, BRAKE] = ahead, across, drive, brake
    rows[:, DEFLECTION : DEFLECTION + 4] = body[:, 9:13]
    rows[:, STRUT : STRUT + 4], rows[:, NORMAL : NORMAL + 4] = body[:, 13:17], body[:, 17:21]
    for i in range(4):
        rows[:, SPEEDS + i] = speed - (1.0 if i % 2 == 0 else -1.0) * 0.5 * car.track[i // 2] * yaw
    return rows
