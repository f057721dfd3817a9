"""The verdict: one answer a parameter.

The vehicle's parameters come from one joint posterior over every relation that the estimators found (`pipelines.joint`).
What that does not hold (roll gradient, frequencies, drag …) is the answer of the estimator that identified it best, and of
these the one with the narrowest interval: intervals are not multiplied, as estimators share what was known before and often
a relation. Published methods are witnesses: they speak only where nobody else does. Where answers that call themselves
identified contradict each other, the interval is widened to hold them, and it is said.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipelines.joint.answers import as_known
from pipelines.joint.inference import Inference, infer
from pipelines.joint.information import prior_spreads
from pipelines.joint.kept import KeptRelations
from pipelines.joint.tails import told_with_tails
from pipelines.joint.vehicle.stated import stated_relations
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.parameters import PARAMETERS
from pipelines.results import (
    Estimate,
    FloatArray,
    JointVerdict,
    ParameterEstimate,
    Prior,
)
from pipelines.vehicles.priors import measured_cg_height, measured_roll_inertia
from pipelines.vehicles.vehicle import Vehicle
from pipelines.verdict.beyond import beyond_measured
from pipelines.verdict.loaded import with_its_load
from pipelines.verdict.missing import WAYS, why_nobody
from pipelines.verdict.widened import ALONE, SHARE, not_told, widened

ORDER = ("identified", "weak", "not_identifiable")
QUANTILE = 1.96
CONFLICT = 2.0
WEAK_RATIO = 0.5
"""CONFLICT: distance in joint standard deviations from which two answers contradict each other. WEAK_RATIO: share of the
prior's spread (of what an answer without a prior may have) above which one widened by a conflict is no longer called identified."""

LOADED: dict[str, tuple[float, float]] = {
    "mass_kg": (0.1, 0.07),
    "roll_inertia_kgm2": (0.08, 0.12),
    "pitch_inertia_kgm2": (0.05, 0.08),
    "cg_to_front_axle_m": (0.0, 0.04),
    "cg_height_m": (0.0, 0.06),
}
"""What an unknown load does to the empty vehicle's figure: by what share it changes it in the mean, and the spread of that."""

BY_DEFLECTIONS = "roll_gradient_degpg"
"""What one estimator tells from the roll angle alone: where that is by deflections, their scale is its scale."""

AGAINST = 2.0
"""By what factor an answer is less sure whose motion contradicts the rest as another estimator reduced it, which does not tell the
parameter: bump stops and the like are in both, and by how much is not known."""

ASIDE = ("roll_center_height_m", "pitch_arm_m", "pitch_inertia_kgm2", "drag_area_m2")
"""Parameters of the joint posterior that few ask for: in the verdict where the drive told them or an estimator gave them."""


@dataclass(frozen=True)
class _Given:
    """An estimator's answer for one parameter."""

    estimator: str
    witness: bool
    entry: ParameterEstimate

    @property
    def value(self) -> float:
        return math.nan if self.entry.value is None else self.entry.value

    @property
    def std(self) -> float:
        return math.inf if self.entry.std is None else self.entry.std


def _prior(name: str, vehicle: Vehicle) -> Prior | None:
    """What is known of a parameter without any log, with the load that is stated."""
    empty = _prior_empty(name, vehicle)
    return None if empty is None else with_its_load(name, empty, vehicle)


def _prior_empty(name: str, vehicle: Vehicle) -> Prior | None:
    """The same of the empty vehicle; with an unknown load where none is stated."""
    stated = vehicle.get(name)
    if stated is not None and name in LOADED and not vehicle.load_stated:
        more, spread = (x * stated.value for x in LOADED[name])
        return Prior(
            stated.value + more, math.hypot(stated.std, spread), f"{stated.source}, with an unknown load"
        )
    if stated is not None:
        return Prior(stated.value, stated.std, f"{stated.source} (empty vehicle)")
    mass = vehicle.get("mass_kg")
    mass_kg = None if mass is None else mass.value
    if name == "cg_height_m":
        return measured_cg_height(vehicle.body, mass_kg, vehicle.powertrain)
    if name == "roll_inertia_kgm2":
        return measured_roll_inertia(mass_kg)
    return None


def _unanswered(name: str, reason: str, vehicle: Vehicle) -> ParameterEstimate:
    """A parameter that no estimator gave: its prior, or no figures."""
    prior = _prior(name, vehicle)
    reference = vehicle.reference.get(name)
    if prior is None:
        return ParameterEstimate(
            name, None, None, None, None, "not_identifiable", reason, None, reference, ()
        )
    half = 1.96 * prior.std
    words = f"{reason}; the figures are the prior's"
    return ParameterEstimate(
        name,
        prior.value,
        prior.std,
        prior.value - half,
        prior.value + half,
        "not_identifiable",
        words,
        prior,
        reference,
        ("prior",),
    )


