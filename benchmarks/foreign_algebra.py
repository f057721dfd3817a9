"""A point on wheels: speed and curvature are what they are, and every load is m a h over a lever. No motion of its own.

What a student, a game or a fleet's tool has: no unsprung mass, no roll centres, no dampers, loads and angles that follow
accelerations at once. `foreign_recorders.plain_car` makes a car without what this author never heard of.
"""

from __future__ import annotations

import numpy as np
from foreign_car import Array, Car, G
from foreign_course import RATE_HZ, Course
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


def smooth(values: Array, seconds: float) -> Array:
    """A symmetric bell of this width, so that derivatives are finite."""
    half = int(3 * seconds * LOG_HZ)
    weights = np.exp(-0.5 * (np.arange(-half, half + 1) / (seconds * LOG_HZ)) ** 2)
    return np.asarray(np.convolve(np.pad(values, half, mode="edge"), weights / weights.sum(), mode="valid"))


def slope_of(values: Array) -> Array:
    """Derivative by time."""
    return np.asarray(np.gradient(values) * LOG_HZ)


def followed(car: Car, course: Course) -> tuple[Array, ...]:
    """Time, speed, acceleration ahead and across over the road, yaw rate, steering, grade, bank: at the record's rate."""
    at = np.arange(len(course.speed)) / RATE_HZ
    time = np.arange(int(len(course.speed) / RATE_HZ * LOG_HZ)) / LOG_HZ
    speed, steer, grade, bank = (
        np.interp(time, at, c) for c in (course.speed, course.steer, course.grade, course.bank)
    )
    speed = smooth(speed, 0.15)
    yaw = smooth(speed * steer / (car.wheelbase + 0.0025 * speed**2), 0.1)
    return time, speed, slope_of(speed), speed * yaw, yaw, steer, grade, bank


def torques(car: Car, speed: Array, felt: Array) -> tuple[Array, Array]:
    """Drive and brake torque of all wheels for a felt acceleration ahead: m a and what air and rolling take."""
    need = car.radius * (
        car.mass * felt + 0.6 * car.drag_area * speed**2 + car.rolling * car.mass * G * (speed > 0.2)
    )
    return np.maximum(need, 0.0), np.maximum(-need, 0.0)


def run(car: Car, course: Course, choices: Choices) -> Array:
    """Drive the course: (n, WIDTH) rows of `foreign_parts`. choices.tips 1: accelerations without gravity's share."""
    time, speed, ahead, across, yaw, steer, grade, bank = followed(car, course)
    felt_x, felt_y = ahead + G * grade, across + G * bank
    roll = car.mass * car.height * felt_y / (car.roll_stiffness - car.mass * G * car.height)
    front, rear = (2 * k for k in car.spring)
    back = car.wheelbase - car.x
    pitch = -car.mass * car.height * felt_x / (front * car.x**2 + rear * back**2)
    rows = np.zeros((len(time), WIDTH))
    rows[:, T], rows[:, V], rows[:, STEER], rows[:, BANK] = time, speed, steer, bank
    rows[:, P], rows[:, Q], rows[:, R] = slope_of(roll), slope_of(pitch), yaw
    rows[:, DP], rows[:, DQ], rows[:, DR] = (slope_of(rows[:, i]) for i in (P, Q, R))
    tipped = G * (1 - choices.tips)
    rows[:, FX], rows[:, FY], rows[:, FZ] = felt_x - tipped * pitch, felt_y + tipped * roll, G
    rows[:, ROLL], rows[:, PITCH] = roll + bank, pitch - grade
    rows[:, FLAT_X], rows[:, FLAT_Y] = ahead, across
    rows[:, DRIVE], rows[:, BRAKE] = torques(car, speed, felt_x)
    moved = car.mass * car.height * felt_x / (2 * car.wheelbase)
    shares = [0.5 * k * t * t + b for k, t, b in zip(car.spring, car.track, car.bar, strict=True)]
    for i in range(4):
        axle, side = i // 2, 1.0 if i % 2 == 0 else -1.0
        lateral = car.mass * car.height * felt_y * shares[axle] / (sum(shares) * car.track[axle])
        rows[:, NORMAL + i] = car.resting[i] + (moved if axle else -moved) - side * lateral
        level = (car.x if axle == 0 else -back) * pitch
        rows[:, DEFLECTION + i] = level - side * 0.5 * car.track[axle] * roll
        rows[:, STRUT + i] = rows[:, NORMAL + i]
        rows[:, SPEEDS + i] = speed * (1 + 0 * yaw) - side * 0.5 * car.track[axle] * yaw
    return rows
