"""A speed that has nothing to do with the bends that are driven at it is said, and left alone."""

from __future__ import annotations

import numpy as np
import pytest

from parsers.checks.check import check_all
from parsers.drive import Decision, Signal

T = np.arange(6000) / 50
SPEED = 16 + 5 * np.sin(0.4 * T)
YAW = 0.2 * np.sin(0.3 * T) + 0.1 * np.sin(0.9 * T) + 0.03
HEADING = np.cumsum(YAW) / 50
NOISE = 0.05 * np.random.default_rng(3).standard_normal((3, len(T)))


def said(speed: np.ndarray, **more: np.ndarray) -> list[Decision]:
    columns = {
        "speed": speed,
        "accel_x": np.gradient(SPEED, T) + NOISE[0],
        "accel_y": SPEED * YAW + NOISE[1],
        "yaw_rate": YAW + NOISE[2] / 20,
        **more,
    }
    time_ns = np.arange(len(T), dtype=np.int64) * 20_000_000
    signals = {name: Signal(name, time_ns, values, name) for name, values in columns.items()}
    checked = check_all(signals, fix=True, units_stated={})
    assert "speed" in checked.signals
    return [each for each in checked.decisions if "does not go with the bends" in each.found]


def test_a_speed_along_an_axis_of_the_world() -> None:
    for heading in (2 * HEADING, HEADING + 0.9):
        (decision,) = said(SPEED * np.cos(heading))
        assert "driven at about 16 m/s" in decision.found or "driven at about 17 m/s" in decision.found
        assert not decision.applied


@pytest.mark.parametrize(
    "speed",
    [
        SPEED,
        3.6 * SPEED,
        SPEED / 1.609,
        np.where(T < 20, 0.0, SPEED),
        np.roll(SPEED, 60),
        SPEED + NOISE[0] * 10,
    ],
    ids=["right", "km/h", "mph", "late to start", "late", "noisy"],
)
def test_a_speed_that_is_the_vehicle_s(speed: np.ndarray) -> None:
    assert not said(speed)


def test_hills_banks_and_signs_make_no_speed_astray() -> None:
    assert not said(SPEED, accel_x=np.gradient(SPEED, T) + 0.9 * np.sin(0.13 * T))
    assert not said(SPEED, accel_y=0.72 * SPEED * YAW)
    assert not said(SPEED, accel_x=-np.gradient(SPEED, T))
    assert not said(SPEED, accel_y=-SPEED * YAW)
