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
from parsers.jit import kernel, lean_kernel
from pipelines.filters.marginalized_particle.layout import STATE, THETA

LEANS = 1.6
"""A half normal distribution, which lies at the line, has 1.32."""

SIDE = 2
"""Which coordinate changes its sign in the mirror."""


@lean_kernel
def to_coordinates(row: FloatArray, out: FloatArray) -> None:
    """Coordinates of θ, and after them the states, into out (6 + states,)."""
    height = row[2]
    out[0], out[1] = np.log(row[0] / height), np.log(row[1] / height)
    out[2] = np.log(height) - 0.5 * np.log(row[4] / row[3])
    out[3], out[4], out[5] = np.log(row[3]), np.log(row[4]), row[5]
    for j in range(THETA, len(out)):
        out[j] = row[STATE + j - THETA]


@lean_kernel
def from_coordinates(values: FloatArray, row: FloatArray) -> None:
    """The way back."""
    mass, inertia = np.exp(values[3]), np.exp(values[4])
    height = np.exp(values[2]) * np.sqrt(inertia / mass)
    row[0], row[1], row[2] = np.exp(values[0]) * height, np.exp(values[1]) * height, height
    row[3], row[4], row[5] = mass, inertia, values[5]
    for j in range(THETA, len(values)):
        row[STATE + j - THETA] = values[j]


@kernel
def _moments(
    table: FloatArray, weights: FloatArray, particles: int, states: int
) -> tuple[FloatArray, FloatArray]:
    """Weighted mean and covariance (weights' sum one) of coordinates and states; what has no weight may be anything."""
    size = THETA + states
    mean, covariance, at = np.zeros(size), np.zeros((size, size)), np.zeros(size)
    for i in range(particles):
        if weights[i] > 0.0:
            to_coordinates(table[i], at)
            for j in range(size):
                mean[j] += weights[i] * at[j]
    for i in range(particles):
        if weights[i] > 0.0:
            to_coordinates(table[i], at)
            for j in range(size):
                part = weights[i] * (at[j] - mean[j])
                for m in range(min(j + 1, THETA)):
                    covariance[j, m] += part * (at[m] - mean[m])
    return mean, covariance


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
    table: FloatArray, weights: FloatArray, particles: int, states: int, mirror: int
) -> tuple[FloatArray, FloatArray, bool]:
    """Mean (6 + states,), root (6 + states, 6) and whether unfolded: what `smooth` needs, from the cloud before resampling."""
    mean, covariance = _moments(table, weights, particles, states)
    unfolded = _unfold(mean, covariance) if mirror else False
    return mean, _root(covariance), unfolded


@kernel
def smooth(
    rng: np.random.Generator,
    table: FloatArray,
    particles: int,
    cloud: tuple[FloatArray, FloatArray, bool],
    width: float,
    mirror: int,
) -> None:
    """Move each particle's θ, and its states with it. cloud: of `cloud_root`. width: b."""
    mean, root, unfolded = cloud
    size = root.shape[0]
    shrink = 1.0 - np.sqrt(1.0 - width * width)
    step, at = np.zeros(THETA), np.zeros(size)
    for i in range(particles):
        to_coordinates(table[i], at)
        if unfolded and rng.random() < 0.5:
            at[SIDE] = -at[SIDE]
        for j in range(THETA):
            step[j] = 0.0
            if root[j, j] > 0.0:
                left = at[j] - mean[j]
                for m in range(j):
                    left -= root[j, m] * step[m]
                step[j] = left / root[j, j]
        for j in range(THETA):
            step[j] *= -shrink
            if root[j, j] > 0.0:
                step[j] += width * rng.standard_normal()
        for j in range(size):
            for m in range(min(j + 1, THETA)):
                at[j] += root[j, m] * step[m]
        if mirror:
            at[SIDE] = abs(at[SIDE])
        from_coordinates(at, table[i])


@lean_kernel
def reflect(row: FloatArray, mirror: int) -> None:
    """Bring a particle back that walked out: K, D, h positive, and with `mirror` h as far above sqrt(I_x / m) as it was below."""
    for column in range(3):
        row[column] = abs(row[column])
    if mirror:
        least = np.sqrt(row[4] / row[3])
        if row[2] < least:
            row[2] = 2.0 * least - row[2]


@lean_kernel
def walk(
    rng: np.random.Generator, table: FloatArray, particles: int, spread: FloatArray, mirror: int
) -> None:
    """(3): add spread (3,) times normal draws to K, D, h."""
    for i in range(particles):
        row = table[i]
        for j in range(3):
            row[j] += spread[j] * rng.standard_normal()
        reflect(row, mirror)
