"""First points for sampling: from the modes, with the likelihood softened until they match the density there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.joint.sampling.gaussianity import LogDensity
from pipelines.joint.sampling.mixture import Mixture, Mode, mixture_of, tempered
from pipelines.joint.sampling.moves import Cloud, powered
from pipelines.results import FloatArray

POWERS = (1.0, 0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6)
"""Of the likelihood; at the last the density is nearly the prior, of which draws are exact."""

ENOUGH = 0.5
"""Share of the draws that count, from which on a power will do."""

MARGIN = 2
"""Powers to go on down from there: the draws do not see the ends of a curved ridge that they do not reach."""

TRIED = 1000
BATCHES = 8


@dataclass(frozen=True)
class Start:
    """Equally likely points at a power of the likelihood. share: of the first draws that counted (0-1)."""

    cloud: Cloud
    power: float
    share: float


def normalised(log_weight: FloatArray) -> FloatArray:
    """(n,) weights of sum 1; all 0 where every log weight is -inf."""
    top = float(np.max(log_weight))
    if not np.isfinite(top):
        return np.zeros(log_weight.size)
    weight = np.exp(log_weight - top)
    return np.asarray(weight / np.sum(weight))


def kish(weight: FloatArray) -> float:
    """Kish's number for weights of sum 1; 0 for none."""
    total = float(np.sum(weight**2))
    return 1 / total if total > 0 else 0.0


def resampled(weight: FloatArray, count: int, rng: np.random.Generator) -> np.ndarray:
    """(count,) systematic resampling for weights of sum 1."""
    edges = np.cumsum(weight)
    at = (np.arange(count) + rng.random()) / count
    index = np.searchsorted(edges, at * edges[-1], side="right")
    return np.asarray(np.minimum(index, weight.size - 1))


def around(density: LogDensity, modes: Sequence[Mode], power: float) -> Mixture:
    """Gaussians about the modes at a power of the likelihood, and wider ones with its 0.4th power, for the tails.

    Half of the weights go by height and volume, half are equal: a mode that seems small must not be missed.
    """
    near = [tempered(mode, power) for mode in modes]
    wide = [tempered(mode, 0.4 * power) for mode in modes]
    places = np.array([place for place, _ in modes])
    height = powered(places, density(places), power)
    volume = np.array([0.5 * np.linalg.slogdet(cov)[1] for _, cov in near])
    weight = 0.5 * normalised(height + volume) + 0.5 / len(modes)
    return mixture_of(np.concatenate([0.75 * weight, 0.25 * weight]), near + wide)


def begin(density: LogDensity, modes: Sequence[Mode], count: int, rng: np.random.Generator) -> Start | None:
    """`count` points at the highest power at which enough draws count, by importance resampling; None: none counts."""
    power, share = _power(density, modes, rng)
    batches = [_draws(density, modes, power, count, rng)]
    while len(batches) < BATCHES and _counting(batches) < ENOUGH * count:
        batches.append(_draws(density, modes, power, count, rng))
    u, value, log_weight = (np.concatenate(column) for column in zip(*batches, strict=True))
    weight = normalised(log_weight)
    if not np.any(weight):
        return None
    index = resampled(weight, count, rng)
    return Start(Cloud(u[index], value[index], index), power, share)


def _power(density: LogDensity, modes: Sequence[Mode], rng: np.random.Generator) -> tuple[float, float]:
    """The power to start at, and the share of draws that count where the search for it ended."""
    shares: list[float] = []
    for candidate in POWERS:
        shares.append(kish(normalised(_draws(density, modes, candidate, TRIED, rng)[2])) / TRIED)
        if shares[-1] > ENOUGH:
            break
    best = min(int(np.argmax(shares)) + MARGIN, len(POWERS) - 1)
    return POWERS[best], max(shares)


def _counting(batches: Sequence[tuple[FloatArray, FloatArray, FloatArray]]) -> float:
    return kish(normalised(np.concatenate([log_weight for _, _, log_weight in batches])))


def _draws(
    density: LogDensity, modes: Sequence[Mode], power: float, count: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Draws about the modes (count, k), their log density and their log weight at a power of the likelihood."""
    mixture = around(density, modes, power)
    u = mixture.draw(count, rng)
    value = density(u)
    return u, value, powered(u, value, power) - mixture.log(u)
