"""The parameters of the roll fit, what is known of them beforehand, and the innovations that they give."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pipelines.estimators.roll_map.data import RollData
from pipelines.filters.kalman import innovations
from pipelines.models.roll import (
    GRAVITY,
    RollCoefficients,
    discretise,
    dry_friction,
    process_noise,
    ramp_response,
)
from pipelines.results import FloatArray

BANK_TIME_S = 8.0
"""Correlation time of what moves the measured angle without the springs: bank, drift of the angle's sensor."""

CLIP = 4.0
"""Innovations beyond this many standard deviations count as outliers (Huber)."""

FRICTION = (0.0, 0.1)
"""m/s² of lateral acceleration that the suspension's dry friction holds: 20-70 N a wheel (dampers' seals, bushings,
ball joints), times the track of both axles, over m h of a car."""

SLIP = 0.002
"""rad of roll (1.5 mm at a wheel) after which friction has turned round."""


@dataclass(frozen=True)
class Known:
    """One parameter of the fit: its prior, the step for differences, and its bounds."""

    name: str
    mean: float
    std: float
    step: float
    low: float
    high: float


USUAL_ROLL = RollCoefficients(90.0, 7.0, 0.8)
"""A car's roll motion, for the spectrum of what the road and noise make of it."""

NOISES = ("log_roll_noise", "log_rate_noise", "log_push", "log_bank", "log_input_noise")


ONE_UNIT_S = 0.01
"""s by which roll rate and lateral acceleration of one unit may differ (filters of its own, the sensors' place)."""


def _usual_delay(data: RollData, std_s: float) -> tuple[float, float]:
    """Prior of the first channel's delay against the acceleration.

    A delay τ looks like damping, a τ: 30 ms take half of b. Roll rate and acceleration that were sampled together come
    from one unit, as a rule, and the angle's lag behind the rate can be seen: so its delay is known as well.
    """
    if not data.rate_with_accel or not data.has_rate:
        return 0.0, std_s
    if not data.has_roll:
        return 0.0, ONE_UNIT_S
    # a lag of exactly zero was not found; deflections lag behind the body's rate by what the tyres do
    return (
        (0.0, std_s) if data.rate_shift_s == 0.0 or data.against_axles else (-data.rate_shift_s, ONE_UNIT_S)
    )


def known_parameters(
    data: RollData,
    rate_offset: tuple[float, float] | None,
    max_delay_s: float,
    delay_std_s: float,
    lever: tuple[float, float] | None,
) -> tuple[Known, ...]:
    """The parameters that this drive's channels call for, in a fixed order.

    The priors of a, b, c are those of any road vehicle (2.5 to 16 deg/g); they are taken out again before the
    vehicle's own priors come in. rate_offset: from standstill, with its error. lever: accelerometer ahead of the CG in
    m, with its error (it reads lever times the yaw acceleration on top); None where its place is not known: the delay
    then takes up what it does, and a lever left free besides would take up the tyres' motion too.
    """
    found = [
        Known("a", 110.0, 80.0, 0.05, 10.0, 1000.0),
        Known("b", 6.0, 6.0, 0.02, 0.3, 200.0),
        Known("c", 0.8, 0.6, 0.003, 0.1, 8.0),
        Known("delay", *_usual_delay(data, delay_std_s), 2e-4, -max_delay_s, max_delay_s),
        Known("stiffening", 0.0, 3.0, 0.02, -12.0, 40.0),
        Known("friction", *FRICTION, 0.005, 0.0, 1.0),
    ]
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
            Known("rate_lag", data.rate_shift_s, 0.01, 2e-4, data.rate_shift_s - 0.1, data.rate_shift_s + 0.1)
        )
        if data.against_axles:
            found.append(Known("rate_gain", 1.2, 0.15, 1e-3, 0.5, 3.0))
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
    return tuple(found)


def _steady_angle(
    data: RollData, accel: FloatArray, steady: float, phi: FloatArray, before: FloatArray, after: FloatArray
) -> FloatArray:
    """(n,) the angle that the linear model makes of an acceleration."""
    later = np.append(accel[1:], accel[-1])
    later[data.stops - 1] = accel[data.stops - 1]
    push = np.outer(accel, before) + np.outer(later, after)
    x0 = np.zeros((len(data.starts), 2))
    x0[:, 0] = accel[data.starts] / steady
    nothing = np.zeros((data.size, 1))
    angle, _ = innovations(
        nothing, push, nothing, (data.starts, data.stops), phi=phi, q=np.zeros((2, 2)),
        c=np.array([[-1.0, 0.0]]), r=np.ones(1), x0=x0, p0=np.zeros((2, 2)),
    )  # fmt: skip
    return np.nan_to_num(angle[:, 0])


def _without_curves(
    data: RollData,
    p: Mapping[str, float],
    accel: FloatArray,
    steady: float,
    phi: FloatArray,
    before: FloatArray,
    after: FloatArray,
) -> FloatArray:
    """The acceleration less what curved springs, K φ (1 + s φ²), and dry friction hold of it, to the first order.

    Springs that are 3 % stiffer at 0.1 rad would otherwise move a, and with it the height, by as much. Friction of
    0.1 m/s² left out moved b and c by 20-40 % in a sine with dwell: what turns round with the rate looks like damping
    that shrinks with the amplitude, and a delay takes up the rest.
    """
    inside = _steady_angle(data, accel, steady, phi, before, after)
    held = p["a"] * p["stiffening"] * inside**3
    return np.asarray(accel - held - p["friction"] * dry_friction(inside, data.starts, data.stops, SLIP))


