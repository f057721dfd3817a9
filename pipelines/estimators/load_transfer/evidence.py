"""What the strut forces told, for the joint posterior: what they carry, and their moments a unit of acceleration.

    vertical  sum S = m_s g
    pitch     sum x S = m_s (x - L/2) g,  and a m/s² along  m h - m h_links - past - κ (m_u R + m_s h_path) + (1 - κ) 4 I_w / R
    roll      sum y S = m_s y g,          and a m/s² across m_s (h_s - h_rc) + (1 - camber) (m_u R + 4 I_w / R)
    diagonal  S_fl - S_fr - S_rl + S_rr = 2 y g (m_f / t_f - m_r / t_r) + 4 g m_x

m_f, m_r: mass over each axle; m_x: what one diagonal carries more, a wheel, which no other balance sees.

past: the hubs' inertia that swing arms take past the springs. x from the middle of the wheelbase at rest; a m/s² from where the static loads have their middle, the body's CG: what the links
lift of the whole body in braking (anti-dive of one axle more than the other's) has no moment there. κ: g times pitch per
longitudinal specific force. The same relations as load_balance's by
suspension forces, with the same unknowns, so that they are counted once. Scales and zeros of the sensors are unknowns.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from pipelines.estimators.load_balance.evidence import PATCH
from pipelines.estimators.load_balance.relations import TITLES
from pipelines.estimators.load_transfer.answers import FRICTION_N, Standing, about_cg
from pipelines.estimators.load_transfer.batch import ACROSS, ALONG, BRAKING, STATIC, BatchFit
from pipelines.estimators.load_transfer.data import LEAN, LEANING, OFFSET_STD, TYRES, Known, StrutData
from pipelines.evidence import Evidence, FloatArray, Unknown, Values
from pipelines.joint.from_parameters import direct, evidence_of, hubs_past, loaded_body
from pipelines.joint.vehicle.body import hub_height
from pipelines.joint.vehicle.laden import axis_lever, forces_lever, patch_lag, roll_springs, side_patches
from pipelines.joint.vehicle.outputs import roll_stiffness_of
from pipelines.joint.vehicle.poles import POLES, pitch_centres
from pipelines.joint.vehicle.unknowns import AXLES, CORNERS
from pipelines.models.roll import GRAVITY

SOURCE = "load_transfer_batch"
CARRIER = TITLES["suspension"]
GAIN = "strut_pitch_gain"
BODY = (
    "empty_mass", "empty_x", "empty_y", "empty_h", "load", "load_x", "load_y", "load_h", "unsprung_front",
    "unsprung_rear", "wheelbase", "radius", "hub_low", "spring_front", "spring_rear",
)  # fmt: skip
SCALES = tuple(f"suspension_scale_{axle}" for axle in AXLES)
ZEROS = tuple(f"suspension_zero_{wheel}" for wheel in CORNERS)
TWIST = ("cross", "track_front", "track_rear")
ROLLING = ("rolling_shift", "rolling")
LINKS = (
    "pitch_center_brake", "pitch_center_drive", "jack_brake", "jack_drive", "pitch_path", "hubs_past", "wheel_inertia", *POLES,
)  # fmt: skip
ROLL = (
    "roll_center_front", "roll_center_rear", "camber", "wheel_inertia", "track_front", "track_rear", "track_grows", "axis_sinks", "sinks_front", "sinks_rear", "patch_side",
    "bar_front", "bar_rear", "spring_base_front", "spring_base_rear", "force_base_front", "force_base_rear", "square_front", "square_rear", "cube_front", "cube_rear", "free_front", "free_rear", "stop_front", "stop_rear", "side_path", "wheel_plane", "paths_told", "path_front", "path_rear", "lean_path",
)  # fmt: skip
PITCH_ERROR, ROLL_ERROR, CARRIED_ERROR, CURVE_ERROR = 0.015, 0.015, 0.004, 0.05
LEVEL_GAIN = 0.005
ASKEW: Mapping[str, tuple[str, str, float]] = {
    "x": ("offset_x", "askew_pitch", GRAVITY), "y": ("offset_y", "askew_roll", -GRAVITY)
}  # fmt: skip
"""What an accelerometer's reading lacks: its offset, and gravity through its tilt (m/s² a rad). The same unknowns as in the balances
by deflections: one inertial unit is not two witnesses of where the body's CG lies."""
LEAST_SPREAD = 0.4
"""Shares by which the moments and the sum may be wrong by what the balances leave out; braking and driving both alike and each
for itself. CURVE_ERROR: how far load transfer bends: it turns into a lateral place where all bends go one way. LEVEL_GAIN: scale of the
accelerometers. LEAST_SPREAD: of an acceleration, m/s², below which its moment is what was known before the log."""

