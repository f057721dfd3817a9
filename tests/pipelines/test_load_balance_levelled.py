"""The vertical specific force is levelled by what is upright: a banked bend presses a vehicle down without being an offset."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.load_balance.levelled import lean_of_roads, levelled
from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import Prepared, Segment

SPEED = 25.0


def bends(
    bank: float, *, springs: float = 0.007, offset: float = 0.0
) -> tuple[Prepared, np.ndarray, np.ndarray]:
    """Bends to the left of 4.5 m/s² that lean in by `bank` rad, the springs' roll, and the true vertical force; offset: of accel_z."""
    t = np.arange(0, 240, 0.05)
    share = np.clip(1.5 * np.sin(2 * np.pi * t / 40), 0, 1)
    curve, road = 4.5 * share, -bank * share
    roll = springs * (curve * np.cos(road) + GRAVITY * np.sin(road))
    lean = road + roll
    side = curve * np.cos(lean) + GRAVITY * np.sin(lean)
    up = GRAVITY * np.cos(lean) - curve * np.sin(lean)
    columns = {"accel_y": side, "accel_z": up + offset, "yaw_rate": curve / SPEED}
    sources = dict.fromkeys(columns, "measured")
    still = np.zeros(len(t), dtype=np.bool_)
    prepared = Prepared(
        20.0, 5.0, t, columns, (Segment(0, len(t)),), sources, frozenset(columns), standstill=still
    )
    return prepared, roll, up


@pytest.mark.parametrize("bank", [0.0, 0.12, 0.245])
def test_an_offset_is_taken_out_and_a_banked_bend_is_not(bank: float) -> None:
    prepared, roll, up = bends(bank, offset=0.3)
    found = levelled(prepared, (np.zeros(len(roll)), roll), np.full(len(roll), SPEED))
    assert np.mean(found - up) == pytest.approx(0.0, abs=0.03)


def test_level_roads_are_told_by_the_springs() -> None:
    prepared, roll, _ = bends(0.0)
    assert lean_of_roads(prepared, np.full(len(roll), SPEED)) is None
    assert lean_of_roads(prepared, None) is None


def test_a_channel_that_is_another_is_no_lean() -> None:
    prepared, roll, _ = bends(0.245)
    prepared.columns["accel_y"][:] = np.sin(np.arange(len(roll)) / 30)  # type: ignore[index]
    assert lean_of_roads(prepared, np.full(len(roll), SPEED)) is None
