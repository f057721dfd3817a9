"""Each axis of a gyro is judged by itself: one in deg/s does not turn the others, nor is it taken for an offset."""

from __future__ import annotations

import numpy as np
import pytest
from check_drives import check, found, scaled, sprung
from kinematic_log import HZ, kinematic, times

from parsers.channels import FloatArray
from parsers.drive import Signal

PER_RAD = 180 / np.pi
RATES = ("roll_rate", "pitch_rate", "yaw_rate")


def shaken() -> dict[str, Signal]:
    """A town with a road that turns the body as much as bends and pedals do; no angle is logged."""
    t = times(180)
    rng = np.random.default_rng(8)

    def rough(least: float, most: float, spread: float) -> FloatArray:
        waves = [
            np.sin(2 * np.pi * f * t + rng.uniform(0, 6)) * rng.normal() for f in np.linspace(least, most, 30)
        ]
        made = np.sum(waves, axis=0)
        return np.asarray(spread * made / made.std())

    speed = 12 + np.cumsum(rough(0.03, 0.3, 0.8)) / HZ
    signals = kinematic(speed, rough(0.02, 0.5, 0.12))
    tilted = {"roll": rough(0.4, 2.5, 0.004), "pitch": rough(0.4, 2.5, 0.004)}
    for angle, road in tilted.items():
        turned = signals[f"{angle}_rate"]
        signals = signals | {turned.name: with_more(turned, np.gradient(road) * HZ)}
    roll, pitch = tilted["roll"], tilted["pitch"]
    for wheel, side, end in (("fl", -1, 1), ("fr", 1, 1), ("rl", -1, -1), ("rr", 1, -1)):
        spring = signals[f"suspension_deflection_{wheel}"]
        signals[spring.name] = with_more(spring, 0.6 * side * roll + 1.1 * end * pitch)
    return {name: each for name, each in signals.items() if name not in ("roll", "pitch")}


def with_more(signal: Signal, more: FloatArray) -> Signal:
    return Signal(
        signal.name, signal.time_ns, signal.values + more, signal.source, signal.measured, signal.group
    )


def bare(signals: dict[str, Signal]) -> dict[str, Signal]:
    return {name: each for name, each in signals.items() if not name.startswith("suspension")}


@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize("wrong", [(), *((name,) for name in RATES), RATES[:2], RATES])
def test_the_axes_in_degrees_are_told_and_no_others(wrong: tuple[str, ...], stated: bool) -> None:
    for signals in (shaken(), sprung()):
        fixed, decisions = check(scaled(signals, **dict.fromkeys(wrong, PER_RAD)), stated)
        assert found(decisions, "unit") == set(wrong)
        assert all(np.allclose(fixed[name].values, signals[name].values) for name in RATES)


@pytest.mark.parametrize("stated", [True, False])
def test_a_yaw_rate_in_degrees_turns_itself_alone_where_nothing_else_shows_the_body(stated: bool) -> None:
    signals = bare(shaken())
    fixed, decisions = check(scaled(signals, yaw_rate=PER_RAD), stated)
    assert found(decisions, "unit") == {"yaw_rate"}
    assert np.allclose(fixed["roll_rate"].values, signals["roll_rate"].values)


@pytest.mark.parametrize("factor", [10.0, 25.4, 0.1, 1 / 25.4])
def test_deflections_of_another_scale_make_no_gyro_one_in_degrees(factor: float) -> None:
    signals = shaken()
    springs = {name: factor for name in signals if name.startswith("suspension")}
    _, decisions = check(scaled(signals, **springs))
    assert not found(decisions, "unit") & set(RATES)


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_a_gyro_that_stands_still_is_in_no_other_unit(noise: float) -> None:
    still = kinematic(np.zeros(3000), np.zeros(3000), noise=noise)
    _, decisions = check(still)
    assert not found(decisions, "unit")
