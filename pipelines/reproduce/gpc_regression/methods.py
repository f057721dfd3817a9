"""The methods of 3.9 and their companions on one drive, all with the same answer: values and standard deviations."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from pipelines.chaos.bases import legendre
from pipelines.chaos.collocation import Collocation, collocate
from pipelines.chaos.space import Space
from pipelines.filters.gpc_regression import RegressionFilter, gpc_regression
from pipelines.filters.gpc_update import PUBLISHED, SQUARE_ROOT
from pipelines.filters.products_batch import fit_products
from pipelines.filters.rls_forgetting import rls_forgetting
from pipelines.models.roll_plane import SIMPLE
from pipelines.reproduce.gpc_regression.setup import HALF, INPUT_NOISE, MIDDLE, NOISE, Drive
from pipelines.results import FloatArray

ORDER = 2
WORST_CONDITION = 1e4
QUIET = np.array([1 / 5000, 1 / 5000, 1 / 5000, 1 / 10000])
LOUD = np.array([1 / 10000, 1 / 10000, 1 / 10000, 1 / 20000])
"""Additions c_1 .. c_4 of Table 3.8 (no noise) and Table 3.10 (noise)."""

QUIET_R, LOUD_R = 0.001, 0.1
FORGETTING = 0.999
EVERY = 100
RLS_START_STD = np.array([1e-3, 1e-2, 1e-2, 10.0, 10.0])
"""Starting spread of RLS on the five coefficients (85), around those of the prior's middle; ours, as it is not printed."""


@dataclass(frozen=True)
class Answer:
    """values, std: (4,) at the end, in the order of `setup.NAMES`; track: (k, 4), a row a second.

    other_height: what RLS gives through the pitch equation, NaN elsewhere.
    """

    values: FloatArray
    std: FloatArray
    track: FloatArray
    other_height: float = float("nan")


@cache
def points(factor: float = 4.0) -> Collocation:
    """`factor` times as many Hammersley points as terms."""
    return collocate(
        Space((legendre(),) * len(MIDDLE)), ORDER, factor=factor, worst_condition=WORST_CONDITION
    )


def too_few_points(count: int, rng: np.random.Generator) -> Collocation:
    """Fewer random points than terms, by the pseudo-inverse all the same: what Table 3.8 says literally."""
    whole = points(1.0)
    few = whole.space.sample(rng, count)
    matrix = whole.space.matrix(few, whole.indices)
    return replace(
        whole,
        points=few,
        matrix=matrix,
        inverse=np.asarray(np.linalg.pinv(matrix), dtype=np.float64),
        condition=float("inf"),
    )


def chaos_filter(
    drive: Drive,
    *,
    form: int = SQUARE_ROOT,
    additions: FloatArray | None = None,
    noise: float = NOISE,
    at: Collocation | None = None,
    inputs: bool = False,
) -> Answer:
    """The gPC-EKF for regression (70). at: 4 x S Hammersley points by default. inputs: the known noise on the inputs is taken out."""
    how = RegressionFilter(
        SIMPLE,
        at or points(),
        MIDDLE,
        HALF,
        np.full(3, noise),
        additions,
        form,
        INPUT_NOISE if inputs else None,
    )
    run = gpc_regression(drive.regressors, drive.outputs, how, every=EVERY)
    return Answer(run.track[-1], run.spread[-1], run.track)


def published(drive: Drive, *, quiet: bool) -> Answer:
    """With the printed settings of Table 3.8 (quiet) or 3.10, and 4 x S points: Q in the tables is a multiple of S."""
    additions, noise = (QUIET, QUIET_R) if quiet else (LOUD, LOUD_R)
    return chaos_filter(drive, form=PUBLISHED, additions=additions, noise=noise)


def _from_coefficients(theta: FloatArray) -> FloatArray:
    """m, J_p, J_r and h (by the roll equation) from the free coefficients (85), (..., 5) -> (..., 4)."""
    mass, roll, pitch = 1 / theta[..., 0], 1 / theta[..., 1], 1 / theta[..., 2]
    return np.stack((mass, pitch, roll, theta[..., 3] * roll / mass), axis=-1)


def recursive(drive: Drive, *, inputs: bool = False, forgetting: float = FORGETTING) -> Answer:
    """RLS with exponential forgetting (81)-(85). inputs: the known noise on the inputs is taken out."""
    start = SIMPLE.coefficients(MIDDLE)
    variance = np.full(3, NOISE)
    if inputs:
        variance = variance + INPUT_NOISE @ start**2
    track, _, theta, p = rls_forgetting(
        drive.regressors, drive.outputs, start, np.diag(RLS_START_STD**2), variance=variance,
        forgetting=forgetting, input_variance=INPUT_NOISE if inputs else None, every=EVERY,
    )  # fmt: skip
    values = _from_coefficients(theta)
    # relative slopes of m, J_p, J_r, h by the coefficients
    slopes = np.array([[-1, 0, 0, 0, 0], [0, 0, -1, 0, 0], [0, -1, 0, 0, 0], [1, -1, 0, 1, 0]]) / theta
    std = np.abs(values) * np.sqrt(np.einsum("ij,jk,ik->i", slopes, p, slopes))
    return Answer(values, std, _from_coefficients(track), float(theta[4] / theta[2] * theta[0]))


def batch(drive: Drive, *, inputs: bool = False) -> Answer:
    """Non-linear least squares of all samples; inputs: with the true inputs as unknowns (total least squares)."""
    fit = fit_products(
        SIMPLE, drive.regressors, drive.outputs, np.full(3, NOISE), MIDDLE, INPUT_NOISE if inputs else None
    )
    return Answer(fit.values, fit.std, fit.values[None, :])
