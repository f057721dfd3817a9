"""How fast the marginalised particle filter runs on one core, beside the same filter in numpy, whole arrays over the particles.

python benchmarks/particle_filter_speed.py [particles]

The floor is 1 500 samples a second with 8 000 particles. Times are of the processor, not of the clock on the wall: others may
use the machine. The last line runs Algorithm 2 as published many times on two threads, as a Monte-Carlo study does.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1])]

from pipelines.filters.marginalized_particle.clouds import uniform_cloud  # noqa: E402
from pipelines.filters.marginalized_particle.filter import run_particles  # noqa: E402
from pipelines.filters.marginalized_particle.monte_carlo import run_many  # noqa: E402
from pipelines.filters.marginalized_particle.records import (  # noqa: E402
    BETTER,
    PUBLISHED,
    Cloud,
    Noise,
    ParticleSettings,
    fixed_size,
)

FLOOR = 1500
STEP_S, SAMPLES, PLAIN_SAMPLES, GRAVITY = 0.01, 300, 30, 9.80665
MASS_KG, INERTIA_KGM2 = 1800.0, 500.0
NOISE = Noise(np.deg2rad(0.1), np.deg2rad(0.3), 0.1)
RANGES = {"K": (5e4, 8e4), "D": (3e3, 1e4), "h": (0.55, 1.2)}
MONTE_CARLO = 100


def prior(count: int, rng: np.random.Generator) -> Cloud:
    """Uniform over the paper's ranges."""
    return uniform_cloud(count, RANGES, mass_kg=MASS_KG, roll_inertia_kgm2=INERTIA_KGM2, rng=rng)


