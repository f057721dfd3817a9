"""The whole inference of one drive: which relations count, the posterior, its checks, and what was learned."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipelines.evidence import Evidence
from pipelines.joint.answers import (
    SAMPLED,
    Told,
    estimate_of,
    helping,
    learned_of,
    listed,
    told,
)
from pipelines.joint.bends import bent
from pipelines.joint.channels import CHANNELS
from pipelines.joint.conflict import CONTRADICTED, Check, check
from pipelines.joint.doubts.listed import doubts_of, said
from pipelines.joint.doubts.weighed import Weighed
from pipelines.joint.file_check import LOAD, STATED, file_check
from pipelines.joint.handed_on import Doubted, figures_left
from pipelines.joint.information import Spread, prior_spreads, shares, slopes
from pipelines.joint.kept import KeptRelations, kept_of
from pipelines.joint.mirror import NAMED_WITH, said_of_mirror
from pipelines.joint.mixture import Apart, doubted
from pipelines.joint.next_measurement import next_measurements
from pipelines.joint.no_mass import without_mass
from pipelines.joint.posterior import Joint, log_density, values_at
from pipelines.joint.profile import departure
from pipelines.joint.reached import Modes, Reached, reach
from pipelines.joint.rests import rests_on
from pipelines.joint.sampling.sample import Drawn, no_narrower, sample
from pipelines.joint.tails import freedom_of
from pipelines.joint.vehicle.outputs import outputs_of
from pipelines.joint.vehicle.plain_names import plain_name
from pipelines.joint.ways.other_vehicle import without_answers
from pipelines.joint.ways.rigid_tyres import tyres_open
from pipelines.joint.ways.spring_scale import springs_off
from pipelines.results import FloatArray, JointVerdict, Learned, ParameterEstimate
from pipelines.vehicles.vehicle import Vehicle

CURVED = 0.5
"""Departure of a parameter's profile from a normal one, in nats at two standard deviations (where that has fallen by 2),
from which on the posterior is sampled."""

USUALLY = 10.0
"""Figures' worth that is known beforehand of how well relations keep their spreads."""

DRAWS = 2000
FAR = 2.5
LOOKED_AT = ("cg_height_m", "mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m", "roll_stiffness_nmprad")


TYRES_OF_ANOTHER = 0.06
"""Spread of the tyres' part of a roll gradient by deflections, over it, where the tyres' rate is another vehicle's: a third of 18 %."""


@dataclass(frozen=True)
class Inference:
    """Entries of the verdict by parameter, the record behind them, and the relations for other drives to be joined with.

    doubtful: estimators whose relation contradicted the rest, tyres that give and a right scale taken for granted, and by what factor.
    shared: estimators whose relation was not counted, since that of one that is `doubtful` shows the same.
    springs_off: share by which spring rates, or the deflections' scale, are otherwise than stated (`springs_off`).
    tyres_open: share by which roll by deflections is open, as the tyres may give or not (`tyres_open`).
    """

    parameters: Mapping[str, ParameterEstimate]
    record: JointVerdict
    kept: KeptRelations
    doubtful: Mapping[str, float] = field(default_factory=dict)
    shared: Mapping[str, str] = field(default_factory=dict)
    springs_off: float = 0.0
    tyres_open: float = 0.0


def _inflation(joint: Joint) -> float:
    """Factor for relations that contradict each other or the vehicle file beyond their spreads.

    Relations' spreads are right as a rule: a few figures do not show that they are not, and count beside `USUALLY` that fit.
    """
    count = sum(len(p.residual) for p in joint.parts)
    misfit = sum(float(p.residual @ p.residual) for p in joint.parts) + float(joint.u @ joint.u)
    return math.sqrt(max(1.0, (USUALLY + misfit) / (USUALLY + count)))


def _draws(
    joint: Joint,
    modes: Modes,
    gradients: Mapping[str, FloatArray],
    rng: np.random.Generator,
) -> tuple[Drawn | None, str]:
    """Draws of u where the posterior is not normal, else None; and how it was found, in words."""
    away = departure(joint, gradients, LOOKED_AT)
    if len(modes) == 1 and away < CURVED:
        return None, "Laplace's approximation at the mode (the posterior is close to normal there)"
    drawn = sample(log_density(joint), modes, rng, DRAWS)
    why = f"{len(modes)} modes" if len(modes) > 1 else "it is not normal"
    return drawn, f"sampled, as {why}: {drawn.text}"


