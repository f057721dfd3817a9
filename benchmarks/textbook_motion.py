"""The textbook car in motion: the compiled run over a course. What it models, leaves out, and its signs: `textbook_car`.

Semi-implicit Euler at 1 kHz.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from textbook_car import Car, G, Parts, parts_of

from parsers.jit import kernel, lean_kernel
from pipelines.results import FloatArray

STEP_S = 0.001
EVERY = 10
"""Steps a row of the output, which has 100 Hz."""

(COL_TIME, COL_SPEED, COL_ACCEL, COL_RATE, COL_ROLL, COL_PITCH, COL_DEFLECTION, COL_WHEEL_SPEED, COL_STRUT,
 COL_BRAKE, COL_DRIVE, COL_STEER, COL_CORNER, COLUMNS) = (0, 1, 2, 5, 8, 9, 10, 14, 18, 22, 23, 24, 25, 29)  # fmt: skip
"""Output. ACCEL, RATE: x, y, z of the inertial unit. Four wheels each: deflection from rest, speed of the tread, strut
force, and CORNER, vertical acceleration of the body above the wheel. BRAKE, DRIVE: torque of all wheels. ROLL and PITCH
are against the horizon."""

(VX, VY, YAW_RATE, ROLL, ROLL_RATE, PITCH, PITCH_RATE, HEAVE, HEAVE_RATE, EFFORT,
 FORCE_X, FORCE_Y, YAW_MOMENT, SPIN_MOMENT, LIFT, ROLL_MOMENT, PITCH_MOMENT, SPECIFIC_X, SPECIFIC_Y, GRAVITY,
 VX_SLOPE, VY_SLOPE, YAW_SLOPE, ROLL_SLOPE, PITCH_SLOPE, HEAVE_SLOPE, BODY_PLACES) = range(27)  # fmt: skip
"""The body's vector: its state, the driver's memory, and forces and accelerations of the step."""

(HUB, HUB_RATE, TURNING, LAGGED_X, LAGGED_Y, RUB, LOAD, GROUND_Y, SQUEEZE, SQUEEZE_RATE, STRUT, WHEEL_PLACES) = range(12)  # fmt: skip
"""Rows of the wheels' matrix, a column a wheel: fl, fr, rl, rr. RUB: dry friction as a share of its full force."""


class Course(NamedTuple):
    """What is asked and what the road is, at each step. steer: of the road wheels. brake: pressure; where there is none
    the driver follows speed by throttle or brake."""

    steer: FloatArray
    speed: FloatArray
    brake: FloatArray
    left: FloatArray
    right: FloatArray
    grade: FloatArray
    bank: FloatArray


@lean_kernel
def _at_rest(course: Course, body: FloatArray, k: int) -> bool:
    """Whether the car stands, and is meant to."""
    return bool(body[VX] < 0.3 and course.speed[k] < 0.2)


@lean_kernel
def _driver(car: Car, course: Course, body: FloatArray, k: int) -> tuple[float, float]:
    """Drive and brake torque of all wheels: the pressure asked, or else a controller of speed."""
    brake = course.brake[k] * car.brake_gain
    drive = 0.0
    if course.brake[k] <= 0.0:
        error = course.speed[k] - body[VX]
        body[EFFORT] = min(max(body[EFFORT] + error * STEP_S * 0.25, -1.0), 2.5)
        force = car.mass * min(max(0.9 * error + body[EFFORT], -2.5), 3.0)
        if force >= 0:
            drive = force * car.radius
        else:
            brake = -force * car.radius
    else:
        body[EFFORT] = 0.0
    if _at_rest(course, body, k):
        brake = max(brake, car.mass * 2 * car.radius)
    return drive, brake


@lean_kernel
def _tyre_loads(car: Car, parts: Parts, course: Course, body: FloatArray, wheels: FloatArray, k: int) -> None:
    """Each tyre as a spring on the road's profile, which the rear wheels meet a wheelbase later; it cannot pull."""
    late = max(0, k - int(car.wheelbase / max(body[VX], 2.0) / STEP_S))
    for i in range(4):
        when = k if i < 2 else late
        road = course.left[when] if i % 2 == 0 else course.right[when]
        rest = parts.static[i] + parts.hub_kg[i] * G
        wheels[LOAD, i] = max(0.0, rest + car.tyre_rate * (road - wheels[HUB, i]))


