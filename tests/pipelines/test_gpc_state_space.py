"""The gPC-EKF for state-space systems: against a slow plain filter, against the Kalman filter, and on planted parameters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from parsers.errors import ExpansionError
from pipelines.chaos.bases import hermite, jacobi, legendre
from pipelines.filters.gpc_filter import (
    GpcSettings,
    StateSpaceRun,
    Uncertain,
    estimate_state_space,
    row,
    start_coefficients,
)
from pipelines.filters.gpc_update import PUBLISHED, SQUARE_ROOT
from pipelines.models.mass_spring import MASS_SPRING
from pipelines.results import FloatArray
from pipelines.simulation.mass_spring import (
    MassSpringDrive,
    MassSpringPlant,
    band_limited_noise,
    fine_times,
    simulate_mass_spring,
)

STEP = 0.01
KNOWN = (Uncertain(0.0), Uncertain(0.0))


def drive_of(seed: int = 0, seconds: float = 20.0, plant: MassSpringPlant | None = None) -> MassSpringDrive:
    """Band-limited noise on 100 kg, 400 N/m, 40 N s/m."""
    force = band_limited_noise(np.random.default_rng(seed), fine_times(seconds, STEP), 0.05, 3.0, 200.0)
    return simulate_mass_spring(plant or MassSpringPlant(100.0, 400.0, 40.0), force, STEP)


def slow_step(values: FloatArray, before: float, after: float) -> FloatArray:
    """Runge-Kutta on states (rows 0, 1) of the model, written once more with whole arrays."""
    mass, k, c, f0 = values[2:]

    def slope(s: FloatArray, f: float) -> FloatArray:
        return np.array([s[1], (f + f0 - k * s[0] - c * s[1]) / mass])

    s, middle = values[:2], 0.5 * (before + after)
    a = slope(s, before)
    b = slope(s + 0.5 * STEP * a, middle)
    d = slope(s + 0.5 * STEP * b, middle)
    e = slope(s + STEP * d, after)
    return np.asarray(s + STEP / 6 * (a + 2 * b + 2 * d + e))


def slow_filter(
    run: StateSpaceRun,
    x: FloatArray,
    additions: FloatArray,
    force: FloatArray,
    z: FloatArray,
    settings: GpcSettings,
) -> tuple[FloatArray, FloatArray]:
    """The same filter in plain numpy; position measured. Means and deviations over time."""
    matrix, inverse = run.collocation.matrix, run.collocation.inverse
    logs, means, deviations = np.array(run.logarithm), [], []
    for k in range(len(z)):
        x = x if k == 0 else x + additions
        values = x @ matrix.T
        values[logs] = np.exp(values[logs])
        if k > 0:
            x = x.copy()
            x[:2] = slow_step(values, force[k - 1], force[k]) @ inverse.T
        y = x[0].copy()
        cross = x[:, 1:] @ y[1:]
        cross[0] += settings.state_addition
        total = y[1:] @ y[1:] + settings.state_addition + settings.noise[0]
        mean = x[:, 0] + cross / total * (z[k] - y[0])
        gain = cross / total
        if settings.form == SQUARE_ROOT:
            gain = gain / (1 + np.sqrt(settings.noise[0] / total))
        x = np.column_stack([mean, x[:, 1:] - gain[:, None] * y[1:]])
        means.append(mean)
        deviations.append(np.sqrt(np.sum(x[:, 1:] ** 2, axis=1)))
    return np.array(means), np.array(deviations)


@pytest.mark.parametrize("form", [PUBLISHED, SQUARE_ROOT])
def test_the_compiled_filter_is_the_same_as_a_slow_plain_one(form: int) -> None:
    drive = drive_of(seconds=1.0)
    parameters = (
        Uncertain(130.0, 0.2, logarithm=True, addition=1e-3),
        Uncertain(350.0, 40.0, jacobi(2.0, 3.0), addition=0.1),
        Uncertain(30.0, 5.0),
        Uncertain(0.0),
    )
    states = (Uncertain(0.01, 0.02, hermite()), Uncertain(0.0))
    settings = GpcSettings((1e-3,), 2, 3.0, form, 1e-4 if form == PUBLISHED else 0.0)
    run = estimate_state_space(
        MASS_SPRING, row(drive.force), row(drive.position), STEP, states, parameters, settings
    )
    x, additions = start_coefficients((*states, *parameters), run.collocation, None)
    mean, std = slow_filter(run, x, additions, drive.force, drive.position, settings)
    np.testing.assert_allclose(run.mean, mean, rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(run.std, std, rtol=1e-8, atol=1e-11)


def test_with_known_parameters_it_is_the_kalman_filter() -> None:
    drive = drive_of(seconds=5.0)
    z = drive.position + 0.02 * np.random.default_rng(1).standard_normal(len(drive.position))
    states = (Uncertain(0.1, 0.3, hermite()), Uncertain(-0.2, 0.5, hermite()))
    parameters = tuple(Uncertain(v) for v in (100.0, 400.0, 40.0, 0.0))
    run = estimate_state_space(
        MASS_SPRING, row(drive.force), row(z), STEP, states, parameters, GpcSettings((4e-4,), order=1)
    )
    p = np.array([100.0, 400.0, 40.0, 0.0])
    columns = [slow_step(np.concatenate([e, p])[:, None], 0.0, 0.0)[:, 0] for e in np.eye(2)]
    phi, mean, cov, h = (
        np.column_stack(columns),
        np.array([0.1, -0.2]),
        np.diag([0.09, 0.25]),
        np.array([1.0, 0.0]),
    )
    for k in range(len(z)):
        if k > 0:
            mean = slow_step(np.concatenate([mean, p])[:, None], drive.force[k - 1], drive.force[k])[:, 0]
            cov = phi @ cov @ phi.T
        gain = cov @ h / (h @ cov @ h + 4e-4)
        mean, cov = mean + gain * (z[k] - mean[0]), cov - np.outer(gain, h @ cov)
    np.testing.assert_allclose(run.mean[-1, :2], mean, rtol=1e-9)
    np.testing.assert_allclose(run.std[-1, :2], np.sqrt(np.diag(cov)), rtol=1e-7)


def test_planted_parameters_come_back_with_an_interval_that_holds_them() -> None:
    drive = drive_of(3, 40.0)
    z = drive.position + 0.02 * np.random.default_rng(5).standard_normal(len(drive.position))
    parameters = (*(Uncertain(v, 0.4, hermite(), True) for v in (140.0, 300.0, 55.0)), Uncertain(0.0))
    run = estimate_state_space(
        MASS_SPRING, row(drive.force), row(z), STEP, KNOWN, parameters, GpcSettings((4e-4,))
    )
    assert not run.diverged
    for name, truth in (("mass", 100.0), ("stiffness", 400.0), ("damping", 40.0)):
        low, high = run.interval(name, 3.5)
        assert run.value(name)[-1] == pytest.approx(truth, rel=0.01)
        assert low[-1] < truth < high[-1]
        assert high[-1] - low[-1] < 0.05 * truth


def test_velocity_and_acceleration_can_be_measured_too_and_gaps_are_passed_over() -> None:
    drive = drive_of(4, 20.0)
    accel = (drive.force - 400.0 * drive.position - 40.0 * drive.velocity) / 100.0
    noise = np.random.default_rng(2).standard_normal((2, len(accel)))
    z = np.column_stack([drive.velocity + 0.02 * noise[0], accel + 0.1 * noise[1]])
    z[300:500] = np.nan
    parameters = (
        Uncertain(140.0, 0.4, hermite(), True),
        Uncertain(400.0),
        Uncertain(40.0),
        Uncertain(0.0, 20.0),
    )
    run = estimate_state_space(
        MASS_SPRING, row(drive.force), z, STEP, KNOWN, parameters, GpcSettings((4e-4, 0.01)), outputs=("velocity", "acceleration"),
    )  # fmt: skip
    assert run.value("mass")[-1] == pytest.approx(100.0, rel=0.01)
    assert np.isnan(run.innovation[400]).all()
    assert run.std[499, 2] == pytest.approx(run.std[300, 2], rel=1e-9)


def test_without_improvements_the_spread_collapses_before_the_mass_arrives_and_with_them_it_does_not() -> (
    None
):
    """3.4.1: start 600 kg, 200 sin(t) N."""
    force = 200.0 * np.sin(fine_times(40.0, STEP))
    drive = simulate_mass_spring(MassSpringPlant(100.0, 400.0), force, STEP)

    def mass_of(c: float, c1: float) -> tuple[float, float]:
        parameters = (Uncertain(600.0, 10.0, addition=c1), Uncertain(400.0), Uncertain(0.0), Uncertain(0.0))
        settings = GpcSettings((0.01,), 3, 6.0, PUBLISHED, c)
        run = estimate_state_space(
            MASS_SPRING, row(drive.force), row(drive.position), STEP, KNOWN, parameters, settings
        )
        return float(run.value("mass")[-1]), float(run.std[-1, 2])

    stuck, spread = mass_of(0.0, 0.0)
    found, kept = mass_of(1e-4, 0.005)
    assert stuck > 200.0
    assert spread < 0.05
    assert found == pytest.approx(100.0, rel=0.01)
    assert kept > 0.5


def test_the_first_states_can_be_estimated_as_well() -> None:
    force = band_limited_noise(np.random.default_rng(1), fine_times(10.0, STEP), 0.05, 3.0, 200.0)
    drive = simulate_mass_spring(MassSpringPlant(100.0, 400.0, 40.0), force, STEP, (0.3, -0.4))
    parameters = tuple(Uncertain(v) for v in (100.0, 400.0, 40.0, 0.0))
    states = (Uncertain(0.0, 0.5, hermite()), Uncertain(0.0, 0.5, hermite()))
    run = estimate_state_space(
        MASS_SPRING, row(drive.force), row(drive.position), STEP, states, parameters, GpcSettings((1e-6,), 1), remember_start=True,
    )  # fmt: skip
    assert run.names[-2:] == ("first position", "first velocity")
    assert run.mean[-1, -2:] == pytest.approx([0.3, -0.4], abs=1e-3)


def test_a_distribution_without_updates_stays_as_it_is() -> None:
    """Figure 3.16: a Beta(1,5) mass."""
    drive = drive_of(seconds=2.0)
    parameters = (Uncertain(160.0, 20.0, jacobi(1.0, 5.0)), Uncertain(400.0), Uncertain(0.0), Uncertain(0.0))
    settings = GpcSettings((0.01,), 4, 6.0, PUBLISHED, keep_every=100)
    blind = np.full((len(drive.position), 1), np.nan)
    run = estimate_state_space(MASS_SPRING, row(drive.force), blind, STEP, KNOWN, parameters, settings)
    np.testing.assert_array_equal(run.coefficients[-1, 2], run.coefficients[0, 2])
    assert run.mean[-1, 2] == pytest.approx(160.0 - 20.0 * 2 / 3, rel=1e-9)


def test_a_filter_that_loses_itself_says_so() -> None:
    drive = drive_of(seconds=5.0)
    parameters = (Uncertain(1e-9, 0.0), Uncertain(1e12), Uncertain(0.0), Uncertain(0.0))
    run = estimate_state_space(
        MASS_SPRING, row(drive.force), row(drive.position), STEP, (Uncertain(0.0, 1.0), Uncertain(0.0)), parameters,
        GpcSettings((0.01,)),
    )  # fmt: skip
    assert run.diverged
    assert np.isnan(run.value("mass")[-1])


def test_refusals_say_what_is_wrong() -> None:
    drive = drive_of(seconds=1.0)
    force, z = row(drive.force), row(drive.position)
    parameters = (Uncertain(100.0, 10.0), Uncertain(400.0), Uncertain(40.0), Uncertain(0.0))
    good = GpcSettings((0.01,))

    def run(
        force: FloatArray = force, z: FloatArray = z, settings: GpcSettings = good, step: float = STEP
    ) -> None:
        estimate_state_space(MASS_SPRING, force, z, step, KNOWN, parameters, settings)

    run()
    with pytest.raises(ValueError, match="rows: inputs are"):
        run(force[:-1])
    with pytest.raises(ValueError, match="not finite"):
        run(np.full_like(force, np.nan))
    with pytest.raises(ValueError, match="noise variance"):
        run(settings=replace(good, noise=(0.0,)))
    with pytest.raises(ValueError, match="form"):
        run(settings=replace(good, form=2))
    with pytest.raises(ValueError, match="step"):
        run(step=0.0)
    with pytest.raises(ExpansionError):
        run(settings=replace(good, factor=0.5))
    with pytest.raises(ValueError, match="has the states"):
        estimate_state_space(MASS_SPRING, force, z, STEP, KNOWN, parameters[:2], good)
    with pytest.raises(ValueError, match="no output"):
        estimate_state_space(MASS_SPRING, force, z, STEP, KNOWN, parameters, good, outputs=("speed",))
    noisy = (Uncertain(0.0, start_noise=(0.0, 1.0)), Uncertain(0.0))
    with pytest.raises(ValueError, match="generator"):
        estimate_state_space(MASS_SPRING, force, z, STEP, noisy, parameters, good)
    with pytest.raises(ValueError, match="positive"):
        Uncertain(-1.0, 0.1, legendre(), logarithm=True)
