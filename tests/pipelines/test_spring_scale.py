"""Spring rates against deflections: where the log has their product otherwise, a roll angle by deflections is no surer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.evidence import Evidence
from pipelines.joint.doubts.listed import doubts_of
from pipelines.joint.posterior import find_mode
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.joint.ways.spring_scale import springs_off
from pipelines.results import Estimate, ParameterEstimate
from pipelines.verdict.combine import verdict_of
from tests.pipelines.joint_parts import linear, vehicle

NAME = "roll_gradient_degpg"


def _springs(share: float) -> list[Evidence]:
    """A log that has both rates at that share of the stated ones, to half a per cent."""
    known = before_the_log(vehicle())
    rates = {n: float(known.mean[known.index(n)]) for n in ("spring_front", "spring_rear")}
    return [
        replace(
            linear({n: 1.0}, share * rate, 0.005 * rate, n), carrier=f"{n} by spring deflections", kind="roll"
        )
        for n, rate in rates.items()
    ]


@pytest.mark.parametrize(("share", "low", "high"), [(1.0, 0.0, 0.0), (1.03, 0.0, 0.0), (0.75, 0.15, 0.3)])
def test_the_share_is_what_the_log_has_them_otherwise(share: float, low: float, high: float) -> None:
    joint = find_mode(_springs(share), before_the_log(vehicle()))
    assert low <= springs_off(joint, doubts_of(joint, vehicle()), vehicle()) <= high


def test_unstated_springs_are_no_contradiction() -> None:
    silent = replace(
        vehicle(),
        quantities={k: q for k, q in vehicle().quantities.items() if not k.startswith("spring_rate")},
    )
    joint = find_mode(_springs(0.75), before_the_log(silent))
    assert springs_off(joint, doubts_of(joint, silent), silent) == 0.0


@pytest.mark.parametrize(("share", "weak"), [(1.0, False), (0.75, True)])
def test_the_gradient_by_deflections_is_no_surer(share: float, weak: bool) -> None:
    told = {NAME: ParameterEstimate(NAME, 4.0, 0.1, 3.804, 4.196, "identified", "seen")}
    found = verdict_of(
        (Estimate("one", "ran", "", told, evidence=tuple(_springs(share))),), vehicle()
    ).parameters[NAME]
    assert found.value == 4.0
    assert found.std is not None
    assert (found.status == "weak") is weak
    assert (found.std > 0.5) is weak
    assert ("scale of the deflections" in found.reason) is weak


def test_a_gradient_of_another_estimator_stays_beside_deflections() -> None:
    """A navigation unit's roll leads; the springs are otherwise all the same."""
    one = {NAME: ParameterEstimate(NAME, 4.0, 0.1, 3.804, 4.196, "identified", "seen")}
    ins = Estimate("ins", "ran", "", one)
    other = {NAME: ParameterEstimate(NAME, 4.0, 0.2, 3.608, 4.392, "identified", "seen by deflections")}
    springs = Estimate("one", "ran", "", other, evidence=tuple(_springs(0.75)))
    found = verdict_of((ins, springs), vehicle()).parameters[NAME]
    assert "scale of the deflections" not in found.reason
    assert found.status == "identified"


def test_a_gradient_by_an_angle_against_the_horizon_stays() -> None:
    told = {NAME: ParameterEstimate(NAME, 4.0, 0.1, 3.804, 4.196, "identified", "seen")}
    evidence = tuple(replace(e, carrier="horizon", title=e.title + "!") for e in _springs(0.75)[:1])
    other = tuple(replace(e, carrier="struts", kind="vertical") for e in _springs(0.75)[1:])
    found = verdict_of((Estimate("one", "ran", "", told, evidence=evidence + other),), vehicle()).parameters[
        NAME
    ]
    assert "scale of the deflections" not in found.reason
    assert np.isclose(found.value or 0, 4.0)
