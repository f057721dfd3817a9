"""Methods by names that a reader understands; the names of the command line stand once, under Estimators."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

from pipelines.drive_results import DriveResults
from pipelines.results import Assumption, Estimate, JointVerdict, Learned, ParameterEstimate

NAMES: Mapping[str, str] = {
    "roll_map": "Roll dynamics",
    "marginalized_particle_filter": "Particle filter on roll",
    "base_excitation_batch": "Base excitation (batch)",
    "base_excitation": "Base excitation",
    "axle_load_gls": "Axle loads (batch)",
    "hekf_ekf": "Axle loads (filters)",
    "brake_roll_batch": "Braking and roll (batch)",
    "integrated_observer": "Braking and roll",
    "load_balance": "Force and moment balances",
    "load_transfer_batch": "Load transfer (batch)",
    "load_transfer": "Load transfer (LTM)",
    "modified_load_transfer": "Load transfer (MLTM)",
    "high_frequency_load_transfer": "Load transfer (HFLTM)",
    "gpc_bayesian_map": "Polynomial chaos (MAP)",
    "suspension_mapping": "Suspension mapping",
    "roll_plane": "Roll plane",
    "pitch_plane": "Pitch plane",
    "gpc_roll_plane": "Roll and pitch plane",
}
"""Each registered estimator's title, short enough for a figure: an estimator that is not in here is printed by its own name."""

_CODE = {title: name for name, title in NAMES.items()}
_KNOWN = re.compile(
    r"(?<![\w./\-])(" + "|".join(sorted(map(re.escape, NAMES), key=len, reverse=True)) + r")(?![\w/\-]|\.\w)"
)


def title_of(name: str) -> str:
    """An estimator's short title; its name where it has none."""
    return NAMES.get(name, name)


def code_of(title: str) -> str:
    """The name for `--estimators` of a short title; empty where title and name are the same."""
    return _CODE.get(title, "")


def in_words(text: str) -> str:
    """A sentence with the estimators that it names by their titles."""
    return _KNOWN.sub(lambda found: NAMES[found[0]], text)


def _parameters(found: Mapping[str, ParameterEstimate]) -> dict[str, ParameterEstimate]:
    return {name: replace(estimate, reason=in_words(estimate.reason)) for name, estimate in found.items()}


def _assumptions(found: tuple[Assumption, ...]) -> tuple[Assumption, ...]:
    return tuple(Assumption(in_words(a.name), in_words(a.value), in_words(a.source)) for a in found)


def _estimate(estimate: Estimate) -> Estimate:
    return replace(
        estimate,
        estimator=title_of(estimate.estimator),
        reason=in_words(estimate.reason),
        parameters=_parameters(estimate.parameters),
        traces=tuple(replace(t, name=in_words(t.name), note=in_words(t.note)) for t in estimate.traces),
        scatters=tuple(replace(s, title=in_words(s.title), note=in_words(s.note)) for s in estimate.scatters),
        assumptions=_assumptions(estimate.assumptions),
    )


def _learned(learned: Learned) -> Learned:
    return replace(
        learned,
        shares=tuple(replace(share, relation=in_words(share.relation)) for share in learned.shares),
        next=tuple(replace(following, action=in_words(following.action)) for following in learned.next),
    )


def _joint(joint: JointVerdict) -> JointVerdict:
    return replace(
        joint,
        learned={name: _learned(learned) for name, learned in joint.learned.items()},
        relations=tuple(
            replace(c, relation=in_words(c.relation), source=in_words(c.source), text=in_words(c.text))
            for c in joint.relations
        ),
        not_counted=tuple((in_words(relation), in_words(why)) for relation, why in joint.not_counted),
        far=tuple(map(in_words, joint.far)),
        spoke_for=tuple(map(in_words, joint.spoke_for)),
    )


def with_titles(results: DriveResults) -> DriveResults:
    """Results for print: every estimator by its title. Twice is the same as once."""
    return replace(
        results,
        verdict=_parameters(results.verdict),
        estimates=tuple(map(_estimate, results.estimates)),
        joint=None if results.joint is None else _joint(results.joint),
        limits=tuple(map(in_words, results.limits)),
        notes=tuple(map(in_words, results.notes)),
        assumptions=_assumptions(results.assumptions),
    )
