"""Draws from a posterior that is not Gaussian: skewed, bounded, curved, or with several modes.

Sequential Monte Carlo (Del Moral, Doucet & Jasra 2006): points about the modes at a power of the likelihood at which
Gaussians still fit; then the power rises to 1 in steps that keep half of the points counting, with moves after each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.joint.sampling.gaussianity import LogDensity, not_gaussian
from pipelines.joint.sampling.guide import fit_guide, informed_basis
from pipelines.joint.sampling.mixture import Mode, mixture_of, tempered
from pipelines.joint.sampling.modes import find_modes
from pipelines.joint.sampling.moves import Cloud, Counted, jump_move, powered, slice_move
from pipelines.joint.sampling.start import begin, kish, normalised, resampled
from pipelines.results import FloatArray

__all__ = ["Drawn", "LogDensity", "find_modes", "no_narrower", "not_gaussian", "sample"]

POINTS = 1000
ROWS = 400_000
"""Rows of the density that may be asked for; once spent, each step makes the least moves."""

FORGOTTEN = 0.4
"""Correlation of the points with themselves before the moves, in the slowest direction, at which the moves are enough."""

LEAST_MOVES, STEP_MOVES, LAST_MOVES = 5, 8, 20
"""Moves a step: at least (the guide is learned from the points: one move would leave their chance errors), at most."""
STARTS = 8
FAR_OUT = 5e-5
"""Power of the likelihood below which the start is far outside: some thirty steps, for each of which there is time for few moves."""


@dataclass(frozen=True)
class Drawn:
    """draws: (n, k), equally likely. effective: how many independent draws they are worth for means and squares along the
    worst known directions, or for the shares of the modes; 0: the density could not be sampled and the draws are the Gaussians'.
    text: how it was done and how good it is, a sentence. power: of the likelihood at which the points began.
    """

    draws: FloatArray
    effective: float
    text: str
    power: float = 1.0

    @property
    def coarse(self) -> bool:
        """Whether the points came from so far outside that they may have lost part of the posterior on their way in."""
        return self.power < FAR_OUT


def no_narrower(column: FloatArray, spread: float) -> FloatArray:
    """(n,) draws of a parameter, stretched about their mean where they scatter less than `spread`."""
    middle, own = float(column.mean()), float(column.std())
    return column if own >= spread else np.asarray(middle + spread / max(own, 1e-300) * (column - middle))


def sample(
    log_density: LogDensity, modes: Sequence[Mode], rng: np.random.Generator, count: int = 2000
) -> Drawn:
    """`count` draws of exp(log_density).

    modes: (k,) place and (k, k) covariance of Gaussian approximations, one or more; their shares are found here. Given one
    only, others are looked for. About 50,000 rows of the density where the modes fit well; from 400,000 on it makes haste.
    """
    density = Counted(log_density)
    given = len(modes)
    if given == 1:
        modes = with_others(density, modes[0], rng)
    points = int(np.clip(count, 200, POINTS))
    start = begin(density, modes, points, rng)
    if start is None:
        draws = mixture_of(np.ones(len(modes)), modes).draw(count, rng)
        return Drawn(draws, 0.0, "not sampled: the density is nought all about its modes")
    cloud, power, steps = start.cloud, start.power, 0
    while True:
        last = power >= 1.0
        cloud, seen = _move(density, modes, power, cloud, rng, -(-count // points) if last else 0)
        if last:
            break
        power, cloud = _hotter(power, cloud, rng)
        steps += 1
    effective, shares = _effective(density, modes, seen, cloud.root)
    draws = np.concatenate(seen)[rng.permutation(points * len(seen))[:count]]
    effective = min(effective, float(count))
    text = _text(start.power, steps, points, len(modes), given, shares, effective, count)
    return Drawn(draws, effective, text, start.power)


def with_others(density: LogDensity, mode: Mode, rng: np.random.Generator) -> list[Mode]:
    """The mode, and others that climbs from likely draws of the prior find."""
    k = mode[0].size
    u = rng.standard_normal((POINTS, k))
    value = density(u)
    likelihood = value + 0.5 * np.einsum("nk,nk->n", u, u)
    power = 1.0
    weight = normalised(likelihood)
    while power > 1e-9 and kish(weight) < 3 * STARTS:
        power *= 0.5
        weight = normalised(power * likelihood)
    if not np.any(weight):
        return [mode]
    starts = u[np.unique(resampled(weight, STARTS, rng))]
    own = np.linalg.inv(mode[1])
    found = []
    for place, covariance in find_modes(density, starts, mode[1]):
        off = place - mode[0]
        if min(off @ own @ off, off @ np.linalg.solve(covariance, off)) > 16.0:
            found.append((place, covariance))
    return [mode, *found]


def _hotter(power: float, cloud: Cloud, rng: np.random.Generator) -> tuple[float, Cloud]:
    """The next power, at which half of the points count, and the points resampled for it."""
    likelihood = powered(cloud.u, cloud.value, 1.0) - powered(cloud.u, cloud.value, 0.0)
    n = cloud.value.size
    low, high = power, 1.0
    if kish(normalised((1.0 - power) * likelihood)) < 0.5 * n:
        for _ in range(40):
            middle = 0.5 * (low + high)
            if kish(normalised((middle - power) * likelihood)) < 0.5 * n:
                high = middle
            else:
                low = middle
    index = resampled(normalised((high - power) * likelihood), n, rng)
    return high, cloud.rows(index)


def _move(
    density: Counted,
    modes: Sequence[Mode],
    power: float,
    cloud: Cloud,
    rng: np.random.Generator,
    keep: int,
) -> tuple[Cloud, list[FloatArray]]:
    """Moves until the points have forgotten where they were, and that `keep` times more with a look each."""
    basis, informed = informed_basis(density, modes, cloud, power, rng)
    guide = fit_guide(basis, informed, cloud, [tempered(mode, power) for mode in modes])
    seen: list[FloatArray] = []
    before, moves = cloud, 0
    most = LAST_MOVES if keep else STEP_MOVES
    while True:
        cloud = slice_move(density, guide, power, cloud, rng)
        if guide.inner.weight.size > 1:
            cloud = jump_move(density, guide, power, cloud, rng)
        moves += 1
        if moves < LEAST_MOVES and (density.count < ROWS or moves < 2):
            continue
        done = moves >= most or density.count > ROWS
        if done or _correlation(before, cloud, basis[:, :informed]) < FORGOTTEN:
            if len(seen) < keep:
                seen.append(cloud.u)
            if len(seen) >= keep:
                return cloud, seen
            before, moves = cloud, 0


def _correlation(before: Cloud, after: Cloud, directions: FloatArray) -> float:
    """Of the points' places before and after, along that principal axis of the informed ones (k, d) where it is most."""
    a, b = before.u @ directions, after.u @ directions
    _, axes = np.linalg.eigh(np.atleast_2d(np.cov(a.T)))
    a, b = a @ axes, b @ axes
    spread = np.var(a, axis=0) + np.var(b, axis=0)
    return float(np.max(1 - np.mean((a - b) ** 2, axis=0) / np.maximum(spread, 1e-300)))


