"""The numbers of the standards and papers, read off the demands and roads that the manoeuvres make."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.simulation.manoeuvres.base import Options, VehicleFigures
from pipelines.simulation.manoeuvres.double_lane_change import iso_3888_1, iso_3888_2, path_offsets
from pipelines.simulation.manoeuvres.path import STEP_M, curvature_of
from pipelines.simulation.manoeuvres.registry import make_scenario
from pipelines.simulation.manoeuvres.script import Script
from pipelines.simulation.manoeuvres.sine_with_dwell import dwell_wave
from pipelines.simulation.roads.profile import altitude_m

CAR = VehicleFigures()
G = 9.80665
DT = 0.01


def made(name, options=None, vehicle=CAR):
    return make_scenario(name, vehicle, options or Options(), np.random.default_rng(1))


def lateral_of(scenario, ahead_m=0.0):
    """What the road asks for at the planned place: curvature times speed squared."""
    speed = np.nan_to_num(scenario.demand.target_speed_mps)
    # coasting: the speed before it
    known = np.flatnonzero(np.isfinite(scenario.demand.target_speed_mps))
    speed = np.interp(np.arange(len(speed)), known, scenario.demand.target_speed_mps[known])
    place = np.cumsum(speed) * DT + ahead_m
    road = scenario.road
    return np.interp(place, road.step_m * np.arange(len(road.left_m)), road.curvature_1pm) * speed**2


def runs(flags):
    """(start, end) of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(int), [0]))))
    return list(zip(edges[::2], edges[1::2], strict=True))


def test_the_dwell_wave_is_that_of_fmvss_126():
    wave = dwell_wave(1.0)
    t = DT * np.arange(1, len(wave) + 1)
    assert len(wave) * DT == pytest.approx(1 / 0.7 + 0.5, abs=DT)
    assert t[np.argmax(wave)] == pytest.approx(0.25 / 0.7, abs=DT)
    ((start, end),) = runs(wave < -0.9999)
    assert (end - start) * DT == pytest.approx(0.5, abs=3 * DT)
    assert t[start] == pytest.approx(0.75 / 0.7, abs=2 * DT)
    # 0.7 Hz on either side of the dwell
    assert t[np.flatnonzero(wave < 0)[0]] == pytest.approx(0.5 / 0.7, abs=2 * DT)
    assert wave[:50] == pytest.approx(np.sin(2 * np.pi * 0.7 * t[:50]))
    assert wave[-1] == 0


def test_sine_with_dwell_series():
    scenario = made("sine_with_dwell")
    steer, target = scenario.demand.steering_wheel_angle_rad, scenario.demand.target_speed_mps
    unit = 16.0 * 0.3 * G * (2.78 / (80 / 3.6) ** 2 + 0.0035) + np.radians(13.5) * 0.25
    waves = runs(np.abs(steer) > 1e-9)
    assert len(waves) == 6
    # the first half wave, to the left in the first series; the dwell is on the other side
    first = [steer[a : a + 60][np.argmax(np.abs(steer[a : a + 60]))] for a, _ in waves]
    assert np.array(first[:3]) == pytest.approx(unit * np.array([1.5, 2.0, 2.5]), rel=1e-3)
    assert np.array(first[3:]) == pytest.approx(-unit * np.array([1.5, 2.0, 2.5]), rel=1e-3)
    assert [steer[a : a + 190].min() for a, _ in waves[:3]] == pytest.approx(-np.array(first[:3]), rel=1e-3)
    # coasting from the first turn of the wheel on, at 80 km/h
    assert np.isnan(target[np.abs(steer) > 1e-9]).all()
    for a, b in runs(np.isnan(target)):
        assert target[a - 1] == pytest.approx(80 / 3.6, abs=2 / 3.6)
        assert (b - a) * DT > 1.9 + 1.75
    assert np.nanmax(np.abs(np.diff(steer))) / DT < 2 * np.pi * 0.7 * 2.5 * unit * 1.01


def test_severity_and_side_change_the_amplitude():
    plain = made("sine_with_dwell", Options(direction="right")).demand.steering_wheel_angle_rad
    double = made("sine_with_dwell", Options(direction="right", severity=2.0)).demand.steering_wheel_angle_rad
    assert np.abs(double).max() == pytest.approx(2 * np.abs(plain).max())
    assert plain[np.flatnonzero(plain)[0]] < 0
    huge = made("sine_with_dwell", Options(severity=10.0)).demand.steering_wheel_angle_rad
    assert np.degrees(np.abs(huge).max()) == pytest.approx(300.0)


def test_slowly_increasing_steer():
    scenario = made("slowly_increasing_steer")
    steer, speed = scenario.demand.steering_wheel_angle_rad, scenario.demand.target_speed_mps
    rate = np.degrees(np.diff(steer)) / DT
    rising = runs(np.abs(rate - 13.5) < 1e-6)
    falling = runs(np.abs(rate + 13.5) < 1e-6)
    assert max(b - a for a, b in rising) * DT == pytest.approx(np.degrees(steer.max()) / 13.5, abs=2 * DT)
    assert max(b - a for a, b in falling) * DT > 2
    assert speed[steer != 0] == pytest.approx(80 / 3.6)
    assert steer.max() == pytest.approx(CAR.steering_wheel_rad(0.5 * G, 80 / 3.6) + np.radians(13.5) * 0.25)
    assert steer.min() == -steer.max()


