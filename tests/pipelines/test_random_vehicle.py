"""Random vehicles of the full plant: as the measured ones are, and able to drive."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from parsers.errors import SettingsError
from parsers.signals import WHEELS
from pipelines.simulation.loads import truth
from pipelines.simulation.logs.drive import Choice, preset, simulate_log
from pipelines.simulation.logs.loads import PLACES
from pipelines.simulation.manoeuvres.base import Options
from pipelines.simulation.plant.body import PlantVehicle
from pipelines.simulation.plant.linear import modes, small_motion
from pipelines.simulation.plant.random_vehicle import KINDS, random_vehicle
from pipelines.simulation.plant.run import simulate
from pipelines.simulation.records import GRAVITY, Demand, straight_road
from pipelines.vehicles.priors import measured_pitch_inertia, measured_roll_inertia, measured_vehicles

BODIES = pytest.mark.parametrize("body", list(KINDS))


@cache
def drawn(body: str) -> tuple[PlantVehicle, ...]:
    """Six of a body style."""
    return tuple(random_vehicle(np.random.default_rng([seed, 11]), body) for seed in range(6))


@BODIES
def test_size_and_height_are_those_of_measured_vehicles(body: str) -> None:
    table = measured_vehicles()
    same = np.array([b == body for b in table.body]) & np.isfinite(table.track)
    stability = table.track[same] / (2 * table.height[same])
    for vehicle in drawn(body):
        ours = (vehicle.track_front_m + vehicle.track_rear_m) / (4 * vehicle.cg_height_m)
        assert 0.95 * stability.min() < ours < 1.05 * stability.max()
        assert 0.9 * table.mass[same].min() < vehicle.mass_kg < 1.1 * table.mass[same].max()
        assert 0.5 < 1 - vehicle.cg_to_front_axle_m / vehicle.wheelbase_m < 0.66


def test_inertias_lie_about_the_measured_lines() -> None:
    off: dict[str, list[float]] = {"roll_inertia_kgm2": [], "pitch_inertia_kgm2": []}
    for vehicle in (v for body in KINDS for v in drawn(body)):
        known = truth(vehicle, ())
        track = 0.5 * (vehicle.track_front_m + vehicle.track_rear_m)
        lines = (measured_roll_inertia(vehicle.mass_kg, track), measured_pitch_inertia(vehicle.mass_kg))
        for name, line in zip(off, lines, strict=True):
            if line is not None:
                off[name].append((known[name] - line.value) / line.value)
    for errors in off.values():
        assert len(errors) > 30
        assert abs(np.mean(errors)) < 0.08
        assert np.std(errors) < 0.20
        assert np.abs(errors).max() < 0.45


@BODIES
def test_ride_roll_and_hop_are_those_of_road_vehicles(body: str) -> None:
    for vehicle in drawn(body):
        known = truth(vehicle, ())
        assert 3.5 < known["roll_gradient_degpg"] < 8.0
        assert 1.0 < known["roll_natural_frequency_hz"] < 2.2
        mass, damping, stiffness = small_motion(vehicle)
        hertz, shapes = modes(mass, stiffness)
        assert np.all((hertz[:3] > 0.85) & (hertz[:3] < 2.2))
        assert np.all((hertz[3:] > 4.5) & (hertz[3:] < 17))
        for k in range(3):
            shape = shapes[:, k]
            ratio = shape @ damping @ shape / (4 * np.pi * hertz[k] * (shape @ mass @ shape))
            assert 0.09 < ratio < 0.6


@BODIES
def test_it_stands_still_and_even(body: str) -> None:
    vehicle = drawn(body)[0]
    nothing = np.zeros(201)
    run = simulate(vehicle, Demand(0.01, nothing, nothing, nothing, nothing), straight_road(10))
    corners = [run.truth[f"corner_mass_{w}_kg"] for w in WHEELS]
    assert sum(corners) == pytest.approx(vehicle.mass_kg, rel=1e-9)
    assert abs(run.truth["cg_lateral_offset_m"]) < 0.018
    for wheel, mass in zip(WHEELS, corners, strict=True):
        assert run.columns[f"tire_normal_force_{wheel}_n"] / GRAVITY == pytest.approx(mass, rel=1e-4)
    assert np.abs(run.columns["heave_m"]).max() < 1e-5


@BODIES
def test_it_drives_a_sine_with_dwell_under_a_load(body: str) -> None:
    vehicle = drawn(body)[1]
    loads = tuple(PLACES["roof"][1](vehicle, 100.0))
    made = simulate_log(Choice("sine_with_dwell", vehicle, loads, Options(severity=0.8), seed=4))
    columns = made.run.columns
    assert not made.rolled_over
    assert 3.0 < np.abs(columns["accel_y_mps2"]).max() < 10.0
    assert np.degrees(np.abs(columns["roll_rad"]).max()) < 10.0
    assert np.abs(columns["yaw_rate_radps"][-50:]).max() < 0.01


def test_the_seed_says_which() -> None:
    first, again, other = (preset("random", seed) for seed in (7, 7, 8))
    assert first == again
    assert first != other
    assert {preset("random", seed).body for seed in range(60)} == set(KINDS)
    with pytest.raises(ValueError, match="Tank"):
        random_vehicle(np.random.default_rng(1), "Tank")
    with pytest.raises(SettingsError, match="randm") as refused:
        preset("randm")
    assert "random" in str(refused.value.hint)
