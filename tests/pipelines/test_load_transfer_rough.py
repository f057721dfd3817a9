"""On rough roads the published filters know what their models leave out: quick forces, and the body's roll inertia."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.estimators.load_transfer.data import StrutData
from pipelines.estimators.load_transfer.rough import quick_mass_share, roll_inertia_doubt
from pipelines.results import FloatArray

HZ, N = 100.0, 6000
LOADS = np.full(4, 4000.0)


def data_of(forces: FloatArray, roll_acceleration: FloatArray) -> StrutData:
    zero, time_s = np.zeros(N), np.arange(N) / HZ
    starts = np.zeros(N)
    starts[0] = 1.0
    return StrutData(
        time_s=time_s, rate_hz=HZ, forces=forces, corners=np.full((N, 4), 9.81), vertical=np.full(N, 9.81), along=zero,
        across=zero, offset_std=(0.1, 0.1), roll=zero, pitch=zero, speed=zero, yaw_rate=zero,
        roll_acceleration=roll_acceleration, pitch_acceleration=zero, braking=zero, starts=starts, rows=np.arange(N),
        drive_rows=N, moving=True, words=(),
    )  # fmt: skip


def test_quick_forces_make_a_mass_less_sure_and_slow_ones_do_not() -> None:
    time_s = np.arange(N) / HZ
    quick = LOADS + 400 * np.sqrt(2) * np.sin(2 * np.pi * 8 * time_s)[:, None] * np.array([1, -1, -1, 1])
    slow = LOADS + 400 * np.sqrt(2) * np.sin(2 * np.pi * 0.1 * time_s)[:, None] * np.array([1, -1, -1, 1])
    # a tenth of the load: twice its square
    assert quick_mass_share(data_of(quick, np.zeros(N)), LOADS) == pytest.approx(0.02, rel=0.05)
    assert quick_mass_share(data_of(slow, np.zeros(N)), LOADS) < 0.0005


def test_a_roll_arm_is_unsure_by_the_share_of_the_rolling_bodys_moment() -> None:
    rng = np.random.default_rng(0)
    across = rng.standard_normal(N)
    rough = data_of(np.tile(LOADS, (N, 1)), 1.5 * rng.standard_normal(N))
    smooth = replace(rough, roll_acceleration=0.1 * rough.roll_acceleration)
    one, other = (roll_inertia_doubt(d, across, 0.55, 1.6) for d in (rough, smooth))
    # k² p'' over h A_y: 0.35 * 1.5 / 0.55
    assert one == pytest.approx(0.55 * (0.592**2 * 1.5 / 0.55) ** 2, rel=0.05)
    assert other == pytest.approx(one / 100, rel=0.01)
