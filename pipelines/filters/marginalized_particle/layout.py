"""Where a particle's numbers stand in the filter's table, and small records that the kernels pass on.

The table is (tiles, width): LANES particles a tile, and of each column the numbers of all of them side by side, so that a loop over
the lanes becomes vector instructions. Of the particle in lane i of a tile, column C stands at C + i. The columns, in this order:

K to Z   K, D, h, m, I_x, z (`records.COLUMNS`)
A        A(θ) over one step, row by row
LEVEL    the response to an input of one through the step (B(θ)); AFTER: the part of it that the sample after brings
LOG      logarithm of the weight; WEIGHT: the weight, sum one. Lanes behind the last particle have minus infinity and zero
STATE    the state's mean: roll, roll rate, and with offsets: of roll, of roll rate, of acceleration
then     its covariance, upper triangle row by row
last     of the sample's own noise in the input, where that is a sensor's: mean, variance, covariance with the five states
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from parsers.channels import FloatArray, IntArray
from pipelines.filters.lanes import LANES

THETA = 6
K, D, H, M, I_X, Z = (c * LANES for c in range(THETA))
A00, A01, A10, A11 = (c * LANES for c in range(6, 10))
LEVEL0, LEVEL1, AFTER0, AFTER1 = (c * LANES for c in range(10, 14))
LOG, WEIGHT = 14 * LANES, 15 * LANES
STATE = 16 * LANES
ROLL, RATE, ROLL_OFFSET, RATE_OFFSET, ACCEL_OFFSET = (STATE + j * LANES for j in range(5))
COV2 = STATE + 2 * LANES
COV5 = STATE + 5 * LANES
WIDTH2 = COV2 + 3 * LANES
WIDTH5 = COV5 + 15 * LANES
NOISE_MEAN, NOISE_VARIANCE, NOISE_COV = WIDTH5, WIDTH5 + LANES, WIDTH5 + 2 * LANES
WIDTH_SENSED = NOISE_COV + 5 * LANES
COV = tuple(COV5 + j * LANES for j in range(15))
"""Of the covariance of five states, row by row: (0 0) ... (0 4), (1 1) ... (4 4)."""

WITH_NOISE = tuple(NOISE_COV + j * LANES for j in range(5))


def tiles_of(particles: int) -> int:
    """How many tiles hold so many particles."""
    return -(-particles // LANES)


def tiled(columns: FloatArray, tiles: int, width: int) -> FloatArray:
    """A table of this size whose first columns are those of (N, c); lanes behind the last particle are copies of it, of no weight."""
    count, here = columns.shape
    rows = np.minimum(np.arange(tiles * LANES), count - 1)
    table = np.zeros((tiles, width))
    table[:, : here * LANES] = (
        columns[rows].reshape(tiles, LANES, here).transpose(0, 2, 1).reshape(tiles, here * LANES)
    )
    table[:, LOG : LOG + LANES] = -np.inf
    return table


def columns_of(table: FloatArray, count: int, columns: int) -> FloatArray:
    """(count, columns) of the table's first columns: the way back."""
    tiles = len(table)
    first = table[:, : columns * LANES].reshape(tiles, columns, LANES).transpose(0, 2, 1)
    return np.ascontiguousarray(first.reshape(tiles * LANES, columns)[:count])


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
    """`ParticleSettings` and `Noise` as numbers: variances r0, r1 (R) and q (Q_a); offsets: 1 where they are states; own: 1 where
    not all particles have the same m, I_x and z."""

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
    own: int


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
