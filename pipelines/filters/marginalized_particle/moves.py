"""How particles move in θ: the random walk (3), or Liu and West's smoothed move, which keeps mean and covariance.

The smoothed move shrinks each particle towards the mean by a = sqrt(1 - b²) and adds b times a draw of the cloud's own
covariance (Liu and West, Combined parameter and state estimation in simulation-based filtering, 2001). It is made in

    log(K / h), log(D / h), log(h / h*), log m, log I_x, z       with h* = sqrt(I_x / m)

where everything stays positive, what the roll fixes well stands apart from what it fixes badly, and the mirror image of a
particle differs in one sign only. Above the mirror line a cloud that leans on it (mean of log(h / h*) below LEANS standard
deviations) would be pushed off it by every move; it is unfolded first, each particle to one of its two images, which are
equally likely and have the same roll, and folded back afterwards.

A particle's state is that of its old θ; it follows θ by the cloud's regression of the states on θ, or a sensor's offset, which
no measurement refreshes quickly, would go on belonging to a θ that is no longer there.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray
from parsers.jit import kernel, lean_kernel, vector_kernel
from pipelines.filters.lanes import LANES, RandomState, exp, log, random_bits, two_normals
from pipelines.filters.marginalized_particle.layout import I_X, STATE, THETA, WEIGHT, D, H, K, M, Z
from pipelines.filters.marginalized_particle.statistics import sum_of

LEANS = 1.6
"""A half normal distribution, which lies at the line, has 1.32."""

SIDE = 2
"""Which coordinate changes its sign in the mirror."""


@vector_kernel
def to_coordinates(row: FloatArray, states: int, out: FloatArray) -> None:
    """Coordinates of a tile's θ, and after them the states, into out ((6 + states) x LANES,)."""
    for i in range(LANES):
        height, mass, inertia = log(row[H + i]), log(row[M + i]), log(row[I_X + i])
        out[K + i] = log(row[K + i]) - height
        out[D + i] = log(row[D + i]) - height
        out[H + i] = height - 0.5 * (inertia - mass)
        out[M + i], out[I_X + i], out[Z + i] = mass, inertia, row[Z + i]
    for i in range(states * LANES):
        out[THETA * LANES + i] = row[STATE + i]


@vector_kernel
def from_coordinates(values: FloatArray, states: int, row: FloatArray) -> None:
    """The way back."""
    for i in range(LANES):
        mass, inertia = exp(values[M + i]), exp(values[I_X + i])
        height = exp(values[H + i]) * np.sqrt(inertia / mass)
        row[K + i], row[D + i] = exp(values[K + i]) * height, exp(values[D + i]) * height
        row[H + i], row[M + i], row[I_X + i], row[Z + i] = height, mass, inertia, values[Z + i]
    for i in range(states * LANES):
        row[STATE + i] = values[THETA * LANES + i]


@vector_kernel
def _add_moments(
    row: FloatArray, size: int, origin: FloatArray, at: FloatArray, first: FloatArray, second: FloatArray
) -> None:
    """Add a tile's weighted differences from origin (size,), and their products, lane by lane.

    at: coordinates (size x LANES,), overwritten. first: (size x LANES,). second: (size x 6 x LANES,), of which the lower half is used.
    """
    for j in range(size):
        for i in range(LANES):
            weight = row[WEIGHT + i]
            off = at[j * LANES + i] - origin[j] if weight > 0.0 else 0.0
            at[j * LANES + i] = off
            first[j * LANES + i] += weight * off
    for j in range(size):
        for m in range(min(j + 1, THETA)):
            to = (j * THETA + m) * LANES
            for i in range(LANES):
                second[to + i] += row[WEIGHT + i] * at[j * LANES + i] * at[m * LANES + i]


