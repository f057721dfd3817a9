"""Deflections whose size a gyro contradicts are left out, with the unit that would explain it; those that tyres explain are not."""

from __future__ import annotations

import numpy as np
import pytest

from parsers.checks.check import check_all
from parsers.checks.grid import make_grid
from parsers.checks.travel import axle_shares, wrong_travel
from parsers.drive import Signal

HZ = 50.0


def _signals(
    scale: float, *, tyres: float = 0.2, track: float = 1.6, noise: float = 0.0005
) -> dict[str, Signal]:
    """A minute and a half of weaving; the springs roll by 1 - tyres of the body's roll, shown times scale."""
    rng = np.random.default_rng(2)
    t = np.arange(int(90 * HZ)) / HZ
    roll = 0.05 * np.sin(1.7 * t) * np.sin(0.12 * t)
    columns = {
        "roll_rate": np.gradient(roll) * HZ + 0.005 + 0.003 * rng.standard_normal(len(t)),
        "accel_y": 9.81 * roll / 0.1 + 0.05 * rng.standard_normal(len(t)),
    }
    for wheel, side in (("fl", -1), ("fr", 1), ("rl", -1), ("rr", 1)):
        travel = side * 0.5 * track * (1 - tyres) * roll
        columns[f"suspension_deflection_{wheel}"] = scale * (
            0.01 + travel + noise * rng.standard_normal(len(t))
        )
    stamps = (t * 1e9).astype(np.int64)
    return {name: Signal(name, stamps, values, name) for name, values in columns.items()}


@pytest.mark.parametrize(
    ("scale", "words"),
    [(2.54, "cm called inches"), (10.0, "mm called cm"), (0.1, "cm called mm"), (1 / 2.54, "inches called cm"), (3.5, "3.")],
)  # fmt: skip
def test_a_wrong_unit_is_found_and_named(scale: float, words: str) -> None:
    signals = _signals(scale)
    found = wrong_travel(signals, make_grid(signals))
    assert [each.signal for each in found] == [name for name in signals if name.startswith("suspension")]
    assert all(each.applied and words in each.found for each in found)
    kept = check_all(signals, fix=True, units_stated={}).signals
    assert not any(name.startswith("suspension") for name in kept)
    assert "roll_rate" in kept


@pytest.mark.parametrize(("tyres", "track"), [(0.0, 2.1), (0.35, 1.3), (0.2, 1.55)])
def test_what_tyres_and_tracks_explain_is_left_alone(tyres: float, track: float) -> None:
    signals = _signals(1.0, tyres=tyres, track=track)
    assert not wrong_travel(signals, make_grid(signals))


def test_without_a_gyro_or_motion_nothing_is_said() -> None:
    signals = _signals(10.0)
    without = {name: signal for name, signal in signals.items() if name != "roll_rate"}
    assert not wrong_travel(without, make_grid(without))
    noisy = _signals(10.0, noise=0.5)
    assert not wrong_travel(noisy, make_grid(noisy))


def test_a_wheel_of_the_wrong_sign_is_no_unit() -> None:
    signals = _signals(1.0)
    wrong = signals["suspension_deflection_fl"]
    signals["suspension_deflection_fl"] = Signal(wrong.name, wrong.time_ns, -wrong.values, wrong.name)
    assert not wrong_travel(signals, make_grid(signals))


def _on_a_rough_road(scale: float) -> dict[str, Signal]:
    """Wheels that follow what is uneven, each for itself, and a body that turns with a road's crossfall: more than it leans on its springs."""
    signals = _signals(scale)
    rng = np.random.default_rng(7)
    t = signals["roll_rate"].time_ns / 1e9
    road = np.convolve(rng.standard_normal(len(t)), np.hanning(401), mode="same")
    banked = 0.04 * road / road.std()
    changed = {"roll_rate": signals["roll_rate"].values + np.gradient(banked) * HZ}
    for wheel in ("fl", "fr", "rl", "rr"):
        bump = np.convolve(rng.standard_normal(len(t)), np.hanning(25), mode="same")
        name = f"suspension_deflection_{wheel}"
        changed[name] = signals[name].values + scale * 0.004 * bump / bump.std()
    made = {name: Signal(name, signals[name].time_ns, values, name) for name, values in changed.items()}
    return signals | made


@pytest.mark.parametrize("scale", [0.1, 0.4, 3.5])
def test_a_rough_road_hides_no_wrong_unit(scale: float) -> None:
    signals = _on_a_rough_road(scale)
    assert len(wrong_travel(signals, make_grid(signals))) == 4


def test_a_rough_road_is_no_wrong_unit() -> None:
    signals = _on_a_rough_road(1.0)
    assert axle_shares(make_grid(signals)).keys() == {"f", "r"}
    assert not wrong_travel(signals, make_grid(signals))


def _on_banked_roads(scale: float, *, bank: float, felt: bool = True) -> dict[str, Signal]:
    """Bends on roads that lean into them by `bank` rad per m/s², as quickly as they bend; the gyro turns with body and road.

    felt: whether yaw rate and speed are logged beside the lateral acceleration, so that the bank shows.
    """
    rng = np.random.default_rng(6)
    t = np.arange(int(400 * HZ)) / HZ
    curve = np.convolve(rng.standard_normal(len(t)), np.hanning(200), mode="same")
    curve *= 1.5 / curve.std()
    road = -bank * curve
    lean = 0.011 * (curve + 9.81 * road)
    roll = lean / 0.85 + road
    columns = {
        "roll_rate": np.gradient(roll) * HZ + 0.003 * rng.standard_normal(len(t)),
        "accel_y": curve + 9.81 * roll + 0.1 * rng.standard_normal(len(t)),
    }
    if felt:
        columns |= {"yaw_rate": curve / 20.0, "speed": np.full(len(t), 20.0)}
    for wheel, side in (("fl", -1), ("fr", 1), ("rl", -1), ("rr", 1)):
        travel = 0.01 + 0.5 * 1.55 * side * lean + 0.0003 * rng.standard_normal(len(t))
        columns[f"suspension_deflection_{wheel}"] = scale * travel
    stamps = (t * 1e9).astype(np.int64)
    return {name: Signal(name, stamps, values, name) for name, values in columns.items()}


@pytest.mark.parametrize("bank", [0.0, 0.004, 0.006, 0.009, 0.016, 0.03])
def test_right_deflections_are_kept_where_roads_bank(bank: float) -> None:
    signals = _on_banked_roads(1.0, bank=bank)
    assert not wrong_travel(signals, make_grid(signals))


@pytest.mark.parametrize("bank", [0.005, 0.006])
def test_where_nothing_tells_the_bank_a_factor_of_two_is_left(bank: float) -> None:
    signals = _on_banked_roads(1.0, bank=bank, felt=False)
    assert max(each.ratio for each in axle_shares(make_grid(signals)).values()) > 1.41
    assert not wrong_travel(signals, make_grid(signals))


@pytest.mark.parametrize(
    ("scale", "bank"), [(10.0, 0.006), (10.0, 0.016), (2.54, 0.0), (0.1, 0.0), (0.05, 0.006), (3.5, 0.0)]
)
def test_a_wrong_unit_is_found_where_roads_bank_too(scale: float, bank: float) -> None:
    signals = _on_banked_roads(scale, bank=bank)
    assert len(wrong_travel(signals, make_grid(signals))) == 4
