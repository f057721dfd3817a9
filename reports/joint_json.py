"""The joint posterior for results.json: what was learned of each parameter, the relations, and what was left out."""

from __future__ import annotations

from typing import Any

import numpy as np

from pipelines.results import FloatArray, JointVerdict, Learned, RelationCheck
from reports.sections.joint_words import is_conflict

MOST_POINTS = 101
FIGURES = 6
"""Significant figures of a density: as many as any plot of it can show."""


def _rounded(values: FloatArray) -> list[float]:
    return [float(f"{value:.{FIGURES - 1}e}") for value in values.tolist()]


def _density(learned: Learned) -> dict[str, Any] | None:
    """Prior and posterior density on at most 101 points of the grid; None where they are not known."""
    size = learned.grid.size
    if size == 0 or {learned.prior_density.size, learned.density.size} != {size}:
        return None
    rows = np.unique(np.linspace(0, size - 1, min(size, MOST_POINTS)).round().astype(int))
    return {
        "grid": _rounded(learned.grid[rows]),
        "prior": _rounded(learned.prior_density[rows]),
        "posterior": _rounded(learned.density[rows]),
    }


def _learned(learned: Learned) -> dict[str, Any]:
    prior = learned.prior
    return {
        "prior": {"value": prior.value, "std": prior.std, "source": prior.source},
        "bits": learned.bits,
        "relations": [
            {"relation": s.relation, "bits": s.bits, "std_without": s.std_without, "std_alone": s.std_alone}
            for s in learned.shares
        ],
        "next": [{"action": n.action, "std_after": n.std_after} for n in learned.next],
        "density": _density(learned),
    }


def _relation(check: RelationCheck) -> dict[str, Any]:
    return {
        "relation": check.relation,
        "source": check.source,
        "numbers": check.numbers,
        "chi2": check.chi2,
        "probability": check.probability,
        "widened": check.widened,
        "conflict": is_conflict(check),
        "text": check.text,
    }


def joint_json(joint: JointVerdict | None) -> dict[str, Any] | None:
    """The joint posterior as plain data; None where nothing was joined. Figures that are not finite are left to `plain`."""
    if joint is None:
        return None
    return {
        "method": joint.method,
        "inflation": joint.inflation,
        "runtime_s": joint.runtime_s,
        "parameters": {name: _learned(learned) for name, learned in joint.learned.items()},
        "relations": [_relation(check) for check in joint.relations],
        "not_counted": [{"relation": relation, "reason": why} for relation, why in joint.not_counted],
        "spoke_for": list(joint.spoke_for),
        "far": list(joint.far),
    }
