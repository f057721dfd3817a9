"""How near does the batch estimate come to what one manoeuvre allows? Berntorp's model with m and I_x given.

python benchmarks/roll_limit.py [runs] [--seed N]

The plant equals the model: (I_x + m h²) φ'' + D φ' + K φ = m h f, f = a_y cos φ + g sin φ as an accelerometer on the roll axis reads it, SUV
values, a sine with dwell of two seconds with half a second of quiet before and two after, at 100 Hz; noise 0.1 deg, 0.3 deg/s, 0.1 m/s².
Offsets of angle and rate are parameters. The estimate is `roll_map`'s first stage on the raw samples (whole band, no low-pass) with
every other nuisance parameter held at what the plant has, and K, D, h follow from a, b, c (`suspension_of`).

The bound: f is known by its noisy measurement only, so its true course is a nuisance. Taking it out of the Fisher information leaves
the slopes of the outputs by the true course, weighed by the covariance of the outputs' noise and of the input's noise as the motion
carries it. Offsets and the state at the start have the fit's priors, K, D and h none: it is a posterior bound in these alone.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1])]

from pipelines.estimators.roll_map.data import RollData  # noqa: E402
from pipelines.estimators.roll_map.fit import fit_roll  # noqa: E402
from pipelines.estimators.roll_map.model import Known  # noqa: E402
from pipelines.estimators.roll_map.spectrum import Shifter, motion_band  # noqa: E402
from pipelines.models.roll import (  # noqa: E402
    RollCoefficients,
    discretise,
    height_sensitivity,
    mirror_height,
    suspension_of,
)
from pipelines.results import FloatArray  # noqa: E402

MASS, INERTIA, HEIGHT, STIFFNESS, DAMPING = 1800.0, 500.0, 0.74, 65e3, 5.5e3
ANGLE, RATE, ACCEL = np.radians(0.1), np.radians(0.3), 0.1
STEP = 0.01
OFFSET_PRIOR = {"roll_offset": 0.1, "rate_offset": 0.03}
TRUTH = RollCoefficients(
    STIFFNESS / (MASS * HEIGHT), DAMPING / (MASS * HEIGHT), INERTIA / (MASS * HEIGHT) + HEIGHT
)


def sine_with_dwell(peak: float = 6.0) -> FloatArray:
    """(n,) lateral acceleration: a sine of 0.7 Hz with half a second's dwell at its second peak, and quiet around it."""
    t = np.arange(-0.5, 4.0, STEP)
    first, dwell = 0.75 / 0.7, 0.75 / 0.7 + 0.5
    push = np.sin(2 * np.pi * 0.7 * t) * ((t > 0) & (t < first))
    push -= 1.0 * ((t >= first) & (t < dwell))
    push += np.sin(2 * np.pi * 0.7 * (t - 0.5)) * ((t >= dwell) & (t < 1 / 0.7 + 0.5))
    return peak * np.asarray(push)


def motion(roll: RollCoefficients, push: FloatArray) -> FloatArray:
    """(n, 2) angle and rate by exact steps under straight lines."""
    phi, before, after = discretise(roll, STEP)
    out = np.zeros((len(push), 2))
    for k in range(len(push) - 1):
        out[k + 1] = phi @ out[k] + before * push[k] + after * push[k + 1]
    return out


