"""CG height from the slips of a whole drive's braking, in one fit.

Wheel speeds of both axles are predicted from the forces: w = κ v (1 - λ), λ = μ/C (1 + b |μ| + 5/3 b² μ²)(1 + p (F_z/F_z0 - 1)) and
μ = F_x/F_z, with the axle loads of (10a) and (41) and the forces of (1). Park & Choi take b = p = 0 and κ = 1, and
drop C out of each instant's quotient; here both axles share C within one stop, and what the slips hang on is part of
the fit: rolling radii κ, the accelerometer's offset and gain, what is left of the speed's delay, the CG's place, the
brake distribution, what an engine in gear holds back, the tyres' bend, load dependence and how far they sink. Rows without
brakes tell the radii.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from parsers.channels import IntArray
from pipelines.estimators.brake_roll.least import LeastFit, Samples, Unknown, blocks_of, fit_least, jacobian
from pipelines.estimators.brake_roll.rows import within
from pipelines.models.braking import AIR_DENSITY
from pipelines.models.roll import GRAVITY
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import BoolArray
from pipelines.prepare.spans import runs
from pipelines.results import FloatArray

MOST_STOPS = 40
MOST_ROWS = 40_000
LEAST_STOP_S = 0.6
REST_S = 1.0
ROLLING_HZ = 0.5
"""Rows roll freely from a second after the brakes on, and their drive slip is put to f_x below half a hertz: its noise
would else hide the drive slip, and with it the tyres' stiffness that the stops share."""

STRONGEST = 0.75
"""Share of gravity beyond which the tyres are too near their limit for one slip curve."""


@dataclass(frozen=True)
class SlipKnown:
    """Mean and standard deviation of what is known. mass in kg (forces per mass; C takes up its error).

    share_log: of ln(front / rear brake force). bend: b. load: p. squash: share of a tyre's deflection by which its rolling
    radius falls (a third by the textbook, less in a stiff belt). tyre_rate: vertical, of one tyre, N/m. drive_front: share of the drive force on the front
    axle. engine_drag: m/s² that an engine in gear may hold back through the driven axles while the brakes are on (spread). gain: of accel_x. delay: s left. same_tyres: by how much ln C may differ from stop to stop.
    ratio_error: of the quotient of the axles' slips, what no parameter of the fit holds.
    """

    mass: float
    front_m: tuple[float, float]
    wheelbase_m: float
    radius_m: float
    wheel_inertia: float
    drag_area: float
    share_log: float
    offset: float = 0.05
    gain: float = 0.01
    delay: float = 0.01
    bend: tuple[float, float] = (0.25, 0.2)
    load: tuple[float, float] = (0.0, 0.1)
    squash: tuple[float, float] = (0.2, 0.12)
    tyre_rate: float = 220_000.0
    radius: float = 0.02
    drive_front: tuple[float, float] = (0.5, 0.5)
    engine_drag: float = 1e-6
    same_tyres: float = 0.1
    ratio_error: float = 0.0


@dataclass(frozen=True)
class SlipData:
    """Columns (n,) SI at rate_hz, low-passed alike at band_hz. front_torque, rear_torque: of both wheels. rows: straight,
    flat, no brake control, not split; braked: the brakes are on (past their onset)."""

    rate_hz: float
    band_hz: float
    speed: FloatArray
    f_x: FloatArray
    front: FloatArray
    rear: FloatArray
    front_torque: FloatArray
    rear_torque: FloatArray
    drive_torque: FloatArray | None
    rows: BoolArray
    braked: BoolArray


@dataclass(frozen=True)
class SlipFit:
    """height, std in m. fit: all parameters. rows: fitted rows, stops: their number. strongest: m/s² of braking.

    predicted: (rows, 2) wheel speeds. slopes: normalised slip stiffness by stop.
    """

    height: float
    std: float
    fit: LeastFit
    rows: IntArray
    stops: int
    strongest: float
    predicted: FloatArray
    slopes: FloatArray


@dataclass(frozen=True)
class _Rows:
    """The fitted rows' columns, each (n,). stop: number of the stop, -1 without brakes."""

    v: FloatArray
    f: FloatArray
    front_torque: FloatArray
    rear_torque: FloatArray
    engine: FloatArray
    stop: IntArray
    seen: FloatArray


def _stops(data: SlipData) -> list[tuple[int, int]]:
    """The stops with the most braking: at least LEAST_STOP_S long."""
    found = [
        (a, b)
        for a, b in runs(data.braked & data.rows & (data.speed > 3.0) & (data.f_x > -STRONGEST * GRAVITY))
        if b - a >= LEAST_STOP_S * data.rate_hz
    ]
    found.sort(key=lambda ab: float(np.sum(data.f_x[ab[0] : ab[1]])))
    return sorted(found[:MOST_STOPS])


