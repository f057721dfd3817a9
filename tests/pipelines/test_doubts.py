"""Doubts of what was taken for known: exact mixtures on linear relations, what the log does not see, what it speaks for."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t as student

from pipelines.joint.answers import Told
from pipelines.joint.doubts.listed import doubts_of, said
from pipelines.joint.doubts.simple_models import BETWEEN, HUBS, LEAN, SIMPLE, STILL, UPRIGHT, WHEELS
from pipelines.joint.doubts.stated_figures import OFTEN_WRONG, UNLIKE, WEIGHED, chance_wrong
from pipelines.joint.doubts.weighed import WIDER, WRONG_FILE
from pipelines.joint.mixture import doubted
from pipelines.joint.posterior import find_mode
from pipelines.joint.tails import FREEDOM
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.results import INNER, FloatArray
from pipelines.vehicles.vehicle import Quantity, Vehicle
from tests.pipelines.joint_parts import linear, told_height, vehicle

KNOWN = before_the_log(told_height(vehicle()))
MASS = KNOWN.index("empty_mass")


def _normal(x: FloatArray, mean: float, std: float) -> FloatArray:
    return np.asarray(np.exp(-0.5 * ((x - mean) / std) ** 2) / std)


def _moments(x: FloatArray, density: FloatArray) -> tuple[float, float]:
    mean = float(x @ density / density.sum())
    return mean, math.sqrt(float((x - mean) ** 2 @ density / density.sum()))


def _heavy(x: FloatArray, mean: float, std: float) -> FloatArray:
    """Share below x of Student's distribution with the 95 % interval of a normal one."""
    outer = student.ppf(0.975, FREEDOM) / 1.959964
    return np.asarray(student.cdf(outer * (x - mean) / std, FREEDOM))


def _only(title: str) -> Vehicle:
    """A file that states nothing that could be doubted but one figure."""
    whole = vehicle()
    return told_height(replace(whole, quantities={k: v for k, v in whole.quantities.items() if k == title}))


def _with(**figures: float) -> Vehicle:
    whole = vehicle()
    more = {key: Quantity(value, 0.01 * abs(value), "rig") for key, value in figures.items()}
    return replace(whole, quantities={**whole.quantities, **more})


def test_figures_of_a_rig_are_wrong_less_often_than_a_data_sheets() -> None:
    sheet, weighed = _only("mass_kg"), _with(cg_lateral_offset_m=0.004)
    assert chance_wrong("stated mass", sheet) == OFTEN_WRONG["stated mass"]
    assert chance_wrong("stated mass", weighed) == WRONG_FILE
    assert chance_wrong("stated place of the CG", weighed) == WEIGHED
    assert chance_wrong("stated place of the CG", sheet) == WRONG_FILE
    assert chance_wrong("stated spring rates", weighed) == chance_wrong("stated spring rates", sheet)
    rates = {
        f"spring_rate_{axle}{end}_npm": 28e3
        for axle in ("front", "rear")
        for end in ("", "_bump", "_rebound")
    }
    one_axle = {key: rate for key, rate in rates.items() if "rear" not in key}
    assert chance_wrong("stated spring rates", _with(**rates)) == WRONG_FILE
    assert chance_wrong("stated spring rates", _with(**one_axle)) == OFTEN_WRONG["stated spring rates"]
    assert chance_wrong("stated tracks", _with(**rates)) == WRONG_FILE


def test_an_empty_height_that_is_far_from_the_measured_vehicles_may_be_unlike_them() -> None:
    """Three of their spreads below; a file that states the height has no such doubt."""
    far, height = KNOWN.index("empty_h"), float(KNOWN.mean[KNOWN.index("empty_h")])
    seen = height - 3 * float(KNOWN.std[far])
    joint = find_mode([linear({"empty_h": 1.0}, seen, 0.01)], KNOWN)
    asked = [d for d in doubts_of(joint, _only("mass_kg")) if d.doubt.names == ("empty_h",)]
    assert [d.doubt.chance for d in asked] == [UNLIKE]
    assert 4 * UNLIKE < asked[0].weight < 20 * UNLIKE
    # and it is lower than with the measured vehicles' spread
    assert asked[0].moved[0] * KNOWN.std[far] < -0.001
    stated = _with(cg_height_m=0.6)
    assert not [d for d in doubts_of(joint, stated) if "unlike" in d.doubt.text]


