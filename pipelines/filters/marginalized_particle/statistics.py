"""What a weighted cloud says at one sample: means, standard deviations, quantiles."""

from __future__ import annotations

from parsers.channels import FloatArray, IntArray
from parsers.jit import lean_kernel, vector_kernel
from pipelines.filters.lanes import LANES, LOWEST, exp, floor
from pipelines.filters.marginalized_particle.layout import LOG, STATE, WEIGHT, D, H, K

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
def _bins_of(row: FloatArray, column: int, low: float, per: float, places: IntArray) -> None:
    """Which bin each lane falls into, into places from `column` on; the bins of the columns follow each other."""
    first = column // LANES * BINS
    for i in range(LANES):
        place = (row[column + i] - low) * per
        # of what is no number both comparisons are false
        place = place if place > 0.0 else 0.0
        places[column + i] = first + floor(place if place < BINS - 1.0 else BINS - 1.0)


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
            _bins_of(row, j * LANES, mean[j] - REACH * std[j], per, places)
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
def weigh(row: FloatArray, best: float, origin: FloatArray, sums: FloatArray) -> None:
    """A tile's weights over the heaviest's, not yet of sum one, and K, D, h as differences from the heaviest particle's.

    origin: of `origin_of`. sums: (2 x 3 + 2 rows of LANES,), added to lane by lane: weights, their squares, then of each column its
    weighted differences and their weighted squares.
    """
    for i in range(LANES):
        at = row[LOG + i]
        weight = exp(at - best) if at > best + LOWEST else 0.0
        row[WEIGHT + i] = weight
        sums[i] += weight
        sums[LANES + i] += weight * weight
        live = weight > 0.0
        stiffness = row[K + i] - origin[0] if live else 0.0
        damping = row[D + i] - origin[1] if live else 0.0
        height = row[H + i] - origin[2] if live else 0.0
        sums[2 * LANES + i] += weight * stiffness
        sums[3 * LANES + i] += weight * stiffness * stiffness
        sums[4 * LANES + i] += weight * damping
        sums[5 * LANES + i] += weight * damping * damping
        sums[6 * LANES + i] += weight * height
        sums[7 * LANES + i] += weight * height * height


@vector_kernel
def weigh_states(row: FloatArray, states: int, origin: FloatArray, sums: FloatArray) -> None:
    """As `weigh`, of the state's means, with the variance that each particle's own covariance adds. sums: behind those of `weigh`."""
    own = STATE + states * LANES
    for j in range(states):
        for i in range(LANES):
            weight = row[WEIGHT + i]
            live = weight > 0.0
            off = row[STATE + j * LANES + i] - origin[3 + j] if live else 0.0
            variance = row[own + i] if live else 0.0
            sums[(8 + 2 * j) * LANES + i] += weight * off
            sums[(9 + 2 * j) * LANES + i] += weight * (off * off + variance)
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
