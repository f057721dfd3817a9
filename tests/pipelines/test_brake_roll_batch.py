"""The companion of Park & Choi's observer: what it recovers, what its intervals hold, and what it refuses."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from park_drive import Errors, joined, park_drive, park_vehicle

from pipelines.estimators.brake_roll.estimator import BrakeRollBatch
from pipelines.estimators.brake_roll.least import Samples, Unknown, fit_least
from pipelines.estimators.brake_roll.mass import MassKnown, fit_mass
from pipelines.models.braking import drag
from pipelines.reproduce.park.drives import braking, slalom
from pipelines.reproduce.park.methods import (
    SILENT,
    Told,
    braking_bound,
    companion_braking,
    companion_roll,
    roll_bound,
)
from pipelines.reproduce.park.plant import ParkCar, drive_park
from pipelines.reproduce.park.sensors import ParkSensors, sense
from pipelines.reproduce.park.study import STUDY_SENSORS
from pipelines.vehicles.vehicle import Quantity, Vehicle

CAR = ParkCar()
METHOD = BrakeRollBatch()
DEFAULTS = {s.name: s.default for s in METHOD.settings} | {"draws": 20_000.0}


def estimate(drive, vehicle, **settings):
    chosen = DEFAULTS | settings
    return METHOD.estimate(METHOD.prepare(drive, chosen), vehicle, chosen, np.random.default_rng(0))


@pytest.fixture(scope="module")
def stop_run():
    return drive_park(CAR, braking(CAR, 80, 0.6))


@pytest.fixture(scope="module")
def slalom_run():
    return drive_park(CAR, slalom())


def test_the_fit_equals_linear_least_squares_with_its_prior():
    rng = np.random.default_rng(1)
    x = rng.standard_normal((500, 2))
    y = x @ np.array([1.0, 2.0]) + 0.1 * rng.standard_normal(500)
    samples = Samples(y, np.zeros(500, np.int64), np.arange(500) // 25, np.array([0.1]), np.array([1e-6]))
    unknowns = (Unknown("a", 0.0, math.inf, 1e-4), Unknown("b", 0.0, 0.05, 1e-4))
    fit = fit_least(lambda p: x @ p, samples, unknowns)
    noise = fit.noise[0]
    information = x.T @ x / noise**2 + np.diag([0.0, 1 / 0.05**2])
    np.testing.assert_allclose(fit.values, np.linalg.solve(information, x.T @ y / noise**2), rtol=1e-3)
    np.testing.assert_allclose(
        np.sqrt(np.diag(fit.white)), np.sqrt(np.diag(np.linalg.inv(information))), rtol=0.02
    )
    assert fit.converged


def test_residuals_that_hang_together_widen_the_interval():
    rng = np.random.default_rng(2)
    x = np.ones((2000, 1))
    wander = np.repeat(rng.standard_normal(40), 50)
    samples = Samples(
        wander, np.zeros(2000, np.int64), np.arange(2000) // 50, np.array([1.0]), np.array([1e-6])
    )
    fit = fit_least(lambda p: x @ p, samples, (Unknown("a", 0.0, math.inf, 1e-4),))
    assert fit.std("a") > 4 * math.sqrt(fit.white[0, 0])


def test_wild_rows_hardly_move_the_fit():
    rng = np.random.default_rng(3)
    y = 1.0 + 0.1 * rng.standard_normal(400)
    y[::40] += 20.0
    samples = Samples(y, np.zeros(400, np.int64), np.arange(400) // 20, np.array([0.1]), np.array([1e-6]))
    fit = fit_least(lambda p: np.full(400, p[0]), samples, (Unknown("a", 0.0, math.inf, 1e-4),))
    assert fit.value("a") == pytest.approx(1.0, abs=0.1)


def test_braking_recovers_the_height_with_radii_offset_and_delay_unknown(stop_run):
    bound = braking_bound(stop_run, CAR, STUDY_SENSORS, np.random.default_rng(0))
    assert 0.003 < bound < 0.02
    rng = np.random.default_rng(7)
    errors = []
    for _ in range(12):
        fit = companion_braking(sense(stop_run, CAR, STUDY_SENSORS, rng), CAR, STUDY_SENSORS, Told())
        assert fit is not None
        assert abs(fit.height - 0.637) < 4 * fit.std
        assert 0.7 * bound < fit.std < 1.6 * bound
        errors.append(fit.height - 0.637)
    assert np.sqrt(np.mean(np.square(errors))) < 1.7 * bound


def test_a_wrong_cg_place_moves_the_height_and_its_spread_says_so(stop_run):
    moved = CAR.shifted(0.033)
    data = sense(drive_park(moved, braking(moved, 80, 0.6)), CAR, ParkSensors(), np.random.default_rng(2))
    sure = companion_braking(data, CAR, ParkSensors(), Told())
    honest = companion_braking(data, CAR, ParkSensors(), Told(front_m=0.033))
    assert sure is not None
    assert honest is not None
    assert 0.637 - sure.height == pytest.approx(0.033 / 0.6, rel=0.3)
    assert abs(sure.height - 0.637) > 4 * sure.std
    assert abs(honest.height - 0.637) < 1.96 * honest.std


def test_bent_tyres_are_covered_when_they_are_allowed_for():
    car = replace(CAR, slip_bend=0.3)
    data = sense(drive_park(car, braking(car, 80, 0.6)), CAR, ParkSensors(), np.random.default_rng(3))
    honest = companion_braking(data, CAR, ParkSensors(), Told(bend=(0.25, 0.2), load=(0.0, 0.1)))
    assert honest is not None
    assert abs(honest.height - 0.637) < 1.96 * honest.std
    assert honest.std > 0.03


def test_slalom_recovers_the_height_near_its_bound(slalom_run):
    bound = roll_bound(slalom_run, CAR, STUDY_SENSORS, CAR.mass, np.random.default_rng(0))
    rng = np.random.default_rng(8)
    errors = []
    for _ in range(5):
        found = companion_roll(
            sense(slalom_run, CAR, STUDY_SENSORS, rng), CAR, STUDY_SENSORS, CAR.mass, Told()
        )
        assert found is not None
        errors.append(found[0] - 0.637)
        assert found[1] < 3 * bound
    assert np.sqrt(np.mean(np.square(errors))) < 2.5 * bound


def test_the_lateral_fit_without_noise_is_exact(slalom_run):
    data = sense(slalom_run, CAR, SILENT, np.random.default_rng(0))
    found = companion_roll(data, CAR, STUDY_SENSORS, CAR.mass, Told())
    assert found is not None
    assert found[0] == pytest.approx(0.637, abs=0.0006)


def mass_columns(rng, mass=1755.0, grade=0.0):
    t = np.arange(0, 120, 0.05)
    a = 1.2 * np.sin(0.4 * t) - 0.5 * np.sin(0.13 * t)
    v = 20 + np.cumsum(a) * 0.05
    force = mass * (a + 9.80665 * grade) + drag(v, 0.7) + 0.012 * mass * 9.80665 + 4 * 1.0 / 0.32**2 * a
    drive, brake = np.maximum(force, 0) * 0.32, np.maximum(-force, 0) * 0.32
    f = a + 9.80665 * grade + 0.02 * rng.standard_normal(len(t))
    return f, v, brake, drive


def test_the_balance_tells_the_mass_on_any_grade():
    known = MassKnown(1600.0, 0.32, 1e-4, 1.0, (0.7, 0.05), 1e-3, drive=1e-3, pitch=1e-3)
    for grade in (0.0, 0.05):
        f, v, brake, drive = mass_columns(np.random.default_rng(4), grade=grade)
        fit = fit_mass(f, v, brake, drive, np.ones(len(f), bool), 20.0, known)
        assert fit is not None
        assert fit.mass == pytest.approx(1755.0, rel=0.01)
        assert abs(fit.mass - 1755.0) < 4 * fit.std


def test_the_mass_is_known_no_better_than_the_torques():
    f, v, brake, drive = mass_columns(np.random.default_rng(5))
    rows = np.ones(len(f), bool)
    loose = MassKnown(1600.0, 0.32, 1e-4, 1.0, (0.7, 0.05), 0.05, drive=0.05, pitch=1e-3)
    both = fit_mass(f, v, 1.05 * brake, 1.05 * drive, rows, 20.0, loose)
    alone = fit_mass(f, v, brake, None, rows, 20.0, loose)
    assert both is not None
    assert alone is not None
    assert both.std > 0.03 * 1755
    assert alone.std > 0.045 * 1755
    assert abs(both.mass - 1755) < 2 * both.std
    assert fit_mass(f, v, None, None, rows, 20.0, loose) is None
    assert fit_mass(f, v, 0.0 * brake, 0.0 * drive, rows, 20.0, loose) is None


def stops(rng, fade, lets_go_s, mass=1755.0):
    """Six stops from a cruise whose driving force, which is not logged, lasts into each: f_x, speed, brake torque."""
    columns = []
    for top, hard in ((27, 3.0), (22, 4.0), (30, 2.0), (18, 2.5), (25, 3.5), (28, 4.5)):
        since = np.arange(-8, top / hard, 0.05)
        v = top - hard * np.maximum(since, 0.0)
        resistance = drag(v, 0.7) + 0.012 * mass * 9.80665
        engine = resistance * np.exp(-np.maximum(since, 0.0) / lets_go_s)
        brakes = mass * hard * (since > 0)
        f = (engine - brakes - resistance) / (mass + 4 * 1.0 / 0.32**2)
        columns.append((f, v, 0.32 * brakes / (1 + fade * (v / 20 - 1))))
    f, v, brake = (np.concatenate(column) for column in zip(*columns, strict=True))
    return f + 0.02 * rng.standard_normal(len(v)), v, brake


@pytest.mark.parametrize(("fade", "lets_go_s"), [(0.0, 0.01), (-0.02, 0.01), (0.03, 0.01), (0.0, 0.3)])
def test_brakes_that_fade_and_an_engine_that_still_pulls_are_no_drag(fade, lets_go_s):
    known = MassKnown(1600.0, 0.32, 1e-4, 1.0, (0.6, 0.3), 0.03, pitch=1e-3)
    f, v, brake = stops(np.random.default_rng(8), fade, lets_go_s)
    fit = fit_mass(f, v, brake, None, np.ones(len(f), bool), 20.0, known)
    assert fit is not None
    assert abs(fit.fit.value("drag_area") - 0.7) < 2.5 * fit.fit.std("drag_area")
    assert abs(fit.mass - 1755) < 2.5 * fit.std


def mixed_drive(errors, without=(), seed=1):
    cruise = braking(CAR, 80, 0.6, 12.0)
    return park_drive(CAR, joined(cruise, cruise, slalom()), errors, seed, without)


TYRES = {
    "slip_bend": 0.0,
    "slip_bend_std": 1e-3,
    "slip_load": 0.0,
    "slip_load_std": 1e-3,
    "squash": 0.0,
    "squash_std": 1e-3,
}


def test_a_log_gives_height_and_mass_with_offsets_and_a_late_speed():
    drive = mixed_drive(
        Errors(accel_x=-0.1, accel_y=-0.07, roll_rate=0.004, speed_delay_s=0.15, speed_hz=10.0)
    )
    found = estimate(drive, park_vehicle(CAR, load_std=60.0), **TYRES)
    height, mass, lean = (found.parameters[n] for n in ("cg_height_m", "mass_kg", "roll_gradient_degpg"))
    assert height.low < 0.637 < height.high
    assert height.status != "not_identifiable"
    assert height.std < 0.8 * height.prior.std
    assert mass.low < 1755 < mass.high
    expected = CAR.mass * CAR.arm / CAR.roll_stiffness
    assert found.diagnostics["roll_per_lateral_acceleration"] == pytest.approx(expected, rel=0.03)
    # right here, where the ground is flat: no log of slow bends can know that
    assert lean.status == "not_identifiable"
    assert "roads lean into their bends" in lean.reason
    assert found.diagnostics["speed_delay_s"] == pytest.approx(0.15, abs=0.03)
    assert {t.name for t in found.traces} >= {"roll rate", "wheel speeds in braking"}
    assert not found.witness


def test_wheels_tell_the_speed_where_nothing_else_does():
    """Their speeds alone: the roll per lateral acceleration was read up to 5 Hz then, where roads roll the body."""
    speeds = ("speed", "gps_speed_2d", "gps_speed_3d")
    found = [
        estimate(mixed_drive(Errors(), without), park_vehicle(CAR, load_std=60.0), **TYRES)
        for without in ((), speeds)
    ]
    with_speed, by_wheels = (each.diagnostics["roll_per_lateral_acceleration"] for each in found)
    assert by_wheels == pytest.approx(with_speed, rel=0.02)


def test_without_torques_the_mass_is_refused():
    found = estimate(
        mixed_drive(Errors(), ("brake_pressure", "drive_torque")), park_vehicle(CAR, load_std=60.0)
    )
    mass = found.parameters["mass_kg"]
    assert mass.status == "not_identifiable"
    assert "torque" in mass.reason
    assert mass.value == mass.prior.value


def test_loose_brake_gains_leave_the_mass_weak():
    drive = mixed_drive(Errors(), ("drive_torque",))
    tight = estimate(drive, park_vehicle(CAR, load_std=100.0), **TYRES).parameters["mass_kg"]
    loose = estimate(drive, park_vehicle(CAR, load_std=100.0, brake_std=0.08), **TYRES).parameters["mass_kg"]
    assert tight.status == "identified"
    assert loose.status != "identified"
    assert loose.std > 1.5 * tight.std


def test_a_cruise_tells_nothing():
    stop = braking(CAR, 80, 0.6, 40.0)
    drive = park_drive(CAR, replace(stop, pressure=np.zeros(len(stop.pressure))), Errors())
    found = estimate(drive, park_vehicle(CAR))
    for name in ("cg_height_m", "mass_kg", "roll_gradient_degpg", "roll_stiffness_nmprad"):
        assert found.parameters[name].status == "not_identifiable"
    assert found.parameters["roll_gradient_degpg"].value is None


def test_an_unknown_load_widens_the_height_from_roll():
    drive = mixed_drive(Errors(), ("brake_pressure", "drive_torque"))
    told = park_vehicle(CAR, cg_height_m=0.3)
    untold = replace(told, load={})
    sure, unsure = (estimate(drive, v).parameters["cg_height_m"] for v in (told, untold))
    assert unsure.std > sure.std
    assert sure.low < 0.637 < sure.high
    assert unsure.low < 0.637 < unsure.high


def test_a_gyro_that_sees_nothing_is_refused():
    drive = mixed_drive(Errors())
    rate = drive.signals["roll_rate"]
    noise = 0.01 * np.random.default_rng(0).standard_normal(len(rate.values))
    broken = {**drive.signals, "roll_rate": replace(rate, values=-rate.values + noise)}
    broken["accel_y"] = drive.signals["accel_y"]
    del broken["gps_speed_2d"]
    found = estimate(replace(drive, signals=broken), park_vehicle(CAR))
    assert found.parameters["roll_gradient_degpg"].status == "not_identifiable"


def test_no_vehicle_no_height():
    found = estimate(mixed_drive(Errors()), Vehicle(quantities={"wheelbase_m": Quantity(2.57, 0.01, "file")}))
    assert found.parameters["cg_height_m"].status == "not_identifiable"
    assert "mass_kg" in found.reason
