"""Where the links' poles stand in side view: about which heights they let the loaded body pitch, and what becomes of these as it moves.

Braked with F, a wheel on a side-view swing arm of length l, its pole e above ground, lifts the body by F e / l. The pole is a place of
the body: where a load brings the body down by d, or braking lifts the tail by as much, e and the pitch centre go along, by
d over l times the axle's distance and its share of F. `poles_sink` is that a metre, both axles alike; trailing arms and twist beams of
0.4 m have 1.4, multilinks and struts 0.2 to 0.5, straight guides (and most simulators) none.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pipelines.joint.vehicle.body import BRAKED_FRONT, TYRE_SHARE, Body, Values, hub_height
from pipelines.joint.vehicle.book import AXLES, Book
from pipelines.joint.vehicle.laden import pressed
from pipelines.joint.vehicle.suspension import levels
from pipelines.vehicles.spring_base import rigid_axle

POLES = (
    "poles_sink", "poles_rear", "poles_stay_front", "poles_stay_rear", "free_front", "free_rear", "stop_front", "stop_rear",
    "square_front", "square_rear", "cube_front", "cube_rear",
)  # fmt: skip
"""Unknowns that `pole_drop` hangs on, beside the load, the springs and the wheelbase."""

USUAL_SINK = (0.5, 0.55)
"""Where the file has no wheel recessions: between simulators' none and 0.2 to 1.4 of vehicles."""
OF_REAR, OF_REAR_STD = 0.75, 0.2
"""Share of it that is the rear axle's, whose arms are the shorter ones."""
ROUND = 0.2
"""How far arms' poles move as the arms turn, beside a fixed pole's: share of `poles_sink`."""
MOVING = {False: (0.0, 0.08), True: (0.45, 0.4)}
"""What links that turn add to `poles_sink` beside fixed poles, by whether the rear axle is rigid: links or leaves of half a metre
turn as the axle rises, and change the way of a wheel whose pole is far off or nowhere; arms and struts do so by little."""


def poles(book: Book) -> None:
    """How far pitch centres go along with the body. The book has `hubs_past`.

    A rig that told the wheels' recession and the pitch centre told of the arms' lengths: foot and hub of a wheel go different ways by
    the radius over the length, so that the pitch centre over the radius, less what the hubs' ways make of it, is the sum over both axles.
    """
    if all(book.vehicle.get(f"wheel_recession_{axle}") is not None for axle in AXLES):
        mean, std = book.rows["hubs_past"]
        turning, unsure = MOVING[rigid_axle(book.vehicle, "rear")]
        spread = float(np.hypot(np.hypot(std, ROUND * mean), unsure))
        book.put("poles_sink", mean + turning, spread)
    else:
        said = "how far the pitch centre comes down for a metre that the body does"
        book.put("poles_sink", *USUAL_SINK, said)
    book.put("poles_rear", OF_REAR, OF_REAR_STD)
    for axle in AXLES:
        # springs that level themselves let no load bring the body down
        book.put(f"poles_stay_{axle}", float(levels(book.vehicle, axle)), 0.0)


def pole_drop(p: Mapping[str, Any]) -> Any:
    """m by which a load brings the pitch centres down; a number, or an array of many vehicles'."""
    rear = p["poles_rear"]
    shares = {"front": 1 - rear, "rear": rear}
    down = sum(share * (1 - p[f"poles_stay_{axle}"]) * pressed(p, axle) for axle, share in shares.items())
    return p["poles_sink"] * TYRE_SHARE * down


def pitch_centres(p: Values, body: Body) -> tuple[float, float]:
    """Heights above ground about which links let the loaded body pitch in braking and in driving, m.

    The unknowns are those about the empty body's CG. What links lift the body by (`jack_brake`, `jack_drive`, over its mass and
    the acceleration) has another moment about a CG that a load moved back.
    """
    empty = p["empty_mass"] - p["unsprung_front"] - p["unsprung_rear"]
    before = (p["empty_mass"] * p["empty_x"] - p["unsprung_rear"] * p["wheelbase"]) / empty
    back = (body.x - before) * body.sprung / body.mass
    lower = pole_drop(p)
    braking = p["pitch_center_brake"] - lower - back * p["jack_brake"]
    return braking, p["pitch_center_drive"] - lower - back * p["jack_drive"]


def dip_levers(p: Values, body: Body) -> tuple[float, float]:
    """m by which the pitch centre in braking, and in driving, rises for a rad that the body's nose is down.

    Wheels go up along the body's own axis, which then leans forward: braked front wheels push it up by F times the angle, rear ones down.
    And the poles go along: down in front, up behind.
    """
    behind = p["wheelbase"] - body.x
    drive, rear = p["drive_front"], p["poles_rear"]
    along = p["poles_sink"] * (rear * behind - (1 - rear) * body.x)
    braking = BRAKED_FRONT * body.x - (1 - BRAKED_FRONT) * behind
    return braking + along, drive * body.x - (1 - drive) * behind + along


def past_the_springs(p: Values) -> float:
    """kg m of the hubs' inertia that their links take to the tyres when speed changes.

    A wheel that is braked with F on a swing arm of length l, its pole e above ground, puts F e - m_u a (e - R) over l on its
    links. `pitch_center_brake` is e times half the wheelbase over l, `hubs_past` that lever alone, so that F's part is the
    links' and the rest, m_u (hubs_past R - pitch_center_brake), is here. A shaft's torque changes F's part (the pole stands R
    lower for it), and not the hub's own.
    """
    hubs = p["unsprung_front"] + p["unsprung_rear"]
    past: float = hubs * (p["hubs_past"] * hub_height(p) - p["pitch_center_brake"] + pole_drop(p))
    return past
