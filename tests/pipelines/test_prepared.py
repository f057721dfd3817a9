"""How much of a column there is, beside pauses of the recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.estimators.load_balance.data import speed_of
from pipelines.prepare.prepared import Prepared, Segment


def _prepared(pause: int) -> Prepared:
    """200 rows of speed with ten holes, and of a gyro that is there in every other row, with a pause in the middle."""
    speed = np.concatenate((np.full(100, 9.0), np.full(pause, np.nan), np.full(100, 11.0)))
    gyro = speed.copy()
    gyro[::2] = np.nan
    speed[20:30] = np.nan
    rows = len(speed)
    return Prepared(
        rate_hz=50.0,
        cutoff_hz=10.0,
        time_s=np.arange(rows) / 50.0,
        columns={"speed": speed, "yaw_rate": gyro},
        segments=(Segment(0, 100), Segment(100 + pause, rows)),
        sources={},
        measured=frozenset(("speed", "yaw_rate")),
        standstill=np.zeros(rows, dtype=bool),
    )


@pytest.mark.parametrize("pause", [0, 360_000])
def test_a_pause_takes_no_share_of_any_channel(pause: int) -> None:
    prepared = _prepared(pause)
    assert int(prepared.recorded.sum()) == 195
    assert prepared.share_of(prepared.columns["speed"]) == pytest.approx(190 / 195)
    assert prepared.share_of(prepared.columns["yaw_rate"]) == pytest.approx(100 / 195)
    # an hour's pause in a file used to take the speed for one that is hardly there
    assert speed_of(prepared) is not None


def test_nothing_recorded_is_nothing_there() -> None:
    nothing = np.full(5, np.nan)
    prepared = replace(_prepared(0), time_s=np.arange(5.0), columns={"speed": nothing})
    assert prepared.share_of(nothing) == 0.0
    assert speed_of(prepared) is None
