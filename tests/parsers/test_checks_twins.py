"""One sensor's samples at both wheels of an axle: found in bends, left alone where no bend tells."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from axle_drives import drive

from parsers.checks import check_all
from parsers.checks.grid import make_grid
from parsers.checks.twins import twins
from parsers.drive import Signal


def doubled(*ends: str, bends: float = 1.0) -> dict[str, Signal]:
    """A drive of which these axles have their mean at both wheels."""
    signals = drive(1.0)
    for end in ends:
        names = [f"suspension_deflection_{end}{side}" for side in "lr"]
        mean = 0.5 * (signals[names[0]].values + signals[names[1]].values)
        signals |= {name: replace(signals[name], values=mean.copy()) for name in names}
    return signals | {"accel_y": replace(signals["accel_y"], values=bends * signals["accel_y"].values)}


def test_one_axles_mean_at_both_wheels_is_left_out() -> None:
    checked = check_all(doubled("r"), fix=True, units_stated={})
    found = [each for each in checked.decisions if "one sensor's samples" in each.found]
    assert {each.signal for each in found} == {"suspension_deflection_rl", "suspension_deflection_rr"}
    assert not {"suspension_deflection_rl", "suspension_deflection_rr"} & checked.signals.keys()
    assert "suspension_deflection_fl" in checked.signals
    assert "6000 equal samples" in found[0].evidence


def test_both_axles_are_found_and_without_fix_only_said() -> None:
    signals = doubled("f", "r")
    assert set(check_all(signals, fix=True, units_stated={}).signals) == {"accel_y"}
    left = check_all(signals, fix=False, units_stated={})
    assert set(left.signals) == set(signals)
    assert sum("one sensor's samples" in each.found for each in left.decisions) == 4


def test_by_yaw_rate_and_speed_where_no_lateral_acceleration_is_there() -> None:
    signals = doubled("f")
    side = signals.pop("accel_y")
    signals["speed"] = replace(side, name="speed", values=np.full(len(side.values), 20.0))
    signals["yaw_rate"] = replace(side, name="yaw_rate", values=side.values / 20.0)
    assert len(twins(signals, make_grid(signals))) == 2


def test_straight_drives_dead_wheels_and_two_sensors_are_left_alone() -> None:
    straight = doubled("f", "r", bends=0.05)
    assert not twins(straight, make_grid(straight))
    right = drive(1.0)
    assert not twins(right, make_grid(right))
    dead = {n: replace(s, values=np.zeros(len(s.values))) if n != "accel_y" else s for n, s in right.items()}
    assert not twins(dead, make_grid(dead))
    alone = {n: s for n, s in doubled("f").items() if not n.startswith("suspension")}
    assert not twins(alone, make_grid(alone))
