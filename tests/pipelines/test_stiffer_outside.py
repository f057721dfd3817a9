"""Bump stops of which the vehicle file is silent, found by the body that rises in bends; and what slow motion leaves open of a gradient."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.estimators.roll_map.fit import _doubts
from pipelines.estimators.roll_map.open_slope import FRICTION
from pipelines.estimators.roll_map.spectrum import motion_band
from pipelines.estimators.roll_map.stiffer_outside import NOT_SEEN, RisesInBends, rises_in_bends, with_rise
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.results import FloatArray, ParameterEstimate
from tests.pipelines.test_roll_map_parts import _data

HZ = 16.0
ROWS = np.arange(8000)
RATE, LOAD = 20e3, 400.0
GRADIENT = ParameterEstimate("roll_gradient_degpg", 6.0, 0.1, 5.8, 6.2, "identified", "from the log")


def _wheels(lean_n: FloatArray, stop_npm: float, clear_m: float) -> tuple[FloatArray, FloatArray]:
    """Outer and inner deflection (n,) under ± lean_n beside LOAD, on straight springs with a stop."""
    push = np.stack([LOAD + lean_n, LOAD - lean_n])
    free = push / RATE
    return tuple(np.where(free < clear_m, free, (push + stop_npm * clear_m) / (RATE + stop_npm)))  # type: ignore[return-value]


def _drive(
    stop_npm: float = 0.0, *, links: float = 0.1, circle: bool = False, noise: float = 3e-4
) -> Prepared:
    """Bends both ways at changing speed and pedals. links: what they lift of the axle, over its lean. circle: faster and faster on one."""
    rng = np.random.default_rng(3)
    t = ROWS / HZ
    speed = 14 + 4 * np.sin(0.11 * t)
    accel = 4 * np.sin(0.31 * t) * np.sin(0.043 * t)
    if circle:
        speed = 5 + 12 * (t % 125) / 125
        accel = speed**2 / 45 * np.where((t // 125) % 2 == 0, 1.0, -1.0)
    pedals = 0.8 * np.sin(0.23 * t)
    left, right = _wheels(180.0 * accel, stop_npm, 0.028)
    mean = 0.5 * (left + right) - links * 0.5 * np.abs(right - left) + 0.004 * pedals - 3e-6 * speed**2
    half = 0.5 * (right - left)
    columns = {
        "accel_y": accel,
        "accel_x": pedals + 0.05 * rng.standard_normal(len(t)),
        "speed": speed,
        "suspension_deflection_fl": mean - half + noise * rng.standard_normal(len(t)),
        "suspension_deflection_fr": mean + half + noise * rng.standard_normal(len(t)),
    }
    return Prepared(
        HZ, 4.0, t, columns, (Segment(0, len(t)),), {}, frozenset(columns), np.zeros(len(t), dtype=bool)
    )


@pytest.mark.parametrize("links", [0.0, 0.1, 0.18])
def test_straight_springs_and_links_that_lift_leave_the_gradient_alone(links: float) -> None:
    seen = rises_in_bends(_drive(links=links), ROWS)
    assert seen.slope == pytest.approx(links, abs=0.02)
    assert with_rise(GRADIENT, seen) is GRADIENT


def test_stops_under_the_outer_wheels_make_it_weak() -> None:
    seen = rises_in_bends(_drive(60e3), ROWS)
    assert seen.slope > 0.35
    assert seen.share == 1
    told = with_rise(GRADIENT, seen)
    assert (told.status, told.std) == ("weak", pytest.approx(np.hypot(0.1, 0.6)))
    assert "bump_stop_clearance" in told.refused
    assert told.low is not None
    assert told.high is not None
    assert told.high - told.low > 2.3


def test_a_little_of_it_widens_and_stays_identified() -> None:
    told = with_rise(GRADIENT, RisesInBends(0.22, 0.2))
    assert told.status == "identified"
    assert told.std == pytest.approx(np.hypot(0.1, 0.12))


def test_what_cannot_show_it_says_nothing() -> None:
    assert rises_in_bends(_drive(60e3, circle=True), ROWS) == NOT_SEEN
    stopped = _drive(60e3)
    for lacking in ("accel_x", "speed", "suspension_deflection_fl"):
        columns = {name: column for name, column in stopped.columns.items() if name != lacking}
        without = Prepared(
            HZ, 4.0, stopped.time_s, columns, stopped.segments, {}, frozenset(columns), stopped.standstill
        )
        assert rises_in_bends(without, ROWS) == NOT_SEEN
    assert rises_in_bends(stopped, ROWS[:100]) == NOT_SEEN


@pytest.mark.parametrize(("hz", "slow"), [(0.05, 1.0), (0.1, 0.97), (0.25, 0.02), (0.5, 0.0)])
def test_a_slalom_is_no_road_s_bends(hz: float, slow: float) -> None:
    """However short: the spectrum's lines of some seconds would count a fifth of a slalom at 0.25 Hz as slow."""
    n = 26 * 16
    accel = 4 * np.sin(2 * np.pi * hz * np.arange(n) / 16)
    assert motion_band(accel, [(0, n)], 16.0).slow_share == pytest.approx(slow, abs=0.05)


def test_friction_of_a_lean_that_lasts_may_be_missed_altogether() -> None:
    accel = 4 * np.sin(0.3 * np.arange(2000) / 16)
    data = _data(accel, accel / 110, np.gradient(accel / 110) * 16, True)
    values = {"a": 110.0, "friction": 0.15}
    quick, lasting = (_doubts(replace(data, slow_share=share), values, 1.0)[FRICTION] for share in (0.3, 1.0))
    spread = float(np.std(accel))
    assert quick < 0.07 / spread
    assert lasting > 0.15 / spread
