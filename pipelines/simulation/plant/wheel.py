"""What each wheel of the plant adds: suspension force, tyre forces, and its share of the body's equations."""

from __future__ import annotations

import math

from parsers.jit import lean_kernel
from pipelines.results import FloatArray
from pipelines.simulation.plant import layout as at
from pipelines.simulation.plant.solve import add_mass
from pipelines.simulation.plant.tyre import brush, load_factor

Turn = tuple[float, float, float, float, float, float, float, float, float]
Three = tuple[float, float, float]
Ground = tuple[float, float, float, float]

STOP_S = 0.002
"""A brake that could stop its wheel within this time holds it instead of turning it back."""
LOW_SPEED_DAMPING_S = 0.02
"""What a standing tyre's damping adds to its deflection, a m/s of slip."""
DRY_RATE = 1200.0
SLOW_RADPS = 3.0
SLIDING_RATE = 200.0


@lean_kernel
def suspension(y: FloatArray, body: FloatArray, wheels: FloatArray, dy: FloatArray, aux: FloatArray) -> None:
    """Force of each suspension (+ pushes body and wheel apart) into aux, growth of its dry friction into dy.

    Spring with stiffening and stops, anti-roll bar, damper with two slopes and a knee, Dahl's dry friction.
    """
    for i in range(4):
        d, v = y[at.DEFLECTION + i], y[at.DEFLECTION_RATE + i]
        other = y[at.DEFLECTION + (i ^ 1)]
        force = wheels[i, at.PRELOAD] + wheels[i, at.SPRING] * d * (1.0 + body[at.STIFFENING] * d * d)
        if d > body[at.BUMP_AT]:
            force += body[at.BUMP_RATE] * (d - body[at.BUMP_AT])
        elif d < -body[at.REBOUND_AT]:
            force += body[at.BUMP_RATE] * (d + body[at.REBOUND_AT])
        force += wheels[i, at.BAR] * (d - other)
        speed = abs(v)
        if speed > body[at.KNEE]:
            speed = body[at.KNEE] + body[at.BLOW_OFF] * (speed - body[at.KNEE])
        if v > 0.0:
            force += wheels[i, at.COMPRESSION] * speed
            dry = body[at.DRY_FORCE]
        else:
            force -= wheels[i, at.EXTENSION] * speed
            dry = -body[at.DRY_FORCE]
        rate = min(abs(v) / body[at.DRY_TRAVEL], DRY_RATE)
        dy[at.DRY + i] = (dry * body[at.DRY_ON] - y[at.DRY + i]) * rate
        aux[at.W_FORCE + i] = force + y[at.DRY + i]


@lean_kernel
def _limited(slip: float, limit: float) -> float:
    """What the slip control leaves of a torque: all below the limit, little from twice the limit on; 0 = no control."""
    if limit <= 0.0 or slip <= limit:
        return 1.0
    return max(2.0 - slip / limit, 0.02)


