"""Axle loads that come late are put where they belong, those that come by half a second are used at rest only."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from pipelines.estimators.load_balance.axle_lag import (
    IN_TIME,
    LATE_S,
    OWN_LAG_S,
    Lateness,
    earlier,
    lag_s,
    lateness,
)
from pipelines.estimators.load_balance.smoothing import Smoother, moving_mean
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.vehicles.kinds import Kind

RATE = 20.0


def prepared(
    late_s: float,
    *,
    held_s: float = 0.0,
    filtered_hz: float = 0.0,
    mean_s: float = 0.0,
    noise: float = 100.0,
    shaken: float = 0.0,
    quick: bool = False,
) -> Prepared:
    """mean_s: what comes is a mean over so long before. quick: pedals that are kicked. shaken: vertical acceleration on a rough road, m/s²; without it no vertical accelerometer is there."""
    rng = np.random.default_rng(2)
    n = 6000
    time_s = np.arange(n) / RATE
    pushed = np.convolve(
        rng.standard_normal(n), np.hanning(12 if quick else 60) / (3 if quick else 12), mode="same"
    )
    heave = shaken * np.convolve(rng.standard_normal(n), np.hanning(12) / 3, mode="same")
    moved, lifted = (np.interp(time_s - late_s, time_s, x) for x in (600 * pushed, 900 * heave))
    if filtered_hz:
        share = 1 - np.exp(-2 * np.pi * filtered_hz / RATE)
        moved, lifted = (lfilter([share], [1, share - 1], x) for x in (moved, lifted))
    if mean_s:
        rows = round(mean_s * RATE)
        moved, lifted = (lfilter(np.full(rows, 1 / rows), [1.0], x) for x in (moved, lifted))
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


def late_of(p: Prepared, kind: Kind) -> float:
    return lateness(p, kind).late_s


def transfer_lag(p: Prepared) -> float | None:
    return lag_s(p, p.columns["axle_load_rear"] - p.columns["axle_load_front"], p.columns["accel_x"])


@pytest.mark.parametrize("late_s", [0.0, 0.1, 0.5, 1.5])
def test_a_lag_is_found(late_s: float) -> None:
    assert transfer_lag(prepared(late_s)) == pytest.approx(late_s, abs=1.5 / RATE)


@pytest.mark.parametrize("late_s", [0.15, 0.2, 0.3])
def test_a_rough_road_tells_the_sensor_s_lag_by_itself(late_s: float) -> None:
    """Load transfer that is late by itself is no sensor's fault; heave is at once."""
    assert late_of(prepared(late_s, shaken=1.0), "heavy") == pytest.approx(late_s, abs=1.5 / RATE)
    assert late_of(prepared(0.0, shaken=1.0), "heavy") == 0.0


@pytest.mark.parametrize(("kind", "own"), OWN_LAG_S.items())
def test_load_transfer_itself_is_not_late_and_slow_scales_are(kind: str, own: float) -> None:
    assert late_of(prepared(own), kind) == 0.0  # type: ignore[arg-type]
    assert late_of(prepared(own, held_s=1.5), kind) > LATE_S  # type: ignore[arg-type]
    assert late_of(prepared(own + 0.3, filtered_hz=0.8), kind) > LATE_S  # type: ignore[arg-type]


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
    assert late_of(prepared(1.0, noise=1e5), "car") == 0.0
    nothing = Prepared(RATE, 5.0, np.zeros(0), {}, (), {}, frozenset(), np.zeros(0, np.bool_))
    assert late_of(nothing, "car") == 0.0


@pytest.mark.parametrize("mean_s", [0.5, 0.6, 0.7])
@pytest.mark.parametrize("shaken", [0.0, 1.0])
def test_a_mean_over_half_a_second_is_told_from_what_is_sent_late(mean_s: float, shaken: float) -> None:
    """A weighing unit's mean is late by half its length; what is merely late keeps all that is quick."""
    found = lateness(prepared(0.0, mean_s=mean_s, shaken=shaken, quick=True), "car")
    assert found.mean_s == pytest.approx(mean_s, abs=3 / RATE)
    assert found.late_s == pytest.approx(mean_s / 2, abs=1.5 / RATE)
    own = 0.0 if shaken else OWN_LAG_S["car"]
    sent = lateness(prepared(0.3 + own, shaken=shaken, quick=True), "car")
    assert sent.mean_s == 0.0
    assert sent.late_s == pytest.approx(0.3, abs=1.5 / RATE)


def test_a_mean_is_late_by_half_of_it_whatever_braking_says() -> None:
    """A stiff lorry's load transfer is not late: what is usual of its kind was taken off a weighing unit's lateness."""
    found = lateness(prepared(0.0, mean_s=0.5, quick=True), "heavy")
    assert found.late_s == pytest.approx(0.25, abs=1.5 / RATE)


def test_columns_averaged_alike_keep_their_sums() -> None:
    """What a late scale shows of the balances: each column's mean over as long."""
    p, q = prepared(0.0, shaken=1.0, noise=0.0), prepared(0.0, mean_s=0.55, shaken=1.0, noise=0.0)
    # eleven samples: five to either side
    found = Lateness(0.25, 0.51)
    shown = Smoother(q, 3.0)(earlier(q.columns["axle_load_front"], q, found.late_s))
    averaged = Smoother(p, 3.0, found.mean_s)(p.columns["axle_load_front"])
    as_it_is = Smoother(p, 3.0)(p.columns["axle_load_front"])
    there = np.isfinite(shown) & np.isfinite(averaged)
    assert there.mean() > 0.95
    assert np.std((shown - averaged)[there]) < 0.1 * np.std((shown - as_it_is)[there])


def test_averaged_columns_are_whole_to_the_ends_of_their_segments() -> None:
    """The nodding body's columns need whole segments: they were lost, and the balance by the pitch angle with them."""
    p = prepared(0.0, shaken=1.0)
    assert np.isfinite(Smoother(p, 3.0, 0.5).whole(p.columns["accel_x"])).all()


def test_a_moving_mean_is_that_of_a_plain_loop() -> None:
    values = np.random.default_rng(4).standard_normal(50)
    for half in (1, 4, 30):
        plain = [np.mean(values[max(i - half, 0) : i + half + 1]) for i in range(50)]
        assert moving_mean(values, half) == pytest.approx(plain)


def test_without_axle_loads_nothing_is_late() -> None:
    p = prepared(0.5)
    columns = {name: values for name, values in p.columns.items() if not name.startswith("axle")}
    assert lateness(replace(p, columns=columns), "car") is IN_TIME
