"""Algorithm 2, compiled: one call runs a whole drive.

Line 3 (7) and line 10 (8) are taken together, before resampling instead of after: the particle's copies would repeat the
same arithmetic. Weights are kept as logarithms whose exponentials sum to one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.jit import kernel, lean_kernel
from pipelines.filters.lanes import LANES, RandomState
from pipelines.filters.marginalized_particle.adaptation import (
    Places,
    resample,
    wanted_size,
)
from pipelines.filters.marginalized_particle.discretise import discretise
from pipelines.filters.marginalized_particle.layout import (
    LOG,
    WEIGHT,
    Record,
    Rules,
    Signals,
    Start,
)
from pipelines.filters.marginalized_particle.moves import cloud_root, smooth, walk
from pipelines.filters.marginalized_particle.statistics import (
    BINS,
    add_up,
    lighten,
    origin_of,
    quantiles,
)
from pipelines.filters.marginalized_particle.tile_step import (
    advance,
    begin,
    forget,
    level,
    measure,
    renew,
    share_out,
)

LEVELS = (0.025, 0.5, 0.975)


@lean_kernel
def heaviest_of(table: FloatArray, tiles: int, lanes: FloatArray) -> int:
    """Which particle has the largest logarithm, -1 where none has a weight any more. lanes: of `measure`."""
    best = -np.inf
    for i in range(LANES):
        best = max(best, lanes[i])
    if best > -np.inf:
        for tile in range(tiles):
            for i in range(LANES):
                if table[tile, LOG + i] == best:
                    return tile * LANES + i
    return -1


@lean_kernel
def note(
    k: int,
    particles: int,
    origin: FloatArray,
    sums: FloatArray,
    innovations: FloatArray,
    record: Record,
) -> None:
    """Row k of the record. sums: of `add_up`. innovations: of `measure`."""
    total, squares = sums[0], sums[1]
    record.particles[k] = particles
    record.effective[k] = total * total / squares
    for j in range(len(origin)):
        mean = sums[2 + 2 * j] / total
        variance = max(sums[3 + 2 * j] / total - mean * mean, 0.0)
        if j < 3:
            record.mean[k, j] = origin[j] + mean
            record.std[k, j] = np.sqrt(variance)
        else:
            record.state[k, j - 3] = origin[j] + mean
            record.state_std[k, j - 3] = np.sqrt(variance)
    for j in range(2):
        record.innovation[k, j] = innovations[2 * j]
        record.innovation_std[k, j] = np.sqrt(innovations[2 * j + 1])


@lean_kernel
def keep(at: int, table: FloatArray, particles: int, over: float, kept: FloatArray, counts: IntArray) -> None:
    """Keep the cloud as snapshot `at`. over: what makes the table's weights have sum one."""
    counts[at] = particles
    for n in range(particles):
        row, i = table[n // LANES], n % LANES
        for j in range(6):
            kept[at, n, j] = row[j * LANES + i]
        kept[at, n, 6] = over * row[WEIGHT + i]


@kernel
def weigh_sample(
    k: int,
    table: FloatArray,
    particles: int,
    start: Start,
    rules: Rules,
    work: tuple[FloatArray, FloatArray, FloatArray, FloatArray, tuple[FloatArray, IntArray]],
    record: Record,
) -> tuple[float, float, float, int, int]:
    """Lines 4-6 and row k of the record; weights are left with the heaviest's at one.

    Returns what makes their sum one, the logarithm of it that the logarithms are to lose, the sum of squared weights (of sum one),
    the heaviest particle, and 1 where all weight was lost.
    """
    origin, innovations, highest, sums, bins = work
    tiles, states = -(-particles // LANES), len(origin) - 3
    heaviest, lost = heaviest_of(table, tiles, highest), 0
    if heaviest < 0:
        lost, heaviest = 1, 0
        for tile in range(tiles):
            begin(table[tile], start, 1, rules)
            share_out(table[tile], tile, particles)
    best = table[heaviest // LANES, LOG + heaviest % LANES]
    origin_of(table, heaviest, states, origin)
    for j in range(len(sums)):
        sums[j] = 0.0
    for tile in range(tiles):
        lighten(table[tile], best)
        add_up(table[tile], states, origin, sums)
    total, squares = sums[0], sums[1]
    evidence = best + np.log(total)
    record.log_likelihood[k] = -np.inf if lost else evidence
    note(k, particles, origin, sums, innovations, record)
    if rules.every > 0 and k % rules.every == 0:
        quantiles(table, tiles, 1.0 / total, record.mean[k], record.std[k], LEVELS, bins, record.quantiles[k])
    return 1.0 / total, evidence, squares / (total * total), heaviest, lost


@lean_kernel
def weights_of(table: FloatArray, particles: int, over: float, weights: FloatArray) -> None:
    """The particles' weights in one line. over: what makes their sum one."""
    for tile in range(-(-particles // LANES)):
        for i in range(LANES):
            weights[tile * LANES + i] = over * table[tile, WEIGHT + i]


RENEWED, LEVELED, SMOOTHED, WALKED, DISCRETISED, BEGUN, AFRESH, ADVANCED, MEASURED = (
    1 << n for n in range(9)
)
"""What a tile goes through between two samples, in this order.

Chosen anew, or leveled (by over and evidence); moved; its coefficients made again; its state begun, and afresh where nothing was
before it; advanced from the row before; measured.
"""


class Pass(NamedTuple):
    """On the way to row `to`. does: of RENEWED to MEASURED. over, evidence: what LEVELED takes."""

    to: int
    does: int
    over: float
    evidence: float


@kernel
def pass_over(
    this: Pass,
    table: FloatArray,
    numbers: FloatArray,
    particles: int,
    signals: Signals,
    start: Start,
    rules: Rules,
    random: RandomState,
    cloud: tuple[FloatArray, FloatArray, bool],
    chosen: IntArray,
    work: tuple[FloatArray, FloatArray, FloatArray, FloatArray, Places],
) -> None:
    """Each tile is gone through once between two samples: from the weighing of one to the measurement of the next.

    numbers: all of the table that `chosen` are chosen from, in one line. cloud: of `cloud_root`. work: two of `measure`, two of
    `smooth`, one of `renew`.
    """
    innovations, highest, at, step, places = work
    does = this.does
    forget(innovations, highest)
    steps = (signals.walk[0], signals.walk[1], signals.walk[2])
    for tile in range(-(-particles // LANES)):
        row = table[tile]
        if does & RENEWED:
            renew(numbers, row, tile, chosen, particles, does & DISCRETISED != 0, rules.own, places)
        if does & LEVELED:
            level(row, this.over, this.evidence)
        if does & SMOOTHED:
            smooth(random, row, cloud, rules.kernel, rules.mirror, (at, step))
        if does & WALKED:
            walk(random, row, steps, rules.mirror)
        if does & DISCRETISED:
            discretise(row, rules.step, rules.gravity)
        if does & BEGUN:
            begin(row, start, does & AFRESH, rules)
        if does & ADVANCED:
            advance(row, signals.accel[this.to - 1], signals.accel[this.to], rules)
        if does & MEASURED:
            measure(row, signals.y[this.to], rules, innovations, highest)


@kernel
def run(
    chances: FloatArray,
    random: RandomState,
    signals: Signals,
    start: Start,
    rules: Rules,
    tables: tuple[FloatArray, FloatArray],
    lines: tuple[FloatArray, FloatArray],
    particles: int,
    record: Record,
) -> tuple[int, int, int]:
    """Algorithm 2. tables: two of (tiles, width), θ and weights (sum one) of the prior in the first. random: of the moves. chances:
    one from 0 to 1 for each time that particles are chosen anew, in turn. lines: the tables' numbers, each in one line.

    Returns how many particles there are at the end, samples at which all weight was lost, and which table holds them.
    """
    table, spare = tables
    line, other = lines
    holds, lost, kept, drawn = 0, 0, 0, 0
    states = 5 if rules.offsets else 2
    innovations, highest = np.zeros(4), np.zeros(LANES)
    bins = (np.zeros(3 * BINS), np.zeros(3 * LANES, dtype=np.int64))
    work = (np.zeros(3 + states), innovations, highest, np.zeros(8 + 2 * states), bins)
    moved = (
        innovations,
        highest,
        np.zeros((6 + states) * LANES),
        np.zeros(6 * LANES),
        np.zeros(LANES, dtype=np.uint64),
    )
    weights = np.zeros(table.shape[0] * LANES)
    chosen = np.zeros(table.shape[0] * LANES, dtype=np.int64)
    walks = signals.walk[0] > 0.0 or signals.walk[1] > 0.0 or signals.walk[2] > 0.0
    # not False as such: a constant has a type of its own, for which all would be compiled once more
    cloud = (np.zeros(0), np.zeros((0, 0)), rules.kernel < 0.0)
    for segment in range(len(signals.starts)):
        first, stop = signals.starts[segment], signals.stops[segment]
        does = BEGUN | MEASURED
        if segment == 0:
            does |= AFRESH | DISCRETISED
        this = Pass(first, does, 1.0, 0.0)
        pass_over(this, table, other, particles, signals, start, rules, random, cloud, chosen, moved)
        for k in range(first, stop):
            over, evidence, squares, heaviest, none = weigh_sample(
                k, table, particles, start, rules, work, record
            )
            lost += none
            if kept < len(signals.keep) and signals.keep[kept] == k:
                keep(kept, table, particles, over, record.kept, record.kept_count)
                kept += 1
            record.survivors[k] = 0
            last = k + 1 == stop
            again = rules.threshold >= 1.0 or squares * rules.threshold * particles > 1.0
            walked, smoothed = walks and not last, again and rules.kernel > 0.0
            if again:
                size = rules.fixed if rules.fixed > 0 else particles
                if rules.adaptive:
                    size = wanted_size(rules.wanted, particles, squares, rules.most)
                if smoothed:
                    cloud = cloud_root(table, particles, over, heaviest, states, rules.mirror)
                weights_of(table, particles, over, weights)
                record.survivors[k] = resample(weights, particles, size, chances[drawn], chosen)
                drawn += 1
                table, spare, holds, particles = spare, table, 1 - holds, size
                line, other = other, line
            does = RENEWED if again else LEVELED
            does |= 0 if last else ADVANCED | MEASURED
            does |= SMOOTHED | DISCRETISED if smoothed else 0
            does |= WALKED | DISCRETISED if walked else 0
            this = Pass(k + 1, does, over, evidence)
            pass_over(this, table, other, particles, signals, start, rules, random, cloud, chosen, moved)
    return particles, lost, holds
