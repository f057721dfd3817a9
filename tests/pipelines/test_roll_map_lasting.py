"""A navigation unit leans into a bend that lasts, and not into those of a road or a slalom."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.fit import _doubts, _lasting
from pipelines.estimators.roll_map.open_slope import ROAD


def of(accel: np.ndarray, *cuts: int) -> float:
    edges = [0, *cuts, len(accel)]
    data = SimpleNamespace(accel=accel, step_s=0.05, starts=np.array(edges[:-1]), stops=np.array(edges[1:]))
    return _lasting(cast("RollData", data))


def test_what_lasts_and_what_does_not() -> None:
    time_s = np.arange(0, 200, 0.05)
    assert of(np.full(len(time_s), 3.0)) == pytest.approx(1 - 20 / 200, abs=0.01)
    assert of(np.full(len(time_s), -3.0), 2000) == pytest.approx(1 - 20 / 100, abs=0.01)
    assert of(3 * np.sin(2 * np.pi * 0.3 * time_s)) < 0.01
    # bends of six seconds, either way
    assert of(np.sign(np.sin(2 * np.pi * time_s / 12)) * 2.0) < 0.1
    assert of(np.zeros(100)) == 0.0


def road_doubt(explained: float, slow_share: float) -> float:
    """Of a pad driven round and round, whose bank the fit takes for 0.1 degrees by how it changes from sample to sample."""
    accel = np.linspace(0.0, 5.0, 4000)
    yaw, rows = accel / 8.0, np.arange(4000)
    data = SimpleNamespace(
        accel=accel, step_s=0.05, every=1, starts=np.zeros(1, np.int64), stops=np.array([4000]), taken=(rows, rows, rows),
        roll=accel / 90.0, yaw=yaw, has_roll=True, has_yaw=True, against_axles=False, slow_share=slow_share,
    )  # fmt: skip
    return _doubts(
        cast("RollData", data), {"a": 90.0, "log_bank": math.log(0.002), "friction": 0.0}, explained
    )[ROAD]


def test_what_springs_leave_of_the_angle_in_a_bend_that_lasts_is_bank() -> None:
    clear, half = road_doubt(1.0, 1.0), road_doubt(0.5, 1.0)
    # what is left is 0.71 of the roll, of which three tenths may go with the bend
    assert half**2 - clear**2 == pytest.approx((0.3 * 0.7071) ** 2, rel=0.05)
    assert road_doubt(0.5, 0.0) == road_doubt(1.0, 0.0)
