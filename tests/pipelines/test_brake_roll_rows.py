"""Rows that are left out of the brake and roll fits' small steps are left out of all of it: wheel scales, bends, the wheels' own inertia."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from pipelines.estimators.brake_roll.data import wheel_scales
from pipelines.estimators.brake_roll.evidence import bends_share
from pipelines.estimators.brake_roll.mass import MassKnown, fit_mass
from pipelines.vehicles.vehicle import Quantity

KNOWN = SimpleNamespace(
    mass=Quantity(1500.0, 50.0, ""), radius=Quantity(0.3, 0.01, ""), drag_area=Quantity(0.7, 0.05, "")
)


@pytest.mark.parametrize("spinning", [0.0, 0.02, 0.1, 0.2])
def test_wheels_that_spin_at_times_leave_their_scale_alone(spinning: float) -> None:
    """5 % of such rows took 5 % off the scale, at a stated 0.05 %."""
    rng = np.random.default_rng(0)
    count = 6000
    v = 20 + 5 * np.sin(np.arange(count) * 0.01)
    front, rear = (scale * v * (1 + 0.001 * rng.standard_normal(count)) for scale in (1.004, 0.998))
    wild = rng.random(count) < spinning
    data = SimpleNamespace(
        true=SimpleNamespace(speed=v, gain=1.0), front=np.where(wild, 1.2 * front, front), rear=np.where(wild, 1.2 * rear, rear),
        f_x=0.5 * np.cos(np.arange(count) * 0.01), front_torque=None, rear_torque=None, yaw_rate=None,
        rows=np.ones(count, bool), allowed=np.ones(count, bool), rate_hz=50.0,
    )  # fmt: skip
    found = wheel_scales(cast("Any", data), cast("Any", KNOWN))
    assert (found.front, found.rear) == pytest.approx((1.004, 0.998), abs=3 * found.std)


@pytest.mark.parametrize(("speeding", "steep"), [(1.5, 0.0), (0.0, 0.08), (0.6, 0.05)])
def test_a_grade_does_not_spin_wheels_up(speeding: float, steep: float) -> None:
    """On hills at a steady speed the mass was short by the wheels' share, 2.7 %, at 6.6 standard deviations."""
    rng = np.random.default_rng(0)
    mass, radius, inertia, rate = 1500.0, 0.3, 1.0, 40.0
    t = np.arange(int(600 * rate)) / rate
    gained, grade = speeding * np.sin(0.3 * t), steep * np.sin(0.05 * t)
    v = np.cumsum(gained) / rate
    v += 20 - v.mean()
    felt = gained + 9.80665 * np.sin(grade)
    force = mass * felt + 4 * inertia / radius**2 * gained + 0.5 * 1.204 * 0.7 * v**2 + mass * 9.80665 * 0.012
    known = MassKnown(1600.0, radius, 1e-4, inertia, (0.7, 0.02), 0.001, drive=0.001, pitch=0.001)
    noisy = felt + 0.03 * rng.standard_normal(len(t))
    fit = fit_mass(noisy, v, None, force * radius, np.ones(len(t), bool), rate, known)
    assert fit is not None
    assert abs(fit.mass - mass) < 3 * fit.std
    assert fit.std < 0.01 * mass


def test_a_gap_between_two_bends_is_no_test_pads_turn() -> None:
    """The recorder stops in one left bend and starts in another: filled across, they were one turn of two circles."""
    rate, speed = 40.0, 18.0
    lap = [np.full(280, 0.15), np.zeros(200), np.full(280, -0.15), np.zeros(200)]
    before, after = np.concatenate([*lap * 4, np.full(160, 0.15)]), np.concatenate([np.full(120, 0.15), np.zeros(200), *lap * 4])  # fmt: skip
    yaw = np.concatenate([before, np.full(2400, 0.15), after])
    there = np.ones(len(yaw), bool)
    there[len(before) : len(before) + 2400] = False

    def share(rows: np.ndarray, turn: np.ndarray) -> float:
        data = SimpleNamespace(f_y=speed * turn, yaw_rate=turn, rate_hz=rate, rows=rows)
        return bends_share(cast("Any", SimpleNamespace(used=rows)), cast("Any", data))

    halves = np.concatenate([before, [0.0], after])
    assert share(there, yaw) == pytest.approx(share(np.ones(len(halves), bool), halves), abs=0.01)
