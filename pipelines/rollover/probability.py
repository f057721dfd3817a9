"""The probability of having exceeded the rollover threshold during a drive, and what it rests on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pipelines.rollover.body import Body
from pipelines.rollover.margin import AT_LIMIT
from pipelines.rollover.motion import CUTOFF_HZ
from pipelines.rollover_results import Exceedance, TurnSide, WheelLift

SURE = 0.01


def in_words(probability: float) -> str:
    """A probability as it can honestly be said: the draws and the model bear no more than a per cent."""
    if probability < SURE:
        return "less than 1 %"
    if probability > 1 - SURE:
        return "more than 99 %"
    return f"about {100 * probability:.0f} %"


OTHER = {"fl": "rl", "fr": "rr"}


def lifted_by_forces(lifts: Sequence[WheelLift]) -> dict[TurnSide, float]:
    """Probability by tyre forces that both wheels of each side carried nothing at one time.

    Of a pair of events at the same time the less sure one counts; pairs at other times are independent.
    """
    found: dict[TurnSide, float] = {"left": 0.0, "right": 0.0}
    both = [e for e in lifts if e.kind == "side"]
    for event in both:
        partner = OTHER.get(event.wheel)
        pairs = [
            min(event.probability, e.probability)
            for e in both
            if e.wheel == partner
            and e.start_s < event.start_s + event.duration_s
            and event.start_s < e.start_s + e.duration_s
        ]
        side: TurnSide = "left" if event.wheel.endswith("l") else "right"
        found[side] = 1 - (1 - found[side]) * (1 - max(pairs, default=0.0))
    return found


_HEIGHT = {
    "identified": "the CG height is this log's, with its interval",
    "weak": "the CG height is weakly known, and its interval is mostly what was known before",
    "not_identifiable": "the CG height is that of vehicles like this one, not this log's",
}
_MEANING = (
    "exceeded means that one side's wheels carried nothing at some time, not that the vehicle fell over"
)


def exceedance(
    reached: Mapping[TurnSide, float], body: Body, *, by_forces: bool, guessed_roll: bool
) -> Exceedance:
    """Probability that either side's wheels carried nothing at any time.

    reached: side -> its probability; the nearer side's is a lower bound for both together and the larger one counts.
    by_forces: it is from tyre forces. guessed_roll: body roll is a usual one, neither measured nor from the verdict.
    """
    probability = max(reached.values())
    if by_forces:
        return Exceedance(
            probability, in_words(probability), ("told by the tyre forces with their intervals", _MEANING)
        )
    assumptions = [
        _HEIGHT[body.told.status],
        "the height, track, CG offset, roll gradient, sensor offsets and the error of the relation vary independently of each other",
        f"motion below {CUTOFF_HZ:g} Hz; no curb, no trip, no soft shoulder",
        "by accelerations alone a lift cannot be told for sure: at the limit the share moved across stays at 1, "
        f"and {100 * AT_LIMIT:.0f} % as many drives are taken to end there as are spread below it",
        _MEANING,
    ]
    if guessed_roll:
        assumptions.append(
            "body roll of a usual vehicle: this log knows neither a roll angle nor a roll gradient"
        )
    return Exceedance(probability, in_words(probability), tuple(assumptions))


def unknown(why: str) -> Exceedance:
    """No probability, and why."""
    return Exceedance(None, f"not known: {why}")
