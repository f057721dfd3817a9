"""The sign of a roll angle by gravity's part of the lateral acceleration: roads that lean into their bends turn no right angle round."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import G, check, drive, found, only, same, scaled

from parsers.checks.grid import make_grid
from parsers.checks.horizon import gravity_with_roll
from parsers.drive import Signal

RATE = 50.0
SECONDS = 400.0


def _slow(rng: np.random.Generator, rows: int, over_s: float) -> np.ndarray:
    """Noise without what is quicker than some seconds, of spread 1."""
    cells = int(over_s * RATE)
    values = np.convolve(rng.standard_normal(rows), np.hanning(cells), mode="same")
    return values / values.std()


def country(*, against: str = "horizon", gravity: bool = True) -> dict[str, Signal]:
    """A truck at 15 m/s in bends that lean in by more than its body leans out; an accelerometer with a rough road's noise.

    against: what the roll angle is told against, "horizon" or "road". gravity: whether accel_y has gravity's part.
    """
    plain = drive("straight", seconds=SECONDS)
    rng = np.random.default_rng(4)
    rows = len(plain["roll"].values)
    curve = 1.2 * _slow(rng, rows, 8.0)
    bank = -0.023 * curve + 0.006 * _slow(rng, rows, 14.0)
    lean = 0.016 * (curve + G * bank)
    roll = lean + bank
    made = {
        "yaw_rate": curve / 15,
        "accel_y": curve + (G * np.sin(roll) if gravity else 0.0) + 1.0 * rng.standard_normal(rows),
        "roll": (roll if against == "horizon" else lean) + 0.002 * rng.standard_normal(rows),
        "roll_rate": np.gradient(roll, 1 / RATE) + 0.003 * rng.standard_normal(rows),
        "speed": np.full(rows, 15.0),
    }
    return only(plain, "accel_z") | {name: replace(plain[name], values=each) for name, each in made.items()}


@pytest.mark.parametrize(
    "names", [(), ("roll",), ("roll_rate",), ("roll", "roll_rate"), ("accel_y",), ("yaw_rate",)]
)
def test_gravity_tells_each_sign_where_roads_bank_by_more_than_the_body_leans(names: tuple[str, ...]) -> None:
    signals = country()
    assert np.corrcoef(signals["roll"].values, signals["yaw_rate"].values)[0, 1] < -0.8
    fixed, decisions = check(scaled(signals, **dict.fromkeys(names, -1.0)))
    assert found(decisions, "sign") == set(names)
    assert same(fixed, signals)


def test_what_is_said_names_gravity() -> None:
    _, decisions = check(scaled(country(), roll=-1.0))
    (said,) = [each for each in decisions if each.kind == "sign"]
    assert "gravity's part" in said.evidence


@pytest.mark.parametrize("options", [{"against": "road"}, {"gravity": False}])
def test_gravity_says_nothing_of_an_angle_against_the_road_or_where_it_is_not_felt(options: dict) -> None:
    told = gravity_with_roll(make_grid(country(**options)))
    assert told is None or told.sure is None


def test_an_angle_against_the_road_is_left_alone() -> None:
    signals = country(against="road")
    assert "roll" not in found(check(signals)[1], "sign")
