"""Brake torque as logged: of either sign, and with a zero that is the sensor's."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.load_balance.pedals import released_at_zero


def logged(offset: float, sign: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    true = np.zeros(4000)
    for start in range(300, 4000, 800):
        true[start : start + 150] = 400.0 + start / 4
    return true, sign * (true + offset + 8.0 * rng.standard_normal(len(true)))


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("offset", [-20.0, 0.0, 20.0])
def test_what_released_brakes_read_is_taken_off_applied_ones(offset: float, sign: float) -> None:
    true, read = logged(offset, sign)
    brake, on = released_at_zero(read, 60.0)
    assert np.array_equal(on, true > 0)
    assert np.mean(brake[on] - true[on]) == pytest.approx(0.0, abs=1.5)
    assert np.mean(brake[~on]) == pytest.approx(0.0, abs=1.0)


def test_a_drive_without_braking_has_none() -> None:
    brake, on = released_at_zero(15.0 + np.random.default_rng(0).standard_normal(500), 60.0)
    assert not on.any()
    assert abs(brake).max() < 5.0


def test_missing_samples_stay_missing() -> None:
    _, read = logged(10.0)
    read[:50] = np.nan
    brake, on = released_at_zero(read, 60.0)
    assert np.isnan(brake[:50]).all()
    assert not on[:50].any()
    assert np.isfinite(brake[50:]).all()


def test_a_pressure_on_the_standing_vehicle_is_not_its_zero() -> None:
    """Of a manoeuvre's few seconds a foot holds the vehicle for most: its pressure is no offset of the sensor."""
    pushed = np.full(2000, 900.0)
    pushed[1400:] = 5.0
    found, on = released_at_zero(pushed, 60.0)
    assert on[:1400].all()
    assert found[0] == pytest.approx(895.0)
    assert found[-1] == 0.0
