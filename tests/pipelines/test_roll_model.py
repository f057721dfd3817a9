"""The discrete roll model against closed forms, fine integration, and the plant's statics."""

from __future__ import annotations

import numpy as np
import plant_roll as plant
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from pipelines.estimators.roll_map.posterior import expected_rest, suspension_rates
from pipelines.estimators.roll_map.priors import VehicleDraws
from pipelines.models.roll import (
    GRAVITY,
    RollCoefficients,
    damping_ratio,
    discretise,
    exponential,
    process_noise,
    ramp_response,
    roll_gradient_degpg,
    state_matrix,
    undamped_frequency_hz,
)

ROLL = RollCoefficients(a=68.0, b=5.5, c=0.72)


@pytest.mark.parametrize("size", [1e-4, 0.3, 8.0])
def test_exponential_equals_the_library(size: float) -> None:
    matrix = size * np.random.default_rng(4).standard_normal((4, 4))
    wanted = expm(matrix)
    np.testing.assert_allclose(exponential(matrix), wanted, atol=1e-11 * np.abs(wanted).max())


def test_first_order_hold_is_exact_for_straight_lines() -> None:
    step, x0, f0, f1 = 0.0625, np.array([0.02, -0.1]), 1.3, 2.9
    a, b = state_matrix(ROLL)
    found = solve_ivp(
        lambda t, x: a @ x + b * (f0 + (f1 - f0) * t / step), (0, step), x0, rtol=1e-11, atol=1e-13
    )
    phi, before, after = discretise(ROLL, step)
    np.testing.assert_allclose(phi @ x0 + before * f0 + after * f1, found.y[:, -1], rtol=1e-8)


def test_motion_backwards_undoes_motion_forwards() -> None:
    phi, level, slope = ramp_response(ROLL, 0.03)
    back, back_level, back_slope = ramp_response(ROLL, -0.03)
    x0, f0, rise = np.array([0.05, 0.2]), 2.0, 4.0
    x1 = phi @ x0 + level * f0 + slope * rise
    np.testing.assert_allclose(
        back @ x1 + back_level * (f0 + 0.03 * rise) + back_slope * rise, x0, rtol=1e-10
    )


def test_process_noise_is_the_integral_over_the_step() -> None:
    step, intensity = 0.05, 0.01
    times = np.linspace(0, step, 4001)
    a, b = state_matrix(ROLL)
    columns = np.array([expm(a * t) @ b for t in times])
    wanted = intensity * np.trapezoid(columns[:, :, None] * columns[:, None, :], times, axis=0)
    np.testing.assert_allclose(process_noise(ROLL, intensity, step), wanted, rtol=1e-6)


def test_process_noise_of_strong_damping_over_a_long_step_is_the_lasting_one() -> None:
    """The Lyapunov equation solved by hand: var φ = S/(2 a b), var φ' = S/(2 b c)."""
    stiff, intensity = RollCoefficients(125.0, 31.0, 0.28), 0.01
    lasting = intensity / (2 * stiff.b) * np.diag([1 / stiff.a, 1 / stiff.c])
    found = process_noise(stiff, intensity, 5.0)
    np.testing.assert_allclose(found, lasting, rtol=1e-9, atol=1e-12)
    # in two halves it is the same
    phi = expm(state_matrix(stiff)[0] * 0.2)
    half = process_noise(stiff, intensity, 0.2)
    np.testing.assert_allclose(process_noise(stiff, intensity, 0.4), half + phi @ half @ phi.T, rtol=1e-9)


def test_steady_corner_and_named_figures() -> None:
    """K 68 kN·m/rad, m 1640 kg, h 0.61 m: worked by hand."""
    a = 68_000 / (1640 * 0.61)
    assert roll_gradient_degpg(a) == pytest.approx(np.degrees(1640 * 0.61 * GRAVITY / 68_000))
    inertia, z = 480 + 1640 * 0.61**2, 0.36
    c = 480 / (1640 * 0.61) + 0.61 - z
    assert undamped_frequency_hz(np.array(a), np.array(c), z) == pytest.approx(
        np.sqrt(68_000 / inertia) / (2 * np.pi)
    )
    b = np.array(5600 / (1640 * 0.61))
    assert damping_ratio(np.array(a), b, np.array(c), z) == pytest.approx(
        5600 / (2 * np.sqrt(68_000 * inertia))
    )


def _draw(car: plant.Car) -> VehicleDraws:
    one = np.ones(1)
    return VehicleDraws(
        mass=car.mass * one, sprung=car.sprung_kg * one, unsprung=car.unsprung_kg * one, hub=car.hub_height * one,
        height=car.cg_height * one, sprung_height=car.sprung_height * one, roll_axis=car.roll_axis * one,
        arm=car.arm * one, inertia=car.roll_inertia * one, body_inertia=car.body_inertia * one,
        imu=(car.imu_height - car.roll_axis) * one, tyre_roll=car.tyre_roll * one,
        possible=np.ones(1, dtype=bool),
    )  # fmt: skip


@pytest.mark.parametrize("road", [True, False])
def test_stiffness_comes_back_through_tyres_and_mirror(road: bool) -> None:
    """The static slope of a car on its tyres, put through the mapping, gives the suspension's own stiffness."""
    car = plant.Car()
    a = np.array([GRAVITY * np.degrees(1.0) / car.gradient(road=road)])
    stiffness, _, slope = suspension_rates(_draw(car), a, np.ones(1), against_axles=not road)
    assert stiffness[0] == pytest.approx(car.stiffness, rel=1e-3)
    more, _, _ = suspension_rates(_draw(car), a * 1.0001, np.ones(1), against_axles=not road)
    assert np.log(more[0] / stiffness[0]) / 1e-4 == pytest.approx(slope[0], rel=1e-2)


def test_mirror_image_has_the_same_coefficients() -> None:
    """(K, D, h) scaled by h*/h with h* = I/(m h) moves exactly alike when the accelerometer is at the roll axis."""
    arm, inertia, mass = 0.4, 480.0, 1640.0
    image = inertia / (mass * arm)
    assert inertia / (mass * arm) + arm == pytest.approx(inertia / (mass * image) + image)
    assert 60_000 / (mass * arm) == pytest.approx(60_000 * image / arm / (mass * image))


def test_draws_expect_the_plants_rate_gain() -> None:
    car = plant.Car()
    a = GRAVITY * np.degrees(1.0) / car.gradient(road=False)
    _, gain, _ = expected_rest(_draw(car), a, 5.0, against_axles=True)
    assert gain[0] == pytest.approx(car.gradient(road=True) / car.gradient(road=False), rel=5e-3)


def test_plant_leans_as_its_statics_say() -> None:
    """The judge itself: a slow small circle gives the roll gradient that is worked out apart from it."""
    car = plant.Car()
    motion = plant.simulate(car, plant.circle(0.5, seconds=20.0))
    last = slice(-500, None)
    seen = np.degrees(motion["roll"][last]) / (motion["accel_y"][last] / GRAVITY)
    assert seen.mean() == pytest.approx(car.gradient(road=True), rel=2e-3)
    own = np.degrees(motion["roll"][last] - motion["axle"][last]) / (motion["accel_y"][last] / GRAVITY)
    assert own.mean() == pytest.approx(car.gradient(road=False), rel=2e-3)
