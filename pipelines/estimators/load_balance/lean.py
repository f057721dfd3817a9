"""How the body pitches and rolls against the road: by its deflections, or by what its springs make of the accelerations."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipelines.joint.vehicle.laden import axis_lever, roll_parts
from pipelines.joint.vehicle.poles import pole_drop
from pipelines.joint.vehicle.unknowns import AXLES, CORNERS, Known, body_of
from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import Prepared
from pipelines.results import FloatArray


def _usual_lean(p: Mapping[str, float]) -> tuple[float, float]:
    """rad a m/s² by which a body pitches and rolls on its springs, as stated or as usual: what the links carry they do not."""
    body = body_of(p, None)
    share = body.x / p["wheelbase"]
    front, rear = (2 * p[f"spring_{axle}"] for axle in AXLES)
    held = front * body.x**2 + rear * (p["wheelbase"] - body.x) ** 2
    arm = body.h - axis_lever(p, share)
    upright = sum(roll_parts(p)) - GRAVITY * body.sprung * arm
    links = 0.5 * (p["pitch_center_brake"] + p["pitch_center_drive"]) - pole_drop(p)
    return body.sprung * (body.h - links) / held, body.sprung * arm / max(upright, 0.3 * sum(roll_parts(p)))


def angles_of(prepared: Prepared, known: Known, deflections: bool) -> tuple[FloatArray, FloatArray]:
    """Pitch (nose down) and roll (right side down) of the body against the road, tyres' part included, (n,) rad.

    From the deflections where they are there, else from the accelerations and springs as stated or usual.
    """
    p = known.at(np.zeros(len(known.names)))
    c = prepared.columns
    n = len(prepared.time_s)
    fx = c.get("accel_x", np.zeros(n))
    fy = c.get("accel_y", np.zeros(n))
    moment = (p["empty_mass"] + p["load"]) * p["empty_h"]
    length, track = p["wheelbase"], p["track_front"]
    tyre = p["tyre_rate"]
    pitch_tyre = -moment * np.nan_to_num(fx) / (tyre * length**2)
    roll_tyre = moment * np.nan_to_num(fy) / (tyre * track**2)
    if not deflections:
        nods, rolls = _usual_lean(p)
        pitch_springs, roll_springs = -nods * np.nan_to_num(fx), rolls * np.nan_to_num(fy)
        return np.asarray(pitch_tyre + pitch_springs), np.asarray(roll_tyre + roll_springs)
    fl, fr, rl, rr = (c[f"suspension_deflection_{w}"] for w in CORNERS)
    pitch = (fl + fr - rl - rr) / (2 * length)
    roll = 0.5 * ((fr - fl) / track + (rr - rl) / p["track_rear"])
    return np.asarray(pitch + pitch_tyre), np.asarray(roll + roll_tyre)
