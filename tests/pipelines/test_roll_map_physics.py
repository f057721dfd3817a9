"""What a linear model of roll leaves out: dry friction, a banked road under a vehicle that holds its course, delays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plant_roll as plant
import pytest

from parsers.drive import Drive, Signal
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.estimator import RollMap
from pipelines.models.roll import dry_friction
from pipelines.prepare.signals import prepare_signals
from pipelines.simulation.roll_drive import RollVehicle
from pipelines.vehicles.vehicle import Vehicle

G = 9.80665
DEG = float(np.radians(1.0))


def test_friction_turns_round_with_the_way_and_starts_anew_in_each_segment() -> None:
    way = np.concatenate((np.linspace(0, 0.02, 50), np.linspace(0.02, 0.0, 50)))
    held = dry_friction(np.tile(way, 2), np.array([0, 100]), np.array([100, 200]), 0.002)
    assert held[0] == 0
    assert held[49] == pytest.approx(1 - np.exp(-10), abs=1e-9)
    assert held[99] == pytest.approx(-1 + (2 - np.exp(-10)) * np.exp(-10), abs=1e-9)
    assert held[:100] == pytest.approx(held[100:])
    faster = dry_friction(way[::7], np.array([0]), np.array([len(way[::7])]), 0.002)
    assert faster[7] == pytest.approx(held[49], abs=1e-6)


def _drive(push: np.ndarray, bank: np.ndarray, a: float, rng: np.random.Generator) -> Drive:
    """A body that follows at once, on a road whose bank adds to the angle and, times g, to the reading."""
    roll = (push + G * bank) / (a - G) + bank
    sensed = push + G * roll
    t = np.arange(len(push)) * 10_000_000
    columns = {
        "accel_y": sensed + 0.02 * rng.standard_normal(len(t)),
        "roll": roll + 1e-4 * rng.standard_normal(len(t)),
    }
    speed = np.full(len(t), 8.0)
    signals = {n: Signal(n, t, v, n) for n, v in {**columns, "speed": speed}.items()}
    return Drive(signals, plant.bare_record(len(t) / 100))


def test_a_slow_circle_on_a_banked_road_does_not_tilt_the_gradient(monkeypatch: pytest.MonkeyPatch) -> None:
    """The course is held, so that the accelerometer reads g times the bank: taken as it is, the gradient is too large."""
    a, estimator, seeds = 110.0, RollMap(), range(8)
    drives = []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        bank = plant.wavy_bank(5 * 7000, 0.4 * DEG, rng, 4.0)[::5]
        drives.append(_drive(5.0 * np.minimum(np.arange(7000) / 5600, 1.0), bank, a, rng))

    def scaled(chosen: Sequence[Drive]) -> tuple[list[float], int]:
        """Errors of the gradient, and how many coefficients lie within their interval."""
        errors, inside = [], 0
        for drive in chosen:
            prepared = estimator.prepare(drive, {})
            found = estimator.estimate(
                prepared, Vehicle(), {"draws": 1000.0}, np.random.default_rng(1)
            ).diagnostics
            errors.append(a / found["a"] - 1)
            inside += abs(found["a"] - a) < 1.96 * found["a_std"]
        return errors, inside

    errors, inside = scaled(drives)
    assert inside >= 7
    monkeypatch.setattr(RollData, "holds_course", property(lambda self: False))
    assert np.mean(scaled(drives[:3])[0]) - np.mean(errors[:3]) > 0.12


def test_signals_of_one_clock_are_found() -> None:
    """At the same instants or in the next frames of a bus; not half a period away or at another rate."""
    t = np.arange(500) * 10_000_000
    late = {"accel_y": 0, "roll_rate": 500_000, "yaw_rate": 0, "roll": 5_000_000}
    signals = {n: Signal(n, t + by, np.sin(t / 3e8), n) for n, by in late.items()}
    signals["speed"] = Signal("speed", t[::10], np.ones(50), "speed")
    drive = Drive(signals, plant.bare_record(5.0))
    others = [*late, "speed"]
    prepared = prepare_signals(drive, ["accel_y"], rate_hz=None, cutoff_hz=5.0, optional=others)
    assert prepared.together == {"roll_rate", "yaw_rate"}


def test_truth_of_the_sample_vehicle_is_that_of_the_whole_vehicle() -> None:
    """Sprung 600, wheels at half the track, and both about the common CG."""
    vehicle = RollVehicle()
    hubs = 190 * 0.8**2 + 190 * (0.34 - vehicle.cg_height_m) ** 2
    assert vehicle.roll_inertia_kgm2 == pytest.approx(600 + 1660 * (0.735 - vehicle.cg_height_m) ** 2 + hubs)
    assert vehicle.roll_inertia_kgm2 == pytest.approx(748.2, abs=0.1)
    soft = 1660 * 0.625 * G * (1 / 95_000 + 1 / (250_000 * 1.6**2))
    assert vehicle.roll_gradient_degpg == pytest.approx(np.degrees(soft))
