"""The parameters of the roll fit, what is known of them beforehand, and the innovations that they give."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.motion import rate_gain, simulated
from pipelines.filters.kalman import innovations
from pipelines.models.roll import GRAVITY, RollCoefficients, discretise, process_noise
from pipelines.results import FloatArray

BANK_TIME_S = 8.0
"""Correlation time of what moves the measured angle without the springs: bank, drift of the angle's sensor."""

CLIP = 4.0
"""Innovations beyond this many standard deviations count as outliers (Huber)."""

FRICTION = (0.0, 0.1)
"""m/s² of lateral acceleration that the suspension's dry friction holds: 20-70 N a wheel (dampers' seals, bushings,
ball joints), times the track of both axles, over m h of a car."""


@dataclass(frozen=True)
class Known:
    """One parameter of the fit: its prior, the step for differences, and its bounds."""

    name: str
    mean: float
    std: float
    step: float
    low: float
    high: float


OPTIONS: dict[str, Known] = {
    "stiffening": Known("stiffening", 0.0, 3.0, 0.02, -12.0, 40.0),
    "friction": Known("friction", *FRICTION, 0.005, 0.0, 1.0),
    "knee": Known("knee", 0.35, 0.3, 0.01, -0.5, 0.9),
    "series": Known("series", 0.17, 0.04, 0.002, 0.01, 0.6),
    "smoothing": Known("smoothing", 0.0, 1e-3, 2e-5, -1e-3, 8e-3),
}
"""Parts of the model that are there or not, each with one parameter and its prior.

stiffening: s of K φ (1 + s φ²), 3 % at 0.1 rad. friction: see FRICTION. knee: what the dampers' slope loses beyond KNEE_RATE (two
slopes 1 : 0.35-0.75, progressive ones too). series: tyres' share of the roll, road stiffness 0.83 ± 0.04 of the suspension's. smoothing:
variance in s² of the angle's filter beyond the acceleration's (a first-order lag of 30 ms: 0.0009; a mean over 0.1 s: 0.0008;
an accelerometer behind a 5 Hz low-pass: -0.001, no less).
"""

WEAK_PRIOR = {"a": (110.0, 80.0), "b": (6.0, 6.0), "c": (0.8, 0.6), "rate_gain": (1.2, 0.15)}
"""Of any road vehicle (2.5 to 16 deg/g): mean and spread."""

STANDARD = frozenset(("stiffening", "friction"))
"""What every suspension has."""

SHARE_TOLD = 0.12

USUAL_ROLL = RollCoefficients(90.0, 7.0, 0.8)
"""A car's roll motion, for the spectrum of what the road and noise make of it."""

NOISES = ("log_roll_noise", "log_rate_noise", "log_push", "log_bank", "log_input_noise")


ONE_UNIT_S = 0.01
"""s by which roll rate and lateral acceleration of one unit may differ (filters of its own, the sensors' place)."""


TYRE_LEAD_S = 0.011
"""s by which tyres let the body's rate lead that of its deflections: b/(k (1 + κ)) of a car, 0.007-0.015."""


def _usual_delay(data: RollData, std_s: float, rate_lag_s: float, *, tyres: bool) -> tuple[float, float]:
    """Prior of the first channel's delay against the acceleration.

    A delay τ looks like damping, a τ: 30 ms take half of b. Roll rate and acceleration that were sampled together come
    from one unit, as a rule, and the angle's lag behind the rate can be seen: so its delay is known as well. tyres: they
    are a part of the model; else deflections lag behind the body's rate by what tyres do, and nothing is known.
    """
    if not data.rate_with_accel or not data.has_rate:
        return 0.0, std_s
    if not data.has_roll:
        return 0.0, ONE_UNIT_S
    # a lag of exactly zero was not found
    found = data.rate_shift_s != 0.0 and (tyres or not data.against_axles)
    return (-rate_lag_s, ONE_UNIT_S) if found else (0.0, std_s)