def _near_brakes(data: SlipData) -> BoolArray:
    """Rows within a second of the brakes."""
    on = (data.front_torque + data.rear_torque > 0.0) | data.braked
    reach = round(REST_S * data.rate_hz)
    return within(on, reach)


def _rolling_force(data: SlipData) -> FloatArray:
    """f_x below half a hertz, with straight lines across the stops: a filter would carry them into their neighbours."""
    near = _near_brakes(data)
    if near.all():
        return data.f_x
    rows = np.arange(len(data.f_x))
    bridged = np.interp(rows, rows[~near], data.f_x[~near])
    return lowpass(bridged, data.rate_hz, ROLLING_HZ)


def _gather(data: SlipData, stops: list[tuple[int, int]]) -> tuple[IntArray, IntArray]:
    """Rows of the stops and of free rolling, thinned to twice the band, and each row's stop."""
    every = max(1, round(data.rate_hz / (2 * data.band_hz)))
    number = np.full(len(data.speed), -1, dtype=np.int64)
    for i, (a, b) in enumerate(stops):
        number[a:b] = i
    rolling = data.rows & ~_near_brakes(data) & (data.speed > 6.0) & (np.abs(data.f_x) < 3.0)
    rows = np.flatnonzero((number >= 0) | rolling)
    rows = rows[rows % every == 0]
    if len(rows) > MOST_ROWS:
        keep = number[rows] >= 0
        free = np.flatnonzero(~keep)
        keep[free[:: max(1, math.ceil(len(free) / MOST_ROWS))]] = True
        rows = rows[keep]
    return rows, number[rows]


def _share_of_front(
    known: SlipKnown, height: float, f: FloatArray, v: FloatArray, front: float
) -> FloatArray:
    """F_zf / (m g), (41) with the wheels' spin."""
    spin = 4 * known.wheel_inertia / (known.radius_m * known.mass)
    air = 0.5 * AIR_DENSITY * known.drag_area * v**2 / known.mass
    moved = (height + spin) * f + height * air
    return np.asarray((GRAVITY * (known.wheelbase_m - front) - moved) / (GRAVITY * known.wheelbase_m))


def _weight(x: FloatArray, rows: _Rows, known: SlipKnown) -> tuple[FloatArray, FloatArray]:
    """Specific force without its errors, and the front axle's share of the load, (n,) each."""
    f = (rows.f - x[3]) / (1 + x[4])
    return f, np.clip(_share_of_front(known, x[0], f, rows.v, x[1]), 0.05, 0.95)


def _slips(x: FloatArray, rows: _Rows, known: SlipKnown) -> tuple[FloatArray, FloatArray]:
    """λ of the front and of the rear axle, (n,) each, braking positive. x: as in `_unknowns`."""
    share, bend, load, drive = x[2], x[5], x[6], x[7]
    f, weight = _weight(x, rows, known)
    air = 0.5 * AIR_DENSITY * known.drag_area * rows.v**2 / known.mass
    spin = 2 * known.wheel_inertia / (known.radius_m**2 * known.mass)
    per = 1 / (known.mass * known.radius_m)
    half = math.exp(0.5 * share)
    pulled = np.where(rows.stop >= 0, x[12] - per * rows.engine, -f - air - 2 * spin * f)
    ahead = per * rows.front_torque * half + drive * pulled + spin * f
    behind = per * rows.rear_torque / half + (1 - drive) * pulled + spin * f
    level = np.append(x[13:-1], 0.0)[rows.stop] + x[11]
    found = []
    for force, part in ((ahead, weight), (behind, 1 - weight)):
        mu = force / (GRAVITY * part)
        # the first terms of the brush's slip over its force, for b = 1 / (3 µ_max)
        bent = 1 + bend * np.abs(mu) + 5 / 3 * (bend * mu) ** 2
        found.append(mu * np.exp(-level) * bent * (1 + load * (2 * part - 1)))
    return found[0], found[1]


