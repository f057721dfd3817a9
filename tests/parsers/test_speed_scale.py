"""A speed that both accelerations contradict alike is said, with the unit that would explain it; banked bends and right speeds are not."""

from __future__ import annotations

import numpy as np
import pytest

from parsers.checks.grid import make_grid
from parsers.checks.speed_scale import speed_scale
from parsers.drive import Decision, Signal

HZ = 50.0


def _said(scale: float, *, banked: float = 0.0, doubted: frozenset[str] = frozenset()) -> list[Decision]:
    """Three minutes of bends and braking, dive and lean in the accelerometers; scale: of the speed; banked: share of the bends' force."""
    rng = np.random.default_rng(4)
    t = np.arange(int(180 * HZ)) / HZ
    speed = 15 + 6 * np.sin(0.25 * t) + np.sin(1.3 * t)
    yaw = 0.2 * np.sin(0.5 * t) + 0.1 * np.sin(1.3 * t)
    columns = {
        "speed": scale * speed + 0.02 * rng.standard_normal(len(t)),
        "yaw_rate": yaw,
        "accel_x": 1.05 * np.gradient(speed) * HZ + 0.1 * rng.standard_normal(len(t)),
        "accel_y": (1.06 - banked) * speed * yaw + 0.1 * rng.standard_normal(len(t)),
    }
    stamps = (t * 1e9).astype(np.int64)
    grid = make_grid({name: Signal(name, stamps, values, name) for name, values in columns.items()})
    return speed_scale(grid, doubted)


@pytest.mark.parametrize(
    ("scale", "words"),
    [(1.609, "km/h called mph"), (0.6214, "mph called km/h"), (1.35, "1.3"), (0.75, "0.7")],
)
def test_a_wrong_scale_is_said(scale: float, words: str) -> None:
    (found,) = _said(scale)
    assert words in found.found
    assert not found.applied
    assert found.kind == "scale"


@pytest.mark.parametrize(("scale", "banked"), [(1.0, 0.0), (1.05, 0.0), (0.95, 0.0), (1.0, 0.3), (1.0, 0.45)])
def test_right_speeds_and_banked_bends_are_left_alone(scale: float, banked: float) -> None:
    assert not _said(scale, banked=banked)


def test_a_speed_of_which_something_is_said_already_is_not_said_twice() -> None:
    assert not _said(1.609, doubted=frozenset({"speed"}))


@pytest.mark.parametrize("uphill", [1.0, -1.0])
def test_grades_along_a_drive_do_not_make_its_speed_wrong(uphill: float) -> None:
    """Half a minute of bends that lean out and of speeding up where the road falls or climbs, as in simulated hills: both are felt a quarter stronger or weaker."""
    t = np.arange(int(60 * HZ)) / HZ
    speed = 15 + 6 * np.sin(0.25 * t) + 0.3 * np.sin(1.3 * t)
    yaw = 0.2 * np.sin(0.5 * t)
    columns = {
        "speed": speed,
        "yaw_rate": yaw,
        "accel_x": np.gradient(speed) * HZ + uphill * 0.25 * 1.5 * np.cos(0.25 * t),
        "accel_y": (1.05 + 0.25 * uphill) * speed * yaw,
    }
    stamps = (t * 1e9).astype(np.int64)
    signals = {name: Signal(name, stamps, values, name) for name, values in columns.items()}
    assert not speed_scale(make_grid(signals), frozenset())
