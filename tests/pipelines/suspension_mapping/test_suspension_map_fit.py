"""The fit: least squares where nothing else is known, the prior where the drive tells nothing, robust against wild rows."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.suspension_mapping.fit import Known, fit, held_out, prior_of, together
from pipelines.suspension_mapping.spread import fit_spread
from pipelines.suspension_mapping.train import choose_form

N, RATE = 4000, 40.0


def _problem(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    matrix = np.column_stack((np.ones(N), rng.standard_normal((N, 2))))
    truth = np.array([400.0, 1.1, -3.0])
    return matrix, truth, matrix @ truth + 0.5 * rng.standard_normal(N)


WIDE = (np.zeros(3), np.full(3, 1e6))
STARTS = np.eye(1, N).ravel()


def test_equals_least_squares_where_nothing_is_known() -> None:
    matrix, _, measured = _problem(np.random.default_rng(1))
    plain = np.linalg.lstsq(matrix, measured, rcond=None)[0]
    found = fit(matrix, measured, WIDE, STARTS, RATE)
    assert found.coefficients == pytest.approx(plain, abs=0.005)
    expected = 0.5**2 / N
    assert np.diag(found.covariance)[1] == pytest.approx(expected, rel=0.6)


def test_wild_rows_hardly_move_it() -> None:
    rng = np.random.default_rng(2)
    matrix, truth, measured = _problem(rng)
    measured[rng.random(N) < 0.02] += 500.0
    plain = np.linalg.lstsq(matrix, measured, rcond=None)[0]
    found = fit(matrix, measured, WIDE, STARTS, RATE).coefficients
    assert np.abs(found - truth).max() < 0.1
    assert np.abs(plain - truth).max() > 5.0


def test_the_prior_stays_where_the_drive_tells_nothing() -> None:
    rng = np.random.default_rng(3)
    matrix = np.column_stack((np.ones(N), np.zeros(N)))
    found = fit(
        matrix, 5.0 + rng.standard_normal(N), (np.array([0.0, 7.0]), np.array([100.0, 2.0])), STARTS, RATE
    )
    assert found.coefficients[1] == pytest.approx(7.0)
    assert np.sqrt(found.covariance[1, 1]) == pytest.approx(2.0)


def test_rows_that_hang_together_count_as_fewer() -> None:
    rng = np.random.default_rng(4)
    white = rng.standard_normal(N)
    slow = np.repeat(rng.standard_normal(N // 40), 40)
    assert together(white, STARTS, RATE) < 3
    assert 15 < together(slow, STARTS, RATE) < 80


def test_left_out_rows_are_mapped_by_the_others_alone() -> None:
    rng = np.random.default_rng(5)
    matrix, _, measured = _problem(rng)
    group = (np.arange(N) // 400) % 5
    whole = fit(matrix, measured, WIDE, STARTS, RATE)
    left = held_out(matrix, measured, WIDE, whole, group)
    rows = group != 2
    weights = np.sqrt(whole.weights[rows])[:, None]
    others = np.linalg.lstsq(matrix[rows] * weights, measured[rows] * weights.ravel(), rcond=None)[0]
    assert left[group == 2] == pytest.approx((measured - matrix @ others)[group == 2], abs=1e-3)


def test_a_richer_form_must_be_worth_it() -> None:
    assert choose_form({"a": 100.0, "b": 95.0, "c": 80.0}) == "c"
    assert choose_form({"a": 100.0, "b": 95.0, "c": 91.0}) == "a"
    assert choose_form({"a": 100.0, "b": 60.0, "c": 58.0}) == "b"


def test_spread_follows_the_state_and_holds_95_percent() -> None:
    rng = np.random.default_rng(6)
    state = np.column_stack((np.ones(N), rng.random(N) * 25, np.zeros((N, 3))))
    std = np.sqrt(100 + 40 * state[:, 1])
    residuals = std[:, None] * rng.standard_normal((N, 2))
    spread, factor = fit_spread(residuals, state)
    assert spread[0] == pytest.approx(100, rel=0.4)
    assert spread[1] == pytest.approx(40, rel=0.2)
    assert factor == pytest.approx(1.0, abs=0.05)


def test_what_is_known_of_the_vehicle_goes_into_the_prior() -> None:
    mean, std = prior_of(
        ("one", "hub", "deflection"), 5000.0, Known((50.0, 2.0), (30_000.0, 600.0)), springs=True
    )
    assert mean[1:] == pytest.approx([50.0, 30_000.0])
    assert std[2] == pytest.approx(600.0)
    usual = prior_of(("hub",), 5000.0, Known(), springs=False)[0][0]
    assert 30 < usual < 60
