"""A brake pressure that stands at one value is left out where the vehicle surely brakes, and said where it likely does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import check, drive
from kinematic_log import beside, kinematic, times

from parsers.drive import Decision, Signal


def said(decisions: tuple[Decision, ...], name: str) -> list[Decision]:
    return [each for each in decisions if each.signal == name and "stands at" in each.found]


@pytest.mark.parametrize("value", [0.0, 2e5])
def test_a_pressure_that_stands_in_hard_braking_is_left_out(value: float) -> None:
    fixed, decisions = check(beside(drive("brake"), "brake_pressure", value))
    (one,) = said(decisions, "brake_pressure")
    assert one.applied
    assert "brake_pressure" not in fixed


def braked(least: float) -> dict[str, Signal]:
    """A minute at 20 m/s in which the vehicle slows by so many m/s² for two seconds, and speeds up again."""
    t = times(60)
    change = -least * ((t > 20) & (t < 22)) + 0.5 * least * ((t > 30) & (t < 34))
    return beside(kinematic(20 + np.cumsum(change) / 50, 0.1 * np.sin(t)), "brake_pressure", 0.0)


@pytest.mark.parametrize(("least", "count"), [(3.0, 1), (1.2, 0)])
def test_a_pressure_that_stands_while_motors_may_brake_is_said_at_most(least: float, count: int) -> None:
    fixed, decisions = check(braked(least))
    found = said(decisions, "brake_pressure")
    assert len(found) == count
    assert not any(each.applied for each in found)
    assert "brake_pressure" in fixed


def test_a_speed_that_breaks_off_is_no_braking() -> None:
    signals = braked(0.0)
    speed = signals["speed"]
    t = times(60)
    values = np.where((t > 40) & (t < 44), speed.values * np.clip(42 - t, 0, 1), speed.values)
    _, decisions = check(signals | {"speed": replace(speed, values=values)})
    assert not said(decisions, "brake_pressure")
