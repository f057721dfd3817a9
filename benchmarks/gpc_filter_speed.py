"""How fast the compiled gPC-EKF runs: samples a second on one core, beside the same filter in plain numpy from the same run.

python benchmarks/gpc_filter_speed.py [samples]

Mass, stiffness, damping and a constant force unknown, order 2: S = 15 terms, 60 collocation points. The floor is 70 000
samples a second.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parent)]

from timing import best  # noqa: E402

from pipelines.filters.gpc_filter import (  # noqa: E402
    GpcSettings,
    StateSpaceRun,
    Uncertain,
    estimate_state_space,
    row,
)
from pipelines.filters.gpc_update import PUBLISHED, SQUARE_ROOT  # noqa: E402
from pipelines.models.mass_spring import MASS_SPRING  # noqa: E402
from pipelines.simulation.mass_spring import (  # noqa: E402
    MassSpringDrive,
    MassSpringPlant,
    band_limited_noise,
    fine_times,
    simulate_mass_spring,
)

FLOOR = 70_000
STEP_S, SENSOR_M = 0.01, 0.02
PLAIN_SHARE = 20


def parameters(logarithm: bool) -> tuple[Uncertain, ...]:
    """Four unknowns; a constant force has no logarithm."""
    first = ((120.0, 20.0), (300.0, 50.0), (30.0, 5.0))
    if logarithm:
        return (*(Uncertain(mean, 0.2, logarithm=True) for mean, _ in first), Uncertain(0.0, 10.0))
    return (*(Uncertain(mean, spread) for mean, spread in first), Uncertain(0.0, 10.0))


def compiled(drive: MassSpringDrive, z: np.ndarray, logarithm: bool, form: int) -> StateSpaceRun:
    """The filter over the whole drive."""
    return estimate_state_space(
        MASS_SPRING, row(drive.force), row(z), STEP_S, (Uncertain(0.0), Uncertain(0.0)), parameters(logarithm),
        GpcSettings((SENSOR_M**2,), order=2, factor=4.0, form=form, keep_every=1),
    )  # fmt: skip


def plain(run: StateSpaceRun, force: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The same filter (square root, no logarithm) with whole numpy arrays for each sample; the last means."""
    matrix, inverse = run.collocation.matrix.T, run.collocation.inverse.T
    x, half = run.coefficients[0].copy(), 0.5 * STEP_S
    noise = SENSOR_M**2
    for k in range(1, len(z)):
        p, v, mass, stiffness, damping, offset = x @ matrix
        before, after = force[k - 1] + offset, force[k] + offset
        middle = 0.5 * (before + after)
        a1 = (before - stiffness * p - damping * v) / mass
        v2 = v + half * a1
        a2 = (middle - stiffness * (p + half * v) - damping * v2) / mass
        v3 = v + half * a2
        a3 = (middle - stiffness * (p + half * v2) - damping * v3) / mass
        v4 = v + STEP_S * a3
        a4 = (after - stiffness * (p + STEP_S * v3) - damping * v4) / mass
        x[0] = (p + STEP_S / 6 * (v + 2 * v2 + 2 * v3 + v4)) @ inverse
        x[1] = (v + STEP_S / 6 * (a1 + 2 * a2 + 2 * a3 + a4)) @ inverse
        y = x[0].copy()
        gain = x[:, 1:] @ y[1:]
        total = y[1:] @ y[1:] + noise
        gain /= total
        x[:, 0] += gain * (z[k] - y[0])
        x[:, 1:] -= np.outer(gain / (1 + np.sqrt(noise / total)), y[1:])
    return np.asarray(x[:, 0])


def main() -> int:
    """Print one line a case; 1 where the floor is not kept."""
    samples = int(sys.argv[1]) if len(sys.argv) > 1 else 40_000
    rng = np.random.default_rng(0)
    force = band_limited_noise(rng, fine_times(samples * STEP_S, STEP_S), 0.05, 3.0, 200.0)
    drive = simulate_mass_spring(MassSpringPlant(100.0, 400.0, 40.0), force, STEP_S)
    z = drive.position + SENSOR_M * rng.standard_normal(len(drive.position))
    few = samples // PLAIN_SHARE
    run = compiled(drive, z, False, SQUARE_ROOT)
    began = time.perf_counter()
    last = plain(run, drive.force[:few], z[:few])
    slow = few / (time.perf_counter() - began)
    np.testing.assert_allclose(last, run.mean[few - 1], rtol=1e-6, atol=1e-9)
    points, terms = run.collocation.matrix.shape
    print(f"S = {terms}, {points} points, {samples} samples; plain numpy {slow:,.0f} samples/s (same answer)")
    slowest = np.inf
    for words, logarithm, form in (
        ("square root", False, SQUARE_ROOT),
        ("as published", False, PUBLISHED),
        ("square root, logarithms", True, SQUARE_ROOT),
    ):
        rate = len(z) / best(lambda logarithm=logarithm, form=form: compiled(drive, z, logarithm, form))  # type: ignore[misc]
        slowest = min(slowest, rate)
        print(
            f"{words:28s} {rate:10,.0f} samples/s  {rate / slow:6.1f} x plain numpy  {rate / FLOOR:5.1f} x the floor"
        )
    return 0 if slowest >= FLOOR else 1


if __name__ == "__main__":
    sys.exit(main())
