"""How near does the first stage of `roll_map` come to what the data allow? RMSE over the Cramér-Rao bound of a, b, c.

python benchmarks/roll_map_bound.py [runs] [most friction in m/s²]

The plant equals the model: c φ'' + b φ' + a φ (1 + s φ²) + friction = f, white noise on all channels, a bank that wanders and that the
accelerometer feels, as on a road where the vehicle holds its course. The bound is that
of the raw 100 Hz samples (no low-pass) with every nuisance parameter of the fit (delays, offsets, stiffening, friction) and its prior. The
acceleration is known by its noisy measurement only: its true course is a nuisance as well, which leaves the slopes of the outputs by the
true course, whitened by the exact Kalman filter at the truth. (Slopes by the measured course, as this file had them before,
count the input's noise as information: 20 % of b and 33 % of c in the slalom.) Angle and rate come late by delays of their own; the rate's is
small, as one unit gives it with the acceleration.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parent)]

from roll_map_drives import manoeuvre  # noqa: E402

from parsers.drive import Drive, ImportRecord, Signal  # noqa: E402
from parsers.jit import kernel  # noqa: E402
from pipelines.estimators.roll_map.estimator import RollMap  # noqa: E402
from pipelines.estimators.roll_map.motion import SLIP  # noqa: E402
from pipelines.filters.kalman import innovations  # noqa: E402
from pipelines.models.roll import GRAVITY, RollCoefficients, discretise, dry_friction, process_noise  # noqa: E402
from pipelines.results import FloatArray  # noqa: E402
from pipelines.vehicles.vehicle import Vehicle  # noqa: E402

A, B, C = 110.0, 7.0, 0.8
NOISE = {"accel_y": 0.05, "roll": np.radians(0.1), "roll_rate": np.radians(0.3)}
BANK, BANK_S = np.radians(0.2), 8.0
STEP = 0.01
PRIOR = np.array([80.0, 6.0, 0.6, 0.05, 0.01, 0.1, 0.03, 3.0, 0.1])
"""Standard deviations of a, b, c, delay of angle and rate, their offsets, stiffening, friction."""


@kernel
def _motion(push: FloatArray, stiffening: float, friction: float, out: FloatArray) -> None:
    """Roll and its rate (n, 2) at 1 kHz."""
    angle, rate, held = 0.0, 0.0, 0.0
    for i in range(len(push)):
        out[i, 0], out[i, 1] = angle, rate
        rate += (
            0.001
            * (push[i] - friction * held - 7.0 * rate - 110.0 * angle * (1 + stiffening * angle * angle))
            / 0.8
        )
        angle += 0.001 * rate
        held += 0.001 * (rate - abs(rate) * held) / SLIP


def simulate(kind: str, seed: int, most_friction: float) -> tuple[Drive, FloatArray, FloatArray]:
    """A drive, and its clean input and angle at 100 Hz."""
    rng = np.random.default_rng([7, seed])
    speed, push = manoeuvre(kind, np.random.default_rng(99))
    stiffening, friction = 3 * rng.standard_normal(), most_friction * rng.random()
    delay, rate_delay = 0.03 * rng.standard_normal(), 0.01 * rng.standard_normal()
    out = np.zeros((len(push), 2))
    _motion(push, stiffening, friction, out)
    fine = np.arange(len(push)) / 1000
    t = np.arange(0.5, fine[-1] - 0.5, STEP)
    fade = np.exp(-STEP / BANK_S)
    bank, level = np.zeros(len(t)), BANK * rng.standard_normal()
    for i, shock in enumerate(rng.standard_normal(len(t))):
        bank[i] = level
        level = fade * level + BANK * np.sqrt(1 - fade * fade) * shock
    clean = {
        "accel_y": np.interp(t, fine, push) + GRAVITY * bank,
        "roll": np.interp(t - delay, fine, out[:, 0]) + bank + np.radians(0.5),
        "roll_rate": np.interp(t - rate_delay, fine, out[:, 1]) + 0.004,
    }
    time_ns = np.round((t - t[0]) * 1e9).astype(np.int64)
    signals = {
        name: Signal(name, time_ns, values + NOISE[name] * rng.standard_normal(len(t)), name)
        for name, values in clean.items()
    }
    still = np.interp(t, fine, speed)
    signals["speed"] = Signal("speed", time_ns[::10], np.where(still < 0.05, 0.0, still)[::10], "speed")
    found = ImportRecord(
        "simulated", (Path("plant"),), "0", "complete", 0, {}, (), "plant", None, float(t[-1]), ()
    )
    return Drive(signals, found), np.interp(t, fine, push), np.interp(t, fine, out[:, 0])


def _answer(x: FloatArray, clean: FloatArray, angle: FloatArray) -> FloatArray:
    """(n, 2) what the sensors would read without noise, for parameters x (see PRIOR)."""
    a, b, c, delay, rate_delay, roll_offset, rate_offset, stiffening, friction = x
    t = np.arange(len(clean)) * STEP
    push = np.interp(t - delay, t, clean) - a * stiffening * angle**3
    push = push - friction * dry_friction(angle, np.array([0]), np.array([len(t)]), SLIP)
    phi, before, after = discretise(RollCoefficients(a, b, c), STEP)
    later = np.append(push[1:], push[-1])
    feed = np.column_stack([np.full(len(t), roll_offset), np.full(len(t), rate_offset)])
    nothing = np.zeros((len(t), 2))
    moved, _ = innovations(
        nothing, np.outer(push, before) + np.outer(later, after), feed, (np.array([0]), np.array([len(t)])), phi=phi,
        q=np.zeros((2, 2)), c=np.eye(2), r=np.ones(2), x0=np.zeros((1, 2)), p0=np.zeros((2, 2)),
    )  # fmt: skip
    moved = -moved
    moved[:, 1] -= (rate_delay - delay) * np.gradient(moved[:, 1], STEP)
    return np.asarray(moved)


def _whitened(columns: FloatArray) -> FloatArray:
    """Columns (n, 2) in standard deviations of what the exact Kalman filter at the truth would find new in them."""
    n = len(columns)
    roll = RollCoefficients(A, B, C)
    fade = np.exp(-STEP / BANK_S)
    phi, q = np.zeros((3, 3)), np.zeros((3, 3))
    phi[:2, :2], phi[2, 2] = discretise(roll, STEP)[0], fade
    q[:2, :2], q[2, 2] = process_noise(roll, NOISE["accel_y"] ** 2 * STEP, STEP), BANK**2 * (1 - fade**2)
    error, variance = innovations(
        columns, np.zeros((n, 3)), np.zeros_like(columns), (np.array([0]), np.array([n])), phi=phi, q=q,
        c=np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0]]), r=np.array([NOISE["roll"] ** 2, NOISE["roll_rate"] ** 2]),
        x0=np.zeros((1, 3)), p0=np.diag([1e-8, 1e-8, BANK**2]),
    )  # fmt: skip
    return np.asarray(error / np.sqrt(variance))


def bound(kind: str) -> FloatArray:
    """(3,) least standard deviations of a, b, c, with the nuisance parameters' priors counted as data."""
    _, clean, angle = simulate(kind, 0, 0.0)
    x = np.array([A, B, C, 0.0, 0.0, np.radians(0.5), 0.004, 0.0, 0.05])
    slopes = []
    for i, step in enumerate((0.05, 0.01, 0.002, 1e-3, 1e-3, 1e-4, 1e-4, 0.05, 0.005)):
        ends = [_answer(x + side * step * np.eye(len(x))[i], clean, angle) for side in (1, -1)]
        slopes.append(_whitened((ends[0] - ends[1]) / (2 * step)).ravel())
    j = np.array(slopes)
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(j @ j.T + np.diag(1 / PRIOR**2))))[:3])