DIAGONAL = np.array([1.0, -1.0, -1.0, 1.0])


def mean_scale(values: Values) -> float | FloatArray:
    """Of the four sensors' force."""
    return 0.5 * (values[SCALES[0]] + values[SCALES[1]])


def axle_forces(values: Values) -> tuple[float | FloatArray, float | FloatArray]:
    """Mean force of the front and of the rear struts as their sensors should show it, N."""
    body = loaded_body(values)
    rear = GRAVITY * body.sprung * body.x / values["wheelbase"]
    front = GRAVITY * body.sprung - rear
    zeros = [values[f"suspension_zero_{axle[0]}l"] + values[f"suspension_zero_{axle[0]}r"] for axle in AXLES]
    return (front - zeros[0]) / values[SCALES[0]], (rear - zeros[1]) / values[SCALES[1]]


def diagonal_force(values: Values) -> float | FloatArray:
    """What the front left and the rear right strut should show more than the other two at rest, N."""
    body = loaded_body(values)
    behind = body.whole_x / values["wheelbase"]
    total: float | FloatArray = 0.0
    for axle, share, sign in zip(AXLES, (1 - behind, behind), (1.0, -1.0), strict=True):
        aside = 2 * sign * share * body.mass * body.whole_y / values[f"track_{axle}"]
        zeros = values[f"suspension_zero_{axle[0]}l"] - values[f"suspension_zero_{axle[0]}r"]
        more = GRAVITY * (aside + 2 * values["cross"]) - sign * zeros
        total = total + more / values[f"suspension_scale_{axle}"]
    return total


def pitch_moments(values: Values) -> tuple[float | FloatArray, float | FloatArray]:
    """Moment of the struts about the CG a m/s² of specific force while braking and while driving, kg m."""
    body, gain = loaded_body(values), values[GAIN]
    spin = 4 * values["wheel_inertia"] / values["radius"]
    under = body.unsprung * hub_height(values) + body.sprung * values["pitch_path"]
    free = body.moment + body.mass * patch_lag(values) - hubs_past(values) - gain * under + (1 - gain) * spin
    braking, driving = pitch_centres(cast("Mapping[str, float]", values), body)
    return free - body.mass * braking, free - body.mass * driving


def roll_moment(values: Values) -> float | FloatArray:
    """Moment of the struts about the roll axis a m/s² of lateral specific force, kg m."""
    body = loaded_body(values)
    share = body.x / values["wheelbase"]
    spin = 4 * values["wheel_inertia"] / values["radius"]
    hubs = (1 - values["camber"]) * (body.unsprung * hub_height(values) + spin + side_patches(values, body))
    whole = body.sprung * (body.h - axis_lever(values, share)) + hubs
    springs = roll_stiffness_of(values)
    told: float | FloatArray = whole * springs / roll_springs(values, body, springs)
    return told


def _lean(data: StrutData) -> Unknown:
    """κ: from the deflections, or as usual."""
    power = float(np.sum((data.along - data.along.mean()) ** 2))
    if not np.any(data.pitch) or power < 0.01 * data.size:
        return Unknown(GAIN, *LEAN["x"])
    slope = float((data.along - data.along.mean()) @ data.pitch) / power
    value = -GRAVITY * TYRES * slope
    return Unknown(GAIN, value, 0.1 * abs(value) + 0.002)


