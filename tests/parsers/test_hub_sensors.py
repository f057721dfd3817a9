"""Vertical accelerations at a wheel of whose name nobody knows whether they are the hub's: told, and left out where they shake as one."""

from __future__ import annotations

import numpy as np
import pytest

from parsers.channels import ChannelInfo
from parsers.checks import check_all
from parsers.drive import Signal
from parsers.mapping import propose_and_say
from parsers.signals import WHEELS

NOISE = np.random.default_rng(3).standard_normal((5, 3000))


def columns(*stems: str) -> list[ChannelInfo]:
    names = [f"{stem}_{wheel.upper()}" for stem in stems for wheel in WHEELS]
    return [ChannelInfo(name, "t", "g", "table", tags={"column": name}) for name in names]


def test_a_name_that_says_body_comes_first() -> None:
    for stems in (("AccZ", "AccZ_body"), ("AccZ", "Chassis_AccZ"), ("AccZ", "Body_acc")):
        proposals, said = propose_and_say(columns(*stems), None)
        assert proposals["accel_z_sprung_fl"][0].channels == (f"{stems[1]}_FL",)
        assert not any("taken for the body" in each for each in said)


def test_a_name_that_says_neither_is_said_where_it_stands_alone() -> None:
    proposals, said = propose_and_say(columns("AccZ"), None)
    assert proposals["accel_z_sprung_rr"][0].channels == ("AccZ_RR",)
    (sentence,) = (each for each in said if "taken for the body" in each)
    assert sentence.startswith("AccZ_FL, AccZ_FR, AccZ_RL, AccZ_RR: ")
    _, said = propose_and_say(columns("AccZ", "AccZ_hub"), None)
    assert not any("taken for the body" in each for each in said)


def corners(spread: float, body: float | None = None) -> dict[str, Signal]:
    time_ns = np.arange(3000) * 20_000_000
    found = {
        f"accel_z_sprung_{wheel}": Signal(
            f"accel_z_sprung_{wheel}", time_ns, 9.81 + spread * NOISE[k], f"AccZ_{wheel}"
        )
        for k, wheel in enumerate(WHEELS)
    }
    if body is not None:
        found["accel_z"] = Signal("accel_z", time_ns, 9.81 + body * NOISE[4], "AccZ")
    return found


@pytest.mark.parametrize(("spread", "body"), [(30.0, None), (15.0, 5.0), (8.0, 0.6)])
def test_what_shakes_as_a_hub_is_left_out(spread: float, body: float | None) -> None:
    found = check_all(corners(spread, body), fix=True, units_stated={})
    assert not any(name.startswith("accel_z_sprung") for name in found.signals)
    said = [each for each in found.decisions if "as a hub" in each.found]
    assert len(said) == 4
    assert '[signals.accel_z_unsprung_fl] channel = "AccZ_fl"' in said[0].action


@pytest.mark.parametrize(("spread", "body"), [(0.6, None), (5.0, None), (8.0, 3.0), (2.5, 0.2)])
def test_a_body_on_a_rough_road_stays(spread: float, body: float | None) -> None:
    found = check_all(corners(spread, body), fix=True, units_stated={})
    assert sum(name.startswith("accel_z_sprung") for name in found.signals) == 4


def test_one_sensor_that_shakes_is_no_hub() -> None:
    signals = corners(0.6)
    odd = signals["accel_z_sprung_fl"]
    signals["accel_z_sprung_fl"] = Signal(odd.name, odd.time_ns, 9.81 + 20 * NOISE[0], odd.source)
    found = check_all(signals, fix=True, units_stated={})
    assert not any("as a hub" in each.found for each in found.decisions)
