"""What braking and cornering told, for the joint posterior: each part's fit with its priors of the vehicle taken out.

- Slips: height and place of the CG over the wheelbase lie on a line (the more of the load is in front, the lower); the
  place's prior comes out by division. What else the slips hang on (tyres, radii, brake distribution) nobody else knows.
- Longitudinal balance: mass, scales of the torques, drag and rolling resistance as the log alone ties them together.
- Roll against the horizon per sensed lateral acceleration, against suspension and tyres in series.
"""

from __future__ import annotations

import math

import numpy as np

from pipelines.estimators.base_excitation.evidence import SPRINGS
from pipelines.estimators.brake_roll.answers import (
    GRADIENT_DOUBT,
    HEIGHT_ERROR,
    MASS_DOUBT,
    Found,
    gain_spread,
)
from pipelines.estimators.brake_roll.data import BrakeRollData
from pipelines.estimators.brake_roll.lateral import LateralFit
from pipelines.estimators.brake_roll.mass import BRAKE_TORQUE_STD, ROLLING, MassFit
from pipelines.estimators.brake_roll.parts import ARM_SHARE, TYRE_RATE, forward_gain
from pipelines.estimators.brake_roll.rows import window_mean
from pipelines.estimators.brake_roll.slip import SlipFit
from pipelines.estimators.brake_roll.vehicle import BrakeRollVehicle
from pipelines.evidence import Evidence, FloatArray, Unknown, Values
from pipelines.joint.from_parameters import Told, direct, evidence_of, loaded_body, without_prior
from pipelines.joint.vehicle.body import even_factor, hub_height
from pipelines.joint.vehicle.laden import axis_lever, roll_springs, side_patches
from pipelines.joint.vehicle.outputs import roll_stiffness_of
from pipelines.joint.vehicle.unknowns import TOWED
from pipelines.models.roll import GRAVITY
from pipelines.prepare.bends import road_share
from pipelines.vehicles.vehicle import Vehicle

SOURCE = "brake_roll_batch"
ARM, BANK = "torque_arm", "banked_bends"
BEND_S = 4.0
BANKED, BANKED_STD, FLAT_STD = 0.15, 0.4, 0.05
AIR_SHARE, ROLLING_DOUBT, SCALE_DOUBT = 0.12, 0.0015, 0.01
"""BEND_S: what lasts longer is a bend of the road, which may be banked; what is quicker was steered on flat ground. BANKED,
BANKED_STD: what bends that lean inwards take off the roll against the horizon, as a share of it: two thirds on country roads that are
banked by 2.5 to 6 %, nothing in towns. FLAT_STD: the spread of anything else that does. AIR_SHARE: of the drag area: a wind of 2 m/s along a
drive of 20 m/s is a fifth of it, of which turns take about half; air that is thinner or denser. ROLLING_DOUBT: of
rolling resistance, which warms up. SCALE_DOUBT: by how much a torque's scale changes within a drive."""

BODY = (
    "empty_mass", "empty_x", "empty_y", "empty_h", "load", "load_x", "load_y", "load_h", "unsprung_front",
    "unsprung_rear", "wheelbase", "radius", "hub_low", "spring_front", "spring_rear",
)  # fmt: skip
LONGITUDINAL = ("mass", "brakes", "engine", "drag_area", "rolling")


def _slips(fit: SlipFit, known: BrakeRollVehicle) -> Evidence | None:
    """Height and place over the wheelbase."""
    if known.front is None or known.wheelbase is None:
        return None
    length = known.wheelbase.value
    pick = [fit.fit.names.index(name) for name in ("height", "front_m")]
    told = without_prior(
        fit.fit.values[pick], fit.fit.covariance[np.ix_(pick, pick)], np.array([0.0, known.front.value]),
        np.array([math.inf, known.front.std]), white=fit.fit.white[np.ix_(pick, pick)],
    )  # fmt: skip
    if told is None:
        return None
    # what bends the quotient of the axles' slips otherwise: the same at any braking it looks like another place, else like
    # another height
    bent = math.sqrt(max(fit.std**2 - fit.fit.std("height") ** 2, 0.0))
    errors = [math.hypot(HEIGHT_ERROR * fit.height, bent), bent * fit.strongest / GRAVITY]
    model = told.rows * np.square(errors) @ told.rows.T
    told = Told(told.rows, told.observed, told.covariance + model)

    def parameters(values: Values) -> list[float | FloatArray]:
        body, over = loaded_body(values), length / values["wheelbase"]
        return [body.whole_h * over, body.whole_x * over]

    return evidence_of(
        "pitch", "wheel slips", "load transfer in the slips of braked wheels", SOURCE, told, parameters, BODY
    )


