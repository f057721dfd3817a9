"""Outlying vehicles: found, ranked, compared with their kind only, or with their own data sheet."""

from __future__ import annotations

import itertools
import random
from dataclasses import replace

import numpy as np
import pytest

from pipelines.hierarchy.outliers import CHANCE, rank
from pipelines.hierarchy.records import VehicleKnowledge
from tests.pipelines.hierarchy.knowledge import estimate, knowledge

STIFF, MASS = "roll_stiffness_nmprad", "empty_mass_kg"
SHEET = {STIFF: (80e3, 8e3), MASS: (1900.0, 60.0)}


def fleet(count: int, seed: int = 0, weak: float = 1.0, name: str = "v") -> list[VehicleKnowledge]:
    """Vehicles alike: their true figures scatter by 2 %, their intervals are 1 %; the last one's roll stiffness x weak."""
    rng = np.random.default_rng(seed)
    found = []
    for number in range(count):
        truth = {
            STIFF: 80e3 * (1 + 0.02 * rng.standard_normal()),
            MASS: 1900.0 * (1 + 0.005 * rng.standard_normal()),
        }
        truth[STIFF] *= weak if number == count - 1 else 1.0
        stds = {STIFF: 800.0, MASS: 10.0}
        values = {n: truth[n] + stds[n] * rng.standard_normal() for n in truth}
        answers = {n: estimate(n, values[n], stds[n], prior=SHEET[n]) for n in truth}
        height = 0.68 + 0.01 * rng.standard_normal()
        drives = {
            f"{name}{number}d{i}": {"cg_height_m": estimate("cg_height_m", height, 0.01)} for i in range(4)
        }
        found.append(knowledge(f"{name}{number:02d}", answers, drives))
    return found


def test_a_soft_vehicle_comes_first() -> None:
    found = rank(fleet(12, weak=0.75), None)
    first = found[0]
    assert (first.rank, first.vehicle_id, first.parameter) == (1, "v11", STIFF)
    assert first.probability < CHANCE
    assert first.score > 5
    assert first.others == pytest.approx(80e3, rel=0.03)
    assert "Stands out: roll stiffness" in first.text
    assert "below" in first.text
    assert "11 others" in first.text
    assert [o.rank for o in found] == list(range(1, 13))
    assert all(o.probability > CHANCE for o in found[1:])
    assert all(a.probability <= b.probability for a, b in itertools.pairwise(found))


def test_false_alarms_of_alike_vehicles() -> None:
    """A vehicle of a fleet without an odd one stands out in 1 % at most."""
    chances = [o.probability for seed in range(60) for o in rank(fleet(10, seed), None)]
    assert len(chances) == 600
    assert np.mean(np.array(chances) < CHANCE) < 0.025


def test_the_order_given_does_not_matter() -> None:
    vehicles = fleet(8, weak=0.8)
    shuffled = list(vehicles)
    random.Random(2).shuffle(shuffled)
    assert rank(shuffled, None) == rank(vehicles, None)


def test_kinds_are_compared_among_themselves() -> None:
    cars, vans = fleet(6, 1, name="car"), fleet(6, 2, name="van")
    heavy = [
        knowledge(
            v.vehicle_id,
            {MASS: estimate(MASS, (v.vehicle[MASS].estimate.value or 0.0) + 900.0, 10.0)},
        )
        for v in vans
    ]
    kinds = {v.vehicle_id: v.vehicle_id[:3] for v in (*cars, *heavy)}
    assert all(o.probability > CHANCE for o in rank([*cars, *heavy], kinds))


def test_few_of_a_kind_are_compared_with_their_data_sheet() -> None:
    soft = knowledge("soft", {STIFF: estimate(STIFF, 50e3, 800.0, prior=SHEET[STIFF])})
    right = knowledge("right", {STIFF: estimate(STIFF, 81e3, 800.0, prior=SHEET[STIFF])})
    first, second = rank([right, soft], {"soft": "suv", "right": "suv"})
    assert first.vehicle_id == "soft"
    assert "One of only 2 vehicles of its kind: compared with its own data sheet" in first.text
    assert "contradicts its drives" in first.text
    # 30 000 off; by chance a posterior of ± 800 moves sqrt(8000² - 800²)
    assert first.score == pytest.approx(30e3 / np.sqrt(8e3**2 - 800**2))
    assert (first.others, first.others_std) == SHEET[STIFF]
    assert "Goes with it" in second.text
    assert second.probability > 0.5


