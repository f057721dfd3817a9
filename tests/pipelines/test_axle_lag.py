"""Axle loads that come late are used at rest only; those that come as load transfer does are used throughout."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from pipelines.estimators.load_balance.axle_lag import LATE_S, axle_lag_s
from pipelines.prepare.prepared import Prepared, Segment

RATE = 20.0


def prepared(
    late_s: float, *, held_s: float = 0.0, filtered_hz: float = 0.0, noise: float = 100.0
) -> Prepared:
    rng = np.random.default_rng(2)
    n = 6000
    time_s = np.arange(n) / RATE
    pushed = np.convolve(rng.standard_normal(n), np.hanning(60) / 12, mode="same")
    moved = np.interp(time_s - late_s, time_s, 600 * pushed)
    if filtered_hz:
        share = 1 - np.exp(-2 * np.pi * filtered_hz / RATE)
        moved = lfilter([share], [1, share - 1], moved)
    if held_s:
        moved = moved[(np.floor(time_s / held_s) * held_s * RATE).astype(int)]
    columns = {
        "accel_x": pushed + 0.05 * rng.standard_normal(n),
        "axle_load_front": 9000 - moved + noise * rng.standard_normal(n),
        "axle_load_rear": 8000 + moved + noise * rng.standard_normal(n),
    }
    segments = (Segment(0, n // 2), Segment(n // 2, n))
    return Prepared(RATE, 5.0, time_s, columns, segments, {}, frozenset(columns), np.zeros(n, np.bool_))


@pytest.mark.parametrize("late_s", [0.0, 0.1, 0.5, 1.5])
def test_a_lag_is_found(late_s: float) -> None:
    assert axle_lag_s(prepared(late_s)) == pytest.approx(late_s, abs=1.5 / RATE)


def test_load_transfer_itself_is_not_late_and_slow_scales_are() -> None:
    assert axle_lag_s(prepared(0.15)) < LATE_S
    assert axle_lag_s(prepared(0.05, held_s=1.0)) > LATE_S
    assert axle_lag_s(prepared(0.1, filtered_hz=0.8)) > LATE_S


def test_where_nothing_is_alike_nothing_is_told() -> None:
    assert axle_lag_s(prepared(1.0, noise=1e5)) == 0.0
    assert axle_lag_s(Prepared(RATE, 5.0, np.zeros(0), {}, (), {}, frozenset(), np.zeros(0, np.bool_))) == 0.0
