"""Roll-angle observer with an adapted roll arm, its protection against drift, and the synthesis with a second estimate.

Park & Choi, equations (22), (31), (37), (38) and (40). In this file m is the mass estimate, h the adapted arm, f the
lateral specific force, p the roll rate; a hat is the observer's:

    I φ^'' = m f h - k φ^ - c φ^' + L (p - φ^')                 (22), the gain on the roll-rate error
    h'     = g m f / I ((p - φ^') + γ (φ - φ^))                 (31)
    φ      = ∫ p dt, restarted from (f - r v)/9.8 in a steady state   (37), (38)
    H'     = (1 - K) h' + K l (h_long - H)                      (40)

When K falls back to 0, h is set to H less the roll centre's height: left as it was, (40) would add what h still has to
move to a height that is already right, and H would run off.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.jit import kernel
from pipelines.models.roll import GRAVITY, exponential
from pipelines.prepare.prepared import BoolArray


@dataclass(frozen=True)
class AdaptationGains:
    """The vehicle and the gains. SI. centre_m: roll centre above ground, h0. steady_radps: the threshold of (38);
    steady_s: how long the rate has to stay below it: at the turn of a slalom it does for a moment, with v_y' at its most.

    observer: L in N·m·s/rad. adaptation: k_a. gamma: γ in 1/s. synthesis_radps: L_int in 1/s.
    """

    inertia_kgm2: float
    stiffness_nmprad: float
    damping_nmsprad: float
    centre_m: float
    observer: float = 12_000.0
    adaptation: float = 0.015
    gamma: float = 20.39
    steady_radps: float = 0.01
    steady_s: float = 0.2
    synthesis_radps: float = 10 * np.pi


@dataclass(frozen=True)
class Adapted:
    """All (n,). roll, rate: the observer's. angle: ∫ p dt after (38). arm: h^_lat; height: h^_int, above ground.

    error: (φ~' + γ φ~), the first component of x in (26).
    """

    roll: FloatArray
    rate: FloatArray
    angle: FloatArray
    arm: FloatArray
    height: FloatArray
    error: FloatArray


@kernel
def _run(
    signals: FloatArray,
    braking: BoolArray,
    active: BoolArray,
    starts: IntArray,
    stops: IntArray,
    model: FloatArray,
    numbers: tuple[float, float, float, float, float, float, float, int, bool],
    out: FloatArray,
) -> None:
    """signals (n, 5): f, p, r v, m, h_long. model (2, 4): the observer over one step. out (n, 6), as in Adapted."""
    step, inertia, centre, adaptation, gamma, steady, synthesis, steady_rows, reset = numbers
    arm = 0.0
    height = centre
    if len(starts):
        arm = out[starts[0], 3]
        height = out[starts[0], 4]
    blend = 1.0 - np.exp(-synthesis * step)
    for segment in range(len(starts)):
        first = starts[segment]
        angle = (signals[first, 0] - signals[first, 2]) / GRAVITY
        roll = angle
        rate = signals[first, 1]
        quiet = 0
        was_braking = False
        for k in range(first, stops[segment]):
            f, p, turning, m = signals[k, 0], signals[k, 1], signals[k, 2], signals[k, 3]
            quiet = quiet + 1 if abs(p) <= steady else 0
            if quiet >= steady_rows:
                angle = (f - turning) / GRAVITY
            error = (p - rate) + gamma * (angle - roll)
            slope = adaptation * m * f / inertia * error
            if not active[k]:
                slope = 0.0
            if was_braking and not braking[k] and reset:
                arm = height - centre
            if braking[k]:
                height += blend * (signals[k, 4] - height)
            else:
                height += step * slope
            was_braking = braking[k]
            out[k, 0] = roll
            out[k, 1] = rate
            out[k, 2] = angle
            out[k, 5] = error
            push = m * f * arm
            roll, rate = (
                model[0, 0] * roll + model[0, 1] * rate + model[0, 2] * push + model[0, 3] * p,
                model[1, 0] * roll + model[1, 1] * rate + model[1, 2] * push + model[1, 3] * p,
            )
            arm += step * slope
            angle += step * p
            out[k, 3] = arm
            out[k, 4] = height


def gamma_of(inertia: float, stiffness: float, damping: float, observer: float) -> float:
    """γ of (29) in 1/s. Raises ValueError where the observer's gain is too small for a real one."""
    total = damping + observer
    root = total**2 - 4 * inertia * stiffness
    if root < 0:
        raise ValueError(f"the observer's gain {observer:g} leaves (29) without a real solution")
    return float((total + np.sqrt(root)) / (2 * inertia))


def _observer(gains: AdaptationGains, step: float) -> FloatArray:
    """(2, 4): the observer (22) over one step, with its two inputs held: [Φ | moment | roll rate]."""
    block = np.zeros((4, 4))
    block[0, 1] = 1.0
    block[1, 0] = -gains.stiffness_nmprad / gains.inertia_kgm2
    block[1, 1] = -(gains.damping_nmsprad + gains.observer) / gains.inertia_kgm2
    block[1, 2] = 1.0 / gains.inertia_kgm2
    block[1, 3] = gains.observer / gains.inertia_kgm2
    return np.ascontiguousarray(exponential(block * step)[:2])


def adapt_roll(
    accel_y: FloatArray,
    roll_rate: FloatArray,
    turning: FloatArray,
    mass: FloatArray,
    height_long: FloatArray,
    braking: BoolArray,
    active: BoolArray,
    segments: tuple[IntArray, IntArray],
    gains: AdaptationGains,
    *,
    rate_hz: float,
    height_m: float,
    reset: bool = True,
) -> Adapted:
    """Run the observer. All arrays (n,), SI: accel_y is specific force, turning is yaw rate times speed.

    braking: K of (39); height_long counts only there. active: rows in which the arm is adapted. segments: first rows
    and rows past the last; the angle starts anew in each, the arm and the height go on. height_m: h^_int at the
    start. Raises ValueError where shapes do not fit.
    """
    rows = len(accel_y)
    columns = (accel_y, roll_rate, turning, mass, height_long)
    if any(c.shape != (rows,) for c in (*columns, braking, active)):
        raise ValueError("the filter's arrays do not fit together")
    starts, stops = segments
    if len(starts) and (starts.min() < 0 or stops.max() > rows):
        raise ValueError("a segment leaves the arrays")
    out = np.full((rows, 6), np.nan)
    if len(starts):
        out[starts[0], 3] = height_m - gains.centre_m
        out[starts[0], 4] = height_m
    numbers = (
        1 / rate_hz,
        gains.inertia_kgm2,
        gains.centre_m,
        gains.adaptation,
        gains.gamma,
        gains.steady_radps,
        gains.synthesis_radps,
        max(1, round(gains.steady_s * rate_hz)),
        reset,
    )
    signals = np.ascontiguousarray(np.stack(columns, axis=1))
    _run(signals, braking, active, starts, stops, _observer(gains, 1 / rate_hz), numbers, out)
    return Adapted(out[:, 0], out[:, 1], out[:, 2], out[:, 3], out[:, 4], out[:, 5])
