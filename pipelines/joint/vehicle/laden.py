"""What a load makes of a vehicle beside its mass: springs that stand shorter, a body that leans at rest, wheels further apart.

The unknowns describe the empty vehicle and a load in its own axes. All functions take numbers or arrays by name, SI, and give
the like.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pipelines.joint.vehicle.body import Body, carrying, hub_height
from pipelines.joint.vehicle.remembered import once
from pipelines.joint.vehicle.suspension import STOP_POWER
from pipelines.models.roll import GRAVITY

AXLES = ("front", "rear")
Values = Mapping[str, Any]
Number = Any
TRAVEL_M = (-0.1, 0.25)
"""How far a load may press a spring, or lift it."""

STEPS = 8
"""Of Newton's, until a stop's share of a load is known to the micrometre."""
CURVE_STEPS = 4
"""Likewise, for a spring whose rate doubles within the travel."""
SOFTENS, STIFFENS = 0.3, 5.0
"""Least and largest rate of a pressed spring over that at the empty vehicle's height."""
TOUCH_M = 0.002
"""By how much a wheel that rests just before its stop is in it in the mean, as drives move it by 8 mm rms."""


def _on_wheel(p: Values, axle: str) -> Number:
    """The load's share on a wheel, N."""
    behind = p["load_x"] / p["wheelbase"]
    return 0.5 * GRAVITY * p["load"] * (1 - behind if axle == "front" else behind)


def _along_the_curve(rate: Number, square: Number, cube: Number, force: Number) -> Number:
    """Travel at which a spring of force rate d + square d² + cube d³ holds `force`, by Newton's steps from the straight line.

    Within a suspension's travel, and no spring gives way by more than SOFTENS: of rates at three places a parabola may turn down
    behind the last of them, where no spring does.
    """
    d = np.clip(force / rate, *TRAVEL_M)
    for _ in range(CURVE_STEPS):
        slope = np.maximum(rate + (2 * square + 3 * cube * d) * d, SOFTENS * rate)
        d = np.clip(d - ((rate + (square + cube * d) * d) * d - force) / slope, *TRAVEL_M)
    return d


@once
def pressed(p: Values, axle: str) -> Number:
    """How much shorter the load makes a spring, at the wheel, m: no more than a suspension has travel.

    The spring's force is `spring_*` d + `square_*` d² + `cube_*` d³. Beyond `free_*` a bump stop holds along, with `stop_*` times the
    travel into it to the power STOP_POWER.
    """
    rate, free, stop = carrying(p, axle), p[f"free_{axle}"], np.maximum(p[f"stop_{axle}"], 0.0)
    square, cube, force = p[f"square_{axle}"], p[f"cube_{axle}"], _on_wheel(p, axle)
    alone = _along_the_curve(rate, square, cube, force)
    if not np.any(alone > free):
        return alone
    # y² of travel into the stop: stop y³ + rate y² + ... = what the spring leaves, which rises and bends upwards, from above
    left = np.where(alone > free, force - (rate + (square + cube * free) * free) * free, 0.0)
    here = np.maximum(rate + (2 * square + 3 * cube * free) * free, SOFTENS * rate)
    bend = square + 3 * cube * free
    y = np.sqrt(np.maximum(alone - free, 0.0))
    for _ in range(STEPS):
        into = y * y
        holds = (stop * y + here + (bend + cube * into) * into) * into
        slope = (
            3 * stop * y + 2 * np.maximum(here + (2 * bend + 3 * cube * into) * into, SOFTENS * rate)
        ) * y
        y = y - (holds - left) / np.maximum(slope, 1e-12)
    return np.clip(np.where(left > 0, free + y**2, alone), *TRAVEL_M)


@once
def rate_under_load(p: Values, axle: str) -> Number:
    """A wheel's spring rate where the load has it rest, N/m: with the stop, where it rests on that or moves into it."""
    d = pressed(p, axle)
    into = TOUCH_M * np.logaddexp(0.0, (d - p[f"free_{axle}"]) / TOUCH_M)
    stop = STOP_POWER * np.maximum(p[f"stop_{axle}"], 0.0) * into ** (STOP_POWER - 1)
    rate = carrying(p, axle)
    more = (2 * p[f"square_{axle}"] + 3 * p[f"cube_{axle}"] * d) * d
    return p[f"spring_{axle}"] + np.clip(more, (SOFTENS - 1) * rate, (STIFFENS - 1) * rate) + stop


@once
def roll_center(p: Values, axle: str) -> Number:
    """Height of an axle's roll centre under load, m.

    Vehicle files tell that of the empty vehicle. Struts have it sink by one and a half of what the load presses the spring, wishbones
    by a half to once; beam axles, and models whose feet go along straight lines, keep it. A vehicle file that tells it tells it of each
    axle; where it is silent, one unknown is that of both.
    """
    return p[f"roll_center_{axle}"] - (p["axis_sinks"] + p[f"sinks_{axle}"]) * pressed(p, axle)


@once
def widened(p: Values, axle: str) -> Number:
    """The track under load over that of the empty vehicle.

    A wheel whose roll centre is h_rc above ground goes out by h_rc / (t/2) of its travel (that is what makes it the roll centre).
    """
    half = 0.5 * p[f"track_{axle}"]
    return 1 + p["track_grows"] * p[f"roll_center_{axle}"] * pressed(p, axle) / half**2


