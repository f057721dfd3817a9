"""What a weighted cloud says at one sample: means, standard deviations, quantiles."""

from __future__ import annotations

from parsers.channels import FloatArray, IntArray
from parsers.jit import lean_kernel, summing_kernel, vector_kernel
from pipelines.filters.lanes import LANES, LOWEST, exp, floor
from pipelines.filters.marginalized_particle.layout import LOG, STATE, WEIGHT

BINS = 400
REACH = 5.0
"""The quantiles' bins cover the mean -+ REACH standard deviations: a quantile is good to about a hundredth of one."""


@lean_kernel
def _from_bins(
    bins: FloatArray, first: int, low: float, wide: float, levels: tuple[float, float, float], out: FloatArray
) -> None:
    """Quantiles by straight lines through the sums (of sum one) of BINS bins from `first` on."""
    total, level = 0.0, 0
    for b in range(BINS):
        before = total
        total += bins[first + b]
        while level < 3 and (total >= levels[level] or b == BINS - 1):
            part = (levels[level] - before) / bins[first + b] if bins[first + b] > 0.0 else 0.0
            out[level] = low + wide * (b + min(max(part, 0.0), 1.0))
            level += 1


@vector_kernel
def _bins_of(values: FloatArray, low: float, per: float, first: int, places: IntArray) -> None:
    """Which bin each lane falls into, of those from `first` on. values, places: (LANES,)."""
    for i in range(LANES):
        place = (values[i] - low) * per
        # of what is no number both comparisons are false
        place = place if place > 0.0 else 0.0
        places[i] = first + floor(place if place < BINS - 1.0 else BINS - 1.0)


@lean_kernel
def quantiles(
    table: FloatArray,
    tiles: int,
    over: float,
    mean: FloatArray,
    std: FloatArray,
    levels: tuple[float, float, float],
    work: tuple[FloatArray, IntArray],
    out: FloatArray,
) -> None:
    """Weighted quantiles of K, D, h into out (3, 3). over: what makes the table's weights have sum one.

    work: (3 x BINS,) and (3 x LANES,), overwritten.
    """
    bins, places = work
    scale = BINS / (2.0 * REACH)
    for b in range(3 * BINS):
        bins[b] = 0.0
    for tile in range(tiles):
        row = table[tile]
        for j in range(3):
            per = scale / std[j] if std[j] > 0.0 else 0.0
            lanes = slice(j * LANES, (j + 1) * LANES)
            _bins_of(row[lanes], mean[j] - REACH * std[j], per, j * BINS, places[lanes])
        for i in range(LANES):
            weight = row[WEIGHT + i]
            bins[places[i]] += weight
            bins[places[LANES + i]] += weight
            bins[places[2 * LANES + i]] += weight
    for b in range(3 * BINS):
        bins[b] *= over
    for j in range(3):
        _from_bins(bins, j * BINS, mean[j] - REACH * std[j], std[j] / scale, levels, out[j])


@vector_kernel
def lighten(row: FloatArray, best: float) -> None:
    """A tile's weights over the heaviest's."""
    for i in range(LANES):
        at = row[LOG + i]
        row[WEIGHT + i] = exp(at - best) if at > best + LOWEST else 0.0


@summing_kernel
def add_up(row: FloatArray, states: int, origin: FloatArray, sums: FloatArray) -> None:
    """Add a tile to sums (2 + 2 (3 + states),): its weights, their squares, and of K, D, h and the state's means the weighted
    differences from origin (3 + states,) and their weighted squares; to a state's also the variance that each particle has itself.
    """
    total, squares = 0.0, 0.0
    for i in range(LANES):
        total += row[WEIGHT + i]
        squares += row[WEIGHT + i] * row[WEIGHT + i]
    sums[0] += total
    sums[1] += squares
    for j in range(3):
        first, second, start = 0.0, 0.0, origin[j]
        for i in range(LANES):
            weight = row[WEIGHT + i]
            # a lane of no weight may hold anything
            off = row[j * LANES + i] - start if weight > 0.0 else 0.0
            first += weight * off
            second += weight * off * off
        sums[2 + 2 * j] += first
        sums[3 + 2 * j] += second
    own = STATE + states * LANES
    for j in range(states):
        first, second, start = 0.0, 0.0, origin[3 + j]
        for i in range(LANES):
            weight = row[WEIGHT + i]
            off = row[STATE + j * LANES + i] - start if weight > 0.0 else 0.0
            variance = row[own + i] if weight > 0.0 else 0.0
            first += weight * off
            second += weight * (off * off + variance)
        sums[8 + 2 * j] += first
        sums[9 + 2 * j] += second
        own += (states - j) * LANES


@lean_kernel
def origin_of(table: FloatArray, particle: int, states: int, origin: FloatArray) -> None:
    """K, D, h and the states of one particle into origin (3 + states,)."""
    row, i = table[particle // LANES], particle % LANES
    for j in range(3):
        origin[j] = row[j * LANES + i]
    for j in range(states):
        origin[3 + j] = row[STATE + j * LANES + i]


@lean_kernel
def sum_of(lanes: FloatArray, at: int) -> float:
    """Of LANES numbers from place at x LANES on."""
    total = 0.0
    for i in range(LANES):
        total += lanes[at * LANES + i]
    return total