def test_step_steer():
    scenario = made("step_steer")
    steer = scenario.demand.steering_wheel_angle_rad
    (a, b), *_ = runs(steer > 0)
    up = steer[a - 1 : a + 60]
    top = steer.max()
    rise = np.flatnonzero(up >= 0.9 * top)[0] - np.flatnonzero(up > 0.1 * top)[0]
    assert rise * DT <= 0.15
    assert 200 <= np.degrees(np.diff(up).max()) / DT <= 500
    assert np.count_nonzero(steer[a:b] == top) * DT >= 4
    assert top == pytest.approx(CAR.steering_wheel_rad(4.0, 100 / 3.6))
    assert scenario.demand.target_speed_mps[steer != 0] == pytest.approx(100 / 3.6)


def test_sine_sweep_and_weave():
    steer = made("sine_sweep").demand.steering_wheel_angle_rad
    # the ease-out makes the last rows zero; the wave itself is 50 s
    start = np.flatnonzero(steer)[0] - 1
    crossings = np.flatnonzero(np.diff(np.sign(steer[start + 1 : start + 5000])) != 0) * DT
    # half waves against the frequency at their middle, 0.2 to 3 Hz growing evenly on a log scale
    middle = 0.5 * (crossings[1:] + crossings[:-1])
    assert np.diff(crossings) == pytest.approx(0.5 / (0.2 * 15 ** (middle / 50)), abs=2.1 * DT)
    assert crossings[0] < 2.5
    assert crossings[-1] > 49.5
    weave = made("weave").demand.steering_wheel_angle_rad
    crossings = np.flatnonzero(np.diff(np.sign(weave[weave != 0])) != 0)
    assert np.diff(crossings) * DT == pytest.approx(2.5, abs=0.02)
    assert weave.max() == pytest.approx(CAR.steering_wheel_rad(2.0, 100 / 3.6), rel=1e-3)


@pytest.mark.parametrize(("name", "radius"), [("steady_circle", 100.0), ("steady_circle_steps", 100.0)])
def test_steady_circle_is_that_of_iso_4138(name, radius):
    scenario = made(name)
    assert np.abs(scenario.road.curvature_1pm).max() == pytest.approx(1 / radius, rel=1e-6)
    lateral = lateral_of(scenario)
    assert lateral.max() == pytest.approx(5.0, rel=0.02)
    assert lateral.min() == pytest.approx(-5.0, rel=0.02)
    if name == "steady_circle":
        rise = np.diff(lateral) / DT
        ((a, b),) = runs((lateral[:-1] > 1.0) & (rise > 0.01))
        assert rise[a:b] == pytest.approx(0.1, abs=0.002)
    else:
        flat = [b - a for a, b in runs(np.abs(np.diff(lateral)) < 1e-9) if lateral[a] > 0.6]
        assert len([n for n in flat if n * DT >= 4.9]) >= 9


def test_the_35_m_circle_of_park_and_choi():
    scenario = made("circle_35m")
    assert scenario.road.curvature_1pm.max() == pytest.approx(1 / 35)
    assert scenario.road.curvature_1pm.min() == 0
    assert scenario.demand.target_speed_mps.max() == pytest.approx(50 / 3.6)


@pytest.mark.parametrize(
    ("course", "lengths", "offset"),
    [(iso_3888_1, (15, 30, 25, 25, 15), 3.5), (iso_3888_2, (12, 13.5, 11, 12.5, 12), None)],
)
def test_lane_changes_stay_between_the_cones(course, lengths, offset):
    width = 1.84
    made_course = course(width)
    assert made_course.lengths_m == lengths
    if offset is None:
        # 1 m between the right edge of the far lane and the left edge of the first
        offset = 1 + (1.1 * width + 0.25) / 2 + (width + 1) / 2
    assert made_course.offset_m == pytest.approx(offset)
    y = path_offsets(made_course, width)
    x = STEP_M * np.arange(len(y))
    edges = np.cumsum((0, *lengths))
    for k, (lane, middle) in enumerate(zip(made_course.widths_m, (0, offset, 0), strict=True)):
        inside = (x >= edges[2 * k]) & (x <= edges[2 * k + 1])
        assert np.abs(y[inside] - middle).max() <= (lane - width) / 2
    assert y.max() == pytest.approx(offset, rel=0.05)
    heading = np.cumsum(curvature_of(y)) * STEP_M
    assert heading[-1] == pytest.approx(0, abs=2e-3)


def test_lane_changes_are_hard_but_below_the_limit():
    for name, low, high in (("double_lane_change", 3.5, 6.5), ("obstacle_avoidance", 5.0, 7.5)):
        lateral = np.abs(lateral_of(made(name))).max()
        assert low < lateral < high, name


