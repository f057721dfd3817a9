"""Axle loads that come late are put where they belong, those that come by half a second are used at rest only."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from pipelines.estimators.load_balance.axle_lag import LATE_S, OWN_LAG_S, earlier, lag_s, sensor_lag_s
from pipelines.prepare.prepared import Prepared, Segment

RATE = 20.0


def prepared(
    late_s: float, *, held_s: float = 0.0, filtered_hz: float = 0.0, noise: float = 100.0, shaken: float = 0.0
) -> Prepared:
    """shaken: vertical acceleration on a rough road, m/s²; without it no vertical accelerometer is there."""
    rng = np.random.default_rng(2)
    n = 6000
    time_s = np.arange(n) / RATE
    pushed = np.convolve(rng.standard_normal(n), np.hanning(60) / 12, mode="same")
    heave = shaken * np.convolve(rng.standard_normal(n), np.hanning(12) / 3, mode="same")
    moved, lifted = (np.interp(time_s - late_s, time_s, x) for x in (600 * pushed, 900 * heave))
    if filtered_hz:
        share = 1 - np.exp(-2 * np.pi * filtered_hz / RATE)
        moved, lifted = (lfilter([share], [1, share - 1], x) for x in (moved, lifted))
    if held_s:
        moved, lifted = (x[(np.floor(time_s / held_s) * held_s * RATE).astype(int)] for x in (moved, lifted))
    columns = {
        "accel_x": pushed + 0.05 * rng.standard_normal(n),
        "axle_load_front": 9000 + lifted - moved + noise * rng.standard_normal(n),
        "axle_load_rear": 8000 + lifted + moved + noise * rng.standard_normal(n),
    }
    if shaken:
        columns["accel_z"] = 9.8 + heave + 0.05 * rng.standard_normal(n)
    segments = (Segment(0, n // 2), Segment(n // 2, n))
    return Prepared(RATE, 5.0, time_s, columns, segments, {}, frozenset(columns), np.zeros(n, np.bool_))


def transfer_lag(p: Prepared) -> float | None:
    return lag_s(p, p.columns["axle_load_rear"] - p.columns["axle_load_front"], p.columns["accel_x"])


@pytest.mark.parametrize("late_s", [0.0, 0.1, 0.5, 1.5])
def test_a_lag_is_found(late_s: float) -> None:
    assert transfer_lag(prepared(late_s)) == pytest.approx(late_s, abs=1.5 / RATE)


@pytest.mark.parametrize("late_s", [0.15, 0.2, 0.3])
def test_a_rough_road_tells_the_sensor_s_lag_by_itself(late_s: float) -> None:
    """Load transfer that is late by itself is no sensor's fault; heave is at once."""
    assert sensor_lag_s(prepared(late_s, shaken=1.0), "heavy") == pytest.approx(late_s, abs=1.5 / RATE)
    assert sensor_lag_s(prepared(0.0, shaken=1.0), "heavy") == 0.0


@pytest.mark.parametrize(("kind", "own"), OWN_LAG_S.items())
def test_load_transfer_itself_is_not_late_and_slow_scales_are(kind: str, own: float) -> None:
    assert sensor_lag_s(prepared(own), kind) == 0.0  # type: ignore[arg-type]
    assert sensor_lag_s(prepared(own, held_s=1.5), kind) > LATE_S  # type: ignore[arg-type]
    assert sensor_lag_s(prepared(own + 0.3, filtered_hz=0.8), kind) > LATE_S  # type: ignore[arg-type]


def test_a_late_column_is_put_where_it_belongs() -> None:
    p = prepared(0.3, noise=0.0)
    moved = earlier(p.columns["axle_load_rear"], p, 0.3)
    right = prepared(0.0, noise=0.0).columns["axle_load_rear"]
    for segment in p.segments:
        inside = slice(segment.start + 10, segment.stop - 10)
        assert moved[inside] == pytest.approx(right[inside], abs=1.0)
        # nothing is taken from the next segment
        assert np.isnan(moved[segment.stop - 6 : segment.stop]).all()


def test_where_nothing_is_alike_nothing_is_told() -> None:
    assert sensor_lag_s(prepared(1.0, noise=1e5), "car") == 0.0
    nothing = Prepared(RATE, 5.0, np.zeros(0), {}, (), {}, frozenset(), np.zeros(0, np.bool_))
    assert sensor_lag_s(nothing, "car") == 0.0