def test_what_a_rig_found_is_not_left_out_by_a_simple_author() -> None:
    joint = find_mode([linear({"empty_mass": 1.0}, 1900.0, 15.0)], KNOWN)

    def left_out(file: Vehicle) -> set[str]:
        return {piece for d in doubts_of(joint, file) for piece in d.doubt.text.split(BETWEEN)}

    assert left_out(vehicle()) >= {WHEELS, UPRIGHT}
    assert not left_out(vehicle()) & {LEAN, HUBS}
    assert UPRIGHT not in left_out(_with(patch_path_pitch_mprad=0.38))
    assert WHEELS not in left_out(_with(tire_longitudinal_rate_npm=3e5))
    # who states what wheels weigh in turning has them spin up, and may keep their patches under them all the same
    spun = left_out(_with(wheel_inertia_kgm2=1.2))
    assert WHEELS not in spun
    assert STILL in spun


def test_weight_that_does_not_tip_and_hubs_that_load_no_spring_are_doubts_of_relations_that_hang_on_them() -> (
    None
):
    leaning, hubs = linear({"lean_path": 1.0}, 0.0, 1.0), linear({"hubs_past": 1.0}, 0.1, 1.0)
    joint = find_mode([leaning, hubs], KNOWN)

    def chance(piece: str, file: Vehicle) -> float:
        every = doubts_of(joint, file)
        return sum(d.doubt.chance for d in every if piece in d.doubt.text.split(BETWEEN))

    assert chance(HUBS, vehicle()) > 1.5 * chance(LEAN, vehicle()) > 0.2 * SIMPLE
    assert chance(HUBS, _with(wheel_recession_front=0.05, wheel_recession_rear=0.1)) == 0
    assert chance(LEAN, _with(patch_path_pitch_mprad=0.38)) == 0
    assert sum(d.doubt.chance for d in doubts_of(joint, vehicle()) if BETWEEN in d.doubt.text) < SIMPLE + 0.1


def test_loads_that_know_no_lean_are_heard_of() -> None:
    """As a relation that sees the CG's arm above the roll axis would have it, where nobody thought of such a model."""
    arm = 0.5
    joint = find_mode([linear({"lean_path": 1.0}, arm, 0.02)], KNOWN)
    doubts = doubts_of(joint, vehicle())
    spoken = sum(d.weight for d in doubts if LEAN in d.doubt.text.split(BETWEEN))
    assert spoken > 0.9
    gradient = np.zeros(len(joint.u))
    gradient[KNOWN.index("lean_path")] = KNOWN.std[KNOWN.index("lean_path")]
    answer = Told(0.0, 0.01, -0.02, 0.02, None)
    assert doubted(answer, gradient, doubts).value + 0.01 * joint.u[
        KNOWN.index("lean_path")
    ] == pytest.approx(arm, abs=0.12)