def test_a_doubted_answer_contradicts_its_data_sheet_less() -> None:
    """A doubt makes it wider and tells nothing: it must not pass for an answer that hardly left the sheet."""
    sure = knowledge("v", {STIFF: estimate(STIFF, 70e3, 2000.0, prior=SHEET[STIFF])})
    wide = estimate(STIFF, 70e3, float(np.hypot(2000.0, 6000.0)), prior=SHEET[STIFF])
    doubted = knowledge("v", {STIFF: wide})
    parameter = replace(doubted.vehicle[STIFF], doubt=6000.0)
    (before,) = rank([sure], None)
    (after,) = rank([replace(doubted, vehicle={STIFF: parameter})], None)
    assert after.score == pytest.approx(10e3 / np.sqrt(8e3**2 - 2e3**2 + 6e3**2))
    assert after.score < before.score


def test_without_a_kind_a_vehicle_is_alone() -> None:
    found = rank(fleet(5), {})
    assert all("The only vehicle of its kind" in o.text for o in found)


def test_a_data_sheet_that_is_wrong_is_said_of_a_vehicle_like_the_others() -> None:
    """Every vehicle weighs 250 kg more than the sheet has: none stands out, and each is said to contradict its sheet."""
    rng = np.random.default_rng(5)
    vehicles = [
        knowledge(
            f"v{i}", {MASS: estimate(MASS, 2150.0 + 5 * rng.standard_normal(), 10.0, prior=SHEET[MASS])}
        )
        for i in range(6)
    ]
    for outlier in rank(vehicles, None):
        assert outlier.probability > CHANCE
        assert "Goes with the others" in outlier.text
        assert "Its data sheet contradicts its drives: empty mass 1900 kg" in outlier.text


def test_a_typical_load_that_is_odd() -> None:
    vehicles = fleet(9)
    tall = knowledge(
        "tall", {n: p.estimate for n, p in vehicles[0].vehicle.items()},
        {f"d{i}": {"cg_height_m": estimate("cg_height_m", 0.85, 0.01)} for i in range(4)},
    )  # fmt: skip
    first = rank([*vehicles[1:], tall], None)[0]
    assert (first.vehicle_id, first.parameter) == ("tall", "typical cg_height_m")
    assert "CG height above ground as usually loaded 0.850 m" in first.text


def test_where_the_recorder_sits_is_no_matter_of_the_vehicle() -> None:
    """It is not compared with other vehicles', but a data sheet that has it wrong is said."""
    sheet = (0.5, 0.01)
    vehicles = fleet(6)
    moved = knowledge(
        "moved",
        {n: p.estimate for n, p in vehicles[0].vehicle.items()}
        | {"imu_left_m": estimate("imu_left_m", 0.9, 0.004, prior=sheet)},
    )
    found = {o.vehicle_id: o for o in rank([*vehicles[1:], moved], None)}
    assert found["moved"].parameter != "imu_left_m"
    assert "What is known of its recorder's place contradicts its drives: imu_left_m" in found["moved"].text


def test_many_vehicles_are_ranked_alike() -> None:
    """More than can be compared pair by pair: the odd one still comes first."""
    found = rank(fleet(300, weak=0.8), None)
    assert found[0].vehicle_id == "v299"
    assert found[0].probability < 1e-6
    assert sum(o.probability < CHANCE for o in found) < 10


def test_what_was_not_learned_is_not_compared() -> None:
    """Answers that are what was known before, or nothing, make no vehicle an outlier: it has no row."""
    silent = knowledge(
        "silent",
        {
            STIFF: estimate(STIFF, 80e3, 7.9e3, prior=SHEET[STIFF]),
            MASS: estimate(MASS, None, None, status="not_identifiable"),
        },
    )
    found = rank([*fleet(5), silent], None)
    assert "silent" not in {o.vehicle_id for o in found}
    assert len(found) == 5
    assert rank([], None) == ()


def test_a_figure_is_printed_as_fine_as_it_is_known() -> None:
    place = "pitch_center_height_drive_m"
    only = knowledge("only", {place: estimate(place, 0.0199412, 0.01, prior=(-0.0283612, 0.0301))})
    text = rank([only], None)[0].text
    assert f"{place} 0.020 is" in text
    assert "standard deviations from -0.028;" in text
    heavy = knowledge("heavy", {MASS: estimate(MASS, 2150.37, 1.0, prior=(1900.0, 240.0))})
    assert "empty mass 2150 kg is" in rank([heavy], None)[0].text
