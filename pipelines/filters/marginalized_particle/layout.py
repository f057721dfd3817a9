"""Where a particle's numbers stand in its row of the filter's table, and small records that the kernels pass on.

0-5    K, D, h, m, I_x, z (`records.COLUMNS`)
6-9    A(θ) over one step, row by row
10-11  the response to an input of one through the step (B(θ)); 12-13 the part of it that the sample after brings
14-    the state's mean: roll, roll rate, and with offsets: of roll, of roll rate, of acceleration
then   its covariance, upper triangle row by row
last   of the sample's own noise in the input, where that is a sensor's: mean, variance, covariance with the five states
"""

from __future__ import annotations

from typing import NamedTuple

from parsers.channels import FloatArray, IntArray

THETA = 6
A00, A01, A10, A11 = 6, 7, 8, 9
LEVEL0, LEVEL1, AFTER0, AFTER1 = 10, 11, 12, 13
STATE = 14
COV2 = STATE + 2
COV5 = STATE + 5
WIDTH2 = COV2 + 3
WIDTH5 = COV5 + 15
NOISE_MEAN, NOISE_VARIANCE, NOISE_COV = WIDTH5, WIDTH5 + 1, WIDTH5 + 2
WIDTH_SENSED = NOISE_COV + 5


class Signals(NamedTuple):
    """y: (n, 2), NaN where not measured. accel: (n,). starts, stops: rows of the segments. walk: (3,). keep: rows to keep."""

    y: FloatArray
    accel: FloatArray
    starts: IntArray
    stops: IntArray
    walk: FloatArray
    keep: IntArray


class Start(NamedTuple):
    """Variances of the first state: roll, roll rate; of the offsets, as in `records.Offsets`."""

    roll: float
    rate: float
    roll_offset: float
    rate_offset: float
    accel_offset: float


class Rules(NamedTuple):
    """`ParticleSettings` and `Noise` as numbers: variances r0, r1 (R) and q (Q_a); offsets: 1 where they are states."""

    step: float
    gravity: float
    r0: float
    r1: float
    q: float
    threshold: float
    kernel: float
    offsets: int
    hold: int
    mirror: int
    sensed: int
    adaptive: int
    fixed: int
    wanted: int
    most: int
    every: int


class Record(NamedTuple):
    """What the kernel fills: as `records.ParticleRun`. kept: (snapshots, most, 7) θ and weight; kept_count: (snapshots,)."""

    mean: FloatArray
    std: FloatArray
    quantiles: FloatArray
    particles: IntArray
    effective: FloatArray
    state: FloatArray
    state_std: FloatArray
    log_likelihood: FloatArray
    innovation: FloatArray
    innovation_std: FloatArray
    survivors: IntArray
    kept: FloatArray
    kept_count: IntArray
