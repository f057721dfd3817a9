"""The vehicle's parameters as they follow from the unknowns: of one vehicle, or of many at once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

import numpy as np

from pipelines.evidence import Values
from pipelines.joint.body import TYRE_SHARE, Body, body_inertias, body_of, pitch_centres
from pipelines.joint.unknowns import AXLES, CORNERS
from pipelines.models.roll import GRAVITY
from pipelines.results import FloatArray


def body_at(values: Values, given: Mapping[str, float]) -> Body:
    """The loaded vehicle; given["sag"]: see `body_of`. Fields are (n,) where the values are."""
    return body_of(cast("Mapping[str, float]", values), given.get("sag"))


def inertias_of(values: Values) -> tuple[FloatArray, FloatArray]:
    """Roll and pitch inertia of the loaded body about its own CG."""
    roll, pitch = body_inertias(cast("Mapping[str, float]", values))
    return np.asarray(roll), np.asarray(pitch)


def roll_axis_of(values: Values, body: Body) -> FloatArray:
    """Height of the roll axis below the CG."""
    share = np.asarray(body.whole_x) / values["wheelbase"]
    return np.asarray((1 - share) * values["roll_center_front"] + share * values["roll_center_rear"])


def roll_stiffness_of(values: Values, given: Mapping[str, float]) -> FloatArray:
    """Of the suspension, body against axles, N·m/rad: springs and bars, at the height at which the loaded body stands."""
    rates = 2 * (np.asarray(values["spring_front"]) + values["spring_rear"])
    down = GRAVITY * np.asarray(values["load"]) / rates
    if "sag" in given:
        down = np.asarray(given["sag"] / TYRE_SHARE)
    parts = []
    for axle in AXLES:
        rate = (
            values[f"spring_{axle}"]
            + 2 * values[f"square_{axle}"] * down
            + 3 * values[f"cube_{axle}"] * down**2
        )
        parts.append(0.5 * np.asarray(rate) * values[f"track_{axle}"] ** 2 + values[f"bar_{axle}"])
    return np.asarray(parts[0] + parts[1])


def roll_damping_of(values: Values) -> FloatArray:
    """Of the dampers at the drive's own speeds, the mean of bump and rebound, N·m·s/rad."""
    parts = [
        0.25 * (np.asarray(values[f"bump_{a}"]) + values[f"rebound_{a}"]) * values[f"track_{a}"] ** 2
        for a in AXLES
    ]
    return np.asarray(parts[0] + parts[1])


def roll_inertia_of(values: Values, body: Body) -> FloatArray:
    """Of the whole vehicle about its CG: the body's own, and what body and wheels have by their distances."""
    hubs = sum(
        np.asarray(values[f"unsprung_{a}"])
        * (0.25 * values[f"track_{a}"] ** 2 + (values["radius"] - body.whole_h) ** 2)
        for a in AXLES
    )
    return np.asarray(inertias_of(values)[0] + hubs + np.asarray(body.sprung) * (body.h - body.whole_h) ** 2)


def pitch_inertia_of(values: Values, body: Body) -> FloatArray:
    """Of the whole vehicle about its CG, as `roll_inertia_of`."""
    hubs = sum(
        np.asarray(values[f"unsprung_{a}"])
        * ((at - body.whole_x) ** 2 + (values["radius"] - body.whole_h) ** 2)
        for a, at in zip(AXLES, (0.0, values["wheelbase"]), strict=True)
    )
    away = (body.x - body.whole_x) ** 2 + (body.h - body.whole_h) ** 2
    return np.asarray(inertias_of(values)[1] + hubs + np.asarray(body.sprung) * away)


def _corners(values: Values, body: Body) -> dict[str, FloatArray]:
    """Mass over each wheel, level and at rest.

    The lateral moment is shared by the axles as the masses are; what one diagonal carries more is an unknown that no
    balance sees.
    """
    rear = np.asarray(body.mass * body.whole_x / values["wheelbase"])
    found = {}
    for axle, load in zip(AXLES, (body.mass - rear, rear), strict=True):
        moved = load * body.whole_y / values[f"track_{axle}"]
        for side, sign in (("l", 1.0), ("r", -1.0)):
            diagonal = sign if axle == "front" else -sign
            found[f"{axle[0]}{side}"] = np.asarray(
                0.5 * load + sign * moved + diagonal * np.asarray(values["cross"])
            )
    return {f"corner_mass_{w}_kg": found[w] for w in CORNERS}


def outputs_of(values: Values, given: Mapping[str, float]) -> dict[str, FloatArray]:
    """Every parameter of the joint posterior, () or (n,) as the values are."""
    body = body_at(values, given)
    found = {
        "mass_kg": body.mass,
        "sprung_mass_kg": body.sprung,
        "cg_to_front_axle_m": body.whole_x,
        "cg_lateral_offset_m": body.whole_y,
        "cg_height_m": body.whole_h,
        "sprung_cg_height_m": body.h,
        "roll_arm_m": body.h - roll_axis_of(values, body),
        "roll_stiffness_nmprad": roll_stiffness_of(values, given),
        "roll_damping_nmsprad": roll_damping_of(values) * values["damping_factor"],
        "roll_inertia_kgm2": roll_inertia_of(values, body) * values["inertia_factor"],
        "roll_center_height_m": roll_axis_of(values, body),
        "pitch_arm_m": np.asarray(body.h) - pitch_centres(cast("Mapping[str, float]", values), body)[0],
        "pitch_inertia_kgm2": pitch_inertia_of(values, body),
        "drag_area_m2": values["drag"],
        **_corners(values, body),
    }
    return {name: np.asarray(value, dtype=np.float64) for name, value in found.items()}
