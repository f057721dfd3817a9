"""How fast the gPC-EKF for regression runs: samples a second with 15 terms and 60 points, the best of some runs on one core.

python benchmarks/gpc_regression_speed.py [samples]

The target is 70 000 samples a second. The same filter in numpy, sample by sample, stands beside it as its peer.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parent)]

from timing import best  # noqa: E402

from pipelines.filters.gpc_regression import RegressionFilter, gpc_regression  # noqa: E402
from pipelines.filters.gpc_update import SQUARE_ROOT  # noqa: E402
from pipelines.models.roll_plane import SIMPLE  # noqa: E402
from pipelines.reproduce.gpc_regression.methods import points  # noqa: E402
from pipelines.reproduce.gpc_regression.setup import (  # noqa: E402
    HALF,
    INPUT_NOISE,
    MIDDLE,
    NOISE,
    clean_drive,
    noisy,
)

TARGET = 70_000.0


def plain(phi: np.ndarray, z: np.ndarray, how: RegressionFilter) -> np.ndarray:
    """The published update in numpy, whole arrays for the points, one sample after the other."""
    at = how.collocation
    x = at.inverse @ (how.middle + how.half * at.points)
    for k in range(len(z)):
        values = at.matrix @ x
        products = np.prod(values[:, None, :] ** how.model.exponents, axis=2)
        y = at.inverse @ (products @ phi[k].T)
        gain = x[1:].T @ y[1:] @ np.linalg.inv(y[1:].T @ y[1:] + np.diag(how.noise))
        x[0] += gain @ (z[k] - y[0])
        x[1:] -= y[1:] @ gain.T
    return x


def main() -> None:
    """Print samples a second of the kernel, with and without the inputs' noise, and of the peer."""
    samples = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    rng = np.random.default_rng(0)
    drive = noisy(clean_drive(rng), rng, inputs=True)
    phi, z = drive.regressors[:samples], drive.outputs[:samples]
    how = RegressionFilter(SIMPLE, points(), MIDDLE, HALF, np.full(3, NOISE), None, SQUARE_ROOT)
    both = RegressionFilter(SIMPLE, points(), MIDDLE, HALF, np.full(3, NOISE), None, SQUARE_ROOT, INPUT_NOISE)
    few = min(len(z), 1000)
    peer = few / best(lambda: plain(phi[:few], z[:few], how))
    for name, chosen in (("gPC-EKF", how), ("gPC-EKF, inputs' noise taken out", both)):
        rate = len(z) / best(lambda chosen=chosen: gpc_regression(phi, z, chosen))
        print(
            f"{name}: {rate:,.0f} samples/s ({rate / TARGET:.1f} x target, {rate / peer:.0f} x numpy's {peer:,.0f})"
        )


if __name__ == "__main__":
    main()