@dataclass(frozen=True)
class _Level:
    """How far a horizontal force is level. kept: the share of what the reading lacks (`ASKEW`) that is still in it.

    road: m/s² (std), what the road's mean slope, taken for the sensor's, put in.
    """

    axis: str
    kept: float
    road: float

    @property
    def unknowns(self) -> tuple[str, ...]:
        """Names that `lacking` depends on."""
        return ASKEW[self.axis][:2] if self.kept > 0 else ()

    def lacking(self, values: Values) -> float | FloatArray:
        """m/s² that the true force is above the one that was used."""
        offset, tilt, gravity = ASKEW[self.axis]
        return self.kept * (values[offset] + gravity * values[tilt]) if self.kept > 0 else 0.0


def _level(data: StrutData, axis: str) -> _Level:
    """From the spread that is left: sensor² (1 - w) with w the weight that the wheels' motion had against the sensor's prior."""
    left = data.offset_std["xy".index(axis)]
    sensor = OFFSET_STD[axis] * (LEANING if np.any(data.roll) else 1.0)
    if not left < sensor:
        # no accelerometer: the path's own doubt, which nobody shares
        return _Level(axis, 0.0, left)
    weight = 1 - (left / sensor) ** 2
    return _Level(axis, 1 - weight, math.sqrt(weight) * left)


