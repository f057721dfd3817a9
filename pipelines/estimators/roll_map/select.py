"""Which parts the roll model needs: forward selection by the likelihood of held-out stretches, and the weight of what stays open."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pipelines.estimators.roll_map.climb import settle
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.held_out import RAN_AWAY, Gain, gain_of, held_out, spans_of
from pipelines.estimators.roll_map.likelihood import Problem, named
from pipelines.estimators.roll_map.model import OPTIONS, Known
from pipelines.results import FloatArray

TRIAL_STEPS = 15
ASKED = Callable[[frozenset[str]], tuple[Known, ...]]
"""The parameters of a model with certain parts."""


@dataclass(frozen=True)
class Verdict:
    """What the stretches said. supported: parts that the plain model needs. gains: of each part, over the model that it was
    tried on. full_weight: of the model with all parts against the one with the supported ones. stretches: how many. liveliest_s: seconds of
    the drive that were asked, where that is not all of it: the model with the supported parts stands alone then."""

    supported: frozenset[str]
    gains: Mapping[str, Gain]
    full_weight: float
    stretches: int
    liveliest_s: float | None = None

    @property
    def models(self) -> tuple[tuple[frozenset[str], float], ...]:
        """The parts of each model that the answers come from, and its weight; the heaviest first."""
        found = [(self.supported, 1 - self.full_weight), (frozenset(OPTIONS), self.full_weight)]
        kept = [pair for pair in sorted(found, key=lambda pair: -pair[1]) if pair[1] > LEAST_WEIGHT]
        total = sum(weight for _, weight in kept)
        return tuple((parts, weight / total) for parts, weight in kept)


LEAST_WEIGHT = 0.03
"""Weight below which a model is left out."""


@dataclass(frozen=True)
class _Tried:
    """A model fitted to all stretches, and its held-out log likelihoods."""

    parts: frozenset[str]
    values: dict[str, float]
    held: FloatArray


class Selection:
    """Models on the same stretches, with the same weights."""

    def __init__(self, data: RollData, asked: ASKED, start: Mapping[str, float]) -> None:
        """start: a fit's values, whose noise levels are everybody's weights."""
        self._data, self._asked, self._weights = data, asked, dict(start)
        self._spans = spans_of(data)

    @property
    def stretches(self) -> int:
        """How many there are."""
        return int(self._spans.max()) + 1

    def tried(self, parts: frozenset[str], near: Mapping[str, float]) -> _Tried:
        """One model, fitted from values near it; one that does not stand foretells nothing."""
        known = self._asked(parts)
        problem = Problem(self._data, known)
        try:
            x = settle(problem, problem.standing(near, self._weights), self._weights, TRIAL_STEPS)
            found = held_out(problem, x, self._weights, self._spans)
        except np.linalg.LinAlgError:
            return _Tried(parts, dict(near), np.full(self.stretches, RAN_AWAY))
        return _Tried(parts, named(known, x), found)


def _may_join(name: str, parts: frozenset[str], data: RollData) -> bool:
    """Whether a part may be tried on a model with these.

    Of deflections, tyres look like a smoothing of the angle with a delay and a smaller damping (5.4 for 7.0, and equally
    likely): tyres are always there, so that a smoothing is asked for only beside them.
    """
    return name != "smoothing" or not data.against_axles or "series" in parts


def select_parts(data: RollData, asked: ASKED, start: Mapping[str, float]) -> Verdict:
    """Forward from the plain model: the part that gains most joins where its gain is real, until none does.

    Too short a motion for stretches to be held out supports nothing, and leaves both models in the answers.
    """
    selection = Selection(data, asked, start)
    if selection.stretches < 2:
        return Verdict(frozenset(), {}, 0.5, selection.stretches)
    here = selection.tried(frozenset(), start)
    gains: dict[str, Gain] = {}
    left = sorted(name for name in OPTIONS if name != "smoothing" or data.has_roll)
    while asked_now := [name for name in left if _may_join(name, here.parts, data)]:
        others = [selection.tried(here.parts | {name}, here.values) for name in asked_now]
        found = {name: gain_of(other.held, here.held) for name, other in zip(asked_now, others, strict=True)}
        gains |= found
        real = [name for name in asked_now if found[name].real]
        if not real:
            break
        best = max(real, key=lambda name: found[name].total)
        here = others[asked_now.index(best)]
        # what gained nothing on the smaller model is not asked again
        left = [name for name in left if name != best and (name not in found or found[name].total > 0)]
    full = selection.tried(frozenset(OPTIONS), here.values)
    weight = gain_of(full.held, here.held).weight if here.parts != full.parts else 1.0
    return Verdict(here.parts, gains, weight, selection.stretches)