@pytest.mark.parametrize("seen", [1900.0, 1960.0, 2100.0])
def test_the_mean_and_spread_are_those_of_the_mixture(seen: float) -> None:
    """One unknown, two priors: the posterior by brute force on a grid."""
    stated = _only("mass_kg")
    joint = find_mode([linear({"empty_mass": 1.0}, seen, 15.0)], KNOWN)
    doubts = tuple(d for d in doubts_of(joint, stated) if d.doubt.names == ("empty_mass",))
    # by five of its spreads, and by eight hundredths of it
    assert [float(d.doubt.precision[0, 0]) ** -0.5 for d in doubts] == pytest.approx([WIDER, 8.0])
    odds = doubts[0].weight / (1 - sum(d.weight for d in doubts_of(joint, stated)))
    x = np.linspace(1500, 2600, 200001)
    told, likelihood = _normal(x, 1900.0, 19.0), _normal(x, seen, 15.0)
    wrong = _normal(x, 1900.0, 19.0 * WIDER)
    others = 1 - sum(d.doubt.chance for d in doubts_of(joint, stated))
    exact = OFTEN_WRONG["stated mass"] * (wrong @ likelihood) / (others * (told @ likelihood))
    assert math.log(odds) == pytest.approx(math.log(exact), abs=0.01)
    gradient = np.zeros(len(joint.u))
    gradient[MASS] = KNOWN.std[MASS]
    middle = KNOWN.mean[MASS] + KNOWN.std[MASS] * joint.u[MASS]
    std = float(np.sqrt(gradient @ joint.covariance @ gradient))
    answer = Told(middle, std, middle - 1.96 * std, middle + 1.96 * std, None)
    share = odds / (1 + odds)
    found = doubted(answer, gradient, [replace(doubts[0], weight=share)])
    both = (1 - share) * told * likelihood / (told @ likelihood) + share * wrong * likelihood / (
        wrong @ likelihood
    )
    mean = float(x @ both / both.sum())
    assert found.value == pytest.approx(mean, abs=0.02)
    assert found.std == pytest.approx(math.sqrt(float((x - mean) ** 2 @ both / both.sum())), rel=2e-3)
    # the interval is that of the same mixture with Student's tails
    rises = sum(
        weight * _heavy(x, *_moments(x, part))
        for weight, part in ((1 - share, told * likelihood), (share, wrong * likelihood))
    )
    for bound, quantile in ((found.low, 0.025), (found.high, 0.975)):
        assert bound == pytest.approx(float(np.interp(quantile, rises, x)), abs=0.02 * found.std)
    for interval, level in zip(found.inner, INNER, strict=True):
        exact_ = np.interp([0.5 - level / 2, 0.5 + level / 2], rises, x)
        assert interval == pytest.approx(tuple(exact_.tolist()), abs=0.02 * found.std)
    # the same by draws
    draws = np.random.default_rng(1).normal(middle, std, 40_000)
    drawn = doubted(replace(answer, draws=draws), gradient, [replace(doubts[0], weight=share)])
    assert (drawn.low, drawn.high) == pytest.approx((found.low, found.high), abs=0.06 * found.std)
    assert drawn.inner[0] == pytest.approx(found.inner[0], abs=0.06 * found.std)


def test_a_figure_that_the_log_does_not_see_keeps_its_chance_and_moves_nothing() -> None:
    joint = find_mode([linear({"load": 1.0}, 180.0, 10.0)], KNOWN)
    gradient = np.zeros(len(joint.u))
    gradient[KNOWN.index("load")] = 1.0
    doubts = doubts_of(joint, told_height(vehicle()))
    assert sum(d.weight for d in doubts) == pytest.approx(sum(d.doubt.chance for d in doubts), rel=0.05)
    answer = Told(180.0, 10.0, 160.4, 199.6, np.linspace(150, 210, 7))
    found = doubted(answer, gradient, doubts)
    assert found.value == pytest.approx(180.0, abs=0.01)
    assert found.std == pytest.approx(10.0, rel=1e-3)
    assert found.draws == pytest.approx(np.linspace(150, 210, 7), abs=0.1)


def test_physics_that_the_log_contradicts_is_named_and_left() -> None:
    """Wheels without inertia, patches that do not lag: what the log says of them decides."""
    blind = [linear({"wheel_inertia": 1.0}, 0.0, 0.1), linear({"patch_lag": 1.0}, 0.0, 1e-3)]
    doubts = doubts_of(find_mode(blind, KNOWN), vehicle())
    physics = [d.weight for d in doubts if "wheel_inertia" in d.doubt.names]
    assert sum(physics) > 0.9
    assert said(doubts)[0].startswith("wheels that take no torque to spin up (")
    usual = doubts_of(find_mode([linear({"wheel_inertia": 1.0}, 1.2, 0.1)], KNOWN), vehicle())
    assert said(usual) == ()
    assert sum(d.weight for d in usual if "wheel_inertia" in d.doubt.names) < 1e-3


def test_what_the_file_states_is_not_left_out() -> None:
    """Roll centres are in this file; unsprung masses and pitch centres are not."""
    joint = find_mode([linear({"load": 1.0}, 180.0, 10.0)], KNOWN)
    texts = {piece for d in doubts_of(joint, vehicle()) for piece in d.doubt.text.split(BETWEEN)}
    assert "no unsprung masses" in texts
    assert "a roll axis in the ground" not in texts
    assert "a roll axis in the ground" in {
        piece for d in doubts_of(joint, _only("mass_kg")) for piece in d.doubt.text.split(BETWEEN)
    }
