"""The vehicle's parameters as they follow from the unknowns: of one vehicle, or of many at once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

import numpy as np

from pipelines.evidence import Values
from pipelines.joint.vehicle.body import Body, body_inertias, body_of, hub_height
from pipelines.joint.vehicle.laden import leans, rate_under_load, roll_center
from pipelines.joint.vehicle.poles import pitch_centres
from pipelines.joint.vehicle.unknowns import AXLES, CORNERS
from pipelines.results import FloatArray


def body_at(values: Values, given: Mapping[str, float]) -> Body:
    """The loaded vehicle; given["sag"]: see `body_of`. Fields are (n,) where the values are."""
    return body_of(cast("Mapping[str, float]", values), given.get("sag"))


def inertias_of(values: Values) -> tuple[FloatArray, FloatArray]:
    """Roll and pitch inertia of the loaded body about its own CG."""
    roll, pitch = body_inertias(cast("Mapping[str, float]", values))
    return np.asarray(roll), np.asarray(pitch)


def roll_axis_of(values: Values, body: Body) -> FloatArray:
    """Height above ground of the roll axis, below the CG of the vehicle as it stands under its load."""
    share = np.asarray(body.whole_x) / values["wheelbase"]
    return np.asarray((1 - share) * roll_center(values, "front") + share * roll_center(values, "rear"))


def roll_stiffness_of(values: Values, *, empty: bool = False) -> FloatArray:
    """Of the suspension, body against axles, N·m/rad: springs and bars, at the height at which the loaded body stands.

    Springs that stand closer than the wheels add what they stiffen by where they are; what they lack themselves is in the bar.
    empty: at that of the empty one, as data sheets have it.
    """
    parts = []
    for axle in AXLES:
        rate = np.asarray(values[f"spring_{axle}"])
        if not empty:
            rate = rate + values[f"spring_base_{axle}"] ** 2 * (rate_under_load(values, axle) - rate)
        parts.append(0.5 * rate * values[f"track_{axle}"] ** 2 + values[f"bar_{axle}"])
    return np.asarray(parts[0] + parts[1])


def lacked_by_springs(at_wheels: FloatArray, base: FloatArray) -> FloatArray:
    """Roll stiffness that an axle's springs lack where they stand, and that its bar's unknown has less of, N·m/rad.

    at_wheels: the rate of one times the track squared; base: their distance over the track.
    """
    return np.asarray(0.5 * (1 - np.asarray(base) ** 2) * at_wheels)


def roll_damping_of(values: Values) -> FloatArray:
    """Of the dampers at the drive's own speeds, the mean of bump and rebound, N·m·s/rad."""
    parts = [
        0.25
        * (np.asarray(values[f"bump_{a}"]) + values[f"rebound_{a}"])
        * (values[f"spring_base_{a}"] * values[f"track_{a}"]) ** 2
        for a in AXLES
    ]
    return np.asarray(parts[0] + parts[1])


def roll_inertia_of(values: Values, body: Body) -> FloatArray:
    """Of the whole vehicle about its CG: the body's own, and what body and wheels have by their distances."""
    hubs = sum(
        np.asarray(values[f"unsprung_{a}"])
        * (0.25 * values[f"track_{a}"] ** 2 + (hub_height(values) - body.whole_h) ** 2)
        for a in AXLES
    )
    return np.asarray(inertias_of(values)[0] + hubs + np.asarray(body.sprung) * (body.h - body.whole_h) ** 2)


INERTIA_BY_FORCES = "inertia_by_forces"
"""In `given`: the share of the doubt about what swings with the body that is left where forces between body and wheels were set
against its acceleration. Lean and deflections follow tyres, hubs and what gives besides."""


def swinging(values: Values, given: Mapping[str, float]) -> FloatArray:
    """The rigid vehicle's roll inertia over that which the drive's motion tells of."""
    return np.asarray(1 + given.get(INERTIA_BY_FORCES, 1.0) * (np.asarray(values["inertia_factor"]) - 1))


def pitch_inertia_of(values: Values, body: Body) -> FloatArray:
    """Of the whole vehicle about its CG, as `roll_inertia_of`."""
    hubs = sum(
        np.asarray(values[f"unsprung_{a}"])
        * ((at - body.whole_x) ** 2 + (hub_height(values) - body.whole_h) ** 2)
        for a, at in zip(AXLES, (0.0, values["wheelbase"]), strict=True)
    )
    away = (body.x - body.whole_x) ** 2 + (body.h - body.whole_h) ** 2
    return np.asarray(inertias_of(values)[1] + hubs + np.asarray(body.sprung) * away)


def at_rest(values: Values, body: Body) -> tuple[FloatArray, FloatArray]:
    """The whole vehicle's CG behind the front axle and left of the middle as it stands, m.

    `body_of` puts a load on the body, in the body's own axes, in which the relations' levers and accelerations are. Under the
    load the body leans back and to one side, about the height at which it pitches over its wheels and about its roll axis: its
    CG moves on, in a car with its boot full by 20 mm.
    """
    axis = roll_axis_of(values, body)
    back, left = leans(values, body, axis, roll_stiffness_of(values))
    share = np.asarray(body.sprung) / body.mass
    return (
        np.asarray(body.whole_x + share * (body.h - values["pitch_path"]) * back),
        np.asarray(body.whole_y + share * (body.h - axis) * left),
    )


def _corners(values: Values, body: Body, place: tuple[FloatArray, FloatArray]) -> dict[str, FloatArray]:
    """Mass over each wheel, on level ground and at rest. place: of the CG, `at_rest`.

    The lateral moment is shared by the axles as the masses are; what one diagonal carries more is an unknown that no
    balance sees.
    """
    rear = np.asarray(body.mass * place[0] / values["wheelbase"])
    found = {}
    for axle, load in zip(AXLES, (body.mass - rear, rear), strict=True):
        moved = load * place[1] / values[f"track_{axle}"]
        for side, sign in (("l", 1.0), ("r", -1.0)):
            diagonal = sign if axle == "front" else -sign
            found[f"{axle[0]}{side}"] = np.asarray(
                0.5 * load + sign * moved + diagonal * np.asarray(values["cross"])
            )
    return {f"corner_mass_{w}_kg": found[w] for w in CORNERS}


def outputs_of(values: Values, given: Mapping[str, float]) -> dict[str, FloatArray]:
    """Every parameter of the joint posterior, () or (n,) as the values are."""
    body = body_at(values, given)
    place = at_rest(values, body)
    found = {
        "mass_kg": body.mass,
        "sprung_mass_kg": body.sprung,
        "cg_to_front_axle_m": place[0],
        "cg_lateral_offset_m": place[1],
        "cg_height_m": body.whole_h,
        "sprung_cg_height_m": body.h,
        "roll_arm_m": body.h - roll_axis_of(values, body),
        "roll_stiffness_nmprad": roll_stiffness_of(values),
        "roll_damping_nmsprad": roll_damping_of(values) * values["damping_factor"],
        "roll_inertia_kgm2": roll_inertia_of(values, body) * swinging(values, given),
        "roll_center_height_m": roll_axis_of(values, body),
        "pitch_arm_m": np.asarray(body.h) - pitch_centres(cast("Mapping[str, float]", values), body)[0],
        "pitch_inertia_kgm2": pitch_inertia_of(values, body),
        "drag_area_m2": values["drag"],
        **_corners(values, body, place),
    }
    return {name: np.asarray(value, dtype=np.float64) for name, value in found.items()}