def _given(estimates: Sequence[Estimate]) -> dict[str, list[_Given]]:
    """Every answer that an estimator gave, by parameter, the best identified and then the narrowest first.

    A published method comes after all others: it is a witness.
    """
    found: dict[str, list[_Given]] = {}
    for estimate in estimates:
        if estimate.status == "ran":
            for name, entry in estimate.parameters.items():
                found.setdefault(name, []).append(_Given(estimate.estimator, estimate.witness, entry))
    for answers in found.values():
        answers.sort(key=lambda g: (g.witness, ORDER.index(g.entry.status), g.std))
    # who saw that bump stops held the body knows more of it than who did not look
    found.get(BY_DEFLECTIONS, []).sort(key=lambda g: (g.witness, not g.entry.refused))
    return found


def _sources(answers: Sequence[_Given]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(source for g in answers for source in (g.entry.sources or (g.estimator,))))


def _reconciled(name: str, answers: Sequence[_Given]) -> ParameterEstimate:
    """The leading answer; where another one that identified the parameter contradicts it, both in a wider interval."""
    lead = answers[0]
    if len(answers) == 1:
        return lead.entry
    entry = replace(lead.entry, sources=_sources(answers))
    peers = [g for g in answers if g.witness == lead.witness and g.entry.status == "identified"]
    if lead.entry.status != "identified" or len(peers) < 2:
        return entry
    values = np.array([g.value for g in peers])
    stds = np.array([g.std for g in peers])
    apart = np.abs(values - values[0]) / np.hypot(stds, stds[0])
    if apart.max() <= CONFLICT:
        return entry
    # what two methods differ by beyond their own intervals is an error that one of them has and does not know of
    unknown = between_methods(values, stds)
    weights = 1 / (stds**2 + unknown)
    value = float(np.sum(weights * values) / np.sum(weights))
    # the variance between five methods of which one stands apart leaves that one out
    std = max(float(np.sqrt(stds[0] ** 2 + unknown)), float(np.abs(values - value).max()) / QUANTILE)
    digits = PARAMETERS[name].digits if name in PARAMETERS else 3
    said = ", ".join(f"{g.estimator} {g.value:.{digits}f} ± {g.std:.{digits}f}" for g in peers)
    words = f"methods disagree ({said}): the interval is widened to hold them"
    wide = widened(replace(entry, value=value), std, words, fair=ALONE)
    prior = lead.entry.prior
    narrow = std <= WEAK_RATIO * (SHARE * abs(value) if prior is None else prior.std)
    return replace(wide, status="identified") if narrow and wide.status == "weak" else wide


def between_methods(values: FloatArray, stds: FloatArray) -> float:
    """Variance that methods have in common beyond their own (DerSimonian and Laird 1986, eq. 8). values, stds: (n,)."""
    weights = 1 / stds**2
    mean = np.sum(weights * values) / np.sum(weights)
    excess = np.sum(weights * (values - mean) ** 2) - (len(values) - 1)
    return float(max(0.0, excess / (np.sum(weights) - np.sum(weights**2) / np.sum(weights))))


def as_sure_as_its_relation(
    lead: _Given, entry: ParameterEstimate, factor: float, spoke_for: Sequence[str] = ()
) -> ParameterEstimate:
    """What one estimator alone told, with its spread widened as its own relation had to be.

    One whose relation contradicts the rest (roll against the axles, with tyres that give nothing) is no surer of what only it says.
    spoke_for: what the drive was joined with instead, the likeliest first.
    """
    if entry.value is None or entry.std is None or entry.status == "not_identifiable" or factor <= 1:
        return entry
    unless = f" (not with {spoke_for[0].split(':')[0]})" if spoke_for else ""
    if not math.isfinite(factor):
        words = f"the relation of {lead.estimator} contradicts the rest{unless}, and no spread of it would hold both"
        return not_told(entry, words)
    words = f"the relation of {lead.estimator} contradicts the rest{unless}: the interval is {factor:.1f} times as wide"
    return widened(entry, factor * entry.std, words, fair=ALONE)


