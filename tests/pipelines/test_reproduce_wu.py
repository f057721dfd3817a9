"""`cogest reproduce wu`: Table 1's ordering, the four cases, the baseline's failure, and the bound."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipelines.reproduce.base import Reproduction
from pipelines.reproduce.registry import paper
from pipelines.reproduce.wu.plant import Truck, drive, mixture, mixture_information, mixture_variance
from pipelines.reproduce.wu.tables import baseline_noise_free


@pytest.fixture(scope="module")
def page() -> Reproduction:
    return paper("wu").reproduce(5, np.random.default_rng(0), lambda _text, _share: None)


def test_noise_of_17_has_variance_13_and_more_information_than_that() -> None:
    rng = np.random.default_rng(0)
    assert mixture_variance(0.5) == 13.0
    assert np.var(mixture(200_000, 0.5, rng)) == pytest.approx(13.0, rel=0.03)
    assert mixture_information(0.0) == pytest.approx(1.0, rel=1e-6)
    assert 1 / 13 < mixture_information(0.5) < 1


def test_plant_closes_its_balances() -> None:
    truck = Truck()
    run = drive(truck, rear_wheel_drive=False, slope=False, rich=False)
    np.testing.assert_allclose(run.front + run.rear, truck.mass * 9.80665, rtol=1e-12)
    moved = np.cumsum(0.5 * (run.acceleration[1:] + run.acceleration[:-1])) * 0.02
    np.testing.assert_allclose(run.speed[1:] - run.speed[0], moved, atol=0.01)
    assert run.acceleration.max() == pytest.approx(2.1, abs=0.02)
    assert run.acceleration.min() == pytest.approx(-1.7, abs=0.02)
    assert np.degrees(
        drive(truck, rear_wheel_drive=False, slope=True, rich=False).grade.max()
    ) == pytest.approx(6.0, abs=0.05)


def test_table_one_orders_the_filters(page: Reproduction) -> None:
    rows = {row[0]: row for row in page.tables[0].rows}
    huber, plain = rows["HKF"][2], rows["KF"][2]
    assert isinstance(huber, float)
    assert isinstance(plain, float)
    assert huber < 0.6 * plain
    assert plain == pytest.approx(0.965, rel=0.1)


def test_four_cases_are_within_the_claims(page: Reproduction) -> None:
    for row in page.tables[1].rows:
        error = row[3]
        assert isinstance(error, float)
        assert error < (2.0 if row[1] == "a" else 3.0)


def test_slip_baseline_finds_a_with_four_driven_wheels_and_not_with_two() -> None:
    truck = Truck()
    four, two = baseline_noise_free(truck, False), baseline_noise_free(truck, True)
    assert abs(four.axle[-1] / truck.axle - 1) < 0.05
    assert abs(two.axle[-1] / truck.axle - 1) > 0.1


def test_study_reaches_the_bound_and_covers(page: Reproduction) -> None:
    rows = [r for r in page.study if r.method.startswith("companion") and r.bound]
    assert rows
    for row in rows:
        assert row.ratio is not None
        assert row.ratio < 1.7
        assert row.coverage is not None
        assert row.coverage >= 0.8
    published = [
        r for r in page.study if r.method.startswith("HEKF") and r.bound and r.parameter == "cg_height_m"
    ]
    assert np.mean([r.ratio for r in published if r.ratio]) > np.mean([r.ratio for r in rows if r.ratio])


def test_the_page_says_what_differs_and_is_the_same_again(page: Reproduction) -> None:
    assert all(claim.remark for claim in page.claims if claim.agreement == "differs")
    assert {trace.name for trace in page.traces} >= {"wu: height"}
    assert all(math.isfinite(row.rmse) for row in page.study)
    again = paper("wu").reproduce(5, np.random.default_rng(0), lambda _text, _share: None)
    assert again.study == page.study