def _noise_levels(data: RollData) -> list[Known]:
    """Logarithms of the noises' levels, in the order of the sensors, the input, the road's push and the bank."""
    found: list[Known] = []
    if data.has_roll:
        found.append(Known("log_roll_noise", math.log(0.003), 2.0, 0.01, math.log(1e-6), math.log(0.3)))
    if data.has_rate:
        found.append(Known("log_rate_noise", math.log(0.01), 2.0, 0.01, math.log(1e-5), math.log(1.0)))
    found.append(
        Known(
            "log_input_noise",
            0.5 * math.log(max(data.input_noise, 1e-8)),
            0.05,
            0.01,
            math.log(1e-5),
            math.log(1.0),
        )
    )
    found.append(Known("log_push", math.log(0.1), 2.0, 0.01, math.log(1e-4), math.log(20.0)))
    if data.has_roll:
        found.append(Known("log_bank", math.log(0.003), 1.5, 0.01, math.log(1e-5), math.log(0.3)))
    return found


def known_parameters(
    data: RollData,
    rate_offset: tuple[float, float] | None,
    max_delay_s: float,
    delay_std_s: float,
    lever: tuple[float, float] | None,
    options: frozenset[str] = STANDARD,
) -> tuple[Known, ...]:
    """The parameters that this drive's channels and the chosen parts of the model call for, in a fixed order.

    The priors of a, b, c are those of any road vehicle (2.5 to 16 deg/g); they are taken out again before the
    vehicle's own priors come in. rate_offset: from standstill, with its error. lever: accelerometer ahead of the CG in
    m, with its error (it reads lever times the yaw acceleration on top); None where its place is not known: the delay
    then takes up what it does, and a lever left free besides would take up the tyres' motion too.
    """
    tyres = "series" in options
    # what the coarse search found holds the tyres' part; a lag of exactly zero was not found
    lead = TYRE_LEAD_S if tyres and data.against_axles and data.rate_shift_s != 0.0 else 0.0
    rate_lag = data.rate_shift_s + lead
    delay, unsure = _usual_delay(data, delay_std_s, rate_lag, tyres=tyres)
    found = [
        Known("a", *WEAK_PRIOR["a"], 0.05, 10.0, 1000.0),
        Known("b", *WEAK_PRIOR["b"], 0.02, 0.3, 200.0),
        Known("c", *WEAK_PRIOR["c"], 0.003, 0.1, 8.0),
        Known("delay", delay, unsure, 2e-4, delay - max_delay_s, delay + max_delay_s),
    ]
    found += [OPTIONS[name] for name in ("stiffening", "friction", "knee") if name in options]
    if "series" in options:
        # a gyro beside deflections tells the tyres' share; else it is what is known of cars
        told = data.against_axles and data.has_rate
        found.append(replace(OPTIONS["series"], std=SHARE_TOLD) if told else OPTIONS["series"])
    if "smoothing" in options and data.has_roll:
        found.append(OPTIONS["smoothing"])
    if data.has_yaw and lever is not None:
        found.append(Known("lever", *lever, 2e-3, -6.0, 6.0))
    if data.has_roll:
        found.append(Known("roll_offset", 0.0, 0.1, 1e-4, -1.5, 1.5))
    if data.has_rate:
        mean, std = (0.0, 0.03) if rate_offset is None else rate_offset
        found.append(Known("rate_offset", mean, std, 1e-4, -0.5, 0.5))
        if data.has_yaw:
            found.append(Known("yaw_leak", 0.0, 0.03, 1e-4, -0.3, 0.3))
    if data.has_roll and data.has_rate:
        found.append(
            Known("rate_lag", rate_lag, 0.01, 2e-4, data.rate_shift_s - 0.1, data.rate_shift_s + 0.1)
        )
        if data.against_axles and "series" not in options:
            found.append(Known("rate_gain", *WEAK_PRIOR["rate_gain"], 1e-3, 0.5, 3.0))
    return (*found, *_noise_levels(data))


