"""Roads written in pieces, and the speed driven along them."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.simulation.roads.course import STEP_M, Course, Driver, drive, planned_s
from pipelines.simulation.roads.speed_plan import (
    Limits,
    Power,
    _fastest,
    arrival_times,
    fastest,
    over_time,
    slowest_near,
)

FREE = Power(1e9, 1e9, 0.0, 0.0)
DRIVER = Driver((2.0, 2.0), 2.0, 2.5, 1.0, 0.0, 25.0)


def limits(speed, accel=2.0, decel=3.0, step=0.5, wait=None):
    n = len(speed)
    return Limits(
        step,
        np.asarray(speed, float),
        np.full(n, accel),
        np.full(n, decel),
        np.zeros(n),
        np.zeros(n) if wait is None else wait,
    )


def course(build, driver=DRIVER, seed=1):
    made = Course(driver, np.random.default_rng(seed), 4.0)
    build(made)
    return made


def test_kernel_equals_plain_python():
    rng = np.random.default_rng(2)
    speed = rng.uniform(2, 30, 400)
    speed[[0, 150, 399]] = 0
    args = (0.5, speed, rng.uniform(1, 3, 400), rng.uniform(1, 5, 400), rng.uniform(-0.1, 0.1, 400))
    figures = np.array([40.0, 3e-4, 0.012, 3.0])
    plain = _fastest.py_func(*args, figures)
    assert _fastest(*args, figures) == pytest.approx(plain, rel=1e-12)
    assert np.all(plain <= speed + 1e-12)


def test_launch_and_stop_follow_the_textbook():
    speed = np.full(1001, 50.0)
    speed[[0, -1]] = 0
    plan = limits(speed)
    v = fastest(plan, FREE)
    s = 0.5 * np.arange(1001)
    # up with 2, down with 3 m/s² over 500 m: they meet at v² = 2 * 500 / (1/2 + 1/3)
    assert v == pytest.approx(np.minimum(np.sqrt(2 * 2 * s), np.sqrt(2 * 3 * (500 - s))))
    top = np.sqrt(2 * 500 / (1 / 2 + 1 / 3))
    assert arrival_times(v, 0.5)[-1] == pytest.approx(top / 2 + top / 3, rel=1e-3)


def test_power_and_grade_bound_the_launch():
    speed = np.full(4001, 50.0)
    speed[0] = 0
    v = fastest(limits(speed, accel=10.0), Power(10.0, 1e9, 0.0, 0.0))
    # even power from 2 m/s on: v³ grows by 3 P/m a metre
    assert v[-1] ** 3 == pytest.approx(3 * 10.0 * 2000, rel=0.01)
    steep = Limits(0.5, speed, np.full(4001, 10.0), np.full(4001, 3.0), np.full(4001, 0.1), np.zeros(4001))
    v = fastest(steep, Power(10.0, 1e9, 0.0, 0.0))
    assert v[-1] == pytest.approx(10.0 / (9.80665 * np.sin(0.1)), rel=0.01)


@pytest.mark.parametrize("smooth", [0.5, 1.4])
def test_speed_over_time_keeps_the_way_the_waits_and_the_jerk(smooth):
    speed = np.full(1001, 15.0)
    speed[[0, 400, -1]] = 0
    wait = np.zeros(1001)
    wait[[0, 400, -1]] = 4.0, 3.0, 5.0
    plan = limits(speed, wait=wait)
    v = fastest(plan, FREE)
    target = over_time(v, plan, 0.01, smooth)
    assert target.sum() * 0.01 == pytest.approx(500.0, rel=1e-3)
    still = target < 1e-9
    assert still[: round((4 - smooth / 2) / 0.01) - 2].all()
    assert still.sum() * 0.01 == pytest.approx(12 - 2 * smooth, abs=0.1)
    accel = np.diff(target) / 0.01
    assert -3.01 < accel.min() < -2.5
    assert 1.7 < accel.max() < 2.01
    # braking gives way to driving off within smooth seconds at the soonest
    assert np.abs(np.diff(accel)).max() / 0.01 <= 2 * 5.0 / smooth * 1.02


def test_slowest_near():
    values = np.full(50, 10.0)
    values[25] = 4
    near = slowest_near(values, 0.5, 3.0)
    assert np.flatnonzero(near == 4).tolist() == list(range(19, 32))


@pytest.mark.parametrize("tighten", [1.0, 0.5])
@pytest.mark.parametrize(("radius", "degrees"), [(9.0, 90.0), (200.0, -40.0), (60.0, 250.0)])
def test_a_turn_turns_by_its_angle_at_its_lateral_acceleration(radius, degrees, tighten):
    made = course(lambda c: c.turn(radius, np.radians(degrees), 30.0, tighten=tighten))
    curvature, limit, _, _ = made.arrays()
    assert np.degrees(curvature.sum() * STEP_M) == pytest.approx(degrees, rel=1e-6)
    assert np.max(np.abs(curvature) * limit**2) <= 2.0 * 1.0001
    # an even change of curvature: no jump of the steering wheel
    assert np.abs(np.diff(curvature)).max() < 1.5 * np.abs(curvature).max() / 5
    if tighten < 1:
        peak = np.argmax(np.abs(curvature))
        assert peak > 0.5 * len(curvature)


def test_a_lane_change_ends_beside_and_straight():
    made = course(lambda c: c.change_lane(3.5, 100.0, 25.0))
    curvature = made.arrays()[0]
    heading = np.cumsum(curvature) * STEP_M
    assert heading[-1] == pytest.approx(0, abs=1e-9)
    assert np.sum(heading) * STEP_M == pytest.approx(3.5, rel=0.02)


def test_bends_are_slow_from_before_to_behind():
    def build(c):
        c.straight(200, 20.0)
        c.turn(20.0, 1.5, 20.0)
        c.straight(200, 20.0)

    made = course(build)
    curvature, _, _, _ = made.arrays()
    demand, road = drive(made, FREE, 0.9, duration_s=None, rest_s=3.0, step_s=0.01, traffic=False)
    place = np.cumsum(demand.target_speed_mps) * 0.01
    for error in (-4.0, 0.0, 4.0):
        here = np.interp(place + error, STEP_M * np.arange(len(curvature)), curvature)
        assert np.max(np.abs(here) * demand.target_speed_mps**2) < 2.0 * 1.15
    assert np.array_equal(road.curvature_1pm, curvature)


@pytest.mark.parametrize("duration", [12.0, 61.7, 200.0, 500.0])
def test_a_drive_lasts_as_long_as_asked_and_ends_at_rest(duration):
    def build(c):
        for k in range(12):
            c.straight(100, 15.0)
            c.stop(4.0, 4.0 if k % 2 else 1.2)
            c.turn(12.0, 1.5, 15.0)

    made = course(build)
    demand, _ = drive(made, FREE, 0.9, duration_s=duration, rest_s=3.0, step_s=0.01)
    assert demand.duration_s == pytest.approx(duration, abs=0.011)
    assert np.all(demand.target_speed_mps[-150:] < 1e-6)
    assert np.all(demand.target_speed_mps[:300] < 1e-6)
    assert planned_s(made, FREE) > 150


def test_hard_and_soft_stops_have_their_own_braking():
    def build(c):
        c.straight(150, 15.0)
        c.stop(4.0, 5.0)
        c.straight(150, 15.0)
        c.stop(4.0, 1.2)

    demand, _ = drive(course(build), FREE, 0.9, duration_s=None, rest_s=3.0, step_s=0.01, traffic=False)
    accel = np.diff(demand.target_speed_mps) / 0.01
    middle = len(accel) // 2
    # the few metres to the road's end are driven with the driver's own braking
    fast = demand.target_speed_mps[1:] > 4
    assert -5.01 < accel[:middle][fast[:middle]].min() < -4.5
    assert -1.3 < accel[middle:][fast[middle:]].min() < -1.1


def test_laps_are_over_the_same_road():
    def build(c):
        c.straight(50, 20.0)
        c.turn(20.0, 1.5, 20.0)
        c.repeat(2)

    curvature = course(build).arrays()[0][16:]
    lap = len(curvature) // 3
    assert np.array_equal(curvature[:lap], curvature[lap : 2 * lap])
    assert curvature[:lap].max() > 0.04
