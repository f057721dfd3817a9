"""The companion to Wu et al.: exact where the case is linear, honest where the log or the vehicle file is silent."""

from __future__ import annotations

import numpy as np
import plant_axle_load as plant
import pytest

from pipelines.estimators.axle_load_gls.estimator import AxleLoadGls
from pipelines.estimators.axle_load_gls.fit import Colour, fit
from pipelines.filters.whiten import deletion_residuals, whiten
from pipelines.models.axle_load import Noise, axle_loads, bound
from pipelines.needs import readiness
from pipelines.results import Estimate, FloatArray
from pipelines.vehicles.vehicle import Vehicle

ESTIMATOR = AxleLoadGls()
LORRY = plant.Lorry()
SPEED = ("axle_load_rear", "speed", "road_grade")
ACCEL = ("axle_load_rear", "accel_x", "speed")
BOTH = ("axle_load_rear", "axle_load_front", "accel_x", "speed")


def analyse(
    names: tuple[str, ...],
    sensors: plant.Sensors | None = None,
    vehicle: Vehicle | None = None,
    motion: plant.Motion | None = None,
    seed: int = 0,
) -> Estimate:
    moved = plant.motion() if motion is None else motion
    drive = plant.record(LORRY, moved, sensors or plant.Sensors(), names, seed)
    known = plant.vehicle(LORRY) if vehicle is None else vehicle
    return ESTIMATOR.estimate(ESTIMATOR.prepare(drive, {}), known, {}, np.random.default_rng(seed))


def dense(n: int, phi: float, q: float, r: FloatArray) -> FloatArray:
    """Covariance of a stationary first-order process plus white noise."""
    apart = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    return np.asarray(q / (1 - phi**2) * phi**apart + np.diag(r))


def test_whitened_least_squares_is_generalised_least_squares() -> None:
    rng = np.random.default_rng(0)
    n, phi, q = 60, 0.9, 0.4
    r = rng.uniform(0.5, 2.0, n)
    z = rng.standard_normal((n, 3))
    starts = np.zeros(n)
    starts[0] = 1.0
    white, logdet = whiten(z, starts, phi, q, r)
    V = dense(n, phi, q, r)
    np.testing.assert_allclose(white.T @ white, z.T @ np.linalg.solve(V, z), rtol=1e-9)
    assert logdet == pytest.approx(np.linalg.slogdet(V)[1])


def test_deletion_residuals_equal_the_dense_ones() -> None:
    rng = np.random.default_rng(1)
    n, phi, q = 40, 0.8, 0.5
    r = rng.uniform(0.5, 2.0, n)
    e = rng.standard_normal(n)
    starts = np.zeros(n)
    starts[0] = 1.0
    P = np.linalg.inv(dense(n, phi, q, r))
    expected = (P @ e) / np.sqrt(np.diag(P))
    np.testing.assert_allclose(deletion_residuals(e, starts, phi, q, r), expected, rtol=1e-8, atol=1e-10)


def test_information_of_the_linear_fit_is_the_bounds() -> None:
    """With the true noise given, the fit's covariance carried to (h, a) is the Cramér-Rao bound."""
    m = plant.motion(25.0)
    t = slice(None, None, 2)
    acceleration, grade, dt = m.acceleration[t], m.grade[t], 0.02
    mass, length, axle, height, arm = 5762.0, 5.0, 1.5, 1.03, 0.004
    rear = axle_loads(mass, length, axle, height, acceleration, grade, arm)[1]
    n = len(rear)

    def integral(values: FloatArray) -> FloatArray:
        return np.concatenate(([0.0], np.cumsum(values[:-1]) * dt))

    speed = 10 + integral(acceleration)
    columns = np.column_stack((
        speed + plant.G * integral(np.sin(grade)), integral(length * rear), -plant.G * integral(np.cos(grade)),
    ))  # fmt: skip
    starts = np.zeros(n)
    starts[0] = 1.0
    walk = (length * dt * 100.0 / (mass * height)) ** 2
    found = fit(
        columns, starts, Colour(1.0, walk / 0.01, 0.01, given=True), huber=np.inf, lag_rows=0,
        prior_mean=np.zeros(2), prior_precision=np.zeros(2),
    )  # fmt: skip
    assert 1 / (mass * found.beta[0]) == pytest.approx(height, rel=1e-9)
    white, _ = whiten(columns[:, 1:], starts, 1.0, walk, np.full(n, 0.01))
    covariance = np.linalg.inv(white.T @ white)
    b0, b1 = found.beta
    jacobian = np.array([[-1 / (mass * b0**2), 0.0], [-b1 / (mass * b0**2), 1 / (mass * b0)]])
    std = np.sqrt(np.diag(jacobian @ covariance @ jacobian.T))
    limit = bound(rear, grade, dt, mass, length, arm, height, axle, Noise(0.1, 100.0))
    np.testing.assert_allclose(std, limit, rtol=1e-6)


