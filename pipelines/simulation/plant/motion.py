"""The equations of motion of the full plant: a rigid body with four wheels on guides, on tyres, over a road.

The body has six degrees of freedom. Each wheel's carrier is a particle on a guide that is fixed in the body, straight or bent
across (its roll centre then comes down with the body): its
path makes the roll centre (the foot of the wheel moves sideways with jounce), anti-dive and anti-squat, and its hub's
own path takes the body's lean from the wheel. Tyre forces act on the foot, at the road; what the links carry of them
follows from the paths by virtual work, so that momentum and moments close exactly. Kane's equations, in body axes; with
a wheel's acceleration along its guide eliminated they are six linear equations for the body's a and omega'.

Road axes turn with the heading, the grade and the bank; velocities and rates in the state are those against the ground,
so that no acceleration of the road is needed.
"""

from __future__ import annotations

import math

from parsers.jit import kernel, lean_kernel
from pipelines.results import FloatArray
from pipelines.simulation.plant import layout as at
from pipelines.simulation.plant.driver import (
    along,
    grip_under,
    pedals,
    place_on_road,
    smooth_along,
    steering,
)
from pipelines.simulation.plant.solve import solve_six
from pipelines.simulation.plant.wheel import (
    Three,
    Turn,
    hub_place,
    suspension,
    tire_in_plane,
    wheel_into_body,
)

GRAVITY = 9.80665


@lean_kernel
def road_frame(
    y: FloatArray,
    road: FloatArray,
    place: float,
    steps_a_metre: float,
    moving: float,
    turn: Turn,
    aux: FloatArray,
) -> tuple[float, float, float]:
    """Angular velocity of the road axes (x, y, about the normal); grade, bank and the way up (road axes) into aux.

    The road's attitude is that of Euler angles: heading, pitch -grade, roll bank, so that turning on a grade rolls.
    """
    grade, grade_slope = smooth_along(road, at.R_GRADE, place)
    bank, bank_slope = smooth_along(road, at.R_BANK, place)
    rate = y[at.VX] * steps_a_metre * moving
    grade_rate, bank_rate = grade_slope * rate, bank_slope * rate
    sin_grade, cos_grade, sin_bank, cos_bank = 0.0, 1.0, 0.0, 1.0
    if grade != 0.0 or bank != 0.0:
        sin_grade, cos_grade = math.sin(grade), math.cos(grade)
        sin_bank, cos_bank = math.sin(bank), math.cos(bank)
    p, q, r = y[at.P], y[at.Q], y[at.R]
    about_x = turn[0] * p + turn[1] * q + turn[2] * r
    about_z = turn[6] * p + turn[7] * q + turn[8] * r
    tan_pitch = -turn[6] / turn[0]
    share = -sin_grade / (cos_grade * cos_bank)
    yaw = about_z + tan_pitch * (about_x - bank_rate - share * grade_rate * sin_bank)
    yaw /= 1.0 - share * tan_pitch
    world = (yaw - grade_rate * sin_bank) / (cos_grade * cos_bank)
    aux[at.GRADE], aux[at.BANK] = grade, bank
    aux[at.UP_X], aux[at.UP_Y], aux[at.UP_Z] = sin_grade, sin_bank * cos_grade, cos_bank * cos_grade
    return bank_rate + world * sin_grade, world * cos_grade * sin_bank - grade_rate * cos_bank, yaw


