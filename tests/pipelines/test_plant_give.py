"""Roll centres that come down with the body, loads that go along with their patches, and wind: what simple models leave out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from full_plant import clock, demand, free_motion, momentum, without_losses

from pipelines.simulation.loads import Load, loaded, truth
from pipelines.simulation.plant import layout as at
from pipelines.simulation.plant.body import PlantVehicle
from pipelines.simulation.plant.linear import roll_gradient_degpg
from pipelines.simulation.plant.random_vehicle import random_vehicle
from pipelines.simulation.plant.run import simulate
from pipelines.simulation.plant.vehicle import PRESETS
from pipelines.simulation.records import GRAVITY, Air, straight_road

GIVING = replace(
    PRESETS["suv"],
    roll_center_drop_front=1.3,
    roll_center_drop_rear=0.8,
    patch_give=0.6,
    # arms of 0.5 m behind, as a trailing arm has
    side_slope_rear=-0.5,
    side_slope_drive_rear=0.2,
    pole_follow=1.0,
    rolling_resistance=0.0,
)
ROOF = Load(150.0, 2.0, 0.35, 1.7)
THROWN = {
    at.ROLL: 0.05, at.HEIGHT: 0.03, at.VX: 8.0, at.VY: 2.0, at.R: 0.8, at.P: 0.5, at.DEFLECTION: 0.02,
    at.DEFLECTION + 3: -0.03, at.DEFLECTION_RATE: 0.6,
}  # fmt: skip


def test_bent_paths_keep_energy_and_momentum() -> None:
    # a load that goes along with its patch is no spring's force, and takes or gives energy as it goes
    vehicle = loaded(without_losses(replace(GIVING, patch_give=0.0)), [ROOF])
    motion = free_motion(vehicle, THROWN, step_s=0.00025)
    moved = np.ptp(motion.states[:, at.HEIGHT]) * vehicle.sprung_mass_kg * GRAVITY
    assert moved > 500
    assert np.abs(motion.energy - motion.energy[0]).max() < 1e-3 * moved
    assert np.ptp(momentum(motion)[0][:, :2], axis=0) == pytest.approx([0, 0], abs=0.01)


def test_no_force_is_lost_in_bent_links_shifted_patches_or_the_wind() -> None:
    vehicle = loaded(GIVING, [ROOF])
    t = clock(3.0)
    drive = demand(
        3.0, steer=1.2 * np.sin(4 * t), speed=np.nan, brake=np.where(t > 1.5, 4e6, 0.0), torque=800.0
    )
    start = {at.VX: 20.0} | {at.SPIN + i: 20 / 0.35 for i in range(4)}
    air = Air(1.3, wind_ahead_mps=-8.0, wind_left_mps=5.0)
    motion = free_motion(vehicle, start, friction=0.9, drive=drive, rate_hz=1000.0, step_s=0.00025, air=air)
    linear, angular, force, moment = momentum(motion)
    for total, push in ((linear, force), (angular, moment)):
        rate = (total[2:] - total[:-2]) / 0.002
        scale = np.abs(push).max(axis=0) + np.abs(push).max() * 0.02
        assert (np.abs(rate - push[1:-1])[20:] / scale).max() < 2e-3


def test_a_steady_bend_leans_as_the_standing_equations_say() -> None:
    """Two ways to the same lean: the equations of motion, and virtual work at rest."""
    gradients = {}
    for given in (PRESETS["suv"], GIVING):
        vehicle = replace(given, friction_n=0.0)
        ends = [
            simulate(vehicle, demand(25.0, speed=10.0, steer=steer), straight_road(400), rate_hz=50).columns
            for steer in (0.12, -0.12)
        ]
        lean, sensed = (
            float(ends[0][name][-100:].mean() - ends[1][name][-100:].mean())
            for name in ("roll_rad", "accel_y_mps2")
        )
        gradients[vehicle.patch_give] = np.degrees(lean) / sensed * GRAVITY
        assert gradients[vehicle.patch_give] == pytest.approx(roll_gradient_degpg(vehicle), rel=0.004)
    # both give more lean
    assert gradients[0.6] > 1.02 * gradients[0.0]


def test_a_load_brings_the_roll_axis_down_by_what_it_presses_the_springs() -> None:
    straight, bent = truth(PRESETS["suv"], [ROOF]), truth(GIVING, [ROOF])
    down = straight["roll_center_height_m"] - bent["roll_center_height_m"]
    assert 0.005 < down < 0.04
    assert bent["roll_arm_m"] - straight["roll_arm_m"] == pytest.approx(down, abs=1e-4)
    assert truth(GIVING, ())["roll_center_height_m"] == pytest.approx(
        truth(PRESETS["suv"], ())["roll_center_height_m"], abs=1e-6
    )


def braked_moment(vehicle: PlantVehicle) -> float:
    """Pitch moment of the springs' forces, a m/s² of light braking, N m: about the body's CG."""
    moments, pulls = [], []
    for brake in (0.0, 3e5):
        drive = demand(
            9.0,
            speed=np.where(clock(9.0) < 1.0, 22.0, np.nan),
            brake=np.where(clock(9.0) > 2.0, brake, 0.0),
        )
        run = simulate(vehicle, drive, straight_road(600), rate_hz=50).columns
        part = slice(350, 440)
        front, rear = (
            sum(run[f"suspension_force_{axle}{side}_n"][part].mean() for side in "lr") for axle in "fr"
        )
        ahead = vehicle.sprung_cg_behind_front_axle_m
        moments.append(ahead * front - (vehicle.wheelbase_m - ahead) * rear)
        pulls.append(run["accel_x_mps2"][part].mean())
    return float((moments[0] - moments[1]) / (pulls[0] - pulls[1]))


def test_a_loaded_tail_lets_trailing_arms_carry_less_of_a_stop() -> None:
    """What springs hold in braking, by the equations of motion, beside the pitch arm of the standing vehicle."""
    boot = [Load(350.0, 2.9, 0.0, 0.9)]
    held, arms, kilos = [], [], 0.0
    for follow in (0.0, 1.0):
        given = replace(GIVING, pole_follow=follow, friction_n=0.0, patch_give=0.0)
        vehicle = loaded(given, boot)
        held.append(braked_moment(vehicle))
        arms.append(truth(given, boot)["pitch_arm_m"])
        kilos = vehicle.mass_kg
    longer = arms[1] - arms[0]
    assert longer > 0.02
    assert -(held[1] - held[0]) / kilos == pytest.approx(longer, rel=0.1)


def test_head_wind_slows_a_coasting_car_as_its_drag_says() -> None:
    vehicle = replace(PRESETS["sedan"], rolling_resistance=0.0)
    drive = demand(8.0, speed=np.where(clock(8.0) < 0.5, 30.0, np.nan))
    runs = [
        simulate(vehicle, drive, straight_road(400), air=Air(1.25, wind_ahead_mps=wind))
        for wind in (0.0, -10.0)
    ]
    slowed = [run.columns["speed_mps"][200] - run.columns["speed_mps"][700] for run in runs]
    mean = [run.columns["speed_mps"][200:700].mean() for run in runs]
    assert slowed[1] / slowed[0] == pytest.approx((mean[1] + 10) ** 2 / mean[0] ** 2, rel=0.02)


def test_random_vehicles_give_as_real_ones_do() -> None:
    made = [random_vehicle(np.random.default_rng([seed, 5])) for seed in range(40)]
    assert all(0.1 <= v.patch_give <= 0.7 for v in made)
    assert all(0.6 <= v.pole_follow <= 1.2 for v in made)
    rigid = [v for v in made if v.camber_compensation_rear == 1]
    assert rigid
    assert all(v.roll_center_drop_rear == 0 for v in rigid)
    assert all(0.5 <= v.roll_center_drop_front <= 1.6 for v in made)


def test_air_that_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match="density_kgpm3 is 0"):
        Air(density_kgpm3=0.0)
    with pytest.raises(ValueError, match="wind_left_mps"):
        Air(wind_left_mps=float("nan"))
