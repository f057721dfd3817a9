"""What one tile of particles goes through in a sample: (7)-(9), weights, and which particles stand in it.

Loops over the lanes have no jump in them, and no call that is left as one: they become vector instructions.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.jit import lean_kernel, summing_kernel, vector_kernel
from pipelines.filters.lanes import LANES, log
from pipelines.filters.marginalized_particle.adaptation import Places, copy_columns, places_of
from pipelines.filters.marginalized_particle.kalman_step import (
    forward_five,
    forward_two,
    measure_five,
    measure_two,
    restart,
)
from pipelines.filters.marginalized_particle.layout import A00, LOG, STATE, WEIGHT, M, Rules, Start
from pipelines.filters.marginalized_particle.sensed_step import forward_sensed, measure_sensed

LOG_TWO_PI = 1.8378770664093453
ANY = 1e300
"""A logarithm beyond it is none."""


@vector_kernel
def _settle(
    row: FloatArray,
    i: int,
    found: tuple[float, float, float, float],
    there: tuple[float, float],
    constant: float,
    spreads: float,
) -> float:
    """A particle's logarithm after its innovations; returns the weight it had before, zero where it has none any more.

    spreads: 1 where the logarithm of the innovations' variances counts, 0 where not.
    """
    e0, s0, e1, s1 = found
    m0, m1 = there
    # the quotients are those of the gains
    square = e0 * e0 * (m0 / s0) + e1 * e1 * (m1 / s1)
    spread = (m0 * s0 + 1.0 - m0) * (m1 * s1 + 1.0 - m1)
    now = row[LOG + i] + constant - 0.5 * (square + spreads * log(spread))
    # of what is no number both comparisons are false
    live = abs(now) < ANY
    row[LOG + i] = now if live else -np.inf
    return row[WEIGHT + i] if live else 0.0


@summing_kernel
def _measure_tile(
    row: FloatArray,
    y: tuple[float, float],
    there: tuple[float, float],
    constant: float,
    rules: Rules,
    sums: FloatArray,
) -> None:
    """(7) and (8) for a tile."""
    y0, y1 = y
    m0, m1 = there
    r0, r1, q = rules.r0, rules.r1, rules.q
    error0, spread0, error1, spread1 = 0.0, 0.0, 0.0, 0.0
    if rules.sensed:
        hold = 1.0 if rules.hold else 0.0
        for i in range(LANES):
            e0, s0, e1, s1 = measure_sensed(row, i, y, there, (r0, r1), hold, q)
            weight = _settle(row, i, (e0, s0, e1, s1), there, constant, 0.0)
            error0 += weight * e0 if weight > 0.0 else 0.0
            spread0 += weight * s0 if weight > 0.0 else 0.0
            error1 += weight * e1 if weight > 0.0 else 0.0
            spread1 += weight * s1 if weight > 0.0 else 0.0
    elif rules.offsets:
        for i in range(LANES):
            e0, s0, e1, s1 = measure_five(row, i, y0, y1, m0, m1, r0, r1)
            weight = _settle(row, i, (e0, s0, e1, s1), there, constant, 1.0)
            error0 += weight * e0 if weight > 0.0 else 0.0
            spread0 += weight * s0 if weight > 0.0 else 0.0
            error1 += weight * e1 if weight > 0.0 else 0.0
            spread1 += weight * s1 if weight > 0.0 else 0.0
    else:
        for i in range(LANES):
            e0, s0, e1, s1 = measure_two(row, i, y0, y1, m0, m1, r0, r1)
            weight = _settle(row, i, (e0, s0, e1, s1), there, constant, 1.0)
            error0 += weight * e0 if weight > 0.0 else 0.0
            spread0 += weight * s0 if weight > 0.0 else 0.0
            error1 += weight * e1 if weight > 0.0 else 0.0
            spread1 += weight * s1 if weight > 0.0 else 0.0
    sums[0] += error0
    sums[1] += spread0
    sums[2] += error1
    sums[3] += spread1


@vector_kernel
def _highest(row: FloatArray, lanes: FloatArray) -> None:
    """Keep the largest logarithm of each lane."""
    for i in range(LANES):
        lanes[i] = max(lanes[i], row[LOG + i])


@lean_kernel
def forget(sums: FloatArray, lanes: FloatArray) -> None:
    """Before the first tile of a sample is measured."""
    for j in range(4):
        sums[j] = 0.0
    for i in range(LANES):
        lanes[i] = -np.inf


@lean_kernel
def measure(row: FloatArray, y: FloatArray, rules: Rules, sums: FloatArray, lanes: FloatArray) -> None:
    """(7) and (8) for every particle of a tile.

    By (7) the input's noise moves the body. A sensor's does not: what the body felt was another input, and of all that it may have been the
    likeliest leaves e²/s alone. With ln(s) besides, whatever answers less to the input looks likelier, sample by sample: heights
    of a minute came out 3 to 17 bounds too high. (`rules.sensed`, whose step is that of `sensed_step`)

    sums: (4,) innovations and their variances, weighed as before the sample. lanes: (LANES,) largest logarithms. Both added to.
    """
    m0 = 1.0 if np.isfinite(y[0]) else 0.0
    m1 = 1.0 if np.isfinite(y[1]) else 0.0
    seen = ((y[0] if m0 > 0.0 else 0.0), (y[1] if m1 > 0.0 else 0.0))
    _measure_tile(row, seen, (m0, m1), -0.5 * (m0 + m1) * LOG_TWO_PI, rules, sums)
    _highest(row, lanes)


@vector_kernel
def advance(row: FloatArray, now: float, after: float, rules: Rules) -> None:
    """(9) for a tile. now, after: the input at this sample and at the next."""
    change = after - now if rules.hold else 0.0
    if rules.sensed:
        hold = 1.0 if rules.hold else 0.0
        for i in range(LANES):
            forward_sensed(row, i, now, after, hold)
    elif rules.offsets:
        for i in range(LANES):
            forward_five(row, i, now, change, rules.q)
    else:
        for i in range(LANES):
            forward_two(row, i, now, change, rules.q)


@lean_kernel
def begin(row: FloatArray, start: Start, first: int, rules: Rules) -> None:
    """A tile's first state of a segment."""
    for i in range(LANES):
        restart(row, i, start, first, rules.offsets)


@vector_kernel
def level(row: FloatArray, over: float, evidence: float) -> None:
    """A tile's weights to sum one, and their logarithms likewise."""
    for i in range(LANES):
        row[WEIGHT + i] *= over
        row[LOG + i] -= evidence


@lean_kernel
def share_out(row: FloatArray, tile: int, particles: int) -> None:
    """Every particle of a tile the same weight, and none to the lanes behind the last."""
    logarithm = -np.log(particles)
    for i in range(LANES):
        there = tile * LANES + i < particles
        row[LOG + i] = logarithm if there else -np.inf
        row[WEIGHT + i] = 1.0 / particles if there else 0.0


@lean_kernel
def renew(
    numbers: FloatArray,
    row: FloatArray,
    tile: int,
    chosen: IntArray,
    size: int,
    again: bool,
    own: int,
    places: Places,
) -> None:
    """A tile of chosen particles, alike in weight. numbers: all of the old table, in one line. again: their coefficients will be
    made again. own: 1 where particles have masses, inertias or input heights of their own. places: (LANES,), overwritten."""
    width = len(row)
    places_of(tile, chosen, size, width, places)
    copy_columns(numbers, places, row, 0, A00 if own else M)
    if not again:
        copy_columns(numbers, places, row, A00, LOG)
    copy_columns(numbers, places, row, STATE, width)
    share_out(row, tile, size)
