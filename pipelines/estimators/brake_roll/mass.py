"""Mass from the longitudinal balance: what brakes, engine and air give, over what the accelerometer reads.

    m f_x + 4 I_w / R² v' = κ_d T_d / R - κ_b(v) T_b / R - ρ C_d A v² / 2 - m g c_r

with f_x the specific force in the road plane: it holds gravity's part, so that the grade drops out of all but the wheels, which a
grade at a steady speed does not spin up. The balance tells the mass as well as the torques are known: a common error of all torques is an error of the mass (Park & Choi's
braking equations, divided by m, do not hold it at all).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from parsers.channels import IntArray
from pipelines.estimators.brake_roll.least import LeastFit, Samples, Unknown, blocks_of, fit_least
from pipelines.models.braking import AIR_DENSITY
from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import BoolArray
from pipelines.results import FloatArray

BAND_HZ = 1.0
DRIVE_TORQUE_STD = 0.05
BRAKE_TORQUE_STD = 0.05
"""What a torque signal's scale is usually worth: both are models of the engine's and of the brakes' computer."""

ROLLING = (0.012, 0.004)
CORNERING = (0.012, 0.006)
"""Slip angle for a unit of lateral acceleration, rad per m/s²: what tyres drag in bends, per mass, over its square."""

FADE = 0.04
"""By how much the brakes' gain may change from standstill to the mean speed at which they are used (spread): pads grip less, or
more, where they are quick and hot. Without it a stop's force over its speed would pass for the air's."""

LET_GO_S, RELEASED_S = 1.0, 0.25
"""How long after the foot comes down on the brakes the engine may still pull, or hold, and before it leaves them that f_x, which is
smooth, holds what comes next."""

LEAST_FORCE = 0.5
"""m/s², RMS of what the torques give per nominal mass, from which there is something to see."""


@dataclass(frozen=True)
class MassKnown:
    """mass: nominal, where the fit starts. gain: relative standard deviation of the brake torque; drive: of the drive torque. pitch: relative
    standard deviation of what the body's lean adds to f_x. drag_area, rolling: mean and standard deviation."""

    mass: float
    radius_m: float
    radius_std: float
    wheel_inertia: float
    drag_area: tuple[float, float]
    gain: float
    drive: float = DRIVE_TORQUE_STD
    pitch: float = 0.02
    offset: float = 0.1
    rolling: tuple[float, float] = ROLLING


@dataclass(frozen=True)
class MassFit:
    """mass, std in kg. fit: all parameters. rows: (n,) fitted rows; predicted: (n,) specific force. braked, driven: which
    torques were there."""

    mass: float
    std: float
    fit: LeastFit
    rows: IntArray
    predicted: FloatArray
    braked: bool
    driven: bool


def _let_go(pressed: BoolArray, rate_hz: float) -> BoolArray:
    """(n,) rows with the foot on the brakes for LET_GO_S already, and for RELEASED_S more."""
    off = np.concatenate(([0], np.cumsum(~pressed)))
    rows = np.arange(len(pressed))
    first = np.maximum(rows - round(LET_GO_S * rate_hz), 0)
    last = np.minimum(rows + round(RELEASED_S * rate_hz) + 1, len(pressed))
    return np.asarray(off[last] == off[first])


def _chosen(
    use: BoolArray, brake: FloatArray | None, drive: FloatArray | None, rate_hz: float, known: MassKnown
) -> IntArray:
    """Rows of `use` in which every force is known, thinned to twice the band; none without any torque."""
    if drive is None:
        use = np.zeros_like(use) if brake is None else use & _let_go(~(brake <= 0.0), rate_hz)
    elif brake is None:
        # an unmeasured brake: only rows in which the drive pulls can be without it
        use = use & (drive > 0.02 * known.mass * known.radius_m)
    every = max(1, round(rate_hz / (2 * BAND_HZ)))
    chosen = np.flatnonzero(use)
    return np.asarray(chosen[chosen % every == 0])


def _unknowns(known: MassKnown) -> tuple[Unknown, ...]:
    """What is fitted, in the order in which the model takes it."""
    return (
        Unknown("mass", known.mass, math.inf, 0.1),
        Unknown("brakes", 0.0, known.gain, 1e-4),
        Unknown("engine", 0.0, known.drive, 1e-4),
        Unknown("drag_area", known.drag_area[0], known.drag_area[1], 1e-3),
        Unknown("rolling", known.rolling[0], known.rolling[1], 1e-5),
        Unknown("offset", 0.0, known.offset, 1e-4),
        Unknown("cornering", *CORNERING, 1e-5),
        Unknown("fade", 0.0, FADE, 1e-4),
    )


def fit_mass(
    f_x: FloatArray,
    speed: FloatArray,
    brake: FloatArray | None,
    drive: FloatArray | None,
    rows: BoolArray,
    rate_hz: float,
    known: MassKnown,
    side: FloatArray | None = None,
) -> MassFit | None:
    """Fit the mass; None where no torque is there or the torques hardly change.

    f_x: (n,) in the road plane, in m/s². brake, drive: torques of all wheels in N·m, None where they are not measured:
    without the drive torque only braked rows count. side: (n,) lateral specific force, m/s²: tyres that corner drag by its
    square (force times slip angle). rows: moving, straight enough, inside segments.
    """
    chosen = _chosen(rows & (speed > 2.0), brake, drive, rate_hz, known)
    if len(chosen) < 10:
        return None
    zero = np.zeros(len(chosen))
    braking = zero if brake is None else brake[chosen] / known.radius_m
    pulling = zero if drive is None else drive[chosen] / known.radius_m
    if float(np.sqrt(np.mean((pulling - braking) ** 2))) / known.mass < LEAST_FORCE:
        return None
    air = 0.5 * AIR_DENSITY * speed[chosen] ** 2
    spin = 4 * known.wheel_inertia / known.radius_m**2
    cornering = zero if side is None else side[chosen] ** 2
    spun = spin * np.gradient(speed)[chosen] * rate_hz
    usual = float(np.average(speed[chosen], weights=braking + 1e-9))
    quicker = speed[chosen] / usual - 1

    def model(x: FloatArray) -> FloatArray:
        mass, brakes, engine, area, rolling, offset, slip, fade = x
        force = (1 + engine) * pulling - (1 + brakes + fade * quicker) * braking - area * air
        force -= mass * (GRAVITY * rolling + slip * cornering)
        return np.asarray((force - spun) / mass + offset)

    samples = Samples(
        f_x[chosen], np.zeros(len(chosen), dtype=np.int64), blocks_of(chosen, rate_hz, 2.0, 10.0),
        np.array([0.1]), np.array([0.01]),
    )  # fmt: skip
    fit = fit_least(model, samples, _unknowns(known))
    mass = fit.value("mass")
    if not 0.2 * known.mass < mass < 5 * known.mass:
        return None
    shared = math.hypot(known.pitch, known.radius_std / known.radius_m)
    std = math.hypot(fit.std("mass"), shared * mass)
    braked = brake is not None and bool((braking > 0).any())
    return MassFit(mass, std, fit, chosen, model(fit.values), braked, drive is not None)
