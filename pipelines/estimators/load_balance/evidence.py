"""The balances as evidence: mean products of a balance with its instruments, which a right vehicle makes vanish."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import cast

import numpy as np

from pipelines.estimators.load_balance.data import Columns
from pipelines.estimators.load_balance.relations import TITLES
from pipelines.estimators.load_balance.solve import Fit, Reduced
from pipelines.evidence import Evidence, Kind, Values
from pipelines.joint.vehicle.laden import patch_lag
from pipelines.joint.vehicle.remembered import Remembered
from pipelines.results import FloatArray

KINDS: dict[str, Kind] = {
    "pitch": "pitch", "roll": "roll", "vertical": "vertical", "along": "longitudinal", "front axle": "axle", "rear axle": "axle"
}  # fmt: skip


def kind_of(name: str) -> Kind:
    """The physics of a balance, by its name ("pitch by spring deflections")."""
    return KINDS[name.partition(" by ")[0]]


PATCH = "patch_lag"
"""The unknown that tells how far the tyres' patches shift under load, as a height in m."""


def _predict(reduced: Reduced, patch: bool) -> Callable[[Values], FloatArray]:
    total, relation = reduced.total, reduced.relation

    def predict(values: Values) -> FloatArray:
        # a dictionary of numbers or of arrays: the coefficients are plain arithmetic on either
        p = cast("Mapping[str, float]", values)
        if patch:
            p = Remembered(p)
            # what the tyres' patches move shows as if the whole vehicle were higher by as much
            p["empty_h"] = p["empty_h"] + patch_lag(p) * (p["empty_mass"] + p["load"]) / p["empty_mass"]
        terms = relation.coefficients(p)
        vector = np.array(np.broadcast_arrays(*(terms[name] for name in relation.columns)))
        return np.asarray(total @ vector)

    return predict


def evidence_of(fit: Fit, data: Columns, *, heavy: bool) -> tuple[Evidence, ...]:
    """One entry a balance of the fit, at the weights and covariances that it ended with.

    heavy: load transfer is not taken from spring deflections: dry friction is as large.
    """
    found = []
    given = {} if data.sag is None else {"sag": data.sag}
    for reduced in fit.reduced:
        relation = reduced.relation
        _, _, carrier = relation.name.partition(" by ")
        kind = kind_of(relation.name)
        if heavy and carrier.endswith(TITLES["deflection"]) and kind != "vertical":
            continue
        patch = carrier in (TITLES["tyre"], TITLES["axle"])
        names = tuple(fit.known.names[i] for i in relation.unknowns)
        found.append(
            Evidence(
                kind, carrier or "torques", relation.title, "load_balance",
                np.zeros(len(reduced.total)), reduced.covariance, _predict(reduced, patch),
                (*names, PATCH) if patch else names, (), given,
            )
        )  # fmt: skip
    return tuple(found)