@kernel
def derivative(
    time_s: float,
    y: FloatArray,
    body: FloatArray,
    wheels: FloatArray,
    demand: FloatArray,
    road: FloatArray,
    grids: tuple[float, float],
    dy: FloatArray,
    aux: FloatArray,
    work: FloatArray,
) -> None:
    """dy (STATES,) and aux (AUX_SIZE,) at a time and a state. grids: steps a second of the demand, a metre of the road.

    work: (10, 8) scratch. The arrays' indices are those of `plant_layout`.
    """
    sin_roll, cos_roll = math.sin(y[at.ROLL]), math.cos(y[at.ROLL])
    sin_pitch, cos_pitch = math.sin(y[at.PITCH]), math.cos(y[at.PITCH])
    # body to road axes
    turn = (
        cos_pitch, sin_pitch * sin_roll, sin_pitch * cos_roll,
        0.0, cos_roll, -sin_roll,
        -sin_pitch, cos_pitch * sin_roll, cos_pitch * cos_roll,
    )  # fmt: skip
    moving = body[at.ROAD_ON]
    asked_at = time_s * grids[0] * moving
    place = place_on_road(y, grids[1])
    turning = road_frame(y, road, place, grids[1], moving, turn, aux)
    aux[at.WHEEL_ANGLE] = steering(y, body, demand, road, (asked_at, place, grids[1]), turning[2], dy)
    p, q, r = y[at.P], y[at.Q], y[at.R]
    vx, vy, vz = y[at.VX], y[at.VY], y[at.VZ]
    up_x, up_y, up_z = aux[at.UP_X], aux[at.UP_Y], aux[at.UP_Z]
    gx = -GRAVITY * (turn[0] * up_x + turn[6] * up_z)
    gy = -GRAVITY * (turn[1] * up_x + turn[4] * up_y + turn[7] * up_z)
    gz = -GRAVITY * (turn[2] * up_x + turn[5] * up_y + turn[8] * up_z)

    _start_system(body, (p, q, r), (gx, gy, gz), turn, _through_air(y, body), work)
    suspension(y, body, wheels, dy, aux)
    grip = _all_wheels(y, body, wheels, road, grids[1], turn, turning, (gx, gy, gz), dy, aux, work)
    pedals(y, body, demand, asked_at, up_x, grip, dy)

    solve_six(work)
    ax, ay, az = work[6, 0], work[6, 1], work[6, 2]
    bx, by, bz = work[6, 3], work[6, 4], work[6, 5]
    dy[at.P], dy[at.Q], dy[at.R] = bx, by, bz
    tx, ty, tz = turning
    road_x = turn[0] * ax + turn[1] * ay + turn[2] * az
    road_y = turn[4] * ay + turn[5] * az
    road_z = turn[6] * ax + turn[7] * ay + turn[8] * az
    dy[at.VX] = road_x - (ty * vz - tz * vy)
    dy[at.VY] = road_y - (tz * vx - tx * vz)
    dy[at.VZ] = road_z - (tx * vy - ty * vx)
    _places(y, turn, turning, aux, moving, dy)
    aux[at.FORCE_X], aux[at.FORCE_Y], aux[at.FORCE_Z] = ax - gx, ay - gy, az - gz
    aux[at.ALPHA_X], aux[at.ALPHA_Y], aux[at.ALPHA_Z] = bx, by, bz
    _wheel_accelerations(y, wheels, turn, work, dy, aux)


@lean_kernel
def _all_wheels(
    y: FloatArray, body: FloatArray, wheels: FloatArray, road: FloatArray, steps_a_metre: float, turn: Turn,
    turning: Three, gravity: Three, dy: FloatArray, aux: FloatArray, work: FloatArray,
) -> float:  # fmt: skip
    """Put the four wheels into the body's equations; returns the mean friction of the road under them."""
    tan_steer = math.tan(y[at.STEER])
    share = body[at.HALF_TRACK_SHARE]
    grip_sum = 0.0
    behind, length = body[at.CG_BEHIND], body[at.WHEELBASE]
    for i in range(4):
        left = i % 2 == 0
        ahead = behind if i < 2 else behind - length
        at_wheel = (y[at.DISTANCE] + ahead) * steps_a_metre
        height, slope = along(road, at.R_LEFT if left else at.R_RIGHT, at_wheel)
        grip = grip_under(road, left, at_wheel)
        grip_sum += grip
        tan_wheel = 0.0
        if i < 2:
            tan_wheel = (
                tan_steer / (1.0 - tan_steer * share) if left else tan_steer / (1.0 + tan_steer * share)
            )
        uphill = slope * steps_a_metre * body[at.ROAD_ON]
        ground = (height, uphill * y[at.VX], grip, uphill)
        forces = tire_in_plane(i, y, body, wheels, turn, turning, ground, tan_wheel, dy, aux, work)
        wheel_into_body(i, y, wheels, turn, forces, gravity, body[at.MASS], aux, work)
    return 0.25 * grip_sum


@lean_kernel
def _through_air(y: FloatArray, body: FloatArray) -> tuple[float, float]:
    """Speed through the air, along and across the road's axes."""
    cos_heading, sin_heading = math.cos(y[at.HEADING]), math.sin(y[at.HEADING])
    wind_x, wind_y = body[at.WIND_X], body[at.WIND_Y]
    return y[at.VX] - cos_heading * wind_x - sin_heading * wind_y, y[
        at.VY
    ] + sin_heading * wind_x - cos_heading * wind_y


@lean_kernel
def _start_system(
    body: FloatArray,
    rates: tuple[float, float, float],
    gravity: tuple[float, float, float],
    turn: Turn,
    speed: tuple[float, float],
    work: FloatArray,
) -> None:
    """The sprung mass alone, with drag and its own gyroscopic moment: rows 0-5 the matrix, row 6 the right side.

    speed: through the air.
    """
    for i in range(6):
        for j in range(6):
            work[i, j] = 0.0
    mass = body[at.MASS]
    p, q, r = rates
    work[0, 0] = work[1, 1] = work[2, 2] = mass
    ixx, iyy, izz, ixz = body[at.IXX], body[at.IYY], body[at.IZZ], body[at.IXZ]
    work[3, 3], work[4, 4], work[5, 5] = ixx, iyy, izz
    work[5, 3] = -ixz
    hx, hy, hz = ixx * p - ixz * r, iyy * q, izz * r - ixz * p
    work[6, 3] = -(q * hz - r * hy)
    work[6, 4] = -(r * hx - p * hz)
    work[6, 5] = -(p * hy - q * hx)
    drag = -body[at.DRAG] * math.sqrt(speed[0] * speed[0] + speed[1] * speed[1])
    dx, dv = drag * speed[0], drag * speed[1]
    work[6, 0] = mass * gravity[0] + turn[0] * dx
    work[6, 1] = mass * gravity[1] + turn[1] * dx + turn[4] * dv
    work[6, 2] = mass * gravity[2] + turn[2] * dx + turn[5] * dv