def matrices(theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A (N, 2, 2), level and after (N, 2) of each particle, in closed form (damped oscillations)."""
    stiffness, damping, height = theta.T
    inertia = INERTIA_KGM2 + MASS_KG * height**2
    a, b = (stiffness - MASS_KG * GRAVITY * height) / inertia, damping / inertia
    decay, turn = np.exp(-0.5 * b * STEP_S), np.sqrt(a - 0.25 * b * b)
    s, c = np.sin(turn * STEP_S) / turn, np.cos(turn * STEP_S)
    phi = np.empty((len(theta), 2, 2))
    phi[:, 0, 0], phi[:, 0, 1] = decay * (c + 0.5 * b * s), decay * s
    phi[:, 1, 0], phi[:, 1, 1] = -a * decay * s, decay * (c - 0.5 * b * s)
    gain = MASS_KG * height / inertia
    level = np.column_stack(((1 - phi[:, 0, 0]) / a, phi[:, 0, 1])) * gain[:, None]
    first = (gain * STEP_S - level[:, 1] - b * level[:, 0]) / a
    return phi, level, np.column_stack((first, level[:, 0])) / STEP_S


def sine_with_dwell() -> np.ndarray:
    """(SAMPLES,) lateral acceleration of 6 m/s²: three quarters of a 0.7 Hz sine, half a second held, and back to zero."""
    time_s = STEP_S * np.arange(SAMPLES)
    turned = np.where(time_s < 1.07, np.sin(2 * np.pi * 0.7 * time_s), -1.0)
    late = np.clip((time_s - 1.57) / 0.36, 0.0, 1.0)
    return 6.0 * np.where(time_s < 1.57, turned, -np.cos(0.5 * np.pi * late))


def motion(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Roll and roll rate of the model under the sine with dwell, with noise, and the measured acceleration."""
    accel = sine_with_dwell()
    phi, level, after = (part[0] for part in matrices(np.array([[65_000.0, 5_500.0, 0.74]])))
    x = np.zeros((SAMPLES, 2))
    for k in range(SAMPLES - 1):
        x[k + 1] = phi @ x[k] + level * accel[k] + after * (accel[k + 1] - accel[k])
    noise = rng.standard_normal((SAMPLES, 3)) * [NOISE.roll_rad, NOISE.roll_rate_radps, NOISE.accel_mps2]
    return x + noise[:, :2], accel + noise[:, 2]


def plain(
    y: np.ndarray,
    accel: np.ndarray,
    theta: np.ndarray,
    settings: ParticleSettings,
    rng: np.random.Generator,
) -> np.ndarray:
    """Algorithm 2 as published at a fixed size, in numpy; the last mean of K, D, h."""
    n, r = len(theta), np.array([NOISE.roll_rad**2, NOISE.roll_rate_radps**2])
    x, p = np.zeros((n, 2)), np.tile(np.diag([0.2**2, 0.5**2]), (n, 1, 1))
    mean = np.zeros(3)
    for k in range(len(accel) - 1):
        s = p + np.diag(r)
        determinant = s[:, 0, 0] * s[:, 1, 1] - s[:, 0, 1] ** 2
        inverse = np.empty_like(s)
        inverse[:, 0, 0], inverse[:, 1, 1] = s[:, 1, 1] / determinant, s[:, 0, 0] / determinant
        inverse[:, 0, 1] = inverse[:, 1, 0] = -s[:, 0, 1] / determinant
        error = y[k] - x
        logs = -0.5 * (np.einsum("ni,nij,nj->n", error, inverse, error) + np.log(determinant))
        weights = np.exp(logs - logs.max())
        weights /= weights.sum()
        mean = weights @ theta
        np.sqrt(weights @ (theta - mean) ** 2)
        for column in theta.T:
            order = np.argsort(column)
            np.interp([0.025, 0.5, 0.975], np.cumsum(weights[order]), column[order])
        gain = p @ inverse
        x = x + np.einsum("nij,nj->ni", gain, error)
        p = p - gain @ p
        chosen = np.searchsorted(np.cumsum(weights), (rng.random() + np.arange(n)) / n).clip(max=n - 1)
        theta, x, p = theta[chosen], x[chosen], p[chosen]
        theta = np.abs(theta + np.array(settings.walk) * rng.standard_normal((n, 3)))
        phi, level, after = matrices(theta)
        x = np.einsum("nij,nj->ni", phi, x) + level * accel[k] + after * (accel[k + 1] - accel[k])
        noise = NOISE.accel_mps2**2 * level[:, :, None] * level[:, None, :]
        p = phi @ p @ phi.transpose(0, 2, 1) + noise
    return mean


def seconds(run: Callable[[], object], rounds: int = 5) -> float:
    """The least processor time of this thread, after one run that compiles."""
    run()
    times = []
    for _ in range(rounds):
        began = time.thread_time()
        run()
        times.append(time.thread_time() - began)
    return min(times)


def main() -> None:
    """Print one line a variant."""
    particles = int(sys.argv[1]) if len(sys.argv) > 1 else 8000
    rng = np.random.default_rng(0)
    y, accel = motion(rng)
    start = prior(particles, rng)
    published = fixed_size(PUBLISHED, particles)

    def rate(settings: ParticleSettings) -> float:
        return SAMPLES / seconds(
            lambda: run_particles(y, accel, STEP_S, start, NOISE, settings, np.random.default_rng(1))
        )

    few = slice(0, PLAIN_SAMPLES)
    peer = (PLAIN_SAMPLES - 1) / seconds(
        lambda: plain(y[few], accel[few], start.theta[:, :3], published, np.random.default_rng(1)), 2
    )
    print(
        f"{particles} particles, quantiles at every sample; numpy over the particles: {peer:.0f} samples/s of one core"
    )
    cases = {
        "as published: resampled and moved at every sample": published,
        "better, no offsets": fixed_size(replace(BETTER, offsets=None), particles),
        "better, three sensor offsets as states": fixed_size(BETTER, particles),
    }
    for name, settings in cases.items():
        found = rate(settings)
        verdict = "" if found >= FLOOR else f"   below {FLOOR}"
        print(f"{found:8.0f} samples/s   {found / peer:5.1f} x numpy   {name}{verdict}")
    for name, settings in {"as published": PUBLISHED, "better": BETTER}.items():
        began, used = time.perf_counter(), time.process_time()
        run_many(
            lambda _, own: motion(own),
            lambda _, own: prior(particles, own),
            MONTE_CARLO,
            STEP_S,
            NOISE,
            settings,
            np.random.default_rng(2),
        )
        wall, used = time.perf_counter() - began, time.process_time() - used
        scale = 1000 / MONTE_CARLO
        print(
            f"1000 runs of {SAMPLES * STEP_S:.0f} s, {name}, adaptive size, two threads: "
            f"{wall * scale:.0f} s on the wall, {used * scale:.0f} s of processor (from {MONTE_CARLO} runs)"
        )


if __name__ == "__main__":
    main()
