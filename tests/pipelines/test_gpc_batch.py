"""The whole record at once, and the judgement of convergence and excitation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from pipelines.chaos.bases import hermite
from pipelines.filters.gpc_batch import BatchEstimate, estimate_batch
from pipelines.filters.gpc_convergence import least_known, smoothing_slope, spread_report, velocity_test
from pipelines.filters.gpc_filter import GpcSettings, StateSpaceRun, Uncertain, estimate_state_space, row
from pipelines.filters.gpc_update import PUBLISHED
from pipelines.models.mass_spring import MASS_SPRING
from pipelines.results import FloatArray
from pipelines.simulation.mass_spring import (
    MassSpringDrive,
    MassSpringPlant,
    band_limited_noise,
    fine_times,
    simulate_mass_spring,
)

STEP, SENSOR = 0.01, 0.02
TRUTH = np.array([100.0, 400.0, 40.0])
NAMES = ("mass", "stiffness", "damping")


def noise_force(seconds: float, seed: int = 0) -> FloatArray:
    return band_limited_noise(np.random.default_rng(seed), fine_times(seconds, STEP), 0.05, 3.0, 200.0)


def driven(
    force: FloatArray, friction: float = 0.0, begin_s: float = 0.0
) -> tuple[MassSpringDrive, FloatArray]:
    """The drive and its noisy position, from `begin_s` on."""
    drive = simulate_mass_spring(MassSpringPlant(*TRUTH, friction_n=friction), force, STEP)
    part = slice(round(begin_s / STEP), None)
    drive = MassSpringDrive(drive.time_s[part], drive.force[part], drive.position[part], drive.velocity[part])
    return drive, drive.position + SENSOR * np.random.default_rng(9).standard_normal(len(drive.position))


def batch_of(drive: MassSpringDrive, z: FloatArray, factor: float = 1.4) -> BatchEstimate:
    parameters = (*(Uncertain(factor * v, 0.4, hermite(), True) for v in TRUTH), Uncertain(0.0))
    states = (Uncertain(float(z[0]), 0.1, hermite()), Uncertain(0.0, 1.0, hermite()))
    return estimate_batch(
        MASS_SPRING, row(drive.force), row(z), STEP, states, parameters, GpcSettings((SENSOR**2,))
    )


def test_mode_and_covariance_are_those_of_least_squares() -> None:
    drive, z = driven(noise_force(10.0))
    found = batch_of(drive, z)

    def residuals(p: FloatArray) -> FloatArray:
        # the same model, run by the filter with nothing uncertain
        states = (Uncertain(p[0]), Uncertain(p[1]))
        parameters = (*(Uncertain(float(np.exp(v))) for v in p[2:]), Uncertain(0.0))
        run = estimate_state_space(
            MASS_SPRING, row(drive.force), row(z), STEP, states, parameters, GpcSettings((1.0,), 1, 1.0)
        )
        prior = np.array([z[0], 0.0, *np.log(1.4 * TRUTH)])
        spread = np.array([0.1, 1.0, 0.4, 0.4, 0.4])
        return np.concatenate([run.innovation[:, 0] / SENSOR, (p - prior) / spread])

    best = least_squares(residuals, np.array([0.0, 0.0, *np.log(TRUTH)]), x_scale=[0.1, 0.1, 0.1, 0.1, 0.1])
    np.testing.assert_allclose(found.mean[:5], best.x, atol=2e-4)
    np.testing.assert_allclose(
        found.covariance[:5, :5], np.linalg.inv(best.jac.T @ best.jac), rtol=0.02, atol=1e-9
    )
    assert found.converged


def test_it_finds_what_was_planted_and_calls_it_identified() -> None:
    found = batch_of(*driven(noise_force(40.0)))
    for name, truth in zip(NAMES, TRUTH, strict=True):
        low, high = found.interval(name, 3.0)
        assert low < truth < high
        assert found.std(name) < 0.005
        assert found.judge(name)[0] == "identified"
    assert found.noise_ratio[0] == pytest.approx(1.0, abs=0.05)


def test_a_steady_sine_shows_the_damping_but_not_the_mass() -> None:
    force = 200.0 * np.sin(fine_times(70.0, STEP))
    found = batch_of(*driven(force, begin_s=40.0))
    status, reason = found.judge("mass")
    assert status in ("weak", "not_identifiable")
    assert "still is" in reason
    low, high = found.interval("mass")
    assert low < 100.0 < high
    assert high > 1.5 * low
    assert found.value("damping") == pytest.approx(40.0, rel=0.03)


def test_friction_that_the_model_lacks_widens_the_interval() -> None:
    force = noise_force(40.0)
    clean, rough = batch_of(*driven(force)), batch_of(*driven(force, friction=40.0))
    assert rough.std("mass") > 4 * clean.std("mass")
    assert rough.noise_ratio[0] > 1.1
    assert rough.judge("mass")[0] == "weak"
    assert "does not explain" in rough.judge("mass")[1]
    assert clean.allowance.max() < 0.01


def published(force: FloatArray) -> StateSpaceRun:
    drive = simulate_mass_spring(MassSpringPlant(*TRUTH), force, STEP)
    parameters = (*(Uncertain(v, 0.1 * v, addition=2e-4 * v) for v in (180.0, 550.0, 20.0)), Uncertain(0.0))
    settings = GpcSettings((0.01,), 2, 4.0, PUBLISHED, 1e-4, keep_every=100)
    return estimate_state_space(
        MASS_SPRING, row(drive.force), row(drive.position), STEP, (Uncertain(0.0),) * 2, parameters, settings
    )


def test_under_a_sine_the_spread_expands_and_under_noise_it_stays() -> None:
    sine, noise = published(200.0 * np.sin(fine_times(60.0, STEP))), published(noise_force(60.0, 1))
    assert spread_report(sine, "mass", additions=True).excitation == "insufficient"
    assert spread_report(noise, "mass", additions=True).excitation == "sufficient"
    left, direction = least_known(sine, sine.coefficients[-1], NAMES)
    assert left > 1.0
    assert np.abs(direction[:2]).min() > np.abs(direction[2])


def test_without_additions_what_is_not_shown_keeps_its_spread() -> None:
    drive, z = driven(np.zeros(len(fine_times(10.0, STEP))))
    parameters = (Uncertain(120.0, 0.3, logarithm=True), Uncertain(400.0), Uncertain(40.0), Uncertain(0.0))
    run = estimate_state_space(
        MASS_SPRING,
        row(drive.force),
        row(z),
        STEP,
        (Uncertain(0.0),) * 2,
        parameters,
        GpcSettings((SENSOR**2,)),
    )
    report = spread_report(run, "mass", additions=False)
    assert report.excitation == "insufficient"
    assert report.left == pytest.approx(1.0, abs=1e-6)


def test_the_slope_of_the_smoothed_position_is_the_mean_of_its_velocity() -> None:
    slope, mean = smoothing_slope(41, STEP)
    steps = np.random.default_rng(0).standard_normal(40)
    line = np.concatenate([[0.0], np.cumsum(steps) * STEP])
    assert slope @ line == pytest.approx(mean @ steps, rel=1e-12)
    assert mean.sum() == pytest.approx(1.0)
    with pytest.raises(ValueError, match="odd"):
        smoothing_slope(40, STEP)


def test_the_velocities_agree_for_a_motion_and_its_own_velocity_only() -> None:
    time_s = np.arange(4000) * STEP
    position, velocity = np.sin(2 * time_s), 2 * np.cos(2 * time_s)
    fair = velocity_test(time_s, position, velocity)
    plain = velocity_test(time_s, position, velocity, fair=False)
    assert fair.settled_s is not None
    assert fair.difference[-1] < 1e-3
    assert plain.difference[-1] > 5e-3
    assert velocity_test(time_s, position, 1.3 * velocity).settled_s is None
    late = np.where(time_s < 15.0, 0.5, 1.0) * velocity
    found = velocity_test(time_s, position, late).settled_s
    assert found is not None
    assert 15.0 < found < 21.0


def test_a_start_that_the_model_cannot_bear_is_refused() -> None:
    drive, z = driven(noise_force(5.0))
    parameters = (Uncertain(1e-9), Uncertain(1e12), Uncertain(0.0), Uncertain(0.0))
    with pytest.raises(ValueError, match="no finite numbers"):
        estimate_batch(
            MASS_SPRING,
            row(drive.force),
            row(z),
            STEP,
            (Uncertain(1.0), Uncertain(0.0)),
            parameters,
            GpcSettings((1.0,)),
        )


def test_what_was_given_stays_and_what_was_never_measured_is_refused() -> None:
    drive, z = driven(noise_force(5.0))
    given, settings = tuple(Uncertain(float(v)) for v in (*TRUTH, 0.0)), GpcSettings((SENSOR**2,))
    found = estimate_batch(
        MASS_SPRING, row(drive.force), row(z), STEP, (Uncertain(0.0),) * 2, given, settings
    )
    assert found.value("mass") == 100.0
    assert "given" in found.judge("mass")[1]
    nothing = row(np.full_like(z, np.nan))
    with pytest.raises(ValueError, match="no measured value"):
        estimate_batch(MASS_SPRING, row(drive.force), nothing, STEP, (Uncertain(0.0),) * 2, given, settings)


@pytest.mark.parametrize("factor", [1 / 9, 9.0])
def test_a_wrong_noise_variance_does_not_move_the_estimate_or_narrow_its_interval(factor: float) -> None:
    drive, z = driven(noise_force(40.0))
    parameters = (*(Uncertain(1.4 * v, 0.4, hermite(), True) for v in TRUTH), Uncertain(0.0))
    states = (Uncertain(0.0, 0.1, hermite()), Uncertain(0.0, 1.0, hermite()))
    right = batch_of(drive, z)
    wrong = estimate_batch(
        MASS_SPRING, row(drive.force), row(z), STEP, states, parameters, GpcSettings((factor * SENSOR**2,))
    )
    assert wrong.value("mass") == pytest.approx(right.value("mass"), rel=1e-3)
    assert wrong.std("mass") > 0.7 * right.std("mass")