def _effective(
    density: LogDensity, modes: Sequence[Mode], seen: Sequence[FloatArray], root: np.ndarray
) -> tuple[float, FloatArray]:
    """Effective number, and the modes' shares (m,).

    The error of a mean is that of sums over points with one ancestor (Chan & Lai 2013): points that resampling copied
    and the moves have not parted yet count as one. Of the means and squares along all directions the worst twentieth, and
    the modes' shares.
    """
    pooled = np.concatenate(seen)
    size, basis = np.linalg.eigh(np.cov(pooled.T))
    near = mixture_of(np.ones(len(modes)), modes)
    labels = [np.argmax(near.each(u), axis=1)[:, None] == np.arange(len(modes)) for u in seen]
    centred = [(u - pooled.mean(axis=0)) @ basis / np.sqrt(np.maximum(size, 1e-300)) for u in seen]
    tests = [np.hstack([z, z**2, own]) for z, own in zip(centred, labels, strict=True)]
    everything = np.concatenate(tests)
    centre, spread = everything.mean(axis=0), everything.var(axis=0)
    off = np.mean(tests, axis=0) - centre
    families = np.zeros((int(root.max()) + 1, off.shape[1]))
    np.add.at(families, root, off)
    error = np.sum(families**2, axis=0) / off.shape[0] ** 2
    known = spread > 1e-12
    number = np.where(known, spread / np.maximum(error, 1e-300), np.inf)
    k = 2 * size.size
    return float(min(np.quantile(number[:k], 0.05), number[k:].min())), centre[k:]


def _text(
    power: float,
    steps: int,
    points: int,
    modes: int,
    given: int,
    shares: FloatArray,
    effective: float,
    count: int,
) -> str:
    how = f"sampled by sequential Monte Carlo with {points} points"
    if steps:
        how += f" from the likelihood to the power {power:.2g} in {steps} steps"
    if modes > 1:
        found = "" if given == modes else f", {modes - given} found by a search"
        how += f", from {modes} modes{found} (shares {', '.join(f'{s:.2f}' for s in shares)})"
    return f"{how}: {count} draws worth about {effective:.0f} independent ones"
