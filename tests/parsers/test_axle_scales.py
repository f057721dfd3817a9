"""One body leans on both axles: deflections of which one axle's have another scale are found, others are left alone."""

from __future__ import annotations

import warnings
from dataclasses import replace

import pytest
from axle_drives import drive

from parsers.checks import check_all
from parsers.checks.axle_scales import unlike_axles, unlike_sides
from parsers.checks.grid import make_grid
from parsers.drive import Signal


@pytest.mark.parametrize("rear", [0.4, 0.7, 1.45, 2.0])
def test_one_axles_scale_is_found_and_all_are_left_out(rear: float) -> None:
    signals = drive(rear)
    found = unlike_axles(signals, make_grid(signals))
    assert {each.signal for each in found} == signals.keys() - {"accel_y"}
    assert all(each.applied for each in found)
    assert float(found[0].evidence.split(" ")[0]) == pytest.approx(1.05 * rear, rel=0.02)
    checked = check_all(signals, fix=True, units_stated={})
    assert set(checked.signals) == {"accel_y"}
    assert set(check_all(signals, fix=False, units_stated={}).signals) == set(signals)


@pytest.mark.parametrize(
    ("rear", "tyres"), [(1.0, 1.05), (1.0, 0.9), (1.0, 1.36), (0.9, 1.0), (-1.0, 1.0), (5.0, 1.0)]
)
def test_what_tracks_and_tyres_explain_and_what_is_something_else_is_left_alone(
    rear: float, tyres: float
) -> None:
    signals = drive(rear, tyres=tyres)
    assert not unlike_axles(signals, make_grid(signals))


def test_a_drive_that_hardly_leans_tells_nothing() -> None:
    straight = drive(0.7, lean=0.0005)
    assert not unlike_axles(straight, make_grid(straight))
    short = drive(0.7, seconds=20.0)
    assert not unlike_axles(short, make_grid(short))
    without = drive(0.7)
    del without["accel_y"]
    assert not unlike_axles(without, make_grid(without))
    three = drive(0.7)
    del three["suspension_deflection_rr"]
    assert not unlike_axles(three, make_grid(three))


def one_wheel(scale: float, wheel: str = "rr", **options: float) -> dict[str, Signal]:
    signals = drive(1.0, **options)
    name = f"suspension_deflection_{wheel}"
    return signals | {name: replace(signals[name], values=scale * signals[name].values)}


@pytest.mark.parametrize(("scale", "wheel"), [(0.6, "rr"), (1.5, "fl"), (2.0, "rl")])
def test_one_wheels_scale_is_found_and_its_axle_left_out(scale: float, wheel: str) -> None:
    signals = one_wheel(scale, wheel)
    found = unlike_sides(signals, make_grid(signals))
    assert {each.signal for each in found} == {f"suspension_deflection_{wheel[0]}{side}" for side in "lr"}
    told = float(found[0].evidence.split("moves ")[1].split(" ")[0])
    assert told == pytest.approx(scale if wheel[1] == "l" else 1 / scale, rel=0.05)
    checked = check_all(signals, fix=True, units_stated={})
    other = "f" if wheel[0] == "r" else "r"
    assert {f"suspension_deflection_{other}{side}" for side in "lr"} < set(checked.signals)
    assert not {each.signal for each in found} & set(checked.signals)


@pytest.mark.parametrize("scale", [0.87, 1.0, 1.15])
def test_wheels_that_move_alike_within_a_sixth_are_left_alone(scale: float) -> None:
    signals = one_wheel(scale)
    assert not unlike_sides(signals, make_grid(signals))
    still = one_wheel(1.5, lean=0.0)
    quiet = {name: replace(each, values=0.05 * each.values) for name, each in still.items()}
    assert not unlike_sides(quiet, make_grid(quiet))


def test_wheels_that_move_in_one_part_of_the_drive_alone_tell_nothing() -> None:
    """What is left without that part is noise, or nothing at all: no ratio and no spread of one."""
    signals = one_wheel(1.5)
    for still in (0.0, 1e-3):
        parked = {}
        for name, signal in signals.items():
            values = still * signal.values
            values[900:1150] = signal.values[900:1150]
            parked[name] = replace(signal, values=values)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert not unlike_sides(parked, make_grid(parked))


@pytest.mark.parametrize(("stiffens", "wheel"), [(0.3, "rl"), (0.1, "fr")])
def test_a_wheel_on_its_stop_moves_less_and_shows_the_lean_all_the_same(stiffens: float, wheel: str) -> None:
    """Both sensors are right: what the road does to that wheel is less, and the body leans on it as on the other axle."""
    signals = drive(1.0, tyres=1.0, lean=0.01)
    name = f"suspension_deflection_{wheel}"
    lean = 0.01 * 0.5 * signals["accel_y"].values * (1 if wheel[1] == "r" else -1)
    signals[name] = replace(signals[name], values=lean + stiffens * (signals[name].values - lean))
    found = unlike_sides(signals, make_grid(signals))
    assert [(each.signal, each.applied) for each in found] == [(name, False)]
    assert "bump stop" in found[0].action
    assert set(check_all(signals, fix=True, units_stated={}).signals) == set(signals)
