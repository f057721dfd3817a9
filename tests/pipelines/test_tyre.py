"""The tyre in the road plane: slopes, limits, and load sensitivity."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.simulation.plant.tyre import brush, load_factor


def test_starts_linear_and_ends_at_the_friction() -> None:
    assert brush(0.0, 0.2) == 1.0
    assert brush(1e-3, 0.2) == pytest.approx(1 - 1e-3 / 3, abs=1e-7)
    assert 3 * brush(3.0, 0.0) == pytest.approx(1.0)
    assert 30 * brush(30.0, 0.0) == pytest.approx(1.0)


def test_force_rises_to_full_sliding_and_falls_beyond_by_the_loss() -> None:
    rho = np.linspace(0.01, 50, 5000)
    force = rho * np.array([brush(float(r), 0.25) for r in rho])
    peak = int(np.argmax(force))
    assert rho[peak] == pytest.approx(3.0, abs=0.02)
    assert force[peak] == pytest.approx(1.0)
    assert np.all(np.diff(force[:peak]) > 0)
    assert np.all(np.diff(force[peak + 1 :]) <= 0)
    assert force[-1] == pytest.approx(1 - 0.25, abs=0.04)
    # no jump in force or slope where sliding begins
    assert np.abs(np.diff(force, 2)).max() < 2e-4


def test_load_takes_its_share_within_bounds() -> None:
    assert load_factor(0.2, 4000.0, 4000.0) == 1.0
    assert load_factor(0.2, 8000.0, 4000.0) == pytest.approx(0.8)
    assert load_factor(0.2, 0.0, 4000.0) == pytest.approx(1.2)
    assert load_factor(0.2, 1e6, 4000.0) == 0.4