@lean_kernel
def _spin(
    i: int, y: FloatArray, body: FloatArray, wheels: FloatArray, slip: tuple[float, float], radius: float,
    load: float, along: float, dy: FloatArray, aux: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Spin of one wheel under its torques; returns the brake's and the rolling resistance's as they act.

    slip: velocity and its scale [m/s]. along: the tyre's longitudinal force.
    """
    speed = y[at.SPIN + i]
    relative = slip[0] / slip[1]
    drive = y[at.DRIVE] * wheels[i, at.DRIVE_SHARE]
    drive = min(drive, body[at.POWER] * wheels[i, at.DRIVE_SHARE] / max(abs(speed), SLOW_RADPS))
    # driving spins a wheel forward, whichever way the vehicle slides; braking and dragging hold it back
    spinning = -slip[0] / abs(slip[1]) if drive > 0.0 else relative
    drive *= _limited(spinning, body[at.SLIP_LIMIT])
    brake = max(y[at.PRESSURE], 0.0) * body[at.GAIN] * wheels[i, at.BRAKE_SHARE]
    brake *= _limited(relative, body[at.SLIP_LIMIT])
    rolling = body[at.ROLLING] * load * wheels[i, at.FREE_RADIUS]
    most = brake + rolling
    held = wheels[i, at.WHEEL_INERTIA] * speed / STOP_S + drive - radius * along
    acting = min(max(held, -most), most)
    share = acting / most if most > 0.0 else 0.0
    dy[at.SPIN + i] = (drive - acting - radius * along) / wheels[i, at.WHEEL_INERTIA]
    aux[at.W_DRIVE + i] = drive
    aux[at.W_BRAKE + i] = brake * share
    return brake * share, rolling * share


@lean_kernel
def _contact(
    i: int, y: FloatArray, body: FloatArray, wheels: FloatArray, slips: tuple[float, float, float], grip: float,
    load: float, lean: float, dy: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Longitudinal and lateral force of one tyre, in the wheel's axes; growth of its deflections into dy.

    slips: slip velocity along, velocity across, speed along [m/s].
    """
    ux, uy = y[at.U_X + i], y[at.U_Y + i]
    if load <= 0.0:
        dy[at.U_X + i], dy[at.U_Y + i] = -50.0 * ux, -50.0 * uy
        return 0.0, 0.0
    nominal = wheels[i, at.NOMINAL]
    friction = max(grip * body[at.FRICTION], 1e-9) * load_factor(body[at.LOSS_FRICTION], load, nominal)
    softer = load_factor(body[at.LOSS_STIFFNESS], load, nominal)
    stiff_x, stiff_y = body[at.STIFFNESS_X] * softer, wheels[i, at.STIFFNESS_Y] * softer
    speed = abs(slips[2])
    damping = LOW_SPEED_DAMPING_S / (1.0 + 0.1 * speed * speed)
    # a leaning wheel pushes sideways only while it rolls
    leaning = body[at.CAMBER] * speed * speed / (1.0 + speed * speed)
    sx = stiff_x * (ux - damping * slips[0]) / body[at.SIGMA_X] / friction
    sy = (stiff_y * (uy - damping * slips[1]) / body[at.SIGMA_Y] - leaning * lean) / friction
    rho = math.sqrt(sx * sx + sy * sy)
    limit = 3.0 + 3.0 * speed * speed
    back = SLIDING_RATE * (1.0 - limit / rho) if rho > limit else 0.0
    dy[at.U_X + i] = -slips[0] - (speed / body[at.SIGMA_X] + back) * ux
    dy[at.U_Y + i] = -slips[1] - (speed / body[at.SIGMA_Y] + back) * uy
    scale = friction * load * brush(rho, body[at.SLIDING_LOSS])
    return scale * sx, scale * sy


@lean_kernel
def hub_place(i: int, y: FloatArray, wheels: FloatArray) -> Three:
    """Of one wheel, from the sprung CG in body axes: as far along its guide as the wheel is deflected."""
    d = y[at.DEFLECTION + i]
    lengthwise = wheels[i, at.HUB_PATH_X] + 0.5 * wheels[i, at.SIDE_CURVE] * d
    sideways = wheels[i, at.HUB_PATH_Y] + 0.5 * wheels[i, at.PATH_CURVE] * d
    return (
        wheels[i, at.HUB_X] + d * lengthwise,
        wheels[i, at.HUB_Y] + d * sideways,
        wheels[i, at.HUB_Z] + d,
    )


@lean_kernel
def tire_in_plane(
    i: int, y: FloatArray, body: FloatArray, wheels: FloatArray, turn: Turn, turning: Three, ground: Ground,
    tan_wheel: float, dy: FloatArray, aux: FloatArray, work: FloatArray,
) -> tuple[float, float, float, float, float, float, float]:  # fmt: skip
    """Force of the road on one wheel (road axes), squash of its tyre, brake torque, moment about its axle, spin's moment.

    ground: height of the road under the wheel, its rate, friction, slope.
    """
    d, v = y[at.DEFLECTION + i], y[at.DEFLECTION_RATE + i]
    turned, bent = wheels[i, at.SIDE_CURVE] * d, wheels[i, at.PATH_CURVE] * d
    ex, ey = wheels[i, at.FOOT_PATH_X] + turned, wheels[i, at.FOOT_PATH_Y] + bent
    x, yy, z = (
        wheels[i, at.FOOT_X] + d * (ex - 0.5 * turned),
        wheels[i, at.FOOT_Y] + d * (ey - 0.5 * bent),
        wheels[i, at.FOOT_Z] + d,
    )
    p, q, r = y[at.P], y[at.Q], y[at.R]
    vx, vy, vz = q * z - r * yy + v * ex, r * x - p * z + v * ey, p * yy - q * x + v
    # a round wheel stands under its hub however the body pitches, and leans with it in roll
    hx, hy, hz = hub_place(i, y, wheels)
    foot_x = turn[0] * hx + turn[1] * hy + turn[2] * hz
    foot_y = turn[4] * yy + turn[5] * z
    foot_z = turn[6] * hx + turn[7] * hy + turn[8] * hz - turn[5] * (yy - hy) + turn[4] * (z - hz)
    road_x = y[at.VX] + turn[0] * vx + turn[1] * vy + turn[2] * vz
    road_y = y[at.VY] + turn[4] * vy + turn[5] * vz
    road_z = y[at.VZ] + turn[6] * vx + turn[7] * vy + turn[8] * vz
    about_x, about_y = turn[0] * p + turn[1] * q + turn[2] * r, turn[4] * q + turn[5] * r
    road_z += about_y * (turn[0] * x + turn[1] * yy + turn[2] * z - foot_x)
    sinking = ground[1] - road_z + turning[0] * foot_y - turning[1] * foot_x
    squash = ground[0] - y[at.HEIGHT] - foot_z
    load = 0.0
    if squash > 0.0:
        load = max(wheels[i, at.TIRE] * squash + body[at.TIRE_DAMPING] * sinking, 0.0)
    squash = max(squash, 0.0)
    free = wheels[i, at.FREE_RADIUS]
    hub_x, contact_y = road_x + about_y * free, road_y - about_x * squash
    cos_wheel = 1.0 / math.sqrt(1.0 + tan_wheel * tan_wheel)
    sin_wheel = tan_wheel * cos_wheel
    forward, across = cos_wheel * hub_x + sin_wheel * contact_y, cos_wheel * contact_y - sin_wheel * hub_x
    # the wheel rolls on more than the height of its axle: a tyre's belt does not shorten as it is squashed
    rolling_radius = free - squash / 3.0
    slipping = forward - y[at.SPIN + i] * rolling_radius
    lean = y[at.ROLL] + wheels[i, at.CAMBER_RATE] * d
    fx, fy = _contact(i, y, body, wheels, (slipping, across, forward), ground[2], load, lean, dy)
    scale = math.copysign(max(abs(forward), 2.0), forward)
    brake, rolling = _spin(i, y, body, wheels, (slipping, scale), rolling_radius, load, fx, dy, aux)
    # a driven tyre's patch runs ahead of the axle, a braked one's lags, by so much that no power comes from nowhere: torque
    # becomes force on the radius on which the wheel rolls, and what the load's lever does acts on the vehicle as well
    moment = -rolling - fx * (rolling_radius - (free - squash))
    spinning = wheels[i, at.WHEEL_INERTIA]
    # the moment that turns the wheel's own spin is taken from the carrier, which leans less than the body
    spin = spinning * y[at.SPIN + i]
    work[8, 1], work[8, 2] = spin * r, -spin * (p + wheels[i, at.CAMBER_RATE] * v)
    # the middle of the load goes with the patch, which lies beside the wheel by the tyre's deflection across
    give = body[at.PATCH_GIVE] * y[at.U_Y + i]
    # a round wheel meets a slope ahead of its hub, and the road pushes it square to the slope: on a line through the hub
    ahead = ground[3] * (free - squash) - sin_wheel * give
    work[8, 3] = cos_wheel * give
    work[9, 0], work[9, 1], work[9, 2] = foot_x + ahead, foot_y + cos_wheel * give, foot_z + squash
    aux[at.W_STEER + i] = tan_wheel
    aux[at.W_NORMAL + i], aux[at.W_LONG + i], aux[at.W_LAT + i] = load, fx, fy
    aux[at.W_ROAD + i] = ground[0]
    along_x, along_y = cos_wheel * fx - sin_wheel * fy - load * ground[3], sin_wheel * fx + cos_wheel * fy
    return along_x, along_y, load, squash, brake, moment, -spinning * dy[at.SPIN + i]


@lean_kernel
def wheel_into_body(
    i: int, y: FloatArray, wheels: FloatArray, turn: Turn, forces: tuple[float, float, float, float, float, float, float],
    gravity: Three, sprung: float, aux: FloatArray, work: FloatArray,
) -> None:  # fmt: skip
    """Add one wheel to the body's six equations (rows 0-5 lower triangle, row 6 right side; row 7: its own drive)."""
    fx, fy, fz, _, brake, axle, spin = forces
    bx = turn[0] * fx + turn[6] * fz
    by = turn[1] * fx + turn[4] * fy + turn[7] * fz
    bz = turn[2] * fx + turn[5] * fy + turn[8] * fz
    cx, cy, cz = work[9, 0], work[9, 1], work[9, 2]
    # the foot at the road, back in body axes
    x = turn[0] * cx + turn[6] * cz
    z = turn[2] * cx + turn[5] * cy + turn[8] * cz
    yy = turn[1] * cx + turn[4] * cy + turn[7] * cz
    mx, my, mz = yy * bz - z * by, z * bx - x * bz, x * by - yy * bx
    mx, my, mz = mx + work[8, 1], my + axle + spin, mz + work[8, 2]
    d, v = y[at.DEFLECTION + i], y[at.DEFLECTION_RATE + i]
    turned, bent = wheels[i, at.SIDE_CURVE] * d, wheels[i, at.PATH_CURVE] * d
    push = (wheels[i, at.FOOT_PATH_X] + turned) * bx + (wheels[i, at.FOOT_PATH_Y] + bent) * by + bz
    # what turns the carrier (a load beside its wheel, the wheel's spin) pushes it along its guide, on which it leans against the body
    push += (bz * work[8, 3] + work[8, 1]) * wheels[i, at.CAMBER_RATE]
    push += brake * wheels[i, at.BRAKE_TURN] - aux[at.W_FORCE + i]

    ex, ey = wheels[i, at.HUB_PATH_X] + turned, wheels[i, at.HUB_PATH_Y] + bent
    hx, hy, hz = hub_place(i, y, wheels)
    p, q, r = y[at.P], y[at.Q], y[at.R]
    mass = wheels[i, at.UNSPRUNG]
    n = ex * ex + ey * ey + 1.0
    gx, gy, gz = gravity
    work[7, i] = ex * gx + ey * gy + gz + push / mass
    work[7, i] /= n
    # gravity less the accelerations that are known already, across the guide, and the push along it
    dot, square = p * hx + q * hy + r * hz, p * p + q * q + r * r
    kx = gx - (p * dot - square * hx + 2 * v * (q - r * ey) + wheels[i, at.SIDE_CURVE] * v * v)
    ky = gy - (q * dot - square * hy + 2 * v * (r * ex - p) + wheels[i, at.PATH_CURVE] * v * v)
    kz = gz - (r * dot - square * hz + 2 * v * (p * ey - q * ex))
    along = (mass * (ex * kx + ey * ky + kz) + push) / n
    kx, ky, kz = mass * kx - ex * along, mass * ky - ey * along, mass * kz - along
    work[6, 0] += kx + bx
    work[6, 1] += ky + by
    work[6, 2] += kz + bz
    work[6, 3] += hy * kz - hz * ky + mx
    work[6, 4] += hz * kx - hx * kz + my
    work[6, 5] += hx * ky - hy * kx + mz
    work[8, 0] = sprung
    add_mass(mass, (ex, ey, n), (hx, hy, hz), work)
