"""What a drive leaves of the vehicle's own figures with all its doubts: for the join, whose linear relations know of none."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pipelines.joint.answers import told
from pipelines.joint.conflict import Check
from pipelines.joint.doubts.weighed import Weighed
from pipelines.joint.mixture import Apart, moments
from pipelines.joint.posterior import Joint
from pipelines.joint.vehicle.empty import FIGURES, Figure, figure_at


@dataclass(frozen=True)
class Doubted:
    """A posterior with all that is doubted of it. chance: that it is this one; factor: on its spreads, for misfit as a whole."""

    chance: float
    joint: Joint
    checks: Sequence[Check]
    factor: float
    doubts: Sequence[Weighed]


def _apart(figure: Figure, place: Doubted) -> Apart:
    """A figure by one posterior, contradictions in its spread."""
    known = place.joint.known
    value, slope = figure_at(figure, known.names, known.mean + known.std * place.joint.u, known.std)
    gradient = slope * known.std
    answer = told(value, gradient, place.joint, place.checks, place.factor, None, 1.0)
    return Apart(place.chance, answer.value, answer.std, gradient, place.doubts)


def figures_left(first: Doubted, others: Sequence[Doubted]) -> dict[str, tuple[float, float]]:
    """Figure of the vehicle -> value and standard deviation over all doubts, and over the other posteriors that the drive leaves open."""
    found = {}
    for figure in FIGURES:
        if any(not {*figure.needs} <= {*place.joint.known.names} for place in (first, *others)):
            continue
        found[figure.name] = moments(_apart(figure, first), [_apart(figure, place) for place in others])
    return found
