"""A slow, plain reference for posteriors: many chains of adaptive random-walk Metropolis, with a check that they agree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.joint.gaussianity import LogDensity
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


def run_chains(
    log_density: LogDensity,
    starts: FloatArray,
    covariance: FloatArray,
    rng: np.random.Generator,
    steps: int,
    thin: int = 10,
    burn: float = 0.4,
) -> Chains:
    """Random-walk Metropolis of all chains at once from `starts` (chains, k); thin: steps for one that is kept.

    covariance: (k, k) first shape of the steps; until `burn` of the steps it is that of all chains' last places (Haario,
    Saksman & Tamminen 2001), and the size goes by the accepted share. Nothing is adapted later, so that the chains' draws
    are of the density itself.
    """
    here = starts.copy()
    chains, k = here.shape
    value = log_density(here)
    if not np.all(np.isfinite(value)):
        raise ValueError("a chain starts where the density is nought")
    root, size = np.linalg.cholesky(covariance), 2.4 / np.sqrt(k)
    burning, hits = int(burn * steps), 0
    seen: list[FloatArray] = []
    past: list[FloatArray] = []
    for step in range(steps):
        tried = here + size * rng.standard_normal((chains, k)) @ root.T
        new = log_density(tried)
        with np.errstate(invalid="ignore"):
            good = np.log(rng.random(chains)) < new - value
        here, value = np.where(good[:, None], tried, here), np.where(good, new, value)
        if step < burning:
            size *= float(np.exp((np.mean(good) - ACCEPTED) / (1 + step) ** 0.6))
            past.append(here)
            if step + 1 in (burning // 4, burning // 2, 3 * burning // 4):
                last = np.concatenate(past[len(past) // 2 :])
                spread = np.cov(last.T) + 1e-12 * np.eye(k)
                root, past = np.linalg.cholesky(spread), []
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