def _unknowns(known: SlipKnown, stops: int, height_m: float) -> tuple[Unknown, ...]:
    return (
        Unknown("height", height_m, math.inf, 1e-4),
        Unknown("front_m", known.front_m[0], known.front_m[1], 1e-4),
        Unknown("share_log", 0.0, known.share_log, 1e-4),
        Unknown("offset", 0.0, known.offset, 1e-4),
        Unknown("gain", 0.0, known.gain, 1e-5),
        Unknown("bend", known.bend[0], known.bend[1], 1e-4),
        Unknown("load", known.load[0], known.load[1], 1e-4),
        Unknown("drive_front", known.drive_front[0], known.drive_front[1], 1e-3),
        Unknown("radius_front", 0.0, known.radius, 1e-5),
        Unknown("radius_rear", 0.0, known.radius, 1e-5),
        Unknown("squash", known.squash[0], known.squash[1], 1e-4),
        Unknown("log_stiffness", math.log(18.0), math.inf, 1e-4),
        Unknown("engine_drag", 0.0, known.engine_drag, 1e-4),
        *(Unknown(f"stop_{i}", 0.0, known.same_tyres, 1e-4) for i in range(stops)),
        Unknown("delay", 0.0, known.delay, 1e-5),
    )


def _wheels(x: FloatArray, rows: _Rows, known: SlipKnown) -> tuple[FloatArray, FloatArray]:
    """Wheel speeds of both axles, (n,) each. The last of x is the delay."""
    front, rear = _slips(x, rows, known)
    v = rows.v + x[-1] * rows.f
    weight = _weight(x, rows, known)[1]
    static = 1 - x[1] / known.wheelbase_m
    # half the axle's change of load on each tyre, over its rate, over the radius
    sunk = x[10] * (weight - static) * known.mass * GRAVITY / (2 * known.tyre_rate * known.radius_m)
    return (1 + x[8] + sunk) * v * (1 - front), (1 + x[9] - sunk) * v * (1 - rear)


def _paired(front: FloatArray, rear: FloatArray) -> FloatArray:
    """(2 n,): mean and difference of the axles: the speed's error is in the mean alone, so that they do not mix."""
    return np.concatenate((0.5 * (front + rear), front - rear))


Inspect = Callable[[FloatArray, FloatArray, tuple[Unknown, ...]], None]


def _lever(fit: LeastFit, known: SlipKnown, strongest: float) -> float:
    """How far the height goes with the logarithm of the slips' quotient, in m: φ (1 - φ) L g / |a_x|."""
    share = (
        1
        - fit.value("front_m") / known.wheelbase_m
        + fit.value("height") * strongest / (GRAVITY * known.wheelbase_m)
    )
    share = min(max(share, 0.2), 0.8)
    return share * (1 - share) * known.wheelbase_m * GRAVITY / max(strongest, 0.5)


def fit_slip(
    data: SlipData, known: SlipKnown, height_m: float, inspect: Inspect | None = None
) -> SlipFit | None:
    """Fit the height with everything else; None without a stop or without rows that roll freely.

    height_m: where the height starts; it has no prior here. inspect: called with the final parameters (k,), the model's
    derivatives (k, 2 rows) (mean of the axles, then their difference) and the unknowns.
    """
    stops = _stops(data)
    rows, number = _gather(data, stops)
    if not stops or (number < 0).sum() < 5:
        return None
    force = np.where(number >= 0, data.f_x[rows], _rolling_force(data)[rows])
    engine = np.zeros(len(data.speed)) if data.drive_torque is None else data.drive_torque
    gathered = _Rows(
        data.speed[rows], force, data.front_torque[rows], data.rear_torque[rows], engine[rows], number,
        np.stack([data.front[rows], data.rear[rows]], axis=1),
    )  # fmt: skip
    unknowns = _unknowns(known, len(stops), height_m)
    block = blocks_of(rows, data.rate_hz, 0.4, 8.0)
    samples = Samples(
        _paired(gathered.seen[:, 0], gathered.seen[:, 1]),
        np.repeat(np.arange(2), len(rows)),
        np.concatenate((block, block)),
        np.array([0.03, 0.03]),
        np.array([1e-3, 1e-3]),
    )
    fit = fit_least(lambda x: _paired(*_wheels(x, gathered, known)), samples, unknowns)
    if inspect is not None:
        steps = np.array([u.step for u in unknowns])
        inspect(
            fit.values,
            jacobian(lambda x: _paired(*_wheels(x, gathered, known)), fit.values, steps)[1],
            unknowns,
        )
    predicted = np.stack(_wheels(fit.values, gathered, known), axis=1)
    # a slope that nothing holds may have run off: it is drawn, and no number follows from it
    slopes = np.exp(np.clip(fit.values[11] + fit.values[13:-1], -50.0, 50.0))
    strongest = float(-min(data.f_x[a:b].min() for a, b in stops))
    height = fit.value("height")
    std = math.hypot(fit.std("height"), known.ratio_error * _lever(fit, known, strongest))
    return SlipFit(height, std, fit, rows, len(stops), strongest, predicted, slopes)