@pytest.mark.parametrize(("name", "spacing", "speed"), [("slalom", 18.0, 35.0), ("slalom_36m", 36.0, 65.0)])
def test_slalom_swings_once_a_cone(name, spacing, speed):
    scenario = made(name)
    road = scenario.road
    assert scenario.demand.target_speed_mps.max() == pytest.approx(speed / 3.6, rel=0.05)
    sign = np.sign(road.curvature_1pm[np.abs(road.curvature_1pm) > 1e-6])
    crossings = np.flatnonzero(np.diff(sign)) * road.step_m
    middle = np.diff(crossings[3:9])
    assert middle == pytest.approx(spacing, abs=0.1 * spacing)
    assert 3.5 < np.abs(lateral_of(scenario)).max() < 5.2


def test_park_and_chois_slalom_has_three_slaloms_and_two_u_turns():
    scenario = made("slalom_u_turns")
    road = scenario.road
    still = runs(np.abs(road.curvature_1pm - 1 / 22.0) < 1e-9)
    assert len([1 for a, b in still if (b - a) * road.step_m > 50]) == 2
    assert np.abs(lateral_of(scenario)).max() == pytest.approx(0.45 * G, rel=0.15)
    assert scenario.demand.target_speed_mps.max() * 3.6 == pytest.approx(95, abs=6)


@pytest.mark.parametrize(
    ("name", "decel", "speed", "grip"),
    [("straight_braking", 0.6, 80.0, 0.9), ("straight_braking_basalt", 0.25, 50.0, 0.45)],
)
def test_straight_braking_is_that_of_park_and_choi(name, decel, speed, grip):
    scenario = made(name)
    demand = scenario.demand
    assert np.all(scenario.road.friction_left == grip)
    assert demand.target_speed_mps.max() == pytest.approx(speed / 3.6)
    presses = runs(demand.brake_pressure_pa > 0)
    assert len(presses) == 3
    # the pressure's force, with rolling resistance, is the deceleration
    force = demand.brake_pressure_pa.max() * CAR.brake_gain_nmppa / CAR.wheel_radius_m
    assert force / CAR.mass_kg + G * CAR.rolling_resistance == pytest.approx(decel * G, rel=1e-3)
    for a, b in presses:
        assert demand.target_speed_mps[a - 270 : a] == pytest.approx(speed / 3.6)
        # held past the stop, with time to stand
        assert (b - a) * DT > speed / 3.6 / (decel * G) + 4.0
        assert np.all(demand.target_speed_mps[a:b] == 0)


def test_truck_runs_are_those_of_wu():
    flat, slope = made("truck_flat"), made("truck_slope")
    for scenario in (flat, slope):
        assert scenario.demand.duration_s == pytest.approx(25.0)
        assert scenario.demand.target_speed_mps[0] == pytest.approx(15 / 3.6)
        assert np.all(scenario.road.friction_left == 0.85)
    accel = np.diff(flat.demand.target_speed_mps) / DT
    assert accel.max() == pytest.approx(2.1, abs=0.02)
    assert accel.min() == pytest.approx(-1.7, abs=0.02)
    assert len([1 for a, b in runs(accel > 1.0) if b - a > 50]) == 3
    assert len([1 for a, b in runs(accel < -1.0) if b - a > 50]) == 2
    assert np.abs(flat.road.grade_rad).max() == 0
    assert np.degrees(np.abs(slope.road.grade_rad)).max() == pytest.approx(6.0, abs=0.01)
    assert 6.5 < altitude_m(slope.road).max() <= 8.05
    way = np.cumsum(slope.demand.target_speed_mps)[-1] * DT
    down = np.flatnonzero(slope.road.grade_rad < 0)[[0, -1]] * slope.road.step_m
    assert down[1] < way


def test_hills_reach_ten_percent_both_ways():
    grade = made("hills").road.grade_rad
    assert 0.085 < grade.max() < 0.101
    assert -0.101 < grade.min() < -0.085


def test_handling_track_has_closing_and_cambered_bends():
    road = made("handling_track").road
    assert road.curvature_1pm.max() > 1 / 20
    assert road.bank_rad.max() - road.bank_rad.min() > 0.08
    assert np.abs(road.grade_rad).max() > 0.04
    assert 4.5 < np.abs(lateral_of(made("handling_track"))).max() < 6.5


def test_speeds_keep_to_the_power_there_is():
    weak = VehicleFigures(mass_kg=5700.0, power_w=80_000.0)
    script = Script(weak, 0.9)
    script.reach(25.0, 3.0)
    speed = script.demand().target_speed_mps
    accel = np.diff(speed) / DT
    need = weak.mass_kg * (accel + np.array([weak.resistance_mps2(v) for v in speed[1:]])) * speed[1:]
    assert need.max() < 0.8 * weak.power_w
    assert script.speed_mps == pytest.approx(25.0)
