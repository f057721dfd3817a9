"""What an unknown slope of the road does to the two moments: hills that nobody measured, drawn and put through the fit.

A slope t(s) pushes along the road with g t and, where the force normal to the road is not measured, over crests with v dt/dt. The fit
takes both for load transfer, as far as they happen to go with braking and driving: by chance, and the more the fewer the hills.
"""

from __future__ import annotations

import math

import numpy as np

from pipelines.estimators.axle_load_gls.data import AxleData
from pipelines.estimators.axle_load_gls.fit import Fit
from pipelines.estimators.axle_load_gls.road import STILL
from pipelines.filters.whiten import whiten
from pipelines.models.axle_load import GRAVITY
from pipelines.prepare.lowpass import lowpass
from pipelines.results import FloatArray

HILLS: dict[str, tuple[float, float, float]] = {
    "flat": (0.02, 50.0, 400.0),
    "altitude": (0.01, 20.0, 60.0),
}
"""By where the slope is from: standard deviation in rad of what is left of it, and over how many metres it hangs together (from, to).
Public roads have 1.5 to 3 % rms; an altitude low-passed at 0.05 Hz keeps the long hills."""

PRIOR_HILLS, HILL_M = 4.0, 150.0
"""How many hills' worth the usual size counts against what the drive's own residual shows; metres a hill."""

SLOW_HZ = 0.2
DRAWS, BATCH, WAVES = 48, 8, 24
STEP_M = 5.0


def hill_size(data: AxleData, rest: FloatArray, transfer: float) -> float:
    """Standard deviation of the unknown slope, rad: the usual one and what the residual shows. rest (n,): N·m; transfer: M_h, kg·m."""
    usual = HILLS[data.grade_source.kind][0]
    left = total = 0.0
    for first, past in data.runs():
        slow = lowpass(rest[first:past], data.rate_hz, min(SLOW_HZ, 0.4 * data.rate_hz))
        left += float(np.sum((slow - np.mean(slow)) ** 2))
        total += past - first
    seen = math.sqrt(left / max(total, 1.0)) / max(abs(transfer) * GRAVITY, 1e-9)
    speed = np.zeros(1) if data.speed is None else data.speed
    hills = float(np.sum(speed)) * data.dt / HILL_M
    return math.sqrt((PRIOR_HILLS * usual**2 + hills * seen**2) / (PRIOR_HILLS + hills))


def _slopes(
    along: FloatArray, size: float, reach: tuple[float, float], rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Draws of the slope and of its change a metre over the distance, (n, BATCH) each, without their means."""
    grid = np.arange(0.0, float(along[-1]) + 2 * STEP_M, STEP_M)
    slope, bend = np.empty((len(along), BATCH)), np.empty((len(along), BATCH))
    for i in range(BATCH):
        length = math.exp(rng.uniform(math.log(reach[0]), math.log(reach[1])))
        profile = np.zeros(len(grid))
        for wave, phase in zip(
            rng.standard_normal(WAVES) / length, rng.uniform(0, 2 * math.pi, WAVES), strict=True
        ):
            profile += np.cos(wave * grid + phase)
        profile *= size * math.sqrt(2 / WAVES)
        slope[:, i] = np.interp(along, grid, profile)
        bend[:, i] = np.interp(along, grid, np.gradient(profile) / STEP_M)
    return slope - slope.mean(axis=0), bend


def _summed(values: FloatArray, data: AxleData) -> FloatArray:
    """Integral over time of each column from the first row of each run."""
    total = np.cumsum(values, axis=0) * data.dt - 0.5 * values * data.dt
    begin = np.flatnonzero(data.starts > 0.5)
    return np.asarray(total - np.repeat(total[begin], np.diff([*begin, data.size]), axis=0))


def hills_covariance(
    data: AxleData, found: Fit, x: FloatArray, precision: FloatArray, moments: FloatArray, rest: FloatArray, size_of: float | None,
) -> FloatArray:  # fmt: skip
    """(2, 2) of the fit's first two coefficients; zero where the slope was measured or drops out.

    x (n, p): the fit's columns. size_of: by what its columns were divided; None for the form against the speed, whose columns are
    integrals. moments: (M_h, M_c). rest (n,): what the balance leaves of the moment, N·m.
    """
    if data.grade_source.kind not in HILLS or data.speed is None:
        return np.zeros((2, 2))
    _, shortest, longest = HILLS[data.grade_source.kind]
    size = hill_size(data, rest, float(moments[0]))
    along = np.cumsum(np.maximum(data.speed, 0.0)) * data.dt
    # over crests only where nothing showed the force normal to the road
    crests = float(moments[1]) if data.vertical_words == STILL else 0.0
    rng = np.random.default_rng(0)
    colour = found.colour
    variance = colour.white / found.weights
    errors = []
    for _ in range(DRAWS // BATCH):
        slope, bend = _slopes(along, size, (shortest, longest), rng)
        wrong = moments[0] * GRAVITY * slope + crests * data.speed[:, None] ** 2 * bend
        wrong = -_summed(wrong / moments[0], data) if size_of is None else wrong / size_of
        white, _ = whiten(
            np.column_stack((x, wrong)), data.starts, colour.phi, colour.ratio * colour.white, variance
        )
        own, other = white[:, : x.shape[1]], white[:, x.shape[1] :]
        information = own.T @ own + np.diag(precision) * found.scale**2
        scale = np.sqrt(np.diag(information))
        scale[scale == 0] = 1.0
        errors.append(
            np.linalg.solve(information / np.outer(scale, scale), (own.T @ other) / scale[:, None])[:2]
            / scale[:2, None]
        )
    drawn = np.concatenate(errors, axis=1)
    return np.asarray(drawn @ drawn.T / drawn.shape[1])