@pytest.mark.parametrize("names", [SPEED, ACCEL, BOTH, ("axle_load_front", "accel_x"), (*SPEED, "accel_x")])
def test_recovers_what_was_planted(names: tuple[str, ...]) -> None:
    found = analyse(names).parameters
    for name, truth, near in (("cg_height_m", 1.03, 0.025), ("cg_to_front_axle_m", 1.5, 0.03)):
        answer = found[name]
        assert answer.value is not None
        assert answer.low is not None
        assert answer.high is not None
        assert answer.status == "identified"
        assert abs(answer.value - truth) < near
        assert answer.low < truth < answer.high
    if names == BOTH:
        assert found["mass_kg"].value == pytest.approx(5762.0, rel=0.005)
    else:
        assert found["mass_kg"].status == "not_identifiable"


def test_wheel_and_suspension_forces_serve_as_axle_load() -> None:
    wheels = analyse(("tire_normal_force_rl", "tire_normal_force_rr", "accel_x")).parameters["cg_height_m"]
    assert wheels.value == pytest.approx(1.03, abs=0.03)
    axis = plant.vehicle(LORRY, unsprung_mass_rear_kg=300.0, pitch_center_height_m=0.001)
    springs = analyse(("suspension_force_rl", "suspension_force_rr", "accel_x"), vehicle=axis)
    height = springs.parameters["cg_height_m"]
    assert height.value == pytest.approx(1.03, abs=0.04)
    assert height.std is not None
    assert wheels.std is not None
    assert height.std > wheels.std


def test_coverage_over_drives_with_drawn_errors() -> None:
    inside = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        sensors = plant.Sensors(
            load_scale=1 + 0.01 * rng.standard_normal(), load_offset=80 * rng.standard_normal(),
            accel_offset=0.1 * rng.standard_normal(), delay=0.02,
        )  # fmt: skip
        vehicle = plant.vehicle(LORRY, mass=LORRY.mass * (1 + 0.01 * rng.standard_normal()))
        found = analyse(SPEED if seed % 2 else ACCEL, sensors, vehicle, seed=seed).parameters
        for name, truth in (("cg_height_m", 1.03), ("cg_to_front_axle_m", 1.5)):
            answer = found[name]
            assert answer.value is not None
            assert answer.low is not None
            assert answer.high is not None
            assert answer.std is not None
            inside.append(answer.low <= truth <= answer.high)
            assert abs(answer.value - truth) < 4 * answer.std
    assert np.mean(inside) >= 0.9


def test_outliers_and_slow_sensors_are_survived() -> None:
    for sensors in (plant.Sensors(outliers=0.02), plant.Sensors(rate=5.0), plant.Sensors(accel_offset=0.2)):
        answer = analyse(ACCEL, sensors).parameters["cg_height_m"]
        assert answer.value == pytest.approx(1.03, abs=0.04)
        assert answer.low is not None
        assert answer.high is not None
        assert answer.low < 1.03 < answer.high


def test_constant_speed_tells_the_position_but_no_height() -> None:
    for names in (SPEED, ACCEL):
        found = analyse(names, motion=plant.motion(size=0.02, hill=0.0)).parameters
        assert found["cg_height_m"].status == "not_identifiable"
        assert "braking" in found["cg_height_m"].reason
        assert found["cg_to_front_axle_m"].value == pytest.approx(1.5, abs=0.06)


def test_unknown_load_widens_and_no_mass_refuses() -> None:
    told = analyse(ACCEL).parameters["cg_height_m"]
    silent = analyse(ACCEL, vehicle=plant.vehicle(LORRY, load=None, mass=5200.0)).parameters["cg_height_m"]
    assert told.std is not None
    assert silent.std is not None
    assert silent.std > 2 * told.std
    assert "load" in silent.reason
    without = Vehicle(quantities={"wheelbase_m": plant.vehicle(LORRY).quantities["wheelbase_m"]})
    refused = analyse(ACCEL, vehicle=without).parameters["cg_height_m"]
    assert refused.status == "not_identifiable"
    assert "m h" in refused.reason
    assert analyse(BOTH, vehicle=without).parameters["cg_height_m"].value == pytest.approx(1.03, abs=0.04)


def test_a_load_that_does_not_follow_the_force_is_refused() -> None:
    moved = plant.motion()
    drive = plant.record(LORRY, moved, plant.Sensors(), ACCEL)
    other = plant.record(LORRY, plant.motion(size=0.0, hill=0.0), plant.Sensors(), ACCEL)
    mixed = type(drive)({**drive.signals, "axle_load_rear": other.signals["axle_load_rear"]}, drive.record)
    prepared = ESTIMATOR.prepare(mixed, {})
    found = ESTIMATOR.estimate(prepared, plant.vehicle(LORRY), {}, np.random.default_rng(0)).parameters
    assert found["cg_height_m"].status == "not_identifiable"


def test_needs_are_named() -> None:
    ready = readiness(ESTIMATOR, {"speed"}, plant.vehicle(LORRY))
    assert not ready.ready
    assert any("axle" in text for text in ready.missing_signals)
    assert not readiness(ESTIMATOR, set(ACCEL), Vehicle()).ready
    empty = ESTIMATOR.prepare(plant.record(LORRY, plant.motion(5.0), plant.Sensors(), ("speed",)), {})
    found = ESTIMATOR.estimate(empty, plant.vehicle(LORRY), {}, np.random.default_rng(0))
    assert found.parameters["cg_height_m"].status == "not_identifiable"


def test_the_same_generator_gives_the_same_answer() -> None:
    first, second = analyse(ACCEL), analyse(ACCEL)
    assert first.parameters == second.parameters
