"""Algorithm 2, compiled: one call runs a whole drive.

Line 3 (7) and line 10 (8) are taken together, before resampling instead of after: the particle's copies would repeat the
same arithmetic. Weights are kept as logarithms whose exponentials sum to one.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.jit import kernel, lean_kernel
from pipelines.filters.marginalized_particle.adaptation import resample, wanted_size
from pipelines.filters.marginalized_particle.discretise import discretise
from pipelines.filters.marginalized_particle.kalman_step import (
    forward_five,
    forward_two,
    measure_five,
    measure_two,
    restart,
)
from pipelines.filters.marginalized_particle.layout import STATE, Record, Rules, Signals, Start
from pipelines.filters.marginalized_particle.moves import cloud_root, smooth, walk
from pipelines.filters.marginalized_particle.sensed_step import forward_sensed, measure_sensed
from pipelines.filters.marginalized_particle.statistics import quantiles, weigh

LOG_TWO_PI = 1.8378770664093453
LEVELS = (0.025, 0.5, 0.975)


@lean_kernel
def measure(
    table: FloatArray,
    logs: FloatArray,
    weights: FloatArray,
    particles: int,
    y: FloatArray,
    rules: Rules,
    sums: FloatArray,
) -> int:
    """(7) and (8) for every particle; returns the heaviest, -1 where none has a weight any more.

    By (7) the input's noise moves the body. A sensor's does not: what the body felt was another input, and of all that it may have been the
    likeliest leaves e²/s alone. With ln(s) besides, whatever answers less to the input looks likelier, sample by sample: heights
    of a minute came out 3 to 17 bounds too high. (`rules.sensed`, whose step is that of `sensed_step`)

    sums: (4,) innovations and their variances, weighed as before the sample. weights: before the sample, sum one.
    """
    m0 = 1.0 if np.isfinite(y[0]) else 0.0
    m1 = 1.0 if np.isfinite(y[1]) else 0.0
    y0, y1 = (y[0] if m0 > 0.0 else 0.0), (y[1] if m1 > 0.0 else 0.0)
    for j in range(4):
        sums[j] = 0.0
    best, heaviest = -np.inf, -1
    constant = -0.5 * (m0 + m1) * LOG_TWO_PI
    r0, r1 = rules.r0, rules.r1
    for i in range(particles):
        if logs[i] == -np.inf:
            continue
        if rules.sensed:
            e0, s0, e1, s1 = measure_sensed(table[i], (y0, y1), (m0, m1), (r0, r1), rules.hold, rules.q)
        elif rules.offsets:
            e0, s0, e1, s1 = measure_five(table[i], y0, y1, m0, m1, r0, r1)
        else:
            e0, s0, e1, s1 = measure_two(table[i], y0, y1, m0, m1, r0, r1)
        square = m0 * e0 * e0 / s0 + m1 * e1 * e1 / s1
        spread = (m0 * s0 + 1.0 - m0) * (m1 * s1 + 1.0 - m1)
        now = logs[i] + constant - 0.5 * (square if rules.sensed else square + np.log(spread))
        if not np.isfinite(now):
            logs[i] = -np.inf
            continue
        weight = weights[i]
        sums[0] += weight * e0
        sums[1] += weight * s0
        sums[2] += weight * e1
        sums[3] += weight * s1
        logs[i] = now
        if now > best:
            best, heaviest = now, i
    return heaviest


@lean_kernel
def advance(table: FloatArray, particles: int, now: float, after: float, rules: Rules) -> None:
    """(9) for every particle. now, after: the input at this sample and at the next."""
    change = after - now if rules.hold else 0.0
    for i in range(particles):
        if rules.sensed:
            forward_sensed(table[i], now, after, rules.hold)
        elif rules.offsets:
            forward_five(table[i], now, change, rules.q)
        else:
            forward_two(table[i], now, change, rules.q)


@lean_kernel
def prepare(table: FloatArray, particles: int, rules: Rules) -> None:
    """Every particle's coefficients from its θ."""
    for i in range(particles):
        discretise(table[i], rules.step, rules.gravity)


@lean_kernel
def begin(table: FloatArray, particles: int, start: Start, first: int, rules: Rules) -> None:
    """Every particle's first state of a segment."""
    for i in range(particles):
        restart(table[i], start, first, rules.offsets)


