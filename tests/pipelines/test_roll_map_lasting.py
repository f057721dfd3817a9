"""A navigation unit leans into a bend that lasts, and not into those of a road or a slalom."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.fit import _lasting


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