def _far(joint: Joint) -> tuple[str, ...]:
    """Unknowns that ended far from what was known of them."""
    found = zip(joint.known.names, joint.u.tolist(), strict=True)
    return tuple(f"{plain_name(n)} ({x:+.1f} standard deviations)" for n, x in found if abs(x) > FAR)


def _doubtful(
    relations: Sequence[Check], evidence: Sequence[Evidence], kept: Sequence[Evidence]
) -> tuple[dict[str, float], dict[str, str]]:
    """`doubtful` and `shared` of `Inference`."""
    worst_last = sorted((c.record for c in relations if c.in_conflict), key=lambda r: r.widened)
    titles = {record.relation for record in worst_last}
    against = {(e.kind, e.carrier) for e in kept if e.title in titles}
    shared = {
        e.source: other.source
        for e in evidence
        for other in kept
        if (e.kind, e.carrier) == (other.kind, other.carrier) in against and e.source != other.source
    }
    return {record.source: record.widened for record in worst_last}, shared


def infer(evidence: Sequence[Evidence], vehicle: Vehicle, rng: np.random.Generator) -> Inference | None:
    """Join the relations of one drive with what was known of the vehicle; None where no relation can be used.

    Raises LinAlgError where no vehicle that is known of fits the relations.
    """
    started = time.perf_counter()
    reached = reach(evidence, vehicle, rng)
    if reached is None:
        return None
    joint = reached.joint
    middle, gradients = slopes(joint)
    checks = (*reached.checks, *file_check(joint, reached.vehicle))
    factor = _inflation(joint)
    doubts = doubts_of(joint, reached.vehicle, reached.opened[0])
    drawn, method = _draws(joint, reached.modes, gradients, rng)
    priors = prior_spreads(reached.known, reached.stated, rng) if reached.known.mass else {}
    columns = bent(joint, middle, gradients, rng) if drawn is None else _drawn(joint, drawn, gradients)
    rough = 1.0 if drawn is None else SAMPLED
    others = [
        _doubted(other, chance, reached.vehicle, opened)
        for (chance, other), opened in zip(reached.others, reached.opened[1:], strict=True)
    ]
    apart = [_apart(other) for other in others]
    answers = {
        name: doubted(
            told(value, gradients[name], joint, checks, factor, columns.get(name), rough),
            gradients[name],
            doubts,
            [each[name] for each in apart],
            freedom_of(name),
        )
        for name, value in middle.items()
    }
    parameters, learned = _entries(reached, answers, gradients, priors)
    parameters |= _with_mirror(joint, parameters, answers)
    if not reached.known.mass:
        parameters = without_mass(parameters)
    record = JointVerdict(
        learned, tuple(c.record for c in checks if c.record.source != "vehicle file"), reached.dropped,
        (*_far(joint), *_left_to_say(doubts, reached)), method, factor, time.perf_counter() - started, reached.found,
    )  # fmt: skip
    left = {name: (answer.value, answer.std) for name, answer in answers.items()}
    empty = figures_left(Doubted(1.0, joint, checks, factor, doubts), others)
    kept = kept_of(joint, reached.checks, factor, drawn is None, left, empty)
    doubtful, shared = _doubtful(reached.before, evidence, reached.kept)
    off = springs_off(joint, doubts, reached.vehicle, reached.others)
    # another vehicle's tyres give otherwise, by a third of their part
    tyres = max(tyres_open(reached.joint, reached.others), TYRES_OF_ANOTHER * reached.another)
    parameters = without_answers(_with_conflicts(parameters, checks), reached.another)
    return Inference(parameters, record, kept, doubtful, shared, off, tyres)


def _left_to_say(doubts: Sequence[Weighed], reached: Reached) -> tuple[str, ...]:
    """Doubts that the log speaks for; of stated figures and channels none, where those were asked by fits of their own and one is heard."""
    texts, asked = said(doubts), (*STATED, LOAD, *CHANNELS)
    if not any(text.startswith(asked) for text in reached.found):
        return texts
    return tuple(text for text in texts if not text.startswith(asked))