@lean_kernel
def note(
    k: int,
    table: FloatArray,
    weights: FloatArray,
    particles: int,
    origin: int,
    totals: tuple[float, float],
    sums: tuple[FloatArray, FloatArray, FloatArray],
    record: Record,
) -> None:
    """Weights to sum one, and row k of the record. totals: sum of weights and of their squares."""
    total, squares = totals
    of, of_squares, innovation = sums
    for i in range(particles):
        weights[i] /= total
    record.particles[k] = particles
    record.effective[k] = total * total / squares
    for j in range(len(of)):
        mean = of[j] / total
        variance = max(of_squares[j] / total - mean * mean, 0.0)
        if j < 3:
            record.mean[k, j] = table[origin, j] + mean
            record.std[k, j] = np.sqrt(variance)
        else:
            record.state[k, j - 3] = table[origin, STATE + j - 3] + mean
            record.state_std[k, j - 3] = np.sqrt(variance)
    for j in range(2):
        record.innovation[k, j] = innovation[2 * j]
        record.innovation_std[k, j] = np.sqrt(innovation[2 * j + 1])


@lean_kernel
def keep(
    at: int, table: FloatArray, weights: FloatArray, particles: int, kept: FloatArray, counts: IntArray
) -> None:
    """Keep the cloud as snapshot `at`."""
    counts[at] = particles
    for i in range(particles):
        for j in range(6):
            kept[at, i, j] = table[i, j]
        kept[at, i, 6] = weights[i]


@kernel
def weigh_sample(
    k: int,
    table: FloatArray,
    logs: FloatArray,
    weights: FloatArray,
    particles: int,
    start: Start,
    y: FloatArray,
    rules: Rules,
    work: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    record: Record,
) -> tuple[float, int]:
    """Lines 2-6 and row k of the record. Returns the sum of squared weights (sum one), and 1 where all weight was lost."""
    of, of_squares, innovation, bins = work
    heaviest, lost = measure(table, logs, weights, particles, y, rules, innovation), 0
    if heaviest < 0:
        lost, heaviest = 1, 0
        begin(table, particles, start, 1, rules)
        logs[:particles] = 0.0
    states = len(of) - 3
    total, squares = weigh(table, logs, particles, STATE, states, heaviest, weights, of, of_squares)
    evidence = logs[heaviest] + np.log(total)
    record.log_likelihood[k] = -np.inf if lost else evidence
    note(k, table, weights, particles, heaviest, (total, squares), (of, of_squares, innovation), record)
    for i in range(particles):
        logs[i] -= evidence
    if rules.every > 0 and k % rules.every == 0:
        quantiles(table, weights, particles, record.mean[k], record.std[k], LEVELS, bins, record.quantiles[k])
    return squares / (total * total), lost


@kernel
def run(
    rng: np.random.Generator,
    signals: Signals,
    start: Start,
    rules: Rules,
    tables: tuple[FloatArray, FloatArray],
    weights: FloatArray,
    particles: int,
    record: Record,
) -> tuple[int, int, int]:
    """Algorithm 2. tables: two of (most, width), θ of the prior in the first. weights: (most,), sum one over the prior.

    Returns how many particles there are at the end, samples at which all weight was lost, and which table holds them.
    """
    table, spare = tables
    holds, lost, kept = 0, 0, 0
    states = 5 if rules.offsets else 2
    logs = np.empty(table.shape[0])
    for i in range(particles):
        logs[i] = np.log(weights[i]) if weights[i] > 0.0 else -np.inf
    work = (np.zeros(3 + states), np.zeros(3 + states), np.zeros(4), np.zeros((3, 400)))
    prepare(table, particles, rules)
    walks = signals.walk[0] > 0.0 or signals.walk[1] > 0.0 or signals.walk[2] > 0.0
    for segment in range(len(signals.starts)):
        stop = signals.stops[segment]
        begin(table, particles, start, 1 if segment == 0 else 0, rules)
        for k in range(signals.starts[segment], stop):
            squares, none = weigh_sample(
                k, table, logs, weights, particles, start, signals.y[k], rules, work, record
            )
            lost += none
            if kept < len(signals.keep) and signals.keep[kept] == k:
                keep(kept, table, weights, particles, record.kept, record.kept_count)
                kept += 1
            record.survivors[k] = 0
            if rules.threshold >= 1.0 or squares * rules.threshold * particles > 1.0:
                size = rules.fixed if rules.fixed > 0 else particles
                if rules.adaptive:
                    size = wanted_size(rules.wanted, particles, squares, rules.most)
                cloud = (np.zeros(0), np.zeros((0, 0)), False)
                if rules.kernel > 0.0:
                    cloud = cloud_root(table, weights, particles, states, rules.mirror)
                record.survivors[k] = resample(table, weights, particles, spare, size, rng.random())
                table, spare, holds, particles = spare, table, 1 - holds, size
                weights[:size] = 1.0 / size
                logs[:size] = -np.log(size)
                if rules.kernel > 0.0:
                    smooth(rng, table, particles, cloud, rules.kernel, rules.mirror)
                    prepare(table, particles, rules)
            if k + 1 == stop:
                continue
            if walks:
                walk(rng, table, particles, signals.walk, rules.mirror)
                prepare(table, particles, rules)
            advance(table, particles, signals.accel[k], signals.accel[k + 1], rules)
    return particles, lost, holds