def axis_lever(p: Values, share: Number) -> Number:
    """Height at which the links of both axles carry the side force under load, m. share: of it at the rear."""
    front, rear = (roll_center(p, axle) * widened(p, axle) for axle in AXLES)
    return (1 - share) * front + share * rear


def roll_parts(p: Values) -> tuple[Number, Number]:
    """Roll stiffness of the front and of the rear springs and bars, N m/rad."""
    front, rear = (0.5 * p[f"spring_{a}"] * p[f"track_{a}"] ** 2 + p[f"bar_{a}"] for a in AXLES)
    return front, rear


def mean_widening(p: Values) -> Number:
    """`widened` of both axles, as their springs and bars hold the body."""
    parts = roll_parts(p)
    front, rear = (part * widened(p, axle) for part, axle in zip(parts, AXLES, strict=True))
    return (front + rear) / (parts[0] + parts[1])


def forces_lever(p: Values) -> Number:
    """What forces in the springs make of a roll moment, reckoned at the wheels' track, over it: springs that stand closer hold more."""
    parts = roll_parts(p)
    front, rear = (part / p[f"force_base_{axle}"] for part, axle in zip(parts, AXLES, strict=True))
    return (front + rear) / (parts[0] + parts[1])


def _heavier(p: Values) -> Number:
    """The loaded vehicle's mass over the empty one's."""
    return 1 + p["load"] / p["empty_mass"]


def side_patches(p: Values, body: Body) -> Number:
    """N m a m/s² of roll moment that the weight has on tyres whose side force moves their patches towards the inside of the bend.

    The tyres see all of it; the springs as far as the wheels lean with the body, as a rigid axle keeps it to itself. `patch_side` is that
    of the empty vehicle: a load has a side force of its own.
    """
    return GRAVITY * body.mass * p["patch_side"] * _heavier(p)


def patch_lag(p: Values) -> Number:
    """m of height that braked tyres' patches seem to add to the loaded vehicle's CG. `patch_lag` is that of the empty one."""
    return p["patch_lag"] * _heavier(p)


def side_moment(p: Values, body: Body, axle: str) -> Number:
    """N m a rad of roll against the axle by which the weight on its wheels eases what the springs have to hold.

    With a wheel's travel d its foot goes out by h_rc / (t/2) d. In roll one wheel goes up and the other down, so that in the body's
    axes both feet move the same way, by h_rc times the roll, and the axle's share of the body's weight with them.

    A wheel that stays upright by the share c turns against the body by c times the roll, and where its foot stays in its plane, a
    radius R below the hub, the foot comes up by R c² roll²/2 beside the hub's travel: the weight then adds c² R times the roll to
    what the springs hold. Wide tyres that lean stand on their edges instead, and models of feet that are points have none of it
    (`wheel_plane`: 1 a thin disc). And its hub goes across the body by c R times the roll, its own weight m_u against it: on straight
    guides the springs hold g (m_s h_rc + m_u c R) a rad more, from S = Fz + Fy y'_foot - m_u (f_z + f_y y'_hub) with y'_hub less than
    y'_foot by c R over half the track; a disc's hub comes up with it, which takes c² R of that.

    Simple models' weight does not tip a leaning body, as if it eased nothing (`lean_path`, m above the roll axis).

    A rig that rolls the body over pads has both in one (`path_*`, where `paths_told` is 1): the stiffness by the pads' forces, where
    they stand, less that by wheel rates and bars, over the load. It sinks with the roll centre.
    """
    behind = body.x / p["wheelbase"]
    weight = GRAVITY * body.sprung * (1 - behind if axle == "front" else behind)
    disc = p["wheel_plane"] * p["camber"] ** 2 * hub_height(p)
    across = p["camber"] * (1 - p["wheel_plane"] * p["camber"]) * hub_height(p)
    hub = GRAVITY * p[f"unsprung_{axle}"] / weight * across
    by_geometry = p["side_path"] * roll_center(p, axle) + hub - disc
    measured = p[f"path_{axle}"] + roll_center(p, axle) - p[f"roll_center_{axle}"]
    return weight * (by_geometry + p["paths_told"] * (measured - by_geometry) + p["lean_path"])


def roll_springs(p: Values, body: Body, springs: Number) -> Number:
    """N m a rad that hold the body against its axles: the suspension's roll stiffness on tracks that a load widens, and `side_moment`."""
    return springs * mean_widening(p) + side_moment(p, body, "front") + side_moment(p, body, "rear")


def leans(p: Values, body: Body, axis: Number, springs: Number) -> tuple[Number, Number]:
    """rad by which the load has the body lean at rest: back, and to the left.

    axis: height of the roll axis, m. springs: roll stiffness of the suspension, N m/rad. No vehicle's is below twice what its weight
    takes off it, as hardly known springs are in some draws.
    """
    down = [pressed(p, axle) + _on_wheel(p, axle) / p["tyre_rate"] for axle in AXLES]
    width = 0.5 * (p["track_front"] + p["track_rear"])
    tyres = p["tyre_rate"] * width**2
    tips = GRAVITY * body.sprung * np.maximum(body.h - axis, 0.1)
    held = np.maximum(springs, 2 * tips)
    left = GRAVITY * p["load"] * p["load_y"] / np.maximum(held * tyres / (held + tyres) - tips, 0.3 * held)
    return (down[1] - down[0]) / p["wheelbase"], left
