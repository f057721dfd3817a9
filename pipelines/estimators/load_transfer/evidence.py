"""What the strut forces told, for the joint posterior: what they carry, and their moments a unit of acceleration.

    vertical  sum S = m_s g
    pitch     sum x S = m_s (x - L/2) g,  and a m/s² along  m h - m h_links - κ (m_u R + m_s h_path) + (1 - κ) 4 I_w / R
    roll      sum y S = m_s y g,          and a m/s² across m_s (h_s - h_rc) + (1 - camber) (m_u R + 4 I_w / R)

x from the middle of the wheelbase, κ: g times pitch per longitudinal specific force. The same relations as load_balance's by
suspension forces, with the same unknowns, so that they are counted once. Scales and zeros of the sensors are unknowns.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pipelines.estimators.load_balance.evidence import PATCH
from pipelines.estimators.load_balance.relations import TITLES
from pipelines.estimators.load_transfer.answers import Standing, rolling_shift
from pipelines.estimators.load_transfer.batch import ACROSS, ALONG, BRAKING, STATIC, BatchFit
from pipelines.estimators.load_transfer.data import LEAN, TYRES, Known, StrutData
from pipelines.evidence import Evidence, FloatArray, Unknown, Values
from pipelines.joint.from_parameters import direct, evidence_of, loaded_body
from pipelines.joint.unknowns import AXLES, CORNERS
from pipelines.models.roll import GRAVITY
from pipelines.vehicles.vehicle import Vehicle

SOURCE = "load_transfer_batch"
CARRIER = TITLES["suspension"]
GAIN = "strut_pitch_gain"
BODY = (
    "empty_mass", "empty_x", "empty_y", "empty_h", "load", "load_x", "load_y", "load_h", "unsprung_front",
    "unsprung_rear", "wheelbase", "radius", "spring_front", "spring_rear",
)  # fmt: skip
SCALES = tuple(f"suspension_scale_{axle}" for axle in AXLES)
ZEROS = tuple(f"suspension_zero_{wheel}" for wheel in CORNERS)
LINKS = ("pitch_center_brake", "pitch_center_drive", "pitch_path", "wheel_inertia")
ROLL = ("roll_center_front", "roll_center_rear", "camber", "wheel_inertia", "track_front", "track_rear")
PITCH_ERROR, ROLL_ERROR, CARRIED_ERROR, CURVE_ERROR = 0.015, 0.015, 0.002, 0.05
LEVEL_GAIN = 0.005
LEAST_SPREAD = 0.4
"""Shares by which the moments and the sum may be wrong by what the balances leave out; braking and driving both alike and each
for itself. CURVE_ERROR: how far load transfer bends: it turns into a lateral place where all bends go one way. LEVEL_GAIN: scale of the
accelerometers. LEAST_SPREAD: of an acceleration, m/s², below which its moment is what was known before the log."""


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


def pitch_moments(values: Values) -> tuple[float | FloatArray, float | FloatArray]:
    """Moment of the struts about the CG a m/s² of specific force while braking and while driving, kg m."""
    body, gain = loaded_body(values), values[GAIN]
    spin = 4 * values["wheel_inertia"] / values["radius"]
    under = body.unsprung * values["radius"] + body.sprung * values["pitch_path"]
    free = body.moment + body.mass * values[PATCH] - gain * under + (1 - gain) * spin
    return free - body.mass * values["pitch_center_brake"], free - body.mass * values["pitch_center_drive"]


def roll_moment(values: Values) -> float | FloatArray:
    """Moment of the struts about the roll axis a m/s² of lateral specific force, kg m."""
    body = loaded_body(values)
    share = body.x / values["wheelbase"]
    axis = (1 - share) * values["roll_center_front"] + share * values["roll_center_rear"]
    spin = 4 * values["wheel_inertia"] / values["radius"]
    return body.sprung * (body.h - axis) + (1 - values["camber"]) * (body.unsprung * values["radius"] + spin)


def _lean(data: StrutData) -> Unknown:
    """κ: from the deflections, or as usual."""
    power = float(np.sum((data.along - data.along.mean()) ** 2))
    if not np.any(data.pitch) or power < 0.01 * data.size:
        return Unknown(GAIN, *LEAN["x"])
    slope = float((data.along - data.along.mean()) @ data.pitch) / power
    value = -GRAVITY * TYRES * slope
    return Unknown(GAIN, value, 0.1 * abs(value) + 0.002)


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


def _pitching(
    found: BatchFit, data: StrutData, known: Known, vehicle: Vehicle, lever: FloatArray, moving: bool
) -> Evidence:
    """Mean moment, and those a m/s² of braking and of driving."""
    place = rolling_shift(vehicle, known) if data.moving else (0.0, 0.0)
    picks = [(STATIC,), (ALONG, BRAKING), (ALONG,)] if moving else [(STATIC,)]
    value, covariance = _combined(found, [_row(found, lever, *pick) for pick in picks])
    weight = float(found.coefficients[STATIC].sum())
    level = abs(float(value[-1])) * data.offset_std[0] if moving else 0.0
    still = math.hypot(weight * place[1], level, 0.002 * known.wheelbase.value * weight)
    alike, each = math.hypot(PITCH_ERROR, LEVEL_GAIN) * value[1:], PITCH_ERROR * value[1:]
    half = 0.5 * known.wheelbase.value
    own = (_lean(data),) if moving else ()

    def parameters(values: Values) -> list[float | FloatArray]:
        front, rear = axle_forces(values)
        length = 2 * half / values["wheelbase"]
        found_: list[float | FloatArray] = [half * (rear - front) - weight * place[0]]
        if moving:
            found_ += [m * length / mean_scale(values) for m in pitch_moments(values)]
        return found_

    model = np.diag(np.square([still, *each]))
    model[1:, 1:] += np.outer(alike, alike)
    names = (*BODY, *SCALES, *ZEROS, *((*LINKS, PATCH) if moving else ()))
    return evidence_of(
        "pitch", CARRIER, "pitch moment of the struts", SOURCE, direct(value.tolist(), covariance + model), parameters,
        names, own,
    )  # fmt: skip


def _rolling(
    found: BatchFit, data: StrutData, known: Known, lever: FloatArray, moving: bool, standing: Standing
) -> Evidence:
    """Mean moment, and that a m/s² across."""
    rows = [_row(found, lever, STATIC), *([_row(found, -lever, ACROSS)] if moving else [])]
    value, covariance = _combined(found, rows)
    weight = float(found.coefficients[STATIC].sum())
    bent = CURVE_ERROR * abs(float(data.across.mean()) * value[1]) if moving else 0.0
    errors = [
        math.hypot(weight * standing.aside[1], bent),
        *([math.hypot(ROLL_ERROR, LEVEL_GAIN) * value[1]] if moving else []),
    ]
    used = 0.5 * (known.track[0].value + known.track[1].value)

    def parameters(values: Values) -> list[float | FloatArray]:
        body, scale = loaded_body(values), mean_scale(values)
        zeros = sum(
            (half if w[1] == "l" else -half) * values[f"suspension_zero_{w}"]
            for w, half in zip(CORNERS, np.abs(lever).tolist(), strict=True)
        )
        made: list[float | FloatArray] = [(GRAVITY * body.sprung * body.y - zeros) / scale]
        if moving:
            wider = 2 * used / (values["track_front"] + values["track_rear"])
            made.append(roll_moment(values) * wider / scale)
        return made

    names = dict.fromkeys((*BODY, *SCALES, *ZEROS, *(ROLL if moving else ())))
    return evidence_of(
        "roll", CARRIER, "roll moment of the struts", SOURCE,
        direct(value.tolist(), covariance + np.diag(np.square(errors))), parameters, tuple(names),
    )  # fmt: skip


def evidence(
    found: BatchFit, data: StrutData, known: Known, vehicle: Vehicle, standing: Standing, moving: bool
) -> tuple[Evidence, ...]:
    """The relations of one drive. moving: it was long and lively enough for the moments a m/s²."""
    total, pitch, roll = _rows(known)
    along, across = (moving and float(np.std(a)) > LEAST_SPREAD for a in (data.along, data.across))
    told = (
        _carried(found, total),
        _pitching(found, data, known, vehicle, pitch, along and bool(data.braking.any())),
        _rolling(found, data, known, roll, across, standing),
    )
    return tuple(replace(e, dedicated=True) for e in told)