@lean_kernel
def _grip(load: float, slip: float, angle: float) -> tuple[float, float]:
    """Steady tyre force along and across the wheel at a slip ratio and a slip angle."""
    peak = load * (1 - 0.12 * (load / 4500 - 1))
    along = slip / 0.09
    across = np.tan(angle) / 0.10
    both = np.sqrt(along * along + across * across) + 1e-9
    force = peak * np.sin(1.4 * np.arctan(1.25 * both))
    return force * along / both, force * across / both


@lean_kernel
def _wheel(
    car: Car, parts: Parts, body: FloatArray, wheels: FloatArray, i: int, steer: float, drive: float, brake: float
) -> None:  # fmt: skip
    """One wheel on the road: its lagging tyre forces, its spin, and its share of force and moment on the car."""
    x, y = parts.x[i], parts.y[i]
    cos, sin = np.cos(steer), np.sin(steer)
    ux, uy = body[VX] - body[YAW_RATE] * y, body[VY] + body[YAW_RATE] * x
    along = ux * cos + uy * sin
    across = -ux * sin + uy * cos
    speed = abs(along)
    tread = wheels[TURNING, i] * car.radius
    floor = max(speed, 0.8)
    fx, fy = _grip(wheels[LOAD, i], (tread - along) / floor, -np.arctan2(across, floor))
    gain = 0.05 if speed < 1.5 else min(STEP_S / (0.35 / max(speed, 1.5)), 1.0)
    wheels[LAGGED_X, i] += gain * (fx - wheels[LAGGED_X, i])
    wheels[LAGGED_Y, i] += gain * (fy - wheels[LAGGED_Y, i])
    fx, fy = wheels[LAGGED_X, i], wheels[LAGGED_Y, i]
    resistance = car.rolling * wheels[LOAD, i] * car.radius * np.tanh(tread / 0.3)
    if tread - speed > 0.12 * speed + 0.3:  # traction control
        drive *= 0.15
    slope = (drive - brake * np.tanh(tread / 0.15) - resistance - fx * car.radius) / car.wheel_inertia
    slope = max(slope, -wheels[TURNING, i] / STEP_S)
    body[SPIN_MOMENT] += car.wheel_inertia * slope
    wheels[TURNING, i] = max(wheels[TURNING, i] + STEP_S * slope, 0.0)
    ahead = fx * cos - fy * sin
    wheels[GROUND_Y, i] = fx * sin + fy * cos
    body[FORCE_X] += ahead
    body[FORCE_Y] += wheels[GROUND_Y, i]
    body[YAW_MOMENT] += wheels[GROUND_Y, i] * x - ahead * y


@lean_kernel
def _struts(car: Car, parts: Parts, body: FloatArray, wheels: FloatArray) -> None:
    """Deflections, strut forces (springs, bars, dampers, friction, bump stops), and what they do to the body."""
    for i in range(4):
        x, y = parts.body_x[i], parts.body_y[i]
        wheels[SQUEEZE, i] = wheels[HUB, i] - (body[HEAVE] - x * body[PITCH] + y * body[ROLL])
        rate = body[HEAVE_RATE] - x * body[PITCH_RATE] + y * body[ROLL_RATE]
        wheels[SQUEEZE_RATE, i] = wheels[HUB_RATE, i] - rate
    for i in range(4):
        squeeze, rate = wheels[SQUEEZE, i], wheels[SQUEEZE_RATE, i]
        opposite = wheels[SQUEEZE, i + 1 if i % 2 == 0 else i - 1]
        bar = parts.bar[i] * (squeeze - opposite) / (car.track * car.track)
        damping = parts.damper[i] * (0.7 if rate > 0 else 1.3)
        if abs(rate) > 0.25:
            damping *= 0.7
        rub = wheels[RUB, i]
        rub += STEP_S * rate * (1 - rub * np.sign(rate)) / 0.0015
        wheels[RUB, i] = min(max(rub, -1.0), 1.0)
        stop = 2e5 * (squeeze - 0.08) if squeeze > 0.08 else 0.0
        spring = parts.spring[i] * (squeeze + 0.6 * squeeze**2)
        force = parts.static[i] + spring + bar + damping * rate + car.friction * wheels[RUB, i] + stop
        wheels[STRUT, i] = force
        body[LIFT] += force
        body[ROLL_MOMENT] += force * parts.body_y[i]
        body[PITCH_MOMENT] += -force * parts.body_x[i]