def _by_deflections(
    verdict: Mapping[str, ParameterEstimate], told: Sequence[Estimate], lead: str, found: Inference, than: str
) -> dict[str, ParameterEstimate]:
    """A roll gradient by deflections, as sure as the posterior is of what they lack or may be off by.

    Where the log has the springs otherwise, the rates may be right and the deflections' scale wrong; and where its tyres may give or not,
    so much of the roll is open. lead: the estimator that it is of. than: what the springs are otherwise than, in a word.
    """
    entry = verdict.get(BY_DEFLECTIONS)
    if entry is None or entry.value is None or entry.std is None or entry.status == "not_identifiable":
        return {}
    carriers = {
        e.carrier
        for estimate in told
        if estimate.estimator == lead
        for e in estimate.evidence
        if e.kind == "roll"
    }
    if BY_DEFLECTIONS in found.parameters or not any("spring defl" in c for c in carriers):
        return {}
    reasons = []
    if found.springs_off > 0:
        reasons.append(
            f"the log has spring rates, or the scale of the deflections, {found.springs_off:.0%} otherwise than {than}, and what is "
            "seen by deflections is no surer"
        )
    if found.tyres_open > 0:
        reasons.append(
            "tyres that do not give, roads that lean into the bends or another vehicle's file explain the drive as well, and deflections "
            "lack the tyres' part"
        )
    if not reasons:
        return {}
    std = math.hypot(entry.std, math.hypot(found.springs_off, found.tyres_open) * entry.value)
    return {BY_DEFLECTIONS: widened(entry, std, "; ".join(reasons), fair=ALONE)}


def _widened(name: str, answers: Sequence[_Given], found: Inference) -> float:
    """By what factor the leading answer's spread has to grow for what its relation, or the one counted in its place, contradicts."""
    lead = answers[0]
    factor = found.doubtful.get(lead.estimator, 1.0)
    counted = found.shared.get(lead.estimator)
    if counted is None:
        return factor
    # the counted relation's own spread is what had to grow: this one's, of the same motion, is no surer
    std = next((g.std for g in answers if g.estimator == counted), None)
    return max(factor, AGAINST if std is None else found.doubtful[counted] * std / lead.std)


def combine(estimates: Sequence[Estimate], vehicle: Vehicle) -> dict[str, ParameterEstimate]:
    """One answer for every parameter that an estimator gave, and for the core ones that none did."""
    return dict(verdict_of(estimates, vehicle).parameters)


@dataclass(frozen=True)
class Verdict:
    """parameters: one answer each. joint: what is behind those that the joint posterior gave; None without relations.

    kept: the relations, for a fleet's drives to be joined.
    """

    parameters: Mapping[str, ParameterEstimate]
    joint: JointVerdict | None
    kept: KeptRelations | None = None


def verdict_of(
    estimates: Sequence[Estimate],
    vehicle: Vehicle,
    rng: np.random.Generator | None = None,
    signals: Collection[str] = (),
) -> Verdict:
    """The joint posterior's answers; for what it does not hold the best single one; else why there is none.

    rng: for draws (a fixed seed without it). signals: those of the log, for what it lacks.
    """
    rng = np.random.default_rng(0) if rng is None else rng
    told = [e for e in estimates if e.status == "ran" and not e.witness]
    given = _given(estimates)
    verdict = {name: _reconciled(name, answers) for name, answers in given.items()}
    joint: JointVerdict | None = None
    try:
        found = infer([e for estimate in told for e in estimate.evidence], vehicle, rng)
    except np.linalg.LinAlgError:
        # single answers stand, with their own intervals
        found = None
    if found is not None:
        joint = found.record
        verdict |= {
            name: entry
            for name, entry in found.parameters.items()
            if name not in ASIDE or name in verdict or entry.status != "not_identifiable"
        }
        verdict |= {
            name: as_sure_as_its_relation(
                answers[0], verdict[name], _widened(name, answers, found), found.record.spoke_for
            )
            for name, answers in given.items()
            if name not in found.parameters and not answers[0].witness
        }
        if BY_DEFLECTIONS in given:
            lead = given[BY_DEFLECTIONS][0].estimator
            than = "stated" if vehicle.get("spring_rate_front_npm") is not None else "usual"
            verdict |= _by_deflections(verdict, told, lead, found, than)
    held = set() if found is None else set(found.parameters)
    verdict |= {
        name: told_with_tails(entry)
        for name, entry in verdict.items()
        if name not in held and entry.status != "not_identifiable"
    }
    for name in WAYS:
        if name not in verdict:
            verdict[name] = _unanswered(name, why_nobody(name, estimates, signals), vehicle)
    if found is None:
        verdict |= _known_before(verdict, vehicle, rng)
    return Verdict(beyond_measured(verdict, vehicle), joint, None if found is None else found.kept)


def _known_before(
    verdict: Mapping[str, ParameterEstimate], vehicle: Vehicle, rng: np.random.Generator
) -> dict[str, ParameterEstimate]:
    """What no drive told, as it was known before: by the same prior as in a verdict that was joined, whatever the single method took."""
    known = before_the_log(vehicle)
    if not known.mass:
        return {}
    priors = prior_spreads(known, stated_relations(vehicle), rng)
    return {
        name: as_known(entry, priors[name])
        for name, entry in verdict.items()
        if name in priors
        and entry.status == "not_identifiable"
        and entry.value is not None
        and entry.sources == ("prior",)
    }
