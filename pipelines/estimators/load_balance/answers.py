"""From the fit to parameters with intervals, a status, and words on which balance taught what."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pipelines.estimators.load_balance.data import Columns
from pipelines.estimators.load_balance.evidence import kind_of
from pipelines.estimators.load_balance.solve import Fit, without
from pipelines.joint.answers import Told, left_of, prior_record, status_of
from pipelines.joint.doubts.weighed import Weighed
from pipelines.joint.information import Spread
from pipelines.joint.mixture import Apart, doubted
from pipelines.joint.posterior import both_ways, central, values_at
from pipelines.joint.tails import freedom_of
from pipelines.joint.vehicle.outputs import outputs_of as all_outputs
from pipelines.joint.vehicle.unknowns import CORNERS, Known
from pipelines.models.axle_load import patch_shift
from pipelines.parameters import spread_text
from pipelines.results import FloatArray, ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle

SOURCE = ("load_balance",)
GIVEN = (
    "mass_kg", "sprung_mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m", "cg_height_m", "sprung_cg_height_m",
    "roll_arm_m", *(f"corner_mass_{w}_kg" for w in CORNERS), "roll_stiffness_nmprad",
)  # fmt: skip


def outputs_of(
    known: Known, u: FloatArray, sag: float | None
) -> tuple[dict[str, float], dict[str, FloatArray]]:
    """The parameters that this estimator gives, and their derivatives (k,) by u; the roll stiffness where the springs are known."""
    moved = both_ways(u)
    found = all_outputs(values_at(known, moved), {} if sag is None else {"sag": sag})
    given = [name for name in GIVEN if known.springs or name != "roll_stiffness_nmprad"]
    whole = {name: np.broadcast_to(found[name], len(moved)) for name in given}
    middle = {name: float(column[0]) for name, column in whole.items()}
    return middle, {name: central(column) for name, column in whole.items()}


def _taught(fit: Fit, gradient: FloatArray, std: float) -> list[str]:
    """The balances without which the spread would be clearly larger, the first the most."""
    found = []
    for i, reduced in enumerate(fit.reduced):
        alone = fit.inflation * math.sqrt(float(gradient @ without(fit, i) @ gradient))
        if alone > 1.03 * std:
            found.append((alone, f"{reduced.relation.title} (± {spread_text(alone)} without it)"))
    return [words for _, words in sorted(found, reverse=True)]


def _spread(fit: Fit, gradient: FloatArray) -> float:
    return fit.inflation * math.sqrt(float(gradient @ fit.covariance @ gradient))


def _all_taught(fit: Fit) -> str:
    return ", ".join(r.relation.title for r in fit.reduced)


MISSING = {
    "mass": "it needs suspension deflections with spring rates, suspension or tyre forces, axle loads, or drive and brake "
    "torque with the longitudinal acceleration",
    "height": "it needs braking and accelerating, or cornering, seen by suspension deflections (with spring rates), by "
    "suspension, tyre or axle forces, or by the pitch rate with spring rates and torques",
    "place": "it needs suspension deflections with spring rates, or suspension, tyre or axle forces",
}


def _missing(name: str) -> str:
    if "mass_kg" in name:
        return MISSING["mass"]
    return MISSING["height" if "height" in name or "arm" in name or "stiffness" in name else "place"]


def answers(
    fit: Fit,
    data: Columns,
    vehicle: Vehicle,
    priors: Mapping[str, Spread],
    doubts: Sequence[Weighed] = (),
    others: Sequence[tuple[float, Fit, Sequence[Weighed]]] = (),
) -> dict[str, ParameterEstimate]:
    """All parameters of a fit, over all that may be otherwise (`pipelines.joint.doubts`). priors: what was known before.

    others: fits of another kind of load that the log leaves open, each with its chance and its own doubts.
    """
    kinds = {kind_of(r.relation.name) for r in fit.reduced}
    last, after = outputs_of(fit.known, fit.u, data.sag)
    found: dict[str, ParameterEstimate] = {}
    beside = [
        (chance, other, more, *outputs_of(other.known, other.u, data.sag)) for chance, other, more in others
    ]
    for name, value in last.items():
        std = _spread(fit, after[name])
        apart = [
            Apart(chance, values[name], _spread(other, slopes[name]), slopes[name], more)
            for chance, other, more, values, slopes in beside
        ]
        told_alone = Told(value, std, value - 1.96 * std, value + 1.96 * std, None)
        answer = doubted(told_alone, after[name], doubts, apart, freedom_of(name))
        prior = priors[name]
        left = left_of(name, prior, answer.std, answer.low, answer.high)
        status = status_of(name, answer.value, answer.std, left, kinds)
        taught = _taught(fit, after[name], std)
        told = "from " + ", ".join(taught) if taught else f"from all balances alike: {_all_taught(fit)}"
        if status == "not_identifiable":
            reason = f"this drive adds little to what the vehicle file says: {_missing(name)}"
        elif status == "weak":
            reason = f"{told}; the interval is still wide: {_missing(name)}"
        else:
            reason = told
        found[name] = ParameterEstimate(
            name, answer.value, answer.std, answer.low, answer.high, status, reason, prior_record(prior),
            vehicle.reference.get(name), SOURCE if status != "not_identifiable" else ("prior",),
        )  # fmt: skip
    return found


def behind_the_axles(
    parameters: Mapping[str, ParameterEstimate], vehicle: Vehicle
) -> dict[str, ParameterEstimate]:
    """Heights as tyre loads give them, less what the tyres' patches may shift: see `patch_shift`."""
    mass, rate = vehicle.get("mass_kg"), vehicle.get("tire_vertical_rate_npm")
    shift, spread = patch_shift(mass.value if mass else None, rate.value if rate else None)
    moved = dict(parameters)
    for name in ("cg_height_m", "sprung_cg_height_m"):
        p = moved.get(name)
        if p is None or p.status == "not_identifiable":
            continue
        if p.value is None or p.std is None or p.low is None or p.high is None:
            continue
        value, std = p.value - shift, math.hypot(p.std, spread)
        wider = std / p.std
        low, high = value - wider * (p.value - p.low), value + wider * (p.high - p.value)
        moved[name] = replace(p, value=value, std=std, low=low, high=high)
    return moved


def unanswered(
    known: Known,
    names: tuple[str, ...],
    reason: str,
    priors: Mapping[str, Spread],
    reference: Mapping[str, float],
) -> dict[str, ParameterEstimate]:
    """All parameters as they were known before: nothing was learned; no figures where nobody states the vehicle's mass."""
    found = {}
    for name in names:
        prior, told = priors.get(name), reference.get(name)
        if not known.mass or prior is None or (name == "roll_stiffness_nmprad" and not known.springs):
            found[name] = ParameterEstimate(
                name, None, None, None, None, "not_identifiable", reason, None, told
            )
            continue
        words = f"{reason}; the figures are what was known before the log"
        found[name] = ParameterEstimate(
            name, prior.mean, prior.whole_std, *prior.shown, "not_identifiable", words, prior_record(prior, whole=True), told, ("prior",),
        )  # fmt: skip
    return found
