"""The plant's equations: energy, momentum, mirror symmetry, what an accelerometer reads, and the compiled kernel."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from full_plant import (
    clock,
    demand,
    free_motion,
    momentum,
    sine_with_dwell,
    without_losses,
)

from parsers.signals import WHEELS
from pipelines.simulation.loads import Load, loaded
from pipelines.simulation.plant import layout as at
from pipelines.simulation.plant import motion as plant_motion
from pipelines.simulation.plant import wheel as plant_wheel
from pipelines.simulation.plant.run import prepare, simulate, standing
from pipelines.simulation.plant.vehicle import PRESETS
from pipelines.simulation.records import GRAVITY, straight_road

_COMPILED = plant_motion.derivative
ROOF = Load(150.0, 2.0, 0.35, 1.7)
THROWN = {
    at.ROLL: 0.05, at.PITCH: -0.03, at.HEIGHT: 0.03, at.VX: 8.0, at.VY: 2.0, at.R: 0.8, at.P: 0.5, at.Q: 0.3,
    at.DEFLECTION: 0.02, at.DEFLECTION + 3: -0.03,
    at.SPIN: 30.0, at.SPIN + 1: 30.0, at.SPIN + 2: 30.0, at.SPIN + 3: 30.0,
}  # fmt: skip


def test_without_losses_energy_and_momentum_stay() -> None:
    vehicle = loaded(without_losses(PRESETS["suv"]), [ROOF])
    motion = free_motion(vehicle, THROWN, step_s=0.00025)
    energy = motion.energy
    moved = np.ptp(motion.states[:, at.HEIGHT]) * vehicle.sprung_mass_kg * GRAVITY
    assert moved > 500
    assert np.abs(energy - energy[0]).max() < 1e-3 * moved
    linear, _, _, _ = momentum(motion)
    assert np.ptp(linear[:, :2], axis=0) == pytest.approx([0, 0], abs=0.01)


def test_energy_error_falls_with_the_square_of_the_step() -> None:
    vehicle = without_losses(PRESETS["van"])
    drift = [
        np.abs(np.diff(free_motion(vehicle, THROWN, step_s=h, duration_s=1.0).energy)).sum()
        for h in (0.001, 0.0005)
    ]
    assert drift[1] < 0.3 * drift[0]


@pytest.mark.parametrize("name", ["sedan", "truck"])
def test_energy_never_grows_in_free_motion(name: str) -> None:
    vehicle = replace(PRESETS[name], friction_n=0.0)
    for offsets in ({at.ROLL: 0.06}, {at.HEIGHT: 0.15}, {at.PITCH: 0.04, at.P: 0.6}):
        energy = free_motion(vehicle, offsets, duration_s=4.0).energy
        lost = energy[0] - energy[-1]
        assert lost > 30
        assert np.diff(energy).max() < 1e-5 * lost


def test_dry_friction_and_gripping_tyres_take_energy_too() -> None:
    energy = free_motion(
        PRESETS["suv"], {at.ROLL: 0.08, at.HEIGHT: 0.05}, friction=0.9, duration_s=4.0
    ).energy
    # the carcass and the friction's bristles give back a little of what they hold
    assert np.diff(energy).max() < 0.01 * (energy[0] - energy[-1])


def test_forces_close_with_momentum_in_a_hard_manoeuvre() -> None:
    """d/dt of linear and angular momentum equals what road, gravity and drag do: no force is lost in a link."""
    vehicle = loaded(replace(PRESETS["suv"], rolling_resistance=0.0), [ROOF])
    t = clock(3.0)
    drive = demand(
        3.0, steer=1.2 * np.sin(4 * t), speed=np.nan, brake=np.where(t > 1.5, 4e6, 0.0), torque=800.0
    )
    start = {at.VX: 20.0} | {at.SPIN + i: 20 / 0.35 for i in range(4)}
    motion = free_motion(vehicle, start, friction=0.9, drive=drive, rate_hz=1000.0, step_s=0.00025)
    linear, angular, force, moment = momentum(motion)
    lateral = np.abs(motion.columns["accel_y_mps2"]).max()
    assert lateral > 5
    for total, push in ((linear, force), (angular, moment)):
        rate = (total[2:] - total[:-2]) / 0.002
        scale = np.abs(push).max(axis=0) + np.abs(push).max() * 0.02
        assert (np.abs(rate - push[1:-1])[20:] / scale).max() < 2e-3


def test_mirrored_steering_gives_the_mirrored_run() -> None:
    vehicle = replace(PRESETS["suv"], sprung_cg_left_m=0.0)
    runs = [simulate(vehicle, sine_with_dwell(a, 20.0, 4.0), straight_road(200)).columns for a in (1.5, -1.5)]
    for name in ("roll_rad", "accel_y_mps2", "yaw_rate_radps", "y_m", "velocity_y_mps"):
        assert runs[0][name] == pytest.approx(-runs[1][name], abs=1e-9 * max(1, np.abs(runs[0][name]).max()))
    for name in ("pitch_rad", "accel_x_mps2", "heave_m"):
        assert runs[0][name] == pytest.approx(runs[1][name], abs=1e-9)
    swap = {"fl": "fr", "fr": "fl", "rl": "rr", "rr": "rl"}
    for wheel in WHEELS:
        other = runs[1][f"tire_normal_force_{swap[wheel]}_n"]
        assert runs[0][f"tire_normal_force_{wheel}_n"] == pytest.approx(other, abs=1e-4)


def test_specific_force_is_that_of_the_path() -> None:
    """Sensed accelerations follow from the velocities, the rates and gravity; another place from the lever arm."""
    drive = demand(5.0, steer=0.8 * np.sin(3 * clock(5.0)), speed=18.0)
    run = simulate(PRESETS["sedan"], drive, straight_road(200), rate_hz=1000)
    c, dt = run.columns, 1e-3
    rate, roll, pitch = c["yaw_rate_radps"], c["roll_rad"], c["pitch_rad"]
    # whole vehicle's CG, road axes; the sprung one sways little about it
    along = np.gradient(c["velocity_x_mps"], dt) - c["velocity_y_mps"] * rate
    across = np.gradient(c["velocity_y_mps"], dt) + c["velocity_x_mps"] * rate
    assert np.corrcoef(across, c["accel_y_mps2"])[0, 1] > 0.99
    assert np.corrcoef(roll, across)[0, 1] > 0.9
    force = sum(
        c[f"tire_lateral_force_{w}_n"] * np.cos(c[f"wheel_steer_{w}_rad"])
        + c[f"tire_longitudinal_force_{w}_n"] * np.sin(c[f"wheel_steer_{w}_rad"])
        for w in WHEELS
    )
    drag = 0.5 * 1.2 * 0.65 * c["speed_mps"] * c["velocity_y_mps"]
    assert across == pytest.approx((force - drag) / run.truth["mass_kg"], abs=0.02)
    # the body over the left front wheel, from the sensor's identity
    r = np.array([run.sprung_cg_m[0], 0.775 - run.sprung_cg_m[1], 0.32 - run.sprung_cg_m[2]])
    omega = np.column_stack([c[f"{a}_rate_radps"] for a in ("roll", "pitch", "yaw")])
    alpha = np.column_stack([c[f"{a}_acceleration_radps2"] for a in ("roll", "pitch", "yaw")])
    sensed = np.column_stack([c[f"accel_{a}_mps2"] for a in "xyz"])
    there = sensed + np.cross(alpha, r) + np.cross(omega, np.cross(omega, r))
    up = np.column_stack([-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)])
    assert (there * up).sum(axis=1) - GRAVITY == pytest.approx(c["accel_z_sprung_fl_mps2"], abs=0.02)
    assert np.abs(along).max() < 3


def test_rates_are_those_of_the_angles_on_grade_and_bank() -> None:
    """Gyro rates integrate to the angles against the horizon, also where the road turns under the vehicle."""
    rows = np.arange(600.0)
    road = replace(
        straight_road(598),
        curvature_1pm=0.02 * np.sin(rows / 30),
        grade_rad=0.12 * np.sin(rows / 40),
        bank_rad=0.06 * np.sin(rows / 25),
    )
    run = simulate(PRESETS["suv"], demand(20.0, speed=14.0), road, rate_hz=500)
    c = run.columns
    p, q, r = (c[f"{a}_rate_radps"] for a in ("roll", "pitch", "yaw"))
    roll, pitch = c["roll_rad"], c["pitch_rad"]
    roll_rate = p + np.tan(pitch) * (q * np.sin(roll) + r * np.cos(roll))
    pitch_rate = q * np.cos(roll) - r * np.sin(roll)
    assert np.abs(np.gradient(roll, 0.002) - roll_rate)[5:-5].max() < 2e-3
    assert np.abs(np.gradient(pitch, 0.002) - pitch_rate)[5:-5].max() < 2e-3
    assert np.abs(pitch).max() > 0.1
    climbed = np.gradient(c["altitude_m"], c["distance_m"])
    assert climbed == pytest.approx(np.sin(c["road_grade_rad"]), abs=0.01)


def test_compiled_kernel_equals_plain_python(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same derivative from the kernels' Python source, for random states."""
    rng = np.random.default_rng(4)
    drive = demand(5.0, steer=0.3, speed=9.0)
    road = replace(straight_road(100), grade_rad=np.full(102, 0.05), curvature_1pm=np.full(102, 0.01))
    setup = prepare(PRESETS["off_road"], drive, road)
    plain = plant_motion.derivative.py_func  # type: ignore[attr-defined]
    parts = (setup.body, setup.wheels, setup.demand, setup.road, setup.grids)
    # compiled before what it calls is plain Python
    _COMPILED(1.0, standing(setup), *parts, np.zeros(at.STATES), np.zeros(at.AUX_SIZE), np.zeros((16, 8)))
    for module in (plant_motion, plant_wheel):
        for name, value in vars(module).items():
            if hasattr(value, "py_func"):
                monkeypatch.setattr(module, name, value.py_func)
    for _ in range(20):
        y = standing(setup) + 0.05 * rng.standard_normal(at.STATES)
        y[at.VX] += 9.0
        y[at.SPIN : at.SPIN + 4] += 9 / 0.45
        y[at.PRESSURE] = 1e6 * rng.random()
        found = []
        for function in (_COMPILED, plain):
            dy, aux, work = np.zeros(at.STATES), np.zeros(at.AUX_SIZE), np.zeros((16, 8))
            function(1.0, y, *parts, dy, aux, work)
            found.append(np.concatenate([dy, aux]))
        assert found[0] == pytest.approx(found[1], rel=1e-9, abs=1e-9)
