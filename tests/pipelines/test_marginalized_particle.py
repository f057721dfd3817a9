"""The marginalised particle filter: equal to a plain one, to a Kalman filter where θ is known, and (10)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from parsers.jit import kernel
from pipelines.filters.kalman import innovations
from pipelines.filters.marginalized_particle.adaptation import resample, wanted_size
from pipelines.filters.marginalized_particle.clouds import cloud_of, uniform_cloud
from pipelines.filters.marginalized_particle.filter import run_particles
from pipelines.filters.marginalized_particle.records import (
    BETTER,
    PUBLISHED,
    Cloud,
    Noise,
    Offsets,
    ParticleSettings,
    fixed_size,
)
from tests.pipelines.plain_particles import PlainFilter, model

STEP = 0.02
THETA = np.array([65_000.0, 5_500.0, 0.74, 1_800.0, 500.0, 0.0])
NOISE = Noise(np.deg2rad(0.1), np.deg2rad(0.3), 0.1)
RANGES = {"K": (5e4, 8e4), "D": (3e3, 1e4), "h": (0.55, 1.2)}


def steering(n: int) -> np.ndarray:
    """A lateral acceleration that goes one way, stays, and goes the other (n,)."""
    time = STEP * np.arange(n)
    return 5.0 * np.sin(2 * np.pi * 0.6 * time) * np.clip(3.0 - 1.2 * time, 0.0, 1.0)


def drive(
    n: int,
    rng: np.random.Generator,
    theta: np.ndarray = THETA,
    offsets: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> tuple[np.ndarray, np.ndarray]:
    """Measurements of the model itself, with its noise and sensor offsets."""
    a, level, after = model(theta, STEP, 9.80665)
    accel, x = steering(n), np.zeros((n, 2))
    for k in range(n - 1):
        x[k + 1] = a @ x[k] + level * accel[k] + after * (accel[k + 1] - accel[k])
    y = x + rng.standard_normal((n, 2)) * [NOISE.roll_rad, NOISE.roll_rate_radps] + offsets[:2]
    return y, accel + NOISE.accel_mps2 * rng.standard_normal(n) + offsets[2]


def prior(count: int, rng: np.random.Generator) -> Cloud:
    """Uniform, mass and inertia known."""
    return uniform_cloud(count, RANGES, mass_kg=1800.0, roll_inertia_kgm2=500.0, rng=rng)


CASES = {
    "published": replace(PUBLISHED, wanted=30, most=50),
    "fixed size": fixed_size(replace(PUBLISHED, most=40), 40),
    "held input": replace(PUBLISHED, wanted=30, most=50, first_order_hold=False),
    "offsets, rarely resampled": ParticleSettings(
        wanted=20, most=60, threshold=0.5, offsets=Offsets(0.01, 0.01, 0.2)
    ),
    "sensed input": replace(PUBLISHED, wanted=30, most=50, sensed_input=True),
    "sensed input held, with offsets": replace(
        PUBLISHED,
        wanted=30,
        most=50,
        sensed_input=True,
        first_order_hold=False,
        offsets=Offsets(0.01, 0.01, 0.2),
    ),
    "sensed input with offsets": ParticleSettings(
        wanted=20, most=60, threshold=0.5, sensed_input=True, offsets=Offsets(0.01, 0.01, 0.2)
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_kernel_equals_the_plain_filter_on_the_same_random_numbers(name: str) -> None:
    settings, n = CASES[name], 40
    rng = np.random.default_rng(4)
    y, accel = drive(n, rng, offsets=(0.004, -0.003, 0.1))
    y[5, 0], y[9, 1], y[12] = np.nan, np.nan, np.nan
    start = prior(40, rng)
    run = run_particles(y, accel, STEP, start, NOISE, settings, np.random.default_rng(8))
    plain = PlainFilter(start, NOISE, settings, STEP, np.random.default_rng(8))
    for k in range(n):
        evidence = plain.weigh(y[k])
        mean, std = plain.moments()
        assert len(plain.cloud) == run.particles[k]
        assert run.log_likelihood[k] == pytest.approx(evidence, rel=1e-8, abs=1e-8)
        np.testing.assert_allclose(run.mean[k], mean, rtol=1e-8)
        np.testing.assert_allclose(run.std[k], std, rtol=1e-5, atol=1e-9)
        state = (plain.weights @ [particle.mean for particle in plain.cloud])[:5]
        np.testing.assert_allclose(run.state[k, : len(state)], state, rtol=1e-6, atol=1e-10)
        plain.resample()
        if k + 1 < n:
            plain.forward(accel[k], accel[k + 1])
    assert len(run.resampled) == (n if settings.threshold >= 1 else np.count_nonzero(run.survivors))
    assert len(run.resampled) > 0


@pytest.mark.parametrize("offsets", [None, Offsets(0.01, 0.02, 0.3)])
def test_one_particle_is_the_kalman_filter(offsets: Offsets | None) -> None:
    """θ known: the evidence is the likelihood that the general Kalman filter gives, over two segments."""
    rng = np.random.default_rng(1)
    y, accel = drive(120, rng)
    y[30:34, 1] = np.nan
    segments = (np.array([0, 70]), np.array([60, 120]))
    settings = replace(PUBLISHED, walk=(0.0, 0.0, 0.0), adaptive=False, offsets=offsets)
    if offsets is not None:
        segments = (np.array([0]), np.array([120]))
    one = Cloud(THETA[None], np.ones(1))
    run = run_particles(y, accel, STEP, one, NOISE, settings, rng, segments=segments)
    a, level, after = model(THETA, STEP, 9.80665)
    size = 2 if offsets is None else 5
    phi, c, p0 = np.eye(size), np.zeros((2, size)), np.zeros(size)
    phi[:2, :2], c[0, 0], c[1, 1], p0[:2] = a, 1.0, 1.0, [0.2**2, 0.5**2]
    gain, push = np.zeros(size), np.zeros((120, size))
    gain[:2] = level
    push[:-1, :2] = np.outer(accel[:-1], level) + np.outer(np.diff(accel), after)
    if offsets is not None:
        phi[:2, 4], c[0, 2], c[1, 3], p0[2:] = -level, 1.0, 1.0, [0.01**2, 0.02**2, 0.3**2]
    error, variance = innovations(
        y,
        push,
        np.zeros((120, 2)),
        segments,
        phi=phi,
        q=NOISE.accel_mps2**2 * np.outer(gain, gain),
        c=c,
        r=np.array([NOISE.roll_rad**2, NOISE.roll_rate_radps**2]),
        x0=np.zeros((len(segments[0]), size)),
        p0=np.diag(p0),
    )
    expected = -0.5 * np.nansum(error**2 / variance + np.log(2 * np.pi * variance))
    assert np.nansum(run.log_likelihood) == pytest.approx(expected, rel=1e-9)
    inside = np.isfinite(variance)
    np.testing.assert_allclose(run.innovation[inside], error[inside], rtol=1e-6, atol=1e-10)
    np.testing.assert_allclose(run.innovation_std[inside] ** 2, variance[inside], rtol=1e-6)
    np.testing.assert_allclose(run.mean[0], THETA[:3], rtol=1e-12)


def test_a_sensed_input_is_the_least_noise_that_explains_the_drive() -> None:
    """θ known: the squares are those of the likeliest motion and input by one least squares over the whole drive, none of it filtered."""
    rng, rows = np.random.default_rng(2), 40
    y, accel = drive(rows, rng)
    settings = replace(PUBLISHED, walk=(0.0, 0.0, 0.0), adaptive=False, sensed_input=True)
    run = run_particles(y, accel, STEP, Cloud(THETA[None], np.ones(1)), NOISE, settings, rng)
    squares = np.nansum((run.innovation / run.innovation_std) ** 2)
    a, level, after = model(THETA, STEP, 9.80665)
    # unknowns: what noise took from each sample's input, and the state at the first sample less its own sample's part
    answer = np.zeros((rows, 2, rows + 2))
    state = np.zeros((2, rows + 2))
    state[:, rows:] = np.eye(2)
    free = np.zeros((rows, 2))
    for k in range(rows):
        answer[k] = state
        answer[k, :, k] += after
        if k + 1 < rows:
            state = a @ state
            state[:, k] += level - after + a @ after
            free[k + 1] = a @ free[k] + level * accel[k] + after * (accel[k + 1] - accel[k])
    sigma = np.array([NOISE.roll_rad, NOISE.roll_rate_radps])
    spreads = np.append(np.full(rows, NOISE.accel_mps2), [0.2, 0.5])
    design = np.vstack([(answer / sigma[:, None]).reshape(-1, rows + 2), np.diag(1 / spreads)])
    target = np.append(((y - free) / sigma).ravel(), np.zeros(rows + 2))
    left = np.linalg.lstsq(design, target, rcond=None)[1]
    assert squares == pytest.approx(float(left[0]), rel=1e-9)


def test_particles_follow_equation_10() -> None:
    """One heavy particle of weight 1/2 among ten: N sum w² = 10 (1/4 + 9 (1/18)²) = 2.777…"""
    weights = np.append(0.5, np.full(9, 0.5 / 9))
    squares = float((weights**2).sum())
    assert wanted_size(1000, 10, squares, 100_000) == 2778
    assert wanted_size(1000, 10, squares, 2000) == 2000
    assert wanted_size(1000, 8000, 1 / 8000, 9000) == 1000


def test_resampling_is_unbiased() -> None:
    """The mean number of copies is N w, and each number is that rounded down or up."""

    @kernel
    def draw(weights: np.ndarray, start: float, chosen: np.ndarray) -> int:
        return resample(weights, len(weights), len(chosen), start, chosen)

    weights = np.array([0.05, 0.4, 0.0, 0.23, 0.32])
    chosen = np.zeros(7, dtype=np.int64)
    starts = (np.arange(1000) + 0.5) / 1000
    counts = np.zeros((1000, 5))
    for row, start in zip(counts, starts, strict=True):
        different = draw(weights, float(start), chosen)
        assert (np.diff(chosen) >= 0).all()
        row[:] = np.bincount(chosen, minlength=5)
        assert different == np.count_nonzero(row)
    np.testing.assert_allclose(counts.mean(axis=0), 7 * weights, atol=2e-3)
    assert (np.abs(counts - 7 * weights) < 1).all()


def test_recovers_what_was_planted_and_its_interval_holds_it() -> None:
    """40 drives with sensor offsets: within the 95 % interval in 35 or more; the error is a few hundredths."""
    errors, held = [], []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        theta = THETA.copy()
        theta[:3] = [rng.uniform(*RANGES[name]) for name in ("K", "D", "h")]
        y, accel = drive(150, rng, theta, offsets=(0.005, -0.004, 0.1))
        settings = replace(BETTER, wanted=300, most=2500, offsets=Offsets(0.006, 0.006, 0.15))
        run = run_particles(y, accel, STEP, prior(2500, rng), NOISE, settings, rng)
        low, _, high = run.quantiles[-1].T
        held.append((low <= theta[:3]) & (theta[:3] <= high))
        errors.append(run.mean[-1] / theta[:3] - 1)
        assert not run.depleted
    assert (np.sum(held, axis=0) >= 35).all()
    assert (np.sqrt(np.mean(np.square(errors), axis=0)) < 0.08).all()


def test_same_seed_same_figures_and_another_seed_others() -> None:
    rng = np.random.default_rng(0)
    y, accel = drive(60, rng)
    start = prior(200, rng)
    settings = replace(BETTER, wanted=100, most=300)
    runs = [
        run_particles(y, accel, STEP, start, NOISE, settings, np.random.default_rng(s)) for s in (3, 3, 4)
    ]
    np.testing.assert_array_equal(runs[0].mean, runs[1].mean)
    assert (runs[0].mean[-1] != runs[2].mean[-1]).any()


def test_quantiles_are_those_of_the_weighted_particles() -> None:
    rng = np.random.default_rng(0)
    y, accel = drive(50, rng)
    run = run_particles(
        y, accel, STEP, prior(4000, rng), NOISE, replace(BETTER, wanted=1000), rng, snapshots=[49, 7]
    )
    for k, cloud in run.snapshots.items():
        assert len(cloud.weights) == run.particles[k]
        for j in range(3):
            order = np.argsort(cloud.theta[:, j])
            total = np.cumsum(cloud.weights[order])
            exact = cloud.theta[order, j][np.searchsorted(total, [0.025, 0.5, 0.975])]
            np.testing.assert_allclose(run.quantiles[k, j], exact, atol=0.06 * run.std[k, j])


def test_nothing_measured_leaves_the_prior() -> None:
    rng = np.random.default_rng(0)
    start = prior(500, rng)
    y = np.full((30, 2), np.nan)
    run = run_particles(y, np.zeros(30), STEP, start, NOISE, BETTER, rng)
    assert run.evidence == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(run.mean[-1], start.theta[:, :3].mean(axis=0))
    assert len(run.resampled) == 0


def test_impossible_measurements_are_depletion_and_no_nan() -> None:
    """Measurements a thousand standard deviations off: weights of e^-500000; one that overflows: all weight is lost."""
    rng = np.random.default_rng(0)
    y, accel = drive(40, rng)
    y[20:] += 3.0
    run = run_particles(y, accel, STEP, prior(300, rng), NOISE, PUBLISHED, rng)
    assert run.depleted
    assert run.lost == 0
    assert np.isfinite(run.mean).all()
    y[20:] = 1e200
    run = run_particles(y, accel, STEP, prior(300, rng), NOISE, PUBLISHED, rng)
    assert run.lost > 0
    assert run.depleted
    assert run.evidence == -np.inf


def test_unstable_particles_lose_their_weight() -> None:
    """Some particles with less stiffness than gravity needs run away; the others go on."""
    rng = np.random.default_rng(0)
    y, accel = drive(600, rng)
    start = prior(400, rng)
    start.theta[:100, 0] = 500.0
    run = run_particles(y, accel, STEP, start, NOISE, replace(BETTER, wanted=200), rng)
    assert np.isfinite(run.mean).all()
    assert run.lost == 0
    assert run.final.theta[:, 0].min() > 4e4


def test_uncertain_mass_and_inertia_widen_the_interval() -> None:
    rng = np.random.default_rng(2)
    y, accel = drive(150, rng)
    known = run_particles(y, accel, STEP, prior(3000, rng), NOISE, BETTER, rng)
    wide = {"K": (2e4, 2e5), "D": (1e3, 3e4), "h": RANGES["h"]}
    start = uniform_cloud(8000, wide, mass_kg=(1800.0, 180.0), roll_inertia_kgm2=(500.0, 75.0), rng=rng)
    unknown = run_particles(y, accel, STEP, start, NOISE, BETTER, rng)
    assert (unknown.std[-1] > 1.5 * known.std[-1]).all()
    assert np.std(unknown.final.theta[:, 3]) == pytest.approx(180.0, rel=0.3)


def test_refusals() -> None:
    rng = np.random.default_rng(0)
    y, accel = drive(10, rng)
    start = prior(20, rng)
    with pytest.raises(ValueError, match="not finite"):
        run_particles(y, np.append(accel[:-1], np.nan), STEP, start, NOISE, PUBLISHED, rng)
    with pytest.raises(ValueError, match=r"\(n, 2\)"):
        run_particles(y[:, :1], accel, STEP, start, NOISE, PUBLISHED, rng)
    with pytest.raises(ValueError, match="segments"):
        run_particles(y, accel, STEP, start, NOISE, PUBLISHED, rng, segments=(np.array([5]), np.array([11])))
    with pytest.raises(ValueError, match="bandwidth"):
        run_particles(y, accel, STEP, start, NOISE, replace(BETTER, kernel=1.0), rng)
    with pytest.raises(ValueError, match="snapshot"):
        run_particles(y, accel, STEP, start, NOISE, PUBLISHED, rng, snapshots=[10])
    with pytest.raises(ValueError, match="positive standard deviations"):
        Noise(0.0, 1.0, 1.0)
    with pytest.raises(ValueError, match=r"sqrt\(I_x / m\)"):
        uniform_cloud(5, {**RANGES, "h": (0.1, 0.5)}, mass_kg=1800.0, roll_inertia_kgm2=500.0, rng=rng)
    with pytest.raises(ValueError, match="not all zero"):
        Cloud(start.theta, np.zeros(20))
    with pytest.raises(ValueError, match="positive"):
        cloud_of(np.zeros((3, 3)), mass_kg=1.0, roll_inertia_kgm2=1.0, rng=rng)
