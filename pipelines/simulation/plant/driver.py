"""What the plant reads while it drives: the road under each wheel, the demand at an instant, and the driver.

The driver follows the target speed (feed-forward of its slope and of the known resistances, with a proportional and an
integral part) and, where the road has curvature anywhere, its curvature (the steer that a steady bicycle needs, with
feedback of heading and yaw rate). Nothing here is an identification model: the driver knows the vehicle as well as a
practised one does.
"""

from __future__ import annotations

import math

from parsers.jit import lean_kernel
from pipelines.results import FloatArray
from pipelines.simulation.plant import layout as at

PREVIEW_S = 0.2
DRIVER_LAG_S = 0.12
DRIVE_LAG_S = 0.15
PEDAL_LAG_S = 0.08
LINE_LAG_S = 0.03
STANDING_MPS = 0.25
GRAVITY = 9.80665
MOST_BRAKING = 1.6


@lean_kernel
def along(road: FloatArray, column: int, place: float) -> tuple[float, float]:
    """A column of the road at a place [steps of the road], with its slope a step; straight between its rows."""
    last = road.shape[0] - 1
    place = min(max(place, 0.0), float(last))
    row = min(int(place), last - 1)
    low, high = road[row, column], road[row + 1, column]
    return low + (high - low) * (place - row), high - low


@lean_kernel
def smooth_along(road: FloatArray, column: int, place: float) -> tuple[float, float]:
    """As `along`, with a continuous slope (a quadratic spline through the middles of the rows)."""
    last = road.shape[0] - 1
    place = min(max(place, 0.0), float(last))
    row = int(place + 0.5)
    x = place - row
    before, here, after = road[max(row - 1, 0), column], road[row, column], road[min(row + 1, last), column]
    value = 0.5 * (0.5 - x) ** 2 * before + (0.75 - x * x) * here + 0.5 * (0.5 + x) ** 2 * after
    return value, (x - 0.5) * before - 2.0 * x * here + (x + 0.5) * after


@lean_kernel
def asked(demand: FloatArray, column: int, place: float) -> float:
    """A column of the demand at a place [steps of the demand], straight between its rows; its last row holds."""
    last = demand.shape[0] - 1
    place = min(max(place, 0.0), float(last))
    row = min(int(place), last - 1)
    low, high = demand[row, column], demand[row + 1, column]
    return float(low + (high - low) * (place - row))


@lean_kernel
def pedals(
    y: FloatArray,
    body: FloatArray,
    demand: FloatArray,
    place: float,
    climb: float,
    grip: float,
    dy: FloatArray,
) -> None:
    """Derivatives of drive torque, brake pressure and the speed control's integral, into dy.

    place: in steps of the demand. climb: sine of the road's grade. grip: mean of the road's friction under the wheels.
    """
    speed = y[at.VX]
    target = asked(demand, at.D_TARGET, place)
    foot = asked(demand, at.D_BRAKE, place)
    torque = asked(demand, at.D_DRIVE, place)
    pressure, lag = 0.0, PEDAL_LAG_S
    grip *= body[at.FRICTION]
    dy[at.INTEGRAL] = -y[at.INTEGRAL]
    radius, weight = body[at.RADIUS], body[at.TOTAL_MASS] * GRAVITY
    if foot > 0.0:
        pressure, lag = foot, LINE_LAG_S
    elif math.isfinite(target):
        if target < 0.05 and speed < STANDING_MPS:
            pressure = weight * (1.3 * abs(climb) + 0.08) * radius / body[at.GAIN]
            dy[at.INTEGRAL] = -5.0 * y[at.INTEGRAL]
        else:
            error = target - speed
            wanted = asked(demand, at.D_SLOPE, place) + 1.2 * error + 0.3 * y[at.INTEGRAL]
            force = (body[at.TOTAL_MASS] + body[at.SPIN_MASS]) * wanted + body[at.DRAG] * speed * speed
            force += weight * (body[at.ROLLING] + climb)
            wheel_torque = force * radius
            if wheel_torque >= 0.0:
                limit = min(body[at.POWER] / max(speed, 2.0), grip * body[at.DRIVEN_LOAD]) * radius
            else:
                limit = grip * weight * radius
                pressure = min(-wheel_torque, limit) / body[at.GAIN]
            if abs(wheel_torque) < limit:
                dy[at.INTEGRAL] = error
            torque += min(max(wheel_torque, 0.0), limit)
    # no brake system gives much more than what locks every wheel on a good road
    pressure = min(pressure, MOST_BRAKING * weight * radius / body[at.GAIN])
    dy[at.DRIVE] = (torque - y[at.DRIVE]) / DRIVE_LAG_S
    dy[at.PRESSURE] = (pressure - y[at.PRESSURE]) / lag


@lean_kernel
def steering(
    y: FloatArray,
    body: FloatArray,
    demand: FloatArray,
    road: FloatArray,
    places: tuple[float, float, float],
    yaw_rate: float,
    dy: FloatArray,
) -> float:
    """The steering-wheel angle now; derivatives of the driver's part, the heading error and the road wheels' angle into dy.

    places: of the demand, of the road, and steps of the road a metre. yaw_rate: about the road's normal.
    """
    angle = asked(demand, at.D_STEER, places[0]) + y[at.DRIVER_STEER]
    dy[at.STEER] = (angle / body[at.RATIO] - y[at.STEER]) / body[at.STEER_LAG]
    dy[at.DRIVER_STEER] = 0.0
    dy[at.HEADING_ERROR] = 0.0
    if body[at.FOLLOW] > 0.0:
        speed = max(y[at.VX], 0.0)
        here = smooth_along(road, at.R_CURVATURE, places[1])[0]
        ahead = smooth_along(road, at.R_CURVATURE, places[1] + PREVIEW_S * speed * places[2])[0]
        gain = body[at.WHEELBASE] + body[at.UNDERSTEER] * speed * speed
        miss = here * speed - yaw_rate
        wanted = gain * (ahead + (1.6 * y[at.HEADING_ERROR] + 0.25 * miss) / max(speed, 4.0))
        wanted = min(max(wanted, -0.6), 0.6) * body[at.RATIO]
        dy[at.DRIVER_STEER] = (wanted - y[at.DRIVER_STEER]) / DRIVER_LAG_S
        dy[at.HEADING_ERROR] = miss
    return float(angle)


@lean_kernel
def grip_under(road: FloatArray, left: bool, place: float) -> float:
    """Peak friction coefficient of the road under a wheel."""
    return float(along(road, at.R_GRIP_LEFT if left else at.R_GRIP_RIGHT, place)[0])


@lean_kernel
def place_on_road(y: FloatArray, steps_a_metre: float) -> float:
    """The vehicle's place, in steps of the road."""
    return float(y[at.DISTANCE] * steps_a_metre)
