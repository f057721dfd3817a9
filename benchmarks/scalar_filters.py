"""How fast the scalar filters run once compiled: millions of samples a second, the best of some runs on one core.

python benchmarks/scalar_filters.py [samples]

The target is 10 million samples a second. A plain Python loop of the same recursion stands beside the first as its peer.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parent)]

from timing import best  # noqa: E402

from pipelines.filters.bilinear_rls import bilinear_rls  # noqa: E402
from pipelines.filters.hekf import HekfSettings, hekf_ekf  # noqa: E402
from pipelines.filters.least_squares import recursive_least_squares  # noqa: E402
from pipelines.filters.roll_adaptation import AdaptationGains, adapt_roll  # noqa: E402
from pipelines.filters.second_order import second_order_filters  # noqa: E402

TARGET = 10.0


def plain_seconds(phi: np.ndarray, y: np.ndarray) -> float:
    """The two-parameter recursion in plain Python, in s."""
    rows, values = phi.tolist(), y.tolist()
    began = time.perf_counter()
    t0 = t1 = p01 = 0.0
    p00 = p11 = 1000.0
    for (f0, f1), value in zip(rows, values, strict=True):
        g0, g1 = p00 * f0 + p01 * f1, p01 * f0 + p11 * f1
        scale = 1.0 / (1.0 + f0 * g0 + f1 * g1)
        error = (value - t0 * f0 - t1 * f1) * scale
        t0, t1 = t0 + g0 * error, t1 + g1 * error
        p00, p01, p11 = p00 - g0 * g0 * scale, p01 - g0 * g1 * scale, p11 - g1 * g1 * scale
    return time.perf_counter() - began


def main() -> None:
    """Print one line a filter."""
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 2_000_000
    rng = np.random.default_rng(0)
    phi = rng.standard_normal((n, 2))
    y = phi @ [3.0, -1.0] + 0.1 * rng.standard_normal(n)
    few = n // 20
    plain = few / plain_seconds(phi[:few], y[:few]) / 1e6
    noise = rng.standard_normal((3, n))
    active = np.ones(n, dtype=bool)
    terms = 1.0 + 0.1 * rng.standard_normal((n, 3))
    truck = HekfSettings((10.0, 0.8, 1.3), (0.01, 0.1, 0.1), (1e-4, 0.0, 0.0), 0.01)
    speed, load, flat = 10 + 0.1 * noise[0], 20_000 + 100 * noise[1], np.zeros(n)
    gains = AdaptationGains(600.0, 65_000.0, 5_500.0, 0.1)
    whole = (np.array([0]), np.array([n]))
    mass, height, no = np.full(n, 1800.0), np.full(n, 0.7), np.zeros(n, dtype=bool)
    runs: dict[str, Callable[[], object]] = {
        "recursive least squares, 2 parameters (Pence)": lambda: recursive_least_squares(
            phi, y, np.zeros(2), 1000 * np.eye(2), every=200
        ),
        "recursive least squares, 4 parameters": lambda: recursive_least_squares(
            np.column_stack((phi, phi[::-1])), y, np.zeros(4), 1000 * np.eye(4), every=200
        ),
        "filters 1/Λ, s/Λ, s²/Λ (Pence)": lambda: second_order_filters(y, 0.005, 6.0, 0.1),
        "bilinear least squares (Park & Choi)": lambda: bilinear_rls(
            y, terms, active, start=(0.0, 0.0), covariance=(1e-4, 1e-4), forgetting=(0.999, 0.999)
        ),
        "roll observer with adaptation (Park & Choi)": lambda: adapt_roll(
            noise[0],
            0.1 * noise[1],
            noise[0],
            mass,
            height,
            no,
            active,
            whole,
            gains,
            rate_hz=100.0,
            height_m=0.6,
        ),
        "HEKF-EKF (Wu)": lambda: hekf_ekf(speed, load, flat, 0.01, 3000.0, 3.0, 0.01, truck),
    }
    print(f"{n} samples; plain Python loop of the first: {plain:.2f} million samples/s")
    for name, run in runs.items():
        rate = n / best(run) / 1e6
        verdict = "" if rate >= TARGET else f"   below {TARGET:.0f}"
        print(f"{rate:8.1f} million samples/s   {name}{verdict}")


if __name__ == "__main__":
    main()