@lean_kernel
def _pitch_centre(car: Car, body: FloatArray) -> float:
    return car.pitch_centre_braking if body[FORCE_X] < 0 else car.pitch_centre_driving


@lean_kernel
def _accelerate(car: Car, parts: Parts, course: Course, body: FloatArray, k: int) -> None:
    """Accelerations of the car in the road's plane and of the body on its springs."""
    drag = 0.5 * 1.2 * car.drag_area * body[VX] * body[VX]
    ahead, left = (body[FORCE_X] - drag) / car.mass, body[FORCE_Y] / car.mass
    body[SPECIFIC_X], body[SPECIFIC_Y] = ahead, left
    body[VX_SLOPE] = ahead - G * np.sin(course.grade[k]) + body[YAW_RATE] * body[VY]
    body[VY_SLOPE] = left - G * np.sin(course.bank[k]) - body[YAW_RATE] * body[VX]
    body[YAW_SLOPE] = body[YAW_MOMENT] / car.yaw_inertia
    if _at_rest(course, body, k):
        body[VX_SLOPE], body[VY_SLOPE] = -20 * body[VX], -20 * body[VY]
        body[YAW_SLOPE] = -20 * body[YAW_RATE]
    gravity = G * np.cos(course.grade[k]) * np.cos(course.bank[k])
    body[GRAVITY] = gravity
    kg, arm = parts.sprung_kg, parts.arm
    height = parts.sprung_height
    rolling = body[ROLL_MOMENT] + kg * arm * left + kg * gravity * arm * body[ROLL]
    body[ROLL_SLOPE] = rolling / (parts.roll_inertia + kg * arm * arm * (parts.unsprung_kg / car.mass))
    pitching = body[PITCH_MOMENT] - (kg * ahead + drag) * (height - _pitch_centre(car, body))
    pitching += kg * gravity * (height - car.radius) * body[PITCH] - body[SPIN_MOMENT]
    body[PITCH_SLOPE] = pitching / parts.pitch_inertia
    body[HEAVE_SLOPE] = (body[LIFT] - kg * gravity) / kg


@lean_kernel
def _hubs(car: Car, parts: Parts, body: FloatArray, wheels: FloatArray) -> None:
    """Hubs between tyre and strut; links carry part of the load transfer straight to the tyres."""
    centre = _pitch_centre(car, body)
    along = body[FORCE_X] * centre / (2 * car.wheelbase)
    along += parts.unsprung_kg * body[SPECIFIC_X] * (car.radius - centre) / (2 * car.wheelbase)
    for i in range(4):
        first = i if i % 2 == 0 else i - 1
        height = car.roll_centre_front if i < 2 else car.roll_centre_rear
        across = (wheels[GROUND_Y, first] + wheels[GROUND_Y, first + 1]) * height / car.track
        across += 2 * parts.hub_kg[i] * body[SPECIFIC_Y] * (car.radius - height) / car.track
        moved = (-across if i % 2 == 0 else across) + (-along if i < 2 else along)
        up = wheels[LOAD, i] - wheels[STRUT, i] - parts.hub_kg[i] * body[GRAVITY] - moved
        wheels[HUB_RATE, i] += STEP_S * up / parts.hub_kg[i]
        wheels[HUB, i] += STEP_S * wheels[HUB_RATE, i]


