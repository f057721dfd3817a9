"""An accelerometer that leans by degrees is named; a place that slopes, hills and bends that lean are not taken for one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import G, check, drive

from parsers.drive import Signal


def stopping() -> dict[str, Signal]:
    """The made slalom after 10 s at rest, without satellites and angles."""
    signals = drive(seconds=120.0)
    rest = 500
    names = ("accel_x", "accel_y", "accel_z", "yaw_rate", "speed")
    made = {}
    for name in names:
        values = signals[name].values.copy()
        values[:rest] = (G if name == "accel_z" else 0.0) + 0.01 * np.random.default_rng(2).standard_normal(
            rest
        )
        made[name] = replace(signals[name], values=values)
    return made


def added(
    signals: dict[str, Signal], name: str, amount: float, rows: slice = slice(None)
) -> dict[str, Signal]:
    values = signals[name].values.copy()
    values[rows] += amount
    return signals | {name: replace(signals[name], values=values)}


def said(signals: dict[str, Signal]) -> list[str]:
    return [each.found for each in check(signals)[1] if "at rest: the unit leans" in each.found]


@pytest.mark.parametrize("name", ["accel_x", "accel_y"])
def test_a_unit_that_leans_by_five_degrees_is_named(name: str) -> None:
    (text,) = said(added(stopping(), name, -0.86))
    assert text.startswith(f"{name} reads -0.86 m/s² at rest: the unit leans by 5.0°")


def test_roads_and_places_that_slope_are_not() -> None:
    signals = stopping()
    assert said(signals) == []
    assert said(added(signals, "accel_y", 0.25)) == []
    assert said(added(signals, "accel_x", 1.0, slice(0, 500))) == []
    assert said(added(signals, "accel_y", -1.0, slice(500, None))) == []
