"""A torque or a force of another scale than the log says: found by all else, and joined without it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.evidence import Evidence
from pipelines.joint.channels import CHANNELS, TORQUE, WRONG, channels_of
from pipelines.joint.doubts.listed import doubts_of
from pipelines.joint.doubts.weighed import WIDER, WRONG_FILE
from pipelines.joint.inference import infer
from pipelines.joint.posterior import find_mode
from pipelines.joint.reached import Reached, reach
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.joint.ways.channel_ways import channel_ways
from tests.pipelines import joint_parts
from tests.pipelines.joint_parts import vehicle

KNOWN = before_the_log(vehicle())
LOAD = 100.0


def linear(rows: dict[str, float], observed: float, std: float, carrier: str = "made up") -> Evidence:
    """Signals of their own, that no other relation has."""
    return replace(joint_parts.linear(rows, observed, std, carrier), carrier=carrier)


def _weighed_load() -> list[Evidence]:
    """Two other signals that tell the load."""
    return [
        linear({"load": 1.0}, LOAD, 8.0, "scales"),
        linear({"load": 1.0, "empty_mass": 1.0}, 1900.0 + LOAD, 12.0, "a weighbridge"),
    ]


def _torque(factor: float) -> Evidence:
    """A log whose torque is that many times the wheels'."""
    return linear({"load": 1.0, "drive_scale": 2000.0}, LOAD + 2000.0 * (1 + np.log(factor)), 20.0, "torque")


def _reached(*evidence: Evidence) -> Reached:
    found = reach(evidence, vehicle(), np.random.default_rng(0))
    assert found is not None
    return found


def test_every_scale_is_an_unknown() -> None:
    names = [name for scales, _ in CHANNELS.values() for name in scales]
    assert {*names} <= {*KNOWN.names}
    assert len({*names}) == len(names)


def test_a_channel_is_asked_where_a_relation_has_it() -> None:
    assert list(channels_of(_weighed_load())) == []
    assert list(channels_of([*_weighed_load(), _torque(1.0)])) == ["drive torque"]


@pytest.mark.parametrize("factor", [1.0, 1.1, 1.25])
def test_odds_are_those_of_two_integrals(factor: float) -> None:
    """One figure of one unknown under two priors, exactly."""
    seen = 1 + np.log(factor)
    evidence = [linear({"drive_scale": 1.0}, seen, 0.02)]
    ((name, odds, _, _),) = channel_ways(find_mode(evidence, KNOWN), evidence, KNOWN)

    def log_density(std: float) -> float:
        spread = std**2 + 0.02**2
        return float(-0.5 * (seen - 1) ** 2 / spread - 0.5 * np.log(spread))

    assert name == "drive torque"
    exact = log_density(TORQUE) - log_density(0.04) + np.log(WRONG_FILE / (1 - WRONG_FILE))
    assert odds == pytest.approx(exact, abs=1e-3)


@pytest.mark.parametrize("factor", [0.1, 0.6, 1.6])
def test_a_wrong_torque_alone_takes_nothing_with_it(factor: float) -> None:
    found = _reached(*_weighed_load(), _torque(factor))
    assert found.found[0].startswith("drive torque of a wrong scale (range, gear, unit?)")
    assert found.others == ()
    assert not any(c.in_conflict for c in found.checks)
    result = infer([*_weighed_load(), _torque(factor)], vehicle(), np.random.default_rng(0))
    assert result is not None
    mass = result.parameters["mass_kg"]
    assert mass.status == "identified"
    assert mass.value is not None
    assert mass.std is not None
    assert abs(mass.value - 2000.0) < 2 * mass.std < 40.0
    # one cause, named once
    assert not any(text.startswith("drive torque") for text in result.record.far)


def test_where_something_else_contradicts_as_well_nothing_is_settled() -> None:
    """Scales of a load by 60 standard deviations off each other: no torque explains that."""
    evidence = (*_weighed_load(), linear({"load": 1.0}, LOAD + 500.0, 8.0, "other scales"), _torque(0.6))
    assert not _reached(*evidence).found[0].startswith("drive torque of a wrong scale (range")


def test_a_right_torque_is_not_asked() -> None:
    found = _reached(*_weighed_load(), _torque(1.03))
    assert found.found == ()
    assert found.others == ()


def test_a_wrong_scale_has_its_chance_where_nothing_contradicts_it() -> None:
    evidence = [_torque(1.12)]
    joint = find_mode(evidence, KNOWN)
    (doubt,) = [d for d in doubts_of(joint, vehicle()) if d.doubt.text == WRONG.format("drive torque")][:1]
    row = doubt.doubt.names.index("drive_scale")
    assert doubt.doubt.precision[row, row] == pytest.approx(WIDER**-2)
    assert not any(d.doubt.text.startswith("axle loads") for d in doubts_of(joint, vehicle()))
    assert not any(
        d.doubt.text.startswith("drive torque") for d in doubts_of(joint, vehicle(), "drive torque")
    )