def _entries(
    reached: Reached,
    answers: Mapping[str, Told],
    gradients: Mapping[str, FloatArray],
    priors: Mapping[str, Spread],
) -> tuple[dict[str, ParameterEstimate], dict[str, Learned]]:
    """Each parameter's entry in the verdict, and what was learned of it, by which relation."""
    joint, reference = reached.joint, reached.vehicle.reference
    stated = {} if reached.opened[0] else joint.known.keys
    wider = {name: answers[name].std / _laplace(joint, g) for name, g in gradients.items()}
    brought = shares(joint, gradients, wider)
    following = {
        name: helping(steps, answers[name], priors.get(name))
        for name, steps in next_measurements(joint, gradients, wider).items()
    }
    parameters = {
        name: estimate_of(
            name,
            answer,
            priors.get(name),
            brought[name],
            reference.get(name),
            reached.kept,
            following[name],
            rests_on(name, gradients[name], answer.std, joint, stated),
        )
        for name, answer in answers.items()
    }
    learned = {
        name: learned_of(
            name,
            answers[name],
            prior,
            brought[name],
            following[name],
            whole=parameters[name].status == "not_identifiable",
        )
        for name, prior in priors.items()
    }
    return parameters, learned


def _doubted(other: Joint, chance: float, vehicle: Vehicle, opened: str) -> Doubted:
    """A second posterior with its own conflicts and doubts."""
    checks = (*check(other), *file_check(other, vehicle))
    return Doubted(chance, other, checks, _inflation(other), doubts_of(other, vehicle, opened))


def _apart(other: Doubted) -> dict[str, Apart]:
    """Every parameter by a second posterior, for what is told over both."""
    middle, gradients = slopes(other.joint)
    answers = {
        name: told(v, gradients[name], other.joint, other.checks, other.factor, None, 1.0)
        for name, v in middle.items()
    }
    return {
        name: Apart(other.chance, answer.value, answer.std, gradients[name], other.doubts)
        for name, answer in answers.items()
    }


def _drawn(joint: Joint, drawn: Drawn, gradients: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """The parameters of n draws: (n,) each. Coarse ones are spread out to no less than the curvature at the mode says."""
    found = outputs_of(values_at(joint.known, drawn.draws), joint.given)
    columns = {name: np.broadcast_to(column, len(drawn.draws)) for name, column in found.items()}
    if not drawn.coarse:
        return columns
    return {name: no_narrower(column, _laplace(joint, gradients[name])) for name, column in columns.items()}


def _laplace(joint: Joint, gradient: FloatArray) -> float:
    """A parameter's spread by the curvature at the mode, before anything widens it."""
    return math.sqrt(max(float(gradient @ joint.covariance @ gradient), 1e-300))


def _with_mirror(
    joint: Joint, parameters: Mapping[str, ParameterEstimate], answers: Mapping[str, Told]
) -> dict[str, ParameterEstimate]:
    """The heights with what the roll motion's inertia leaves open of them, where they are not sure."""
    words = said_of_mirror(
        joint.given, {name: (answer.value, answer.std) for name, answer in answers.items()}
    )
    open_ = [parameters[n] for n in NAMED_WITH if n in parameters and parameters[n].status != "identified"]
    return {e.name: replace(e, reason=f"{e.reason}; {words}") for e in open_} if words else {}


def _with_conflicts(
    parameters: Mapping[str, ParameterEstimate], checks: Sequence[Check]
) -> dict[str, ParameterEstimate]:
    """Conflicts named with every answer that they widen, behind its own reason; beyond doubt first of all, and nothing is identified."""
    against = [c.record.relation for c in checks if c.in_conflict]
    if not against:
        return dict(parameters)
    words = f"; relations disagree ({listed(against)}): the interval holds what either says"
    first, surely = "", [c.record.relation for c in checks if c.beyond_doubt]
    if surely:
        # no interval holds what a wrong file leaves open
        first = f"{CONTRADICTED} ({listed(surely)}): one of them is wrong; "
        words = ""
    named = {
        name: entry
        if entry.status == "not_identifiable" and not surely
        else replace(entry, reason=first + entry.reason + words, refused=first)
        for name, entry in parameters.items()
    }
    return {
        name: replace(entry, status="weak") if surely and entry.status == "identified" else entry
        for name, entry in named.items()
    }
