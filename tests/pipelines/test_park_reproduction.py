"""The reproduction of Park & Choi: that it runs, is the same for a seed, and that its figures say what its remarks say."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipelines.reproduce.park.drives import braking, circle
from pipelines.reproduce.park.paper import Park
from pipelines.reproduce.park.plant import ParkCar, drive_park


@pytest.fixture(scope="module")
def found():
    return Park().reproduce(3, np.random.default_rng(0), lambda words, share: None)


def test_table_two_follows_the_moved_cg(found):
    table = found.tables[0]
    ours = np.array([row[4] for row in table.rows])
    simple = np.array([row[6] for row in table.rows])
    # the slope of our errors over g dl / |a_x| is that of the statics, whatever the constant error
    assert np.polyfit(simple, ours, 1)[0] == pytest.approx(1.0, abs=0.12)
    printed = np.array([row[2] for row in table.rows])
    assert list(printed) == [-18.0, 28.0, -36.0, 85.0, -91.0]


def test_the_companion_stays_near_its_bound(found):
    rows = {(r.setup.split()[0], r.method): r for r in found.study}
    assert len(rows) == 8
    for setup in ("asphalt", "basalt", "circle", "slalom"):
        row = rows[(setup, "brake_roll_batch")]
        assert row.bound is not None
        assert math.isfinite(row.bound)
        assert row.rmse < 3 * row.bound


def test_the_mass_column_shows_that_the_load_is_not_followed(found):
    table = found.tables[2]
    true, lrls, balance = (np.array([row[i] for row in table.rows]) for i in range(3))
    assert np.ptp(lrls) < 0.1 * np.ptp(true)
    np.testing.assert_allclose(balance, true, atol=20.0)


def test_claims_have_a_remark_where_they_differ(found):
    assert len(found.claims) >= 10
    for claim in found.claims:
        assert claim.agreement != "differs" or claim.remark
    gamma = next(c for c in found.claims if "29" in c.place)
    assert gamma.ours == "20.397"
    assert gamma.agreement == "agrees"


def test_the_same_seed_gives_the_same_figures(found):
    again = Park().reproduce(3, np.random.default_rng(0), lambda words, share: None)
    assert [r.rmse for r in again.study] == [r.rmse for r in found.study]
    assert again.claims == found.claims


def test_the_plant_brakes_as_its_forces_say():
    car = ParkCar()
    run = drive_park(car, braking(car, 80, 0.6))
    steady = (run.time > 3.5) & (run.time < 5.5)
    assert np.mean(run.f_x[steady]) == pytest.approx(-0.6 * 9.80665, rel=0.02)
    # the speed is the integral of what the accelerometer reads
    fallen = run.v[350] - run.v[550]
    assert fallen == pytest.approx(-np.trapezoid(run.f_x[350:551], dx=0.01), rel=1e-3)


def test_the_plant_leans_as_its_springs_say():
    car = ParkCar()
    run = drive_park(car, circle())
    expected = car.mass * car.arm * run.f_y[-1] / car.roll_stiffness
    assert run.roll[-1] == pytest.approx(expected, rel=0.01)
    assert run.v[-1] * run.yaw_rate[-1] + 9.80665 * run.roll[-1] == pytest.approx(run.f_y[-1], rel=0.01)
