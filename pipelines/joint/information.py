"""What a drive taught of each parameter: bits, and the relations that brought them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipelines.evidence import Evidence
from pipelines.joint.posterior import Joint, both_ways, central, find_mode, values_at
from pipelines.joint.vehicle.load_places import placed
from pipelines.joint.vehicle.outputs import outputs_of
from pipelines.joint.vehicle.unknowns import Known
from pipelines.results import FloatArray, Share

PRIOR_DRAWS = 4000


NEVER_NEGATIVE = ("_kg", "_kgm2", "_nmprad", "_nmsprad", "_nspm", "cg_height_m")
"""How names end of parameters that are positive in every vehicle."""
LEAST_POSSIBLE = 0.2


@dataclass(frozen=True)
class Spread:
    """A parameter's distribution: mean, std, and draws (n,) behind them; no draws: a normal law. least: what it cannot be below."""

    mean: float
    std: float
    draws: FloatArray
    least: float = -math.inf

    @property
    def whole_std(self) -> float:
        """The standard deviation of the normal law with this interval, where `std` is that of the distribution's middle."""
        low, high = self.interval
        return 0.5 * (high - low) / 1.96

    @property
    def interval(self) -> tuple[float, float]:
        """Of 95 %: by the draws, as loads make long tails."""
        if not len(self.draws):
            return self.mean - 1.96 * self.std, self.mean + 1.96 * self.std
        low, high = np.quantile(self.draws, (0.025, 0.975))
        return float(low), float(high)

    @property
    def shown(self) -> tuple[float, float]:
        """The interval as it is told: a load's normal law holds loads below nothing, and no vehicle is lighter than its empty one."""
        low, high = self.interval
        return max(low, min(self.least, self.mean)), high


def slopes(joint: Joint) -> tuple[dict[str, float], dict[str, FloatArray]]:
    """Parameters at the mode, and their derivatives (k,) by u, all in one call."""
    moved = both_ways(joint.u)
    found = outputs_of(values_at(joint.known, moved), joint.given)
    whole = {name: np.broadcast_to(column, len(moved)) for name, column in found.items()}
    middle = {name: float(column[0]) for name, column in whole.items()}
    return middle, {name: central(column) for name, column in whole.items()}


def prior_spreads(known: Known, stated: Sequence[Evidence], rng: np.random.Generator) -> dict[str, Spread]:
    """What was known of each parameter before the log: by draws, as loads make it skew.

    stated: what the vehicle file binds. The spread is half of the central 68 %, which a few impossible draws do not move.
    """
    u = rng.standard_normal((PRIOR_DRAWS, len(known.names)))
    if stated:
        before = find_mode(stated, known)
        u = before.u + u @ np.linalg.cholesky(before.covariance).T
    values = placed(known.mean + known.std * u, known.names, known.places, rng)
    found = outputs_of(dict(zip(known.names, values.T, strict=True)), {})
    columns = {name: np.broadcast_to(column, PRIOR_DRAWS) for name, column in found.items()}
    can_be, least = _possible(columns), _least(known)
    spreads = {}
    for name, column in columns.items():
        draws = column[can_be]
        low, middle, high = np.quantile(draws, (0.16, 0.5, 0.84))
        spreads[name] = Spread(
            float(middle), float(0.5 * (high - low)), np.asarray(draws), least.get(name, -math.inf)
        )
    return spreads


def _least(known: Known) -> dict[str, float]:
    """The empty vehicle's masses less twice their spreads; nothing where nobody states its mass."""
    if not known.mass:
        return {}
    axles = ("unsprung_front", "unsprung_rear")
    (kilos, std), *unsprung = (
        (float(known.mean[known.index(n)]), float(known.std[known.index(n)])) for n in ("empty_mass", *axles)
    )
    sprung = kilos - sum(mass for mass, _ in unsprung)
    return {
        "mass_kg": kilos - 2 * std,
        "sprung_mass_kg": sprung - 2 * math.hypot(std, *(each for _, each in unsprung)),
    }


def _possible(columns: Mapping[str, FloatArray]) -> NDArray[np.bool_]:
    """(n,) draws in which nothing is negative that has weight or holds; all, where hardly any is so (figures that cannot be)."""
    held = [column > 0 for name, column in columns.items() if name.endswith(NEVER_NEGATIVE)]
    can_be = np.logical_and.reduce(held) if held else np.ones(PRIOR_DRAWS, dtype=np.bool_)
    return can_be if can_be.mean() > LEAST_POSSIBLE else np.ones(PRIOR_DRAWS, dtype=np.bool_)


def bits(before: float, after: float) -> float:
    """log2 of a spread over a smaller one; never below nought."""
    return float(max(0.0, np.log2(before / after))) if before > 0 and after > 0 else 0.0


def shares(
    joint: Joint, gradients: Mapping[str, FloatArray], wider: Mapping[str, float]
) -> dict[str, tuple[Share, ...]]:
    """For each parameter the relations by what would be lost without them, the first the most.

    wider: by what its spread is larger than that at the mode (conflicts, a posterior that is not normal); all spreads are
    scaled alike, so that they compare.
    """
    without = [joint.without(i) for i in range(len(joint.parts))]
    alone = [joint.alone(i) for i in range(len(joint.parts))]
    found = {}
    for name, g in gradients.items():
        std = float(np.sqrt(g @ joint.covariance @ g))
        entries = [
            Share(
                part.evidence.title,
                bits(float(np.sqrt(g @ lost @ g)), std),
                wider[name] * float(np.sqrt(g @ lost @ g)),
                wider[name] * float(np.sqrt(g @ kept @ g)),
            )
            for part, lost, kept in zip(joint.parts, without, alone, strict=True)
        ]
        found[name] = tuple(sorted(entries, key=lambda s: (-s.bits, s.std_alone)))
    return found