def compare(runs: int, friction: float) -> None:
    """RMSE, claimed standard deviation and their ratio to the bound, by manoeuvre."""
    estimator = RollMap()
    print(
        "| manoeuvre | coefficient | bound % | RMSE / bound | claimed std of the fit / bound | within 1.96 claimed std |"
    )
    print("|---|---|---|---|---|---|")
    for kind in ("sine with dwell", "slalom", "double lane change"):
        least = bound(kind)
        rows = []
        for seed in range(runs):
            drive = simulate(kind, seed, friction)[0]
            prepared = estimator.prepare(drive, {})
            figures = estimator.estimate(
                prepared, Vehicle(), {"draws": 1000.0}, np.random.default_rng(1)
            ).diagnostics
            rows.append([[figures[f"{n}_of_models{end}"] for n in "abc"] for end in ("", "_std")])
        table = np.array(rows)
        error, std = table[:, 0] - (A, B, C), table[:, 1]
        for i, name in enumerate("abc"):
            rmse = np.sqrt(np.mean(error[:, i] ** 2))
            share = 100 * least[i] / (A, B, C)[i]
            inside = np.mean(np.abs(error[:, i]) < 1.96 * std[:, i])
            print(
                f"| {kind} | {name} | {share:.2f} | {rmse / least[i]:.2f} | {std[:, i].mean() / least[i]:.2f} | {inside:.2f} |"
            )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("runs", nargs="?", type=int, default=40, help="of each manoeuvre (default 40)")
    parser.add_argument(
        "friction", nargs="?", type=float, default=0.0, help="the most, m/s² of acceleration (default 0)"
    )
    chosen = parser.parse_args()
    compare(chosen.runs, chosen.friction)


if __name__ == "__main__":
    main()
