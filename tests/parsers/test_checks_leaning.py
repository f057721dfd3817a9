"""Roads that lean into their bends turn the body against the horizon the other way than the springs show: no sensor is turned for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import G, check, drive, found, scaled

from parsers.checks import unchecked
from parsers.checks.grid import Grid
from parsers.checks.leaning import level_roads
from parsers.drive import Signal

RATE = 50.0


def oval(rough: float, *, angle: bool = False, lean: float = 0.25) -> dict[str, Signal]:
    """Long bends to the left at 25 m/s that lean in by `lean` rad; uneven ground rolls the body by `rough` rad (rms).

    angle: with a roll angle against the horizon, instead of deflections.
    """
    plain = drive("straight", seconds=160.0)
    t = np.arange(len(plain["accel_y"].values)) / RATE
    rng = np.random.default_rng(3)
    share = np.clip(1.6 * np.sin(2 * np.pi * t / 32), 0, 1)
    bend = np.convolve(share, np.hanning(125) / np.hanning(125).sum(), mode="same")
    band = np.fft.rfftfreq(len(t), 1 / RATE)
    noise = np.fft.irfft(np.fft.rfft(rng.standard_normal(len(t))) * ((band > 0.8) & (band < 2.5)), len(t))
    wheels = rough * noise / noise.std()
    curve = 5.0 * bend
    net = curve - G * lean * bend
    springs = 0.008 * net + 0.4 * wheels
    roll = springs - lean * bend + 0.6 * wheels
    made = {
        "yaw_rate": curve / 25,
        "accel_y": curve + G * roll,
        "roll_rate": np.gradient(roll, 1 / RATE),
        "speed": np.full(len(t), 25.0) + np.sin(t / 9),
    }
    signals = {n: replace(plain[n], values=v + 0.003 * rng.standard_normal(len(t))) for n, v in made.items()}
    if angle:
        return signals | {"roll": replace(plain["roll"], values=roll)}
    for wheel in ("fl", "fr", "rl", "rr"):
        name, side = f"suspension_deflection_{wheel}", 1 if wheel.endswith("r") else -1
        values = 0.75 * side * springs + 1e-4 * rng.standard_normal(len(t))
        signals[name] = replace(plain["roll"], name=name, values=values)
    return signals


@pytest.mark.parametrize("angle", [False, True])
def test_a_right_sensor_is_left_alone_where_roads_lean(angle: bool) -> None:
    signals = oval(0.003, angle=angle)
    slow = signals["roll"].values if angle else signals["suspension_deflection_fr"].values
    other = signals["accel_y"].values if angle else np.cumsum(signals["roll_rate"].values)
    assert np.corrcoef(slow, other)[0, 1] < -0.5
    assert found(check(signals)[1], "sign") == set()


@pytest.mark.parametrize("angle", [False, True])
def test_a_wrong_sensor_is_told_by_quick_changes_where_roads_lean(angle: bool) -> None:
    names = ("roll_rate", "roll") if angle else ("roll_rate",)
    signals = oval(0.003, angle=angle)
    fixed, decisions = check(scaled(signals, **dict.fromkeys(names, -1.0)))
    assert found(decisions, "sign") == set(names)
    assert all(np.array_equal(fixed[name].values, signals[name].values) for name in names)


@pytest.mark.parametrize("angle", [False, True])
def test_without_quick_changes_it_is_said_that_it_cannot_be_told(angle: bool) -> None:
    signals = oval(0.0, angle=angle)
    assert found(check(signals)[1], "sign") == set()
    name = "roll" if angle else "roll_rate"
    assert any(f"sign of {name}: its quick changes" in text for text in unchecked(signals, {}))


@pytest.mark.parametrize(("felt", "level"), [(1.05, True), (0.88, False)])
def test_a_rough_roads_noise_makes_no_road_level(felt: float, level: bool) -> None:
    """The accelerometer feels so much of yaw rate times speed, and a rough road's noise beside it."""
    rng = np.random.default_rng(2)
    cells = 4000
    curve = np.convolve(rng.standard_normal(cells), np.hanning(80), mode="same")
    curve *= 1.5 / curve.std()
    noisy = felt * curve + 0.6 * rng.standard_normal(cells)
    assert np.std(noisy) > 0.9 * np.std(curve)
    columns = {"accel_y": noisy, "yaw_rate": curve / 20, "speed": np.full(cells, 20.0)}
    assert level_roads(Grid(0.1 * np.arange(cells), columns)) is level
