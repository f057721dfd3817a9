"""Deflections that span more than any road vehicle's wheel travels are left out, with the unit that would explain it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import DEFLECTIONS, drive, sprung

from parsers.checks.check import Checked, check_all
from parsers.drive import Signal


def _rough(scale: float, *, gyro: bool = True, wheels: tuple[str, ...] = DEFLECTIONS) -> dict[str, Signal]:
    """A drive over a rough road, where wheels span 65 to 75 mm, shown times scale; without bends that a gyro could be held against."""
    signals = sprung()
    if not gyro:
        del signals["roll_rate"]
    rng = np.random.default_rng(3)
    for name in wheels:
        old = signals[name]
        bump = np.convolve(rng.standard_normal(len(old.values)), np.hanning(25), mode="same")
        values = scale * (old.values + 0.014 * bump / bump.std())
        signals[name] = replace(old, values=values)
    return signals


def _check(signals: dict[str, Signal], unit: float) -> Checked:
    taken = dict.fromkeys(DEFLECTIONS, unit)
    return check_all(signals, fix=True, units_stated={}, units_taken=taken)


@pytest.mark.parametrize("gyro", [True, False])
def test_mm_called_cm_is_found_without_a_gyro_too(gyro: bool) -> None:
    checked = _check(_rough(10.0, gyro=gyro), 0.01)
    said = [each for each in checked.decisions if each.kind == "range"]
    assert {each.signal for each in said} == set(DEFLECTIONS)
    assert all(each.applied and "as mm called cm would" in each.found for each in said)
    assert not set(DEFLECTIONS) & set(checked.signals)
    assert "accel_y" in checked.signals


def test_one_sensor_of_a_wrong_scale_goes_alone() -> None:
    signals = _rough(1.0) | {DEFLECTIONS[2]: _rough(10.0)[DEFLECTIONS[2]]}
    said = [each for each in _check(signals, 0.01).decisions if each.kind == "range" and each.applied]
    assert [each.signal for each in said] == [DEFLECTIONS[2]]


@pytest.mark.parametrize("scale", [1.0, 4.0])
def test_what_a_lorry_s_wheels_may_travel_is_left_alone(scale: float) -> None:
    checked = _check(_rough(scale, gyro=False), 1.0)
    assert not [each for each in checked.decisions if each.kind == "range"]


def test_without_deflections_nothing_is_said() -> None:
    assert not [each for each in _check(drive(), 1.0).decisions if each.kind == "range"]


@pytest.mark.parametrize("names", [(), ("yaw_rate",), ("accel_y",)])
def test_a_lean_that_no_vehicle_has_is_found_where_wheels_move_little(names: tuple[str, ...]) -> None:
    """Without a gyro; and without one of what tells how a bend is driven, whose own unit may be wrong, nothing is said."""
    signals = sprung()
    del signals["roll_rate"]
    gentle = {"accel_y": 0.5, "yaw_rate": 0.5}
    for scale, wrong in ((1.0, False), (10.0, not names)):
        factors = gentle | dict.fromkeys(DEFLECTIONS, 0.5 * scale)
        driven = {n: replace(s, values=factors.get(n, 1.0) * s.values) for n, s in signals.items()}
        driven = {name: signal for name, signal in driven.items() if name not in names}
        assert max(np.ptp(np.quantile(driven[name].values, [0.01, 0.99])) for name in DEFLECTIONS) < 0.4
        said = [each for each in _check(driven, 0.01).decisions if each.kind == "range"]
        assert len(said) == (4 if wrong else 0)
        assert all("lean" in each.found and "as mm called cm would" in each.found for each in said)
