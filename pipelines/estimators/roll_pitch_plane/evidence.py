"""What quick motion told of the body's inertias, for the joint posterior: the coefficients of the angular accelerations.

What these balances tell of arms and masses is the same relation as load_balance's and load_transfer_batch's by suspension
forces; the inertias are not, as those look below 2 or 3 Hz. The inertial unit sits above the CG, so that its horizontal
forces hold a part of the angular accelerations, which the prediction allows for.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipelines.estimators.load_transfer.evidence import BODY, ROLL, SCALES, mean_scale, roll_moment
from pipelines.estimators.roll_pitch_plane.answers import SensorErrors
from pipelines.estimators.roll_pitch_plane.balances import Wheels, pivot_doubt
from pipelines.estimators.roll_pitch_plane.data import Planes
from pipelines.estimators.roll_pitch_plane.fit import LinearFit
from pipelines.estimators.roll_pitch_plane.known import FEET, NET_MOMENT, ROLL_CENTER, ROLL_RADPS
from pipelines.evidence import Evidence, FloatArray, Kind, Values
from pipelines.joint.from_parameters import evidence_of, hubs_past, loaded_body, without_prior
from pipelines.joint.vehicle.body import hub_height
from pipelines.joint.vehicle.laden import forces_lever
from pipelines.joint.vehicle.outputs import INERTIA_BY_FORCES, inertias_of, roll_axis_of
from pipelines.joint.vehicle.poles import POLES, pole_drop
from pipelines.models.roll import GRAVITY

CARRIER = "suspension forces in quick motion"


INERTIA = ("load_h", "load_x", "load_y", "load_wide", "load_long", "empty_h", "empty_y", "radius", "hub_low", "track_front", "track_rear")  # fmt: skip
"""What the body's inertia hangs on beside the masses: see `body_inertias`."""


def _of(
    fit: LinearFit,
    name: str,
    mass: float,
    errors: SensorErrors,
    doubts: tuple[float, ...],
    kind: Kind,
    source: str,
    inertia: Callable[[Values], float | FloatArray],
    names: tuple[str, ...],
) -> Evidence | None:
    """The coefficient without its prior. doubts: what it may be wrong by, kg m²."""
    value = fit.value(name)
    prior = {"roll_acc": (0.4 * mass, mass), "pitch_acc": (1.5 * mass, 3 * mass)}[name]
    model = sum(d**2 for d in (*doubts, errors.inertia_model * value, errors.accel_scale * value))
    told = without_prior(
        np.array([value]), np.array([[fit.std(name) ** 2 + model]]), np.array([prior[0]]), np.array([prior[1]])
    )  # fmt: skip
    if told is None:
        return None
    axis = "roll" if kind == "roll" else "pitch"
    title = f"{axis} moment of the struts against {axis} acceleration"
    return evidence_of(
        kind,
        CARRIER,
        title,
        source,
        told,
        lambda values: [inertia(values)],
        tuple(dict.fromkeys((*BODY, *SCALES, *names))),
        given={INERTIA_BY_FORCES: 0.5} if kind == "roll" else None,
    )


def roll_evidence(
    fit: LinearFit, planes: Planes, wheels: Wheels, mass: float, errors: SensorErrors
) -> tuple[Evidence, ...]:
    """Roll inertia of the body about its CG."""
    feet = (
        float(np.hypot(FEET[1] * ROLL_CENTER[0], FEET[0] * ROLL_CENTER[1])) * mass * GRAVITY / ROLL_RADPS**2
    )
    doubt = fit.doubt("roll_acc", NET_MOMENT * float(np.std(planes.columns["roll_moment"])))
    # moments of the feet that were not taken off before the fit
    left = (FEET[0] * ROLL_CENTER[0] * mass * GRAVITY - wheels.feet) / ROLL_RADPS**2

    def inertia(values: Values) -> float | FloatArray:
        body, moment = loaded_body(values), roll_moment(values)
        above = values["imu_h"] - body.h
        lean = 1 - values["camber"]
        arm = body.h - roll_axis_of(values, body)
        hubs = body.unsprung * hub_height(values) * lean * (arm - lean * hub_height(values))
        lever: float | FloatArray = forces_lever(values) / mean_scale(values)
        told: float | FloatArray = (inertias_of(values)[0] - moment * above - hubs - left) * lever
        return told

    names = (*INERTIA, "roll_inertia", *ROLL, "imu_h")
    made = _of(fit, "roll_acc", mass, errors, (doubt, feet), "roll", "roll_plane", inertia, names)
    return () if made is None else (made,)


def pitch_evidence(fit: LinearFit, planes: Planes, mass: float, errors: SensorErrors) -> tuple[Evidence, ...]:
    """Pitch inertia of the body about its CG."""
    doubt = fit.doubt("pitch_acc", NET_MOMENT * float(np.std(planes.columns["pitch_moment"])))

    def inertia(values: Values) -> float | FloatArray:
        body = loaded_body(values)
        links = 0.5 * (values["pitch_center_brake"] + values["pitch_center_drive"]) - pole_drop(values)
        spin = 4 * values["wheel_inertia"] / values["radius"]
        moment = body.moment - body.mass * links - hubs_past(values) + spin
        above, ahead = values["imu_h"] - body.h, body.x - values["imu_x"]
        hubs = (body.unsprung * hub_height(values) + spin) * (body.h - hub_height(values))
        # the vertical accelerometer reads pitch where it sits ahead of the CG
        place = body.sprung * (body.x - 0.5 * values["wheelbase"]) * ahead
        told: float | FloatArray = (inertias_of(values)[1] - moment * above - hubs + place) / mean_scale(
            values
        )
        return told

    names = (
        *INERTIA,
        "pitch_inertia",
        "pitch_center_brake",
        "pitch_center_drive",
        *POLES,
        "hubs_past",
        "wheel_inertia",
        "imu_h",
        "imu_x",
    )
    doubts = (doubt, pivot_doubt(planes, mass))
    made = _of(fit, "pitch_acc", mass, errors, doubts, "pitch", "pitch_plane", inertia, names)
    return () if made is None else (made,)