@dataclass(frozen=True)
class Whitener:
    """The filter that turns what simulations of some data leave over into innovations, at one set of noises; see `whitener`."""

    data: RollData
    phi: FloatArray
    q: FloatArray
    c: FloatArray
    r: FloatArray
    p0: FloatArray

    def __call__(self, miss: FloatArray, *, clip: float = CLIP) -> tuple[FloatArray, FloatArray]:
        """Innovations, as large as `miss` ((n, m), or (k, n, m): k simulations of one log, in one pass), and variances (n, m)."""
        taken, starts, stops = self.data.taken
        segments = len(starts)
        error, variance = innovations(
            miss[..., taken, :],
            None,
            None,
            (starts, stops),
            phi=self.phi,
            q=self.q,
            c=self.c,
            r=self.r,
            x0=np.zeros((segments, len(self.phi))),
            p0=self.p0,
            clip=clip,
        )
        if len(taken) == miss.shape[-2]:
            return error, variance
        errors, variances = np.full(miss.shape, np.nan), np.full(miss.shape[-2:], np.nan)
        errors[..., taken, :], variances[taken] = error, variance
        return errors, variances


@lru_cache(maxsize=64)
def _transition(roll: RollCoefficients, step: float) -> FloatArray:
    """(2, 2) of a row's step. Kept: while levels are sought the motion stands, and the usual car's is one for a whole drive."""
    found = discretise(roll, step)[0]
    found.setflags(write=False)
    return found


def whitener(data: RollData, p: Mapping[str, float]) -> Whitener:
    """The filter for the noises and the motion of `p`.

    What a simulation leaves over is noise of the sensors, bank, the accelerometer's noise as the simulation takes it for motion, and
    roll motion that the road makes. The last one's spectrum is taken to be a usual car's, not that of the parameters: else the colour of the noise, and
    not the answer to the acceleration, would decide on b and c (in a slow slalom on a banked road c came out three times too large).
    """
    step = data.step_s * data.every
    fade = math.exp(-step / BANK_TIME_S)
    bank = math.exp(2 * p["log_bank"]) if "log_bank" in p else 0.0
    own = RollCoefficients(p["a"] - (GRAVITY if data.holds_course else 0.0), p["b"], p["c"])
    phi = np.zeros((5, 5))
    phi[:2, :2], phi[2:4, 2:4], phi[4, 4] = _transition(USUAL_ROLL, step), _transition(own, step), fade
    q = np.zeros((5, 5))
    q[:2, :2] = process_noise(USUAL_ROLL, math.exp(2 * p["log_push"]), step)
    q[2:4, 2:4] = process_noise(own, math.exp(2 * p["log_input_noise"]), step)
    q[4, 4] = bank * (1 - fade * fade)
    rows: list[list[float]] = []
    noise: list[float] = []
    if data.has_roll:
        rows.append([1.0, 0.0, 1.0, 0.0, 1.0])
        noise.append(math.exp(2 * p["log_roll_noise"]))
    if data.has_rate:
        gain = rate_gain(data, p)
        rows.append([0.0, gain, 0.0, gain, 0.0])
        noise.append(math.exp(2 * p["log_rate_noise"]))
    p0 = np.diag([1e-8, 1e-8, 0.03**2, 0.2**2, max(bank, 1e-12)])
    return Whitener(data, phi, q, np.array(rows), np.array(noise), p0)


def whitened(
    data: RollData, p: Mapping[str, float], miss: FloatArray, *, clip: float = CLIP
) -> tuple[FloatArray, FloatArray]:
    """Innovations and variances (n, m) of what a simulation leaves over, by the `whitener` of `p`."""
    return whitener(data, p)(miss, clip=clip)


def run(data: RollData, p: Mapping[str, float]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Innovations and variances (n, m), and measurement minus simulation (n, m); angle before rate."""
    miss = simulated(data, p)
    return (*whitened(data, p, miss), miss)