@lean_kernel
def _advance(body: FloatArray) -> None:
    """One step of the body: places by the old rates, then rates."""
    body[ROLL] += STEP_S * body[ROLL_RATE]
    body[PITCH] += STEP_S * body[PITCH_RATE]
    body[HEAVE] += STEP_S * body[HEAVE_RATE]
    body[ROLL_RATE] += STEP_S * body[ROLL_SLOPE]
    body[PITCH_RATE] += STEP_S * body[PITCH_SLOPE]
    body[HEAVE_RATE] += STEP_S * body[HEAVE_SLOPE]
    body[VX] = max(body[VX] + STEP_S * body[VX_SLOPE], 0.0)
    body[VY] += STEP_S * body[VY_SLOPE]
    body[YAW_RATE] += STEP_S * body[YAW_SLOPE]


@lean_kernel
def _write_unit(car: Car, parts: Parts, body: FloatArray, mount: FloatArray, row: FloatArray) -> None:
    """What an inertial unit at `mount` (behind the front axle, left of the middle, above the ground) feels."""
    x, y, z = parts.sprung_behind - mount[0], mount[1] - parts.sprung_left, mount[2] - parts.sprung_height
    roll, pitch, yaw = body[ROLL_SLOPE], body[PITCH_SLOPE], body[YAW_SLOPE]
    ahead, gravity = body[SPECIFIC_X], body[GRAVITY]
    left = body[SPECIFIC_Y] - parts.arm * roll * (parts.unsprung_kg / car.mass)
    up = body[HEAVE_SLOPE] + gravity
    row[COL_ACCEL] = ahead - gravity * body[PITCH] + pitch * z - yaw * y
    row[COL_ACCEL + 1] = left + gravity * body[ROLL] - roll * z + yaw * x
    leaning = ahead * body[PITCH] - body[SPECIFIC_Y] * body[ROLL]
    row[COL_ACCEL + 2] = up + roll * y - pitch * x + leaning
    row[COL_RATE], row[COL_RATE + 1], row[COL_RATE + 2] = body[ROLL_RATE], body[PITCH_RATE], body[YAW_RATE]


@lean_kernel
def _write_wheels(car: Car, parts: Parts, body: FloatArray, wheels: FloatArray, row: FloatArray) -> None:
    for i in range(4):
        row[COL_DEFLECTION + i] = wheels[SQUEEZE, i]
        row[COL_WHEEL_SPEED + i] = wheels[TURNING, i] * car.radius
        row[COL_STRUT + i] = wheels[STRUT, i]
        turned = parts.body_y[i] * body[ROLL_SLOPE] - parts.body_x[i] * body[PITCH_SLOPE]
        row[COL_CORNER + i] = body[HEAVE_SLOPE] + turned


@kernel
def _run(car: Car, parts: Parts, course: Course, mount: FloatArray, out: FloatArray) -> None:
    body, wheels = np.zeros(BODY_PLACES), np.zeros((WHEEL_PLACES, 4))
    body[VX] = course.speed[0]
    wheels[TURNING] = body[VX] / car.radius
    for k in range(EVERY * len(out)):
        drive, brake = _driver(car, course, body, k)
        _tyre_loads(car, parts, course, body, wheels, k)
        body[FORCE_X : PITCH_MOMENT + 1] = 0.0
        for i in range(4):
            steer = course.steer[k] if i < 2 else 0.0
            _wheel(car, parts, body, wheels, i, steer, drive * parts.drive_share[i], brake * parts.brake_share[i])  # fmt: skip
        _struts(car, parts, body, wheels)
        _accelerate(car, parts, course, body, k)
        _hubs(car, parts, body, wheels)
        _advance(body)
        if k % EVERY == 0:
            row = out[k // EVERY]
            row[COL_TIME], row[COL_SPEED] = k * STEP_S, body[VX]
            _write_unit(car, parts, body, mount, row)
            row[COL_ROLL], row[COL_PITCH] = body[ROLL] + course.bank[k], body[PITCH] - course.grade[k]
            _write_wheels(car, parts, body, wheels, row)
            row[COL_BRAKE], row[COL_DRIVE], row[COL_STEER] = brake, drive, course.steer[k]


def run(car: Car, course: Course, mount: FloatArray) -> FloatArray:
    """Drive the course: a row every tenth step, columns COL_*. mount: the inertial unit's place (see `Load`)."""
    out = np.zeros((len(course.speed) // EVERY, COLUMNS))
    _run(car, parts_of(car), course, mount, out)
    return out
