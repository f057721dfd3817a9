"""A vehicle file against the log: closed forms on linear relations, wrong figures, and quiet axes that hid a conflict."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.evidence import Evidence, Values
from pipelines.joint.conflict import check
from pipelines.joint.file_check import LIGHTER, SOURCE, file_check, misfit, worse_test
from pipelines.joint.inference import infer
from pipelines.joint.posterior import find_mode
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.results import FloatArray
from tests.pipelines.joint_parts import linear, vehicle

KNOWN = before_the_log(vehicle())


def test_chi2_is_that_of_the_log_alone_against_the_file() -> None:
    """One unknown measured directly: (measured - stated)² over both variances."""
    joint = find_mode([linear({"empty_mass": 1.0}, 2000.0, 30.0)], KNOWN)
    row = [KNOWN.index("empty_mass")]
    found, count = misfit(joint.u[row], joint.covariance[np.ix_(row, row)])
    assert count == 1
    assert found == pytest.approx(100.0**2 / (30.0**2 + 19.0**2), rel=1e-4)


def test_what_the_log_does_not_see_is_not_judged() -> None:
    joint = find_mode([linear({"load": 1.0}, 900.0, 10.0)], KNOWN)
    row = [KNOWN.index("wheelbase")]
    assert misfit(joint.u[row], joint.covariance[np.ix_(row, row)])[1] == 0
    assert file_check(joint, vehicle()) == ()


def test_springs_wrong_alike_show_in_their_sum() -> None:
    """1.9 standard deviations each, half seen: by themselves a shrug, alike a contradiction."""
    u, covariance = np.array([1.7, 1.7]), np.array([[0.75, -0.2], [-0.2, 0.75]])
    probability, amount, count = worse_test(u, covariance)
    assert count == 1
    assert amount == pytest.approx(2 * 1.7**2 / 0.45)
    assert probability < 0.003 < 0.05


@pytest.mark.parametrize(("off", "conflict"), [(10.0, False), (200.0, True)])
def test_a_mass_that_the_log_contradicts_is_named_and_its_interval_holds_both(
    off: float, conflict: bool
) -> None:
    stated = vehicle()
    relations = [linear({"empty_mass": 1.0}, 1900.0 + off, 15.0), linear({"load": 1.0}, 100.0, 10.0)]
    joint = find_mode(relations, KNOWN)
    checks = file_check(joint, stated)
    assert [c.record.relation for c in checks] == (["stated mass"] if conflict else [])
    found = infer(relations, stated, np.random.default_rng(0))
    assert found is not None
    answer = found.parameters["mass_kg"]
    assert answer.low is not None
    assert answer.high is not None
    assert any(c.source == SOURCE for c in found.record.relations) is conflict
    assert answer.low < 2000.0 + off < answer.high
    if conflict:
        assert "stated mass" in answer.reason
        # released from the file's figure, the mode goes nearly to what the log says
        moved = joint.u + checks[0].shift
        row = KNOWN.index("empty_mass")
        assert KNOWN.mean[row] + KNOWN.std[row] * moved[row] == pytest.approx(2100.0, abs=20.0)


def _quiet(axes: int, tells: float) -> Evidence:
    """One figure of the load among many that every vehicle predicts as nought."""

    def predict(values: Values) -> FloatArray:
        load = np.asarray(values["load"], dtype=np.float64)
        rest = [np.zeros_like(load)] * axes
        return np.stack([load, *rest])

    return Evidence(
        "pitch", "made up", "many figures", "by hand", np.array([tells, *([0.0] * axes)]), np.eye(axes + 1) * 100.0,
        predict, ("load",),
    )  # fmt: skip


@pytest.mark.parametrize("axes", [0, 12])
def test_quiet_figures_do_not_hide_one_that_contradicts(axes: int) -> None:
    """At 3.6 standard deviations one figure is a conflict, whatever else the relation predicts rightly."""
    relations = [linear({"load": 1.0}, 100.0, 40.0), _quiet(axes, 100.0 + 3.6 * np.hypot(40.0, 10.0))]
    found = check(find_mode(relations, KNOWN))
    assert found[1].in_conflict
    assert found[1].record.numbers == 1


@pytest.mark.parametrize(("load", "conflict"), [(-250.0, True), (-30.0, False), (900.0, False)])
def test_no_load_is_less_than_nothing(load: float, conflict: bool) -> None:
    """A load of minus 250 ± 40 kg is another vehicle's file; one of minus 30 is nobody aboard, and one of 900 a cargo."""
    joint = find_mode([linear({"load": 1.0}, load, 40.0)], KNOWN)
    assert [c.record.relation for c in file_check(joint, vehicle())] == ([LIGHTER] if conflict else [])


def test_an_empty_mass_above_the_laden_one_leaves_room_for_the_file() -> None:
    """Either may be wrong: the mass is as unsure as the way from what the log has to nobody aboard."""
    joint = find_mode([linear({"load": 1.0}, -250.0, 40.0)], KNOWN)
    (found,) = file_check(joint, vehicle())
    row = KNOWN.index("load")
    assert KNOWN.mean[row] + KNOWN.std[row] * (joint.u[row] + found.shift[row]) == pytest.approx(
        0.0, abs=1e-6
    )
    told = infer([linear({"load": 1.0}, -250.0, 40.0)], vehicle(), np.random.default_rng(0))
    assert told is not None
    mass = told.parameters["mass_kg"]
    assert mass.value is not None
    assert mass.std is not None
    assert mass.status != "identified"
    empty = float(KNOWN.mean[KNOWN.index("empty_mass")])
    assert mass.value + 1.96 * mass.std > empty
