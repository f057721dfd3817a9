"""Vertical forces at the wheels: those that are another wheel's, or of another gain than their neighbour's, are left out and named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from check_drives import check, drive, scaled

from parsers.checks.force_scales import unlike_gains
from parsers.checks.grid import make_grid
from parsers.drive import Signal
from parsers.signals import WHEELS

KINDS = ("suspension_force", "tire_normal_force")


def loaded(
    kind: str = KINDS[0],
    *,
    to_left: float = 0.0,
    rear_bar: float = 0.5,
    anti: float = 0.0,
    weaves: bool = True,
) -> dict[str, Signal]:
    """A slalom that speeds up and slows down, with four forces. to_left: share of the weight; rear_bar: share of the load transfer that the
    rear axle holds; anti: of braking that the front links hold."""
    signals = drive() if weaves else drive("circle", seconds=90.0)
    rng = np.random.default_rng(7)
    side, along = signals["accel_y"].values, signals["accel_x"].values
    for wheel in WHEELS:
        left, front = (1 if wheel[1] == "l" else -1), (1 if wheel[0] == "f" else -1)
        share = (1 - rear_bar) if front > 0 else rear_bar
        weight = 4000.0 * (1 + left * to_left)
        nod = -front * 250.0 * along * ((1 - anti) if front > 0 else 1.0)
        lift = -3.0 * side**2 * (1 + 0.3 * left)
        name = f"{kind}_{wheel}"
        values = weight - left * 600.0 * share * side + nod + lift + 60 * rng.standard_normal(len(side))
        signals[name] = Signal(name, signals["accel_y"].time_ns, values, name)
    return signals


def exchanged(signals: dict[str, Signal], kind: str, wheels: dict[str, str]) -> dict[str, Signal]:
    """wheels: whose samples stand under whose name."""
    return signals | {
        f"{kind}_{name}": replace(signals[f"{kind}_{of}"], name=f"{kind}_{name}")
        for name, of in wheels.items()
    }


def both(one: str, other: str) -> dict[str, str]:
    return {one: other, other: one}


def left_out(signals: dict[str, Signal]) -> dict[str, str]:
    """Forces that are left out, and what is said of them."""
    fixed, decisions = check(signals)
    found = {each.signal: each.found for each in decisions if "force" in each.signal}
    assert set(found) == {name for name in signals if name not in fixed}
    return found


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "car", [{}, {"to_left": 0.15}, {"rear_bar": 0.3}, {"rear_bar": 0.7, "anti": 0.4}, {"anti": 1.3}]
)
def test_right_forces_stay(kind: str, car: dict[str, float]) -> None:
    assert left_out(loaded(kind, **car)) == {}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("pair", [("fl", "fr"), ("rl", "rr")])
def test_left_and_right_exchanged_on_an_axle(kind: str, pair: tuple[str, str]) -> None:
    found = left_out(exchanged(loaded(kind), kind, both(*pair)))
    assert set(found) == {f"{kind}_{wheel}" for wheel in pair}
    assert all("left and right look exchanged" in text for text in found.values())


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("pair", [("fl", "rl"), ("fr", "rr")])
def test_front_and_rear_exchanged_on_a_side(kind: str, pair: tuple[str, str]) -> None:
    found = left_out(exchanged(loaded(kind), kind, both(*pair)))
    assert set(found) == {f"{kind}_{wheel}" for wheel in pair}
    assert all("front and rear look exchanged" in text for text in found.values())


@pytest.mark.parametrize(
    "wheels",
    [
        both("fl", "fr") | both("rl", "rr"),
        both("fl", "rl") | both("fr", "rr"),
        both("fl", "rr") | both("fr", "rl"),
    ],
)
def test_all_four_exchanged(wheels: dict[str, str]) -> None:
    assert len(left_out(exchanged(loaded(), KINDS[0], wheels))) == len(WHEELS)


@pytest.mark.parametrize(
    "names", [("accel_y",), ("accel_y", "yaw_rate", "steering_wheel_angle"), ("accel_x",)]
)
def test_other_signals_of_the_wrong_sign_do_not_accuse_the_forces(names: tuple[str, ...]) -> None:
    signals = loaded()
    fixed, decisions = check(scaled(signals, **dict.fromkeys(names, -1.0)))
    assert not [each for each in decisions if "force" in each.signal]
    assert {f"{KINDS[0]}_{wheel}" for wheel in WHEELS} <= set(fixed)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("factor", [0.8, 1.2])
@pytest.mark.parametrize("wheel", WHEELS)
def test_a_gain_that_is_a_fifth_off_leaves_its_axle_out(kind: str, factor: float, wheel: str) -> None:
    found = left_out(scaled(loaded(kind, to_left=0.1), **{f"{kind}_{wheel}": factor}))
    assert set(found) == {f"{kind}_{wheel[0]}{side}" for side in "lr"}
    over = factor if wheel[1] == "l" else 1 / factor
    assert all(
        float(text.split("reads ")[1].split(" times")[0]) == pytest.approx(over, rel=0.04)
        for text in found.values()
    )


@pytest.mark.parametrize("factor", [0.97, 1.03])
def test_tolerances_of_gains_are_no_fault(factor: float) -> None:
    assert left_out(scaled(loaded(), **{f"{KINDS[0]}_fl": factor})) == {}


def test_bends_to_one_side_alone_tell_no_gain() -> None:
    """Neither does a drive that hardly brakes: nothing is said."""
    signals = scaled(loaded(weaves=False), **{f"{KINDS[0]}_fl": 1.2})
    assert unlike_gains(make_grid(signals)) == []


def test_numbers_without_bounds_raise_nothing() -> None:
    signals = loaded()
    for value in (1e200, 0.0):
        huge = replace(signals[f"{KINDS[0]}_fl"], values=np.full(len(signals["accel_y"].values), value))
        assert unlike_gains(make_grid(signals | {huge.name: huge})) == []