def bound(push: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least standard deviations of (a, b, c) and of (K, D, h)."""
    n = len(push)
    carried = np.zeros((2 * n, n))
    answer = motion(TRUTH, np.eye(1, n + 1, 1)[0])[1:]
    for k in range(n):
        carried[k:n, k], carried[n + k :, k] = answer[: n - k].T
    noise = np.diag(np.repeat([ANGLE**2, RATE**2], n)) + ACCEL**2 * carried @ carried.T
    slopes = np.zeros((7, 2 * n))
    for row, (name, step) in enumerate((("a", 0.01), ("b", 0.005), ("c", 0.001))):
        ends = [
            motion(RollCoefficients(**(vars(TRUTH) | {name: getattr(TRUTH, name) + side * step})), push)
            for side in (1, -1)
        ]
        slopes[row] = ((ends[0] - ends[1]) / (2 * step)).T.ravel()
    slopes[3, :n] = slopes[4, n:] = 1.0
    phi = discretise(TRUTH, STEP)[0]
    free = np.eye(2)
    for k in range(n):
        slopes[5:, k], slopes[5:, n + k] = free[0], free[1]
        free = phi @ free
    information = slopes @ np.linalg.solve(noise, slopes.T)
    information += np.diag(
        [0.0, 0.0, 0.0, *(1 / std**2 for std in OFFSET_PRIOR.values()), 1 / 0.03**2, 1 / 0.2**2]
    )
    covariance = np.linalg.inv(information)[:3, :3]
    jacobian = np.zeros((3, 3))
    for column, step in enumerate((0.01, 0.005, 0.001)):
        ends_at = [
            np.array(suspension_of(RollCoefficients(*(np.array([TRUTH.a, TRUTH.b, TRUTH.c]) + side * step * np.eye(3)[column])), MASS, INERTIA))
            for side in (1, -1)
        ]  # fmt: skip
        jacobian[:, column] = (ends_at[0] - ends_at[1]) / (2 * step)
    return np.sqrt(np.diag(covariance)), np.sqrt(np.diag(jacobian @ covariance @ jacobian.T))


def recorded(push: FloatArray, rng: np.random.Generator) -> RollData:
    """What the sensors read, as the first stage takes it: raw samples, one stretch, offsets of 0.5 deg and 0.4 deg/s."""
    n = len(push)
    clean = motion(TRUTH, push)
    accel = push + ACCEL * rng.standard_normal(n)
    roll = clean[:, 0] + np.radians(0.5) + ANGLE * rng.standard_normal(n)
    rate = clean[:, 1] + np.radians(0.4) + RATE * rng.standard_normal(n)
    starts, stops = np.array([0]), np.array([n])
    shifter = Shifter(accel, starts, stops, 1 / STEP)
    band = motion_band(accel, [(0, n)], 1 / STEP)
    return RollData(
        step_s=STEP, rows=np.arange(n), starts=starts, stops=stops, accel=accel, roll=roll, rate=rate, whole_roll=roll,
        whole_rate=rate, yaw=np.zeros(n), shifter=shifter, clean_shifter=Shifter(accel, starts, stops, 1 / STEP, band=band), band=band, yaw_shifter=None,
        against_axles=True, has_roll=True, has_rate=True, has_yaw=False, rate_shift_s=0.0, band_hz=0.5 / STEP, top_hz=0.5 / STEP,
        every=1, slow_share=0.0, input_noise=ACCEL**2 * STEP, drive_rows=n, rate_with_accel=True,
    )  # fmt: skip


def parameters() -> tuple[Known, ...]:
    """a, b, c and the offsets free; delays, friction and curves held at nothing; the noises' levels free but the input's, whose floor is seen."""
    held = 1e-9

    def at(name: str, value: float, std: float, step: float, low: float, high: float) -> Known:
        return Known(name, value, std, step, low, high)

    return (
        at("a", 60.0, 1e3, 0.02, 10.0, 1000.0),
        at("b", 5.0, 1e3, 0.01, 0.3, 200.0),
        at("c", 1.0, 1e2, 0.002, 0.1, 8.0),
        at("delay", 0.0, held, 1e-4, -0.2, 0.2),
        at("stiffening", 0.0, held, 0.01, -10.0, 10.0),
        at("friction", 0.0, held, 0.001, 0.0, 1.0),
        at("roll_offset", 0.0, OFFSET_PRIOR["roll_offset"], 1e-4, -1.0, 1.0),
        at("rate_offset", 0.0, OFFSET_PRIOR["rate_offset"], 1e-4, -1.0, 1.0),
        at("log_roll_noise", float(np.log(ANGLE)), 1.0, 0.01, -14.0, -1.0),
        at("log_rate_noise", float(np.log(RATE)), 1.0, 0.01, -14.0, 0.0),
        at("log_input_noise", float(0.5 * np.log(ACCEL**2 * STEP)), 0.05, 0.01, -12.0, 0.0),
        at("log_push", -9.0, held, 0.01, -12.0, 3.0),
        at("log_bank", -11.0, held, 0.01, -12.0, -1.0),
    )


def main() -> None:
    """RMSE over bound and coverage of a, b, c and K, D, h."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("runs", type=int, nargs="?", default=200)
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    push = sine_with_dwell()
    least_abc, least_kdh = bound(push)
    known = parameters()
    truth = np.array([TRUTH.a, TRUTH.b, TRUTH.c, STIFFNESS, DAMPING, HEIGHT])
    least = np.concatenate((least_abc, least_kdh))
    found, spread = [], []
    for seed in range(chosen.seed, chosen.seed + chosen.runs):
        fit = fit_roll(recorded(push, np.random.default_rng([20261121, seed])), known, np.array([len(push)]))
        abc = np.array([fit.values[name] for name in "abc"])
        block = [fit.index(name) for name in "abc"]
        jacobian = np.array(
            [
                (
                    np.array(suspension_of(RollCoefficients(*(abc + step * axis)), MASS, INERTIA))
                    - suspension_of(RollCoefficients(*(abc - step * axis)), MASS, INERTIA)
                )
                / (2 * step)
                for axis, step in zip(np.eye(3), (0.01, 0.005, 0.001), strict=True)
            ]
        ).T
        covariance = fit.covariance[np.ix_(block, block)]
        found.append(np.concatenate((abc, suspension_of(RollCoefficients(*abc), MASS, INERTIA))))
        spread.append(
            np.sqrt(np.concatenate((np.diag(covariance), np.diag(jacobian @ covariance @ jacobian.T))))
        )
    error, std = np.array(found) - truth, np.array(spread)
    print(f"{chosen.runs} runs; mirror of h: {mirror_height(HEIGHT, MASS, INERTIA):.3f} m, flat line at {np.sqrt(INERTIA / MASS):.3f} m, dc/dh = {height_sensitivity(HEIGHT, MASS, INERTIA):.2f}\n")  # fmt: skip
    print(
        "| | bound % | bias / bound | RMSE / bound | claimed std / bound | 95 % covers |\n|---|---|---|---|---|---|"
    )
    for i, name in enumerate(("a", "b", "c", "K", "D", "h")):
        e = error[:, i]
        print(f"| {name} | {100 * least[i] / truth[i]:.2f} | {e.mean() / least[i]:+.2f} | {np.sqrt(np.mean(e**2)) / least[i]:.2f} | {std[:, i].mean() / least[i]:.2f} | {np.mean(np.abs(e) < 1.96 * std[:, i]):.3f} |")  # fmt: skip


if __name__ == "__main__":
    main()