def _input(data: RollData, p: Mapping[str, float]) -> tuple[RollCoefficients, FloatArray]:
    """The linear model and its input (n,): see `simulated`."""
    gravity = GRAVITY if data.holds_course else 0.0
    accel = data.shifter.delayed(p["delay"])
    if data.yaw_shifter is not None and "lever" in p:
        accel = accel - p["lever"] * data.yaw_shifter.slope(p["delay"])
    if data.holds_course:
        accel = accel - gravity * data.whole_roll
    return RollCoefficients(p["a"] - gravity, p["b"], p["c"]), accel


def friction_damping(data: RollData, p: Mapping[str, float]) -> float:
    """Linear damping, in units of b, that takes as much energy from the simulated motion as friction of 1 m/s²."""
    roll, accel = _input(data, p)
    angle = _steady_angle(data, accel, roll.a, *discretise(roll, data.step_s))
    way = np.diff(angle)
    way[data.stops[:-1] - 1] = 0.0
    held = dry_friction(angle, data.starts, data.stops, SLIP)
    power = float(np.sum(way * way)) / data.step_s
    return float(np.sum(held[1:] * way)) / max(power, 1e-12)


def simulated(data: RollData, p: Mapping[str, float]) -> FloatArray:
    """(n, m) measurement minus the motion that the model makes of the acceleration alone.

    A vehicle that holds its course on a banked road reads g times the bank: the accelerometer is not independent of
    what moves the angle without the springs, and slopes come out too large (the gradient by 24 % in slow circles on
    roads with 0.1-0.8 deg of bank). The path's acceleration f - g φ is independent of it: with an angle against the
    horizon, c φ'' + b φ' + (a - g) φ = f - g φ is simulated, the same equation with that input.
    """
    roll, accel = _input(data, p)
    phi, before, after = discretise(roll, data.step_s)
    accel = _without_curves(data, p, accel, roll.a, phi, before, after)
    later = np.append(accel[1:], accel[-1])
    later[data.stops - 1] = accel[data.stops - 1]
    earlier = np.insert(accel[:-1], 0, accel[0])
    earlier[data.starts] = accel[data.starts]
    y: list[FloatArray] = []
    feed: list[FloatArray] = []
    rows: list[FloatArray] = []
    if data.has_roll:
        y.append(data.roll)
        feed.append(np.full(data.size, p["roll_offset"]))
        rows.append(np.array([1.0, 0.0]))
    if data.has_rate:
        # the rate comes `rate_lag` after the angle: the model's rate is read that much earlier, exactly
        late = p["rate_lag"] - data.rate_shift_s if "rate_lag" in p else 0.0
        gain = p.get("rate_gain", 1.0)
        moved, level, ramp = ramp_response(roll, -late)
        slope = (accel - earlier if late >= 0 else later - accel) / data.step_s
        y.append(data.rate)
        offset = p["rate_offset"] + p.get("yaw_leak", 0.0) * data.yaw
        feed.append(offset + gain * (level[1] * accel + ramp[1] * slope))
        rows.append(gain * moved[1])
    x0 = np.zeros((len(data.starts), 2))
    x0[:, 0] = accel[data.starts] / roll.a
    error, _ = innovations(
        np.column_stack(y),
        np.outer(accel, before) + np.outer(later, after),
        np.column_stack(feed),
        (data.starts, data.stops),
        phi=phi,
        q=np.zeros((2, 2)),
        c=np.array(rows),
        r=np.ones(len(rows)),
        x0=x0,
        p0=np.zeros((2, 2)),
    )
    return error


def whitened(
    data: RollData, p: Mapping[str, float], miss: FloatArray, *, clip: float = CLIP
) -> tuple[FloatArray, FloatArray]:
    """Innovations and variances (n, m) of what a simulation leaves over.

    That is noise of the sensors, bank, the accelerometer's noise as the simulation takes it for motion, and roll motion that the
    road makes. The last one's spectrum is taken to be a usual car's, not that of the parameters: else the colour of the noise, and
    not the answer to the acceleration, would decide on b and c (in a slow slalom on a banked road c came out three times too large).
    """
    taken, starts, stops = data.taken
    step = data.step_s * data.every
    fade = math.exp(-step / BANK_TIME_S)
    bank = math.exp(2 * p["log_bank"]) if "log_bank" in p else 0.0
    own = _input(data, p)[0]
    phi = np.zeros((5, 5))
    phi[:2, :2] = discretise(USUAL_ROLL, step)[0]
    phi[2:4, 2:4] = discretise(own, step)[0]
    phi[4, 4] = fade
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
        gain = p.get("rate_gain", 1.0)
        rows.append([0.0, gain, 0.0, gain, 0.0])
        noise.append(math.exp(2 * p["log_rate_noise"]))
    here = miss[taken]
    error, variance = innovations(
        here,
        np.zeros((len(taken), 5)),
        np.zeros_like(here),
        (starts, stops),
        phi=phi,
        q=q,
        c=np.array(rows),
        r=np.array(noise),
        x0=np.zeros((len(data.starts), 5)),
        p0=np.diag([1e-8, 1e-8, 0.03**2, 0.2**2, max(bank, 1e-12)]),
        clip=clip,
    )
    everywhere = np.full((2, *miss.shape), np.nan)
    everywhere[:, taken] = error, variance
    return everywhere[0], everywhere[1]


def run(data: RollData, p: Mapping[str, float]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Innovations and variances (n, m), and measurement minus simulation (n, m); angle before rate."""
    miss = simulated(data, p)
    return (*whitened(data, p, miss), miss)