def _rows(known: Known) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(4,) levers of sum, pitch moment and roll moment."""
    half = 0.5 * known.wheelbase.value
    front, rear = 0.5 * known.track[0].value, 0.5 * known.track[1].value
    return np.ones(4), half * np.array([-1.0, -1.0, 1.0, 1.0]), np.array([front, -front, rear, -rear])


def _combined(found: BatchFit, rows: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """(m,) combinations of coefficients (m, k, 4), and their (m, m) covariance."""
    flat = np.array([row.ravel() for row in rows])
    return flat @ found.coefficients.ravel(), flat @ found.covariance @ flat.T


def _row(found: BatchFit, lever: FloatArray, *columns: int) -> FloatArray:
    row = np.zeros_like(found.coefficients)
    row[list(columns)] = lever
    return row


def _carried(found: BatchFit, lever: FloatArray) -> Evidence:
    value, covariance = _combined(found, [_row(found, lever, STATIC)])
    own = (CARRIED_ERROR * value[0]) ** 2
    return evidence_of(
        "vertical", CARRIER, "what the struts carry in the mean", SOURCE, direct(value.tolist(), covariance + own),
        lambda values: [sum(axle_forces(values))], (*BODY, *SCALES, *ZEROS),
    )  # fmt: skip


def _rolling_moment(values: Values, rolls: bool) -> float | FloatArray:
    """What rolling resistance moves from the front wheels to the rear ones, N m: as in the balances by deflections."""
    if not rolls:
        return 0.0
    arm = values["rolling_shift"] * values["rolling"] * values["radius"]
    return GRAVITY * loaded_body(values).mass * arm


def _pitching(found: BatchFit, data: StrutData, known: Known, lever: FloatArray, moving: bool) -> Evidence:
    """Mean moment, and those a m/s² of braking and of driving."""
    rows = [_row(found, lever, STATIC)]
    if moving:
        about = about_cg(found, known)
        rows += [_row(found, about, ALONG, BRAKING), _row(found, about, ALONG)]
    value, covariance = _combined(found, rows)
    weight = float(found.coefficients[STATIC].sum())
    level = _level(data, "x")
    a_unit = float(lever @ found.coefficients[ALONG]) if moving else 0.0
    still = math.hypot(a_unit * level.road, 0.002 * known.wheelbase.value * weight)
    alike, each = math.hypot(PITCH_ERROR, LEVEL_GAIN) * value[1:], PITCH_ERROR * value[1:]
    half = 0.5 * known.wheelbase.value
    own = (_lean(data),) if moving else ()

    def parameters(values: Values) -> list[float | FloatArray]:
        front, rear = axle_forces(values)
        length = 2 * half / values["wheelbase"]
        found_: list[float | FloatArray] = [
            half * (rear - front) + _rolling_moment(values, data.moving) + a_unit * level.lacking(values)
        ]
        if moving:
            found_ += [m * length / mean_scale(values) for m in pitch_moments(values)]
        return found_

    model = np.diag(np.square([still, *each]))
    model[1:, 1:] += np.outer(alike, alike)
    names = (*BODY, *SCALES, *ZEROS, *ROLLING, *((*LINKS, PATCH, *level.unknowns) if moving else ()))
    return evidence_of(
        "pitch", CARRIER, "pitch moment of the struts", SOURCE, direct(value.tolist(), covariance + model), parameters,
        names, own,
    )  # fmt: skip


def _rolling(
    found: BatchFit, data: StrutData, known: Known, lever: FloatArray, moving: bool, standing: Standing
) -> Evidence:
    """Mean moment, mean force of one diagonal over the other's, and the moment a m/s² across."""
    rows = [
        _row(found, lever, STATIC),
        _row(found, DIAGONAL, STATIC),
        *([_row(found, -lever, ACROSS)] if moving else []),
    ]
    value, covariance = _combined(found, rows)
    weight, level = float(found.coefficients[STATIC].sum()), _level(data, "y")
    a_unit = float(value[2]) if moving else 0.0
    aside = (
        math.hypot(a_unit * level.road, 0.001 * known.wheelbase.value * weight)
        if moving
        else weight * standing.aside[1]
    )
    bent = CURVE_ERROR * abs(float(data.across.mean()) * a_unit) if moving else 0.0
    twist = float(DIAGONAL @ found.coefficients[ACROSS]) if moving else 0.0
    errors = [
        math.hypot(aside, bent),
        math.hypot(2 * FRICTION_N, twist * level.road),
        *([math.hypot(ROLL_ERROR, LEVEL_GAIN) * a_unit] if moving else []),
    ]
    used = 0.5 * (known.track[0].value + known.track[1].value)

    def parameters(values: Values) -> list[float | FloatArray]:
        body, scale = loaded_body(values), mean_scale(values)
        zeros = sum(
            (half if w[1] == "l" else -half) * values[f"suspension_zero_{w}"]
            for w, half in zip(CORNERS, np.abs(lever).tolist(), strict=True)
        )
        made: list[float | FloatArray] = [
            (GRAVITY * body.sprung * body.y - zeros) / scale - a_unit * level.lacking(values),
            diagonal_force(values) + twist * level.lacking(values),
        ]
        if moving:
            wider = 2 * used / (values["track_front"] + values["track_rear"])
            made.append(roll_moment(values) * forces_lever(values) * wider / scale)
        return made

    names = dict.fromkeys((*BODY, *SCALES, *ZEROS, *TWIST, *((*ROLL, *level.unknowns) if moving else ())))
    return evidence_of(
        "roll", CARRIER, "roll moment of the struts", SOURCE,
        direct(value.tolist(), covariance + np.diag(np.square(errors))), parameters, tuple(names),
    )  # fmt: skip


def evidence(
    found: BatchFit, data: StrutData, known: Known, standing: Standing, moving: bool
) -> tuple[Evidence, ...]:
    """The relations of one drive. moving: it was long and lively enough for the moments a m/s²."""
    total, pitch, roll = _rows(known)
    along, across = (moving and float(np.std(a)) > LEAST_SPREAD for a in (data.along, data.across))
    told = (
        _carried(found, total),
        _pitching(found, data, known, pitch, along and bool(data.braking.any())),
        _rolling(found, data, known, roll, across, standing),
    )
    return tuple(replace(e, dedicated=True) for e in told)