@lean_kernel
def _places(
    y: FloatArray,
    turn: Turn,
    turning: tuple[float, float, float],
    aux: FloatArray,
    moving: float,
    dy: FloatArray,
) -> None:
    """Derivatives of place and attitude; a body held for settling (moving = 0) keeps its place on the road."""
    p, q, r = y[at.P], y[at.Q], y[at.R]
    wx = turn[0] * p + turn[1] * q + turn[2] * r
    wy = turn[4] * q + turn[5] * r
    dy[at.ROLL] = (wx - turning[0]) / turn[0]
    dy[at.PITCH] = wy - turning[1]
    dy[at.HEIGHT] = y[at.VZ]
    dy[at.HEADING] = turning[2] * moving
    cos_heading, sin_heading = math.cos(y[at.HEADING]), math.sin(y[at.HEADING])
    level = math.sqrt(1.0 - aux[at.UP_X] * aux[at.UP_X])
    level_x = y[at.VX] * level * moving
    level_y = y[at.VY] * aux[at.UP_Z] / level * moving
    dy[at.X] = level_x * cos_heading - level_y * sin_heading
    dy[at.Y] = level_x * sin_heading + level_y * cos_heading
    dy[at.DISTANCE] = y[at.VX] * moving
    dy[at.ALTITUDE] = (y[at.VX] * aux[at.UP_X] + y[at.VY] * aux[at.UP_Y]) * moving


@lean_kernel
def _wheel_accelerations(
    y: FloatArray,
    wheels: FloatArray,
    turn: Turn,
    work: FloatArray,
    dy: FloatArray,
    aux: FloatArray,
) -> None:
    """Acceleration of each wheel along its guide, and of the body over it and of the hub, normal to the road."""
    ax, ay, az = work[6, 0], work[6, 1], work[6, 2]
    bx, by, bz = work[6, 3], work[6, 4], work[6, 5]
    p, q, r = y[at.P], y[at.Q], y[at.R]
    mx, my, mz = 0.0, 0.0, 0.0
    total = 0.0
    for i in range(4):
        d, v = y[at.DEFLECTION + i], y[at.DEFLECTION_RATE + i]
        turned, bent = wheels[i, at.SIDE_CURVE] * d, wheels[i, at.PATH_CURVE] * d
        ex, ey = wheels[i, at.HUB_PATH_X] + turned, wheels[i, at.HUB_PATH_Y] + bent
        x, yy, z = hub_place(i, y, wheels)
        dot = p * x + q * yy + r * z
        square = p * p + q * q + r * r
        fx = ax + by * z - bz * yy + p * dot - square * x
        fy = ay + bz * x - bx * z + q * dot - square * yy
        fz = az + bx * yy - by * x + r * dot - square * z
        aux[at.W_SPRUNG + i] = turn[6] * fx + turn[7] * fy + turn[8] * fz
        cx, cy, cz = fx + 2 * v * (q - r * ey), fy + 2 * v * (r * ex - p), fz + 2 * v * (p * ey - q * ex)
        cx += wheels[i, at.SIDE_CURVE] * v * v
        cy += wheels[i, at.PATH_CURVE] * v * v
        n = ex * ex + ey * ey + 1.0
        rate = work[7, i] - (ex * cx + ey * cy + cz) / n
        dy[at.DEFLECTION + i] = v
        dy[at.DEFLECTION_RATE + i] = rate
        aux[at.W_UNSPRUNG + i] = (
            turn[6] * (cx + ex * rate) + turn[7] * (cy + ey * rate) + turn[8] * (cz + rate)
        )
        mass = wheels[i, at.UNSPRUNG]
        total += mass
        mx += mass * (q * z - r * yy + ex * v)
        my += mass * (r * x - p * z + ey * v)
        mz += mass * (p * yy - q * x + v)
    total += work[8, 0]
    aux[at.CG_VX] = y[at.VX] + (turn[0] * mx + turn[1] * my + turn[2] * mz) / total
    aux[at.CG_VY] = y[at.VY] + (turn[4] * my + turn[5] * mz) / total