def _longitudinal(
    fit: MassFit, data: BrakeRollData, known: BrakeRollVehicle, drive_std: float, vehicle: Vehicle
) -> Evidence | None:
    """Mass, torques' scales, drag area and rolling resistance."""
    pick = [fit.fit.names.index(name) for name in LONGITUDINAL]
    gained = data.by_pressure and known.gain is not None
    nominal = known.gain.value if known.gain is not None else 1.0
    relative = known.gain.std / nominal if gained and known.gain is not None else BRAKE_TORQUE_STD
    means = np.array([0.0, 0.0, 0.0, known.drag_area.value, ROLLING[0]])
    stds = np.array([math.inf, relative, drive_std, known.drag_area.std, ROLLING[1]])
    told = without_prior(
        fit.fit.values[pick], fit.fit.covariance[np.ix_(pick, pick)], means, stds,
        white=fit.fit.white[np.ix_(pick, pick)],
    )  # fmt: skip
    if told is None:
        return None
    # the mass scales with what the nose's dive adds to the accelerometer, and bends cost torque that nothing tells
    doubt = (
        math.hypot(forward_gain(data)[1], MASS_DOUBT) * fit.mass, SCALE_DOUBT, SCALE_DOUBT,
        AIR_SHARE * known.drag_area.value, ROLLING_DOUBT,
    )  # fmt: skip
    model = told.rows * np.square(doubt) @ told.rows.T
    told = Told(told.rows, told.observed, told.covariance + model)
    tyre = vehicle.get("tire_vertical_rate_npm")
    squash = known.mass.value * GRAVITY / (4 * (TYRE_RATE if tyre is None else tyre.value))
    used = known.radius.value - ARM_SHARE[0] * squash
    share = ARM_SHARE[1] * squash / used

    def parameters(values: Values) -> list[float | FloatArray]:
        body = loaded_body(values)
        arm = used / (values["radius"] * values[ARM])
        # of a torque that the log lacks nothing is told, and nothing asked
        brake = (
            even_factor(values["brake_gain"] / nominal if gained else values["brake_scale"])
            if fit.braked
            else 1.0
        )
        drive = even_factor(values["drive_scale"]) if fit.driven else 1.0
        return [
            body.mass + values[TOWED],
            brake * arm - 1,
            drive * arm - 1,
            values["drag"],
            values["rolling"],
        ]

    brakes, drives = ("brake_gain" if gained else "brake_scale",), ("drive_scale",)
    names = (
        *BODY,
        *(brakes if fit.braked else ()),
        *(drives if fit.driven else ()),
        "drag",
        "rolling",
        TOWED,
    )
    return evidence_of(
        "longitudinal", "torques", "torques against longitudinal acceleration", SOURCE, told, parameters, names,
        (Unknown(ARM, 1.0, share),),
    )  # fmt: skip


def roll_gain(values: Values) -> float | FloatArray:
    """Roll against the road per sensed lateral acceleration, rad per m/s²: suspension and tyres in series."""
    body = loaded_body(values)
    share = body.x / values["wheelbase"]
    axis = axis_lever(values, share)
    stiffness = roll_springs(values, body, roll_stiffness_of(values))
    tyres = 0.5 * values["tyre_rate"] * (values["track_front"] ** 2 + values["track_rear"] ** 2)
    lean = 1 - values["camber"]
    spin = 4 * values["wheel_inertia"] / values["radius"]
    patches = side_patches(values, body)
    hubs = lean * (body.unsprung * hub_height(values) + spin + patches)
    gain: float | FloatArray = (body.sprung * (body.h - axis) + hubs) / stiffness + (
        body.moment + spin + patches
    ) / tyres
    return gain


def bends_share(fit: LateralFit, data: BrakeRollData) -> float:
    """Share of the lateral acceleration's power that is as slow as a road's bends, and may be theirs."""
    assert data.f_y is not None
    side = data.f_y[fit.used] - float(np.mean(data.f_y[fit.used]))
    slow = window_mean(side, round(BEND_S * data.rate_hz / 2))
    share = min(float(np.var(slow)) / max(float(np.var(side)), 1e-12), 1.0)
    kept = np.where(fit.used, data.f_y, 0.0)
    # what is filled across a gap would join the bends before and behind it into a test pad's turn
    yaw = None if data.yaw_rate is None else np.where(data.rows, data.yaw_rate, 0.0)
    return share * road_share(yaw, kept, 1 / data.rate_hz, np.zeros(1, np.int64))


def _banked(fit: LateralFit, data: BrakeRollData) -> Unknown:
    """What superelevation takes off: the more, the slower the drive's bends are."""
    share = bends_share(fit, data)
    return Unknown(BANK, BANKED * share, math.hypot(BANKED_STD * share, FLAT_STD))


def _cornering(fit: LateralFit, data: BrakeRollData) -> Evidence:
    """The roll per lateral acceleration."""
    std = fit.gain * math.hypot(gain_spread(fit), GRADIENT_DOUBT)

    def parameters(values: Values) -> list[float | FloatArray]:
        return [roll_gain(values) * (1 - values[BANK])]

    names = (
        *BODY, *SPRINGS, "track_front", "track_rear", "bar_front", "bar_rear", "roll_center_front", "roll_center_rear", "track_grows", "axis_sinks", "sinks_front", "sinks_rear", "patch_side", "side_path", "wheel_plane", "paths_told", "path_front", "path_rear", "lean_path",
        "camber", "wheel_inertia", "tyre_rate",
    )  # fmt: skip
    return evidence_of(
        "roll", "horizon", "roll against the road in cornering", SOURCE, direct([fit.gain], np.array([[std**2]])),
        parameters, tuple(dict.fromkeys(names)), (_banked(fit, data),),
    )  # fmt: skip


def evidence(
    found: Found, data: BrakeRollData, known: BrakeRollVehicle, drive_std: float, vehicle: Vehicle
) -> tuple[Evidence, ...]:
    """The relations of the parts that spoke. drive_std: relative, of the drive torque's scale."""
    relations: list[Evidence | None] = []
    if found.slip is not None:
        relations.append(_slips(found.slip, known))
    if found.mass is not None:
        relations.append(_longitudinal(found.mass, data, known, drive_std, vehicle))
    if found.lateral is not None:
        relations.append(_cornering(found.lateral, data))
    return tuple(r for r in relations if r is not None)