@kernel
def _moments(
    table: FloatArray, particles: int, over: float, heaviest: int, states: int
) -> tuple[FloatArray, FloatArray]:
    """Weighted mean and covariance of coordinates and states; what has no weight may be anything. over: what makes the weights'
    sum one."""
    size = THETA + states
    at, origin = np.zeros(size * LANES), np.zeros(size)
    first, second = np.zeros(size * LANES), np.zeros(size * THETA * LANES)
    to_coordinates(table[heaviest // LANES], states, at)
    for j in range(size):
        origin[j] = at[j * LANES + heaviest % LANES]
    for tile in range(-(-particles // LANES)):
        to_coordinates(table[tile], states, at)
        _add_moments(table[tile], size, origin, at, first, second)
    mean, covariance = np.zeros(size), np.zeros((size, size))
    for j in range(size):
        mean[j] = over * sum_of(first, j)
    for j in range(size):
        for m in range(min(j + 1, THETA)):
            covariance[j, m] = over * sum_of(second, j * THETA + m) - mean[j] * mean[m]
    return mean + origin, covariance


@kernel
def _unfold(mean: FloatArray, covariance: FloatArray) -> bool:
    """If the cloud leans on the mirror line: moments of both images together, half each. Says whether."""
    spread = covariance[SIDE, SIDE]
    if spread <= 0.0 or mean[SIDE] * mean[SIDE] > LEANS * LEANS * spread:
        return False
    covariance[SIDE, SIDE] += mean[SIDE] * mean[SIDE]
    mean[SIDE] = 0.0
    covariance[SIDE, :SIDE] = 0.0
    covariance[SIDE + 1 :, SIDE] = 0.0
    return True


@kernel
def _root(covariance: FloatArray) -> FloatArray:
    """Lower (size, 6) root: of the coordinates' covariance; below it the states' covariance with them times its inverse transpose.

    A coordinate that does not vary, or only with those before it, gets a root of zero.
    """
    size = covariance.shape[0]
    root = np.zeros((size, THETA))
    for j in range(THETA):
        left = covariance[j, j]
        for m in range(j):
            left -= root[j, m] * root[j, m]
        if left <= 1e-10 * covariance[j, j] or left <= 1e-20:
            continue
        root[j, j] = np.sqrt(left)
        for i in range(j + 1, size):
            total = covariance[i, j]
            for m in range(j):
                total -= root[i, m] * root[j, m]
            root[i, j] = total / root[j, j]
    return root


@kernel
def cloud_root(
    table: FloatArray, particles: int, over: float, heaviest: int, states: int, mirror: int
) -> tuple[FloatArray, FloatArray, bool]:
    """Mean (6 + states,), root (6 + states, 6) and whether unfolded: what `smooth` needs, from the cloud before resampling.

    over: what makes the weights' sum one. heaviest: the heaviest particle."""
    mean, covariance = _moments(table, particles, over, heaviest, states)
    unfolded = _unfold(mean, covariance) if mirror else False
    return mean, _root(covariance), unfolded


@vector_kernel
def _whiten(at: FloatArray, step: FloatArray, mean: FloatArray, root: FloatArray) -> None:
    """Coordinates' differences from the mean, in the root's independent directions (6 x LANES,)."""
    for j in range(THETA):
        for i in range(LANES):
            step[j * LANES + i] = at[j * LANES + i] - mean[j]
        for m in range(j):
            share = root[j, m]
            for i in range(LANES):
                step[j * LANES + i] -= share * step[m * LANES + i]
        over = 1.0 / root[j, j] if root[j, j] > 0.0 else 0.0
        for i in range(LANES):
            step[j * LANES + i] *= over


@vector_kernel
def _fold(state: RandomState, at: FloatArray) -> None:
    """Each lane's image or itself, one as likely as the other."""
    for i in range(LANES):
        turned = random_bits(state, i) >> np.uint64(63) == np.uint64(0)
        at[H + i] = -at[H + i] if turned else at[H + i]


@vector_kernel
def _draw(state: RandomState, step: FloatArray, shrink: float, width: float) -> None:
    """From where each lane stands to how it moves: back by `shrink`, and by `width` anywhere."""
    for j in range(0, THETA, 2):
        for i in range(LANES):
            one, two = two_normals(state, i)
            here, there = j * LANES + i, (j + 1) * LANES + i
            step[here] = width * one - shrink * step[here]
            step[there] = width * two - shrink * step[there]


@vector_kernel
def _go(at: FloatArray, step: FloatArray, root: FloatArray, mirror: int) -> None:
    """Move coordinates and states."""
    for j in range(root.shape[0]):
        for m in range(min(j + 1, THETA)):
            share = root[j, m]
            for i in range(LANES):
                at[j * LANES + i] += share * step[m * LANES + i]
    if mirror:
        for i in range(LANES):
            at[H + i] = abs(at[H + i])


@lean_kernel
def smooth(
    state: RandomState,
    row: FloatArray,
    cloud: tuple[FloatArray, FloatArray, bool],
    width: float,
    mirror: int,
    work: tuple[FloatArray, FloatArray],
) -> None:
    """Move each θ of a tile, and its states with it. cloud: of `cloud_root`. width: b. work: (6 + states) x LANES and 6 x LANES."""
    mean, root, unfolded = cloud
    at, step = work
    states = root.shape[0] - THETA
    to_coordinates(row, states, at)
    if unfolded:
        _fold(state, at)
    _whiten(at, step, mean, root)
    _draw(state, step, 1.0 - np.sqrt(1.0 - width * width), width)
    _go(at, step, root, mirror)
    from_coordinates(at, states, row)


@vector_kernel
def walk(state: RandomState, row: FloatArray, spread: tuple[float, float, float], mirror: int) -> None:
    """(3): add spread times normal draws to a tile's K, D, h; a particle that walks out comes back: K, D, h positive, and with
    `mirror` h as far above sqrt(I_x / m) as it was below."""
    for i in range(LANES):
        one, two = two_normals(state, i)
        row[K + i] = abs(row[K + i] + spread[0] * one)
        row[D + i] = abs(row[D + i] + spread[1] * two)
    for i in range(LANES // 2):
        one, two = two_normals(state, i)
        row[H + i] = abs(row[H + i] + spread[2] * one)
        row[H + LANES // 2 + i] = abs(row[H + LANES // 2 + i] + spread[2] * two)
    if mirror:
        for i in range(LANES):
            least = np.sqrt(row[I_X + i] / row[M + i])
            height = row[H + i]
            row[H + i] = 2.0 * least - height if height < least else height
