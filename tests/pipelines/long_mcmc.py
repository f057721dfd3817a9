"""A slow, plain reference for posteriors: many chains of adaptive Metropolis, with a check that they agree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.joint.sampling.gaussianity import LogDensity
from pipelines.results import FloatArray

ACCEPTED = 0.25
"""Share of accepted steps that the step's size is adapted to; 0.234 is best in many dimensions."""


@dataclass(frozen=True)
class Chains:
    """draws: (steps kept, chains, k), without the first part, in which step and covariance adapt; both are fixed after.

    accepted: share of steps.
    """

    draws: FloatArray
    accepted: float

    def flat(self) -> FloatArray:
        """(n, k) all draws."""
        return self.draws.reshape(-1, self.draws.shape[2])


@dataclass(frozen=True)
class Figures:
    """What chains say of a scalar. error_*: Monte-Carlo standard errors, from the scatter between groups of chains.

    r_hat: split R-hat, near 1 where the chains agree. low, high: quantiles 0.025 and 0.975.
    """

    mean: float
    std: float
    low: float
    high: float
    error_mean: float
    error_std: float
    error_low: float
    error_high: float
    r_hat: float


class _Walk:
    """Random-walk Metropolis (`about` False), or steps that turn about a normal distribution and keep it (Neal's, "preconditioned
    Crank-Nicolson"): where the density is nearly normal these are taken whole, in any number of dimensions.

    size: of a step, adapted by the accepted share; a turn is at most a fresh draw.
    """

    def __init__(self, k: int, *, about: bool) -> None:
        self.about, self.size = about, 0.5 if about else 2.4 / np.sqrt(k)

    def tried(
        self, here: FloatArray, mean: FloatArray, root: FloatArray, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray | float]:
        """Where the chains (n, k) may go, and (n,) what the way there is worth beside the density."""
        fresh = rng.standard_normal(here.shape)
        if not self.about:
            return here + self.size * fresh @ root.T, 0.0
        z = np.linalg.solve(root, (here - mean).T).T
        new = np.sqrt(1 - self.size**2) * z + self.size * fresh
        return mean + new @ root.T, 0.5 * np.sum(new**2 - z**2, axis=1)

    def adapt(self, accepted: float, step: int) -> None:
        """Towards the share ACCEPTED."""
        self.size *= float(np.exp((accepted - ACCEPTED) / (1 + step) ** 0.6))
        if self.about:
            self.size = min(self.size, 1.0)


def run_chains(
    log_density: LogDensity,
    starts: FloatArray,
    covariance: FloatArray,
    rng: np.random.Generator,
    steps: int,
    thin: int = 10,
    burn: float = 0.4,
) -> Chains:
    """All chains at once from `starts` (chains, k), both kinds of step in turn; thin: steps for one that is kept.

    covariance: (k, k) about the starts' mean: what the steps turn about, and the first shape of the walk's steps; until `burn` of the steps
    that is the covariance of all chains' last places (Haario, Saksman & Tamminen 2001), and the sizes go by the accepted share. Nothing is
    adapted later, so that the chains' draws are of the density itself.
    """
    here = starts.copy()
    chains, k = here.shape
    value = log_density(here)
    if not np.all(np.isfinite(value)):
        raise ValueError("a chain starts where the density is nought")
    mean, root = here.mean(axis=0), np.linalg.cholesky(covariance)
    shape = root
    walks = (_Walk(k, about=False), _Walk(k, about=True))
    burning, hits = int(burn * steps), 0
    seen: list[FloatArray] = []
    past: list[FloatArray] = []
    for step in range(steps):
        walk = walks[step % 2]
        tried, worth = walk.tried(here, mean, root if walk.about else shape, rng)
        new = log_density(tried)
        with np.errstate(invalid="ignore"):
            good = np.log(rng.random(chains)) < new - value + worth
        here, value = np.where(good[:, None], tried, here), np.where(good, new, value)
        if step < burning:
            walk.adapt(float(np.mean(good)), step)
            past.append(here)
            if step + 1 in (burning // 4, burning // 2, 3 * burning // 4):
                last = np.concatenate(past[len(past) // 2 :])
                shape, past = np.linalg.cholesky(np.cov(last.T) + 1e-12 * np.eye(k)), []
        else:
            hits += int(np.sum(good))
            if step % thin == 0:
                seen.append(here)
    return Chains(np.array(seen), hits / max((steps - burning) * chains, 1))


def figures_of(draws: FloatArray, groups: int = 8) -> Figures:
    """Of a scalar's draws (steps, chains); the chains are put into groups, whose scatter gives the errors."""
    parts = [draws[:, g::groups].ravel() for g in range(groups)]
    stats = np.array([[p.mean(), p.std(), *np.quantile(p, (0.025, 0.975))] for p in parts])
    error = stats.std(axis=0, ddof=1) / np.sqrt(groups)
    low, high = np.quantile(draws, (0.025, 0.975))
    return Figures(
        float(draws.mean()), float(draws.std()), float(low), float(high), *(float(e) for e in error),
        split_r_hat(draws),
    )  # fmt: skip


def split_r_hat(draws: FloatArray) -> float:
    """Gelman & Rubin's ratio, each chain (steps, chains) split in halves."""
    half = draws.shape[0] // 2
    split = np.concatenate([draws[:half], draws[half : 2 * half]], axis=1)
    within = float(np.mean(np.var(split, axis=0, ddof=1)))
    between = float(np.var(np.mean(split, axis=0), ddof=1))
    return float(np.sqrt((within * (half - 1) / half + between) / within))
