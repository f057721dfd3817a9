"""Park & Choi's observer on logs of the paper's car: what it finds, its gates, and what it refuses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from park_drive import Errors, joined, park_drive, park_vehicle

from pipelines.estimators.brake_roll.data import collect_data, prepare_drive, wheel_scales
from pipelines.estimators.brake_roll.speed import alignment, equals_wheels
from pipelines.estimators.brake_roll.vehicle import known_of
from pipelines.estimators.integrated_observer.core import Gates, robustness_bound, run_braking
from pipelines.estimators.integrated_observer.estimator import IntegratedObserver
from pipelines.prepare.prepared import Segment
from pipelines.reproduce.park.drives import braking, slalom
from pipelines.reproduce.park.methods import SILENT, gains_of, published
from pipelines.reproduce.park.plant import ParkCar, drive_park
from pipelines.reproduce.park.sensors import ParkSensors, sense
from pipelines.vehicles.vehicle import Vehicle

CAR = ParkCar()
METHOD = IntegratedObserver()
DEFAULTS = {s.name: s.default for s in METHOD.settings}


def estimate(drive, vehicle, **settings):
    chosen = DEFAULTS | settings
    return METHOD.estimate(METHOD.prepare(drive, chosen), vehicle, chosen, np.random.default_rng(0))


def stop_input(car=CAR, sensors=SILENT, seed=0):
    return sense(drive_park(car, braking(car, 80, 0.6)), car, sensors, np.random.default_rng(seed))


def test_braking_without_noise_gives_the_height_but_for_drag_and_spin():
    found = published(stop_input(), CAR).brake
    assert found is not None
    assert found.height[-1] == pytest.approx(0.637, abs=0.008)
    c = found.stiffness[found.active]
    np.testing.assert_allclose(c[:, 0], c[:, 1], rtol=1e-9)
    assert np.median(c) == pytest.approx(15 * CAR.mass / CAR.nominal_kg, rel=0.03)


def test_a_wrong_cg_place_moves_the_height_by_g_over_deceleration():
    moved = CAR.shifted(0.055)
    right = published(stop_input(), CAR).brake
    data = sense(drive_park(moved, braking(moved, 80, 0.6)), CAR, SILENT, np.random.default_rng(0))
    wrong = published(data, CAR).brake
    assert right is not None
    assert wrong is not None
    assert right.height[-1] - wrong.height[-1] == pytest.approx(0.055 / 0.6, rel=0.12)


def test_the_mass_does_not_follow_the_load():
    ends = []
    for added in (-200.0, 400.0):
        car = replace(CAR, added_kg=added)
        data = sense(drive_park(car, braking(car, 80, 0.6)), car, ParkSensors(), np.random.default_rng(1))
        brake = published(data, car).brake
        assert brake is not None
        ends.append(brake.added[-1])
    assert abs(ends[1] - ends[0]) < 30.0


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda d: replace(d, apart=np.full(len(d.speed), 1.0)), "split friction"),
        (lambda d: replace(d, steering=np.full(len(d.speed), 0.5)), "steering"),
        (lambda d: replace(d, front=0.85 * d.front), "large slip"),
        (
            lambda d: replace(d, front=d.front * (1 + 0.02 * np.sign(np.sin(np.arange(len(d.front)) * 0.6)))),
            "cycling",
        ),
        (lambda d: replace(d, allowed=np.zeros(len(d.speed), bool)), "slope or satellites"),
    ],
)
def test_each_gate_shuts_the_braking_part(change, why):
    data = stop_input()
    open_part = run_braking(data, CAR.known(), Gates(), 0.5, start_covariance=(1e-5, 1e-4))
    shut = run_braking(change(data), CAR.known(), Gates(), 0.5, start_covariance=(1e-5, 1e-4))
    assert open_part is not None
    assert shut is not None
    assert open_part.active.sum() > 200
    assert shut.active.sum() == 0, why
    assert (shut.height == 0.5).all()


def test_the_stability_bound_shrinks_as_the_estimate_settles():
    data = sense(drive_park(CAR, slalom()), CAR, SILENT, np.random.default_rng(0))
    observed = published(data, CAR, mass=CAR.mass, brakes=False)
    assert observed.roll is not None
    bound = robustness_bound(observed.roll, data.f_y, gains_of(CAR))
    assert np.nanmedian(bound[500:1500]) > 3 * np.nanmedian(bound[-6000:-2000])


def test_a_slalom_log_gives_the_height_and_its_interval_holds_it():
    drive = park_drive(CAR, slalom(), Errors(accel_y=-0.07), without=("brake_pressure",))
    found = estimate(drive, park_vehicle(CAR, cg_height_m=0.3))
    assert found.witness
    height = found.parameters["cg_height_m"]
    assert height.status != "not_identifiable"
    assert height.value == pytest.approx(0.637, rel=0.12)
    assert height.low < 0.637 < height.high
    assert height.std > 0.05 * 0.637
    assert found.parameters["mass_kg"].status == "not_identifiable"
    assert len(found.tracks) == 1
    assert found.traces


def test_gentle_stops_leave_a_wide_interval_that_holds_the_height():
    height = estimate(park_drive(CAR, slalom(), Errors()), park_vehicle(CAR)).parameters["cg_height_m"]
    assert height.status == "not_identifiable"
    assert height.low < 0.637 < height.high
    assert height.std > 0.2


def test_without_brake_data_the_lateral_part_runs_alone_and_says_so():
    drive = park_drive(CAR, slalom(), Errors(), without=("brake_pressure",))
    found = estimate(drive, park_vehicle(CAR))
    height = found.parameters["cg_height_m"]
    assert "no brake pressure" in height.reason
    assert "from roll" in height.reason
    assert height.low < 0.637 < height.high


def test_without_a_roll_rate_the_braking_part_runs_alone():
    demand = joined(*[braking(CAR, 80, 0.6, 12.0)] * 2)
    drive = park_drive(CAR, demand, Errors(), without=("roll_rate",))
    found = estimate(drive, park_vehicle(CAR))
    assert "from braking" in found.parameters["cg_height_m"].reason
    assert found.diagnostics["braking_rows"] > 200


def test_a_straight_cruise_tells_nothing():
    cruise = replace(
        braking(CAR, 80, 0.6, 40.0), pressure=np.zeros(len(braking(CAR, 80, 0.6, 40.0).pressure))
    )
    found = estimate(park_drive(CAR, cruise, Errors()), park_vehicle(CAR))
    height = found.parameters["cg_height_m"]
    assert height.status == "not_identifiable"
    assert "hardly any cornering" in height.reason
    # the figures are those of what was known before
    assert height.value == height.prior.value


def test_little_cornering_leaves_the_start_in_the_result():
    demand = slalom()
    short = replace(
        demand, curvature=demand.curvature[:18_000], speed=demand.speed[:18_000], grade=demand.grade[:18_000],
        pressure=demand.pressure[:18_000],
    )  # fmt: skip
    found = estimate(park_drive(CAR, short, Errors(), without=("brake_pressure",)), park_vehicle(CAR))
    assert found.diagnostics["start_left_share"] > 0.5
    assert found.parameters["cg_height_m"].status == "not_identifiable"


def test_no_mass_no_answer():
    found = estimate(park_drive(CAR, braking(CAR, 80, 0.6), Errors()), Vehicle())
    assert found.parameters["cg_height_m"].status == "not_identifiable"
    assert "mass_kg" in found.reason


def test_a_speed_from_the_wheels_is_found_out():
    drive = park_drive(CAR, joined(*[braking(CAR, 80, 0.6, 12.0)] * 2), Errors())
    wheels = drive.signals["wheel_speed_fl"]
    mean = np.mean([drive.signals[f"wheel_speed_{w}"].values for w in ("fl", "fr", "rl", "rr")], axis=0)
    signals = dict(drive.signals)
    del signals["gps_speed_2d"]
    signals["speed"] = replace(wheels, name="speed", values=mean)
    prepared = prepare_drive(replace(drive, signals=signals), 100.0, 5.0)
    known = known_of(park_vehicle(CAR))
    assert known is not None
    data = collect_data(prepared, known)
    assert any("taken from them" in why for why in data.missing)
    assert equals_wheels(mean, mean)
    assert not equals_wheels(mean * (1 + 0.03 * (np.arange(len(mean)) > 1500)), mean)


def test_the_delay_of_the_speed_and_the_gain_of_the_accelerometer_are_found():
    rate, rng = 50.0, np.random.default_rng(2)
    t = np.arange(round(120 * rate)) / rate
    a = 1.5 * np.sin(2 * np.pi * 0.15 * t) + np.sin(2 * np.pi * 0.33 * t + 1)
    v = 20 + np.cumsum(a) / rate
    late = np.interp(t - 0.15, t, v) + 0.02 * rng.standard_normal(len(t))
    found = alignment(late, 1.06 * a + 0.1, (Segment(0, len(t)),), rate)
    assert found is not None
    delay, delay_std, gain, gain_std = found
    assert delay == pytest.approx(0.15, abs=0.015)
    assert gain == pytest.approx(1.06, abs=0.01)
    assert delay_std < 0.02
    assert gain_std < 0.02
    assert alignment(np.full(len(t), 20.0), np.zeros(len(t)), (Segment(0, len(t)),), rate) is None


def test_wheel_radii_are_read_where_no_force_acts():
    demand = joined(*[braking(CAR, 80, 0.6, 12.0)] * 2)
    drive = park_drive(CAR, demand, Errors(radius_front=0.004, radius_rear=-0.003))
    prepared = prepare_drive(drive, 100.0, 5.0)
    known = known_of(park_vehicle(CAR))
    assert known is not None
    scale = wheel_scales(collect_data(prepared, known), known)
    assert scale.told
    assert scale.front == pytest.approx(1.004, abs=0.0015)
    assert scale.rear == pytest.approx(0.997, abs=0.0015)
