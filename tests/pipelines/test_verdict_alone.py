"""What one estimator alone tells is no surer than its own relation."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pipelines.results import Estimate, ParameterEstimate
from pipelines.verdict.combine import AGAINST, _Given, as_sure_as_its_relation, verdict_of
from tests.pipelines.joint_parts import linear, vehicle

NAME = "roll_gradient_degpg"


def _estimate(source: str, load: float, std: float, gradient: float | None = None) -> Estimate:
    told = {}
    if gradient is not None:
        told[NAME] = ParameterEstimate(
            NAME, gradient, 0.1, gradient - 0.196, gradient + 0.196, "identified", "seen"
        )
    return Estimate(source, "ran", "", told, evidence=(linear({"load": 1.0}, load, std, source),))


@pytest.mark.parametrize(("load", "doubtful"), [(205.0, False), (260.0, True)])
def test_its_spread_grows_by_the_factor_of_its_relation(load: float, doubtful: bool) -> None:
    """The same load by two: 260 ± 10 kg beside 200 ± 10 kg contradict each other at 4.2 standard deviations."""
    told = _estimate("one", load, 10.0, 4.0)
    # another carrier, or the two would be one relation
    other = _estimate("other", 200.0, 10.0)
    other = replace(other, evidence=(replace(other.evidence[0], carrier="something else"),))
    found = verdict_of((told, other), vehicle())
    entry = found.parameters[NAME]
    assert found.joint is not None
    widened = max(r.widened for r in found.joint.relations if r.source == "one")
    assert (widened > 1) is doubtful
    assert entry.value == 4.0
    assert entry.std == pytest.approx(0.1 * widened)
    assert entry.high == pytest.approx(4.0 + 1.96 * 0.1 * widened)
    assert ("contradicts the rest" in entry.reason) is doubtful


def test_it_is_no_surer_than_the_relation_that_was_counted_in_its_place() -> None:
    """One relation by two estimators: the one that tells more is counted, and contradicts the rest; the other one's gradient leads."""
    counted, told = _estimate("counted", 260.0, 9.0, 4.2), _estimate("one", 260.0, 10.0, 4.0)
    wide = replace(counted.parameters[NAME], std=0.3, low=3.6, high=4.8)
    counted = replace(counted, parameters={NAME: wide})
    other = _estimate("other", 200.0, 10.0)
    other = replace(other, evidence=(replace(other.evidence[0], carrier="something else"),))
    found = verdict_of((counted, told, other), vehicle())
    assert found.joint is not None
    assert [r.source for r in found.joint.relations if r.widened > 1]
    widened = max(r.widened for r in found.joint.relations if r.source == "counted")
    assert widened > 1
    assert found.parameters[NAME].value == 4.0
    assert found.parameters[NAME].std == pytest.approx(0.3 * widened)


def test_what_explains_the_drive_otherwise_stands_beside_the_widening() -> None:
    entry = replace(_estimate("one", 200.0, 10.0, 4.0).parameters[NAME])
    lead = _Given("one", False, entry)
    plain = as_sure_as_its_relation(lead, entry, 2.0)
    told = as_sure_as_its_relation(lead, entry, 2.0, ("tyres that do not give: the drive fits no others",))
    assert told.std == plain.std
    assert "contradicts the rest: the interval" in plain.reason
    assert "contradicts the rest (not with tyres that do not give): the interval" in told.reason
    none = as_sure_as_its_relation(lead, entry, float("inf"), ("rigid tyres",))
    assert none.status == "not_identifiable"
    assert "(not with rigid tyres), and no spread" in none.reason


def test_a_parameter_without_relations_stays_as_told() -> None:
    alone = Estimate("one", "ran", "", _estimate("one", 200.0, 10.0, 4.0).parameters)
    assert verdict_of((alone,), vehicle()).parameters[NAME].std == 0.1


def test_where_the_counted_relation_does_not_tell_the_parameter_the_answer_is_half_as_sure() -> None:
    """The same motion as another estimator reduced it contradicts the rest, and that one has no gradient."""
    told, other = _estimate("one", 260.0, 10.0, 4.0), _estimate("other", 200.0, 10.0)
    other = replace(other, evidence=(replace(other.evidence[0], carrier="something else"),))
    found = verdict_of((_estimate("counted", 260.0, 9.0), told, other), vehicle())
    entry = found.parameters[NAME]
    assert (entry.value, entry.status) == (4.0, "weak")
    assert entry.std == pytest.approx(AGAINST * 0.1)
    assert "contradicts the rest" in entry.reason


@pytest.mark.parametrize("widened", [float("inf"), float("nan")])
def test_a_relation_that_no_spread_reconciles_tells_nothing(widened: float) -> None:
    entry = _estimate("one", 200.0, 10.0, 4.0).parameters[NAME]
    found = as_sure_as_its_relation(_Given("one", False, entry), entry, widened)
    assert (found.status, found.value, found.std, found.low, found.high) == ("not_identifiable", *[None] * 4)
    assert "times as wide" not in found.reason
    assert "contradicts the rest" in found.reason


def test_who_saw_bump_stops_leads_though_another_is_surer() -> None:
    """Only one estimator looks at the springs' travel: one that does not is as sure as ever of a gradient that stops made."""
    words = "bump stops were touched in 98% of the bends"
    seen = ParameterEstimate(NAME, 9.3, 0.96, 7.4, 11.2, "weak", f"{words}; seen", refused=f"{words}; ")
    sure = _estimate("sure", 200.0, 10.0, 8.6)
    found = verdict_of((sure, Estimate("looks", "ran", "", {NAME: seen})), vehicle()).parameters[NAME]
    assert (found.value, found.std, found.status) == (9.3, 0.96, "weak")
    assert words in found.reason
    # a stranger's doubt about another parameter does not put it first
    doubted = ParameterEstimate("roll_damping_ratio", 0.3, 0.05, 0.2, 0.4, "weak", "seen", refused="odd; ")
    plain = ParameterEstimate("roll_damping_ratio", 0.2, 0.01, 0.18, 0.22, "identified", "seen")
    pair = [Estimate(s, "ran", "", {p.name: p}) for s, p in (("a", doubted), ("b", plain))]
    assert verdict_of(pair, vehicle()).parameters["roll_damping_ratio"].value == 0.2
