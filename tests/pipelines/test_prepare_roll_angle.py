"""Roll angles from what is there: ranked, and right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import plant_roll as plant
import pytest

from pipelines.prepare.roll_angle import rank_roll, with_roll
from pipelines.prepare.signals import prepare_signals
from pipelines.vehicles.vehicle import Vehicle

QUIET = plant.Sensors(accel_noise=0.01, roll_noise=1e-5, rate_noise=1e-4, roll_offset=0.0, accel_offset=0.0)
NAMES = ["roll_rate", "yaw_rate", "speed", *(f"suspension_deflection_{w}" for w in ("fl", "fr", "rl", "rr"))]


@pytest.fixture(scope="module")
def scene() -> tuple[plant.Car, dict[str, plant.Array], plant.Drive]:
    car = plant.Car()
    motion = plant.simulate(car, plant.slalom(4.0))
    return car, motion, plant.record(motion, car, QUIET, np.random.default_rng(1))


def test_ranked_and_recorded(scene: tuple[plant.Car, dict[str, plant.Array], plant.Drive]) -> None:
    car, _, drive = scene
    vehicle = plant.vehicle_of(car, plant.Knowledge(), np.random.default_rng(2))
    prepared = prepare_signals(drive, ["accel_y", "roll"], rate_hz=16, cutoff_hz=8, optional=NAMES)
    ranked = rank_roll(prepared, vehicle)
    assert [source.kind for source in ranked] == ["measured", "deflections", "gyro_gravity"]
    assert [source.against for source in ranked] == ["horizon", "axles", "horizon"]
    best, source = with_roll(prepared, vehicle)
    assert source is not None
    assert source.kind == "measured"
    assert best.sources["roll"] == "measured: roll"
    assert "ranked below it: derived: suspension deflections" in best.notes[-1]


def test_deflections_give_the_angle_against_the_axles(
    scene: tuple[plant.Car, dict[str, plant.Array], plant.Drive],
) -> None:
    car, motion, drive = scene
    without = plant.without(drive, "roll")
    vehicle = plant.vehicle_of(car, plant.Knowledge(), np.random.default_rng(2))
    prepared = prepare_signals(without, ["accel_y"], rate_hz=16, cutoff_hz=8, optional=NAMES)
    rolled, source = with_roll(prepared, vehicle)
    assert source is not None
    assert source.kind == "deflections"
    assert "roll" not in rolled.measured
    truth = np.interp(
        prepared.time_s, np.arange(len(motion["roll"])) / plant.RATE, motion["roll"] - motion["axle"]
    )
    np.testing.assert_allclose(source.angle[8:-8], truth[8:-8], atol=5e-4)
    silent = rank_roll(prepared, replace(vehicle, quantities={}))
    assert silent[0].kind == "deflections"
    assert "track taken as 1.55 m" in silent[0].how


def test_gyro_and_gravity_follow_a_slalom(
    scene: tuple[plant.Car, dict[str, plant.Array], plant.Drive],
) -> None:
    _, motion, drive = scene
    only = plant.without(drive, "suspension")
    only = replace(only, signals={n: s for n, s in only.signals.items() if n != "roll"})
    prepared = prepare_signals(only, ["accel_y", "roll_rate"], rate_hz=16, cutoff_hz=8, optional=NAMES)
    (source,) = rank_roll(prepared, Vehicle())
    truth = np.interp(prepared.time_s, np.arange(len(motion["roll"])) / plant.RATE, motion["roll"])
    inner = (prepared.time_s > 8) & (prepared.time_s < 38)
    assert np.std((source.angle - truth)[inner]) < 0.1 * np.std(truth[inner])


def test_nothing_there_gives_nothing() -> None:
    t = np.arange(0, 10, 0.01)
    accel = plant.Signal("accel_y", np.round(t * 1e9).astype(np.int64), np.sin(t), "a")
    prepared = prepare_signals(
        plant.Drive({"accel_y": accel}, plant.bare_record(10)), ["accel_y"], rate_hz=16, cutoff_hz=8
    )
    assert rank_roll(prepared, Vehicle()) == ()
    assert with_roll(prepared, Vehicle())[1] is None
