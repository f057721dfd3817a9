"""How honest the marginalised particle filter and its warm starts are where the plant is the model, and where it is not quite.

python benchmarks/particle_filter_study.py [runs]

Vehicles are drawn at random from the prior's ranges, each drives one 3 s sine with dwell; sensor offsets are drawn where the
filter has them as states. RMSE over the Cramér-Rao bound is the root mean square of each run's error over its own bound (of
the innovations of the exact Kalman filter, offsets among the parameters), for vehicles that stand clear of the mirror line.
The second table: how much of the box each warm start keeps, how often all three planted values lie in the 95 % box, and how
often the planted point lies outside the joint density's own 95 % region; also with springs 10 % stiffer at 0.1 rad.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parent)]

from particle_filter_speed import (  # noqa: E402
    GRAVITY,
    INERTIA_KGM2,
    MASS_KG,
    NOISE,
    RANGES,
    SAMPLES,
    STEP_S,
    matrices,
    prior,
    sine_with_dwell,
)

from pipelines.filters.kalman import innovations  # noqa: E402
from pipelines.filters.marginalized_particle.filter import run_particles  # noqa: E402
from pipelines.filters.marginalized_particle.records import (  # noqa: E402
    BETTER,
    PUBLISHED,
    Offsets,
    ParticleSettings,
    fixed_size,
)
from pipelines.filters.marginalized_particle.refine import UniformPrior, refine  # noqa: E402
from pipelines.warm_start import warm_start as warm  # noqa: E402
from pipelines.warm_start.density import Box  # noqa: E402
from pipelines.warm_start.roll_cost import RollError, roll_features  # noqa: E402

OFFSETS = Offsets(np.deg2rad(0.3), np.deg2rad(0.3), 0.1)
CLEAR = 1.15
"""Times the mirror height: from here on the bound is used."""

FINE = 20
BOX = Box(*np.array([RANGES[name] for name in ("K", "D", "h")]).T)


def respond(theta: np.ndarray, accel: np.ndarray, stiffening: float) -> np.ndarray:
    """Roll and roll rate (n, 2), in fine steps; stiffening: share at 0.1 rad that K grows by."""
    stiffness, damping, height = theta
    lever = MASS_KG * height
    inertia = INERTIA_KGM2 + lever * height
    x, step = np.zeros((len(accel), 2)), STEP_S / FINE
    angle = rate = 0.0
    for k in range(len(accel)):
        x[k] = angle, rate
        after = accel[min(k + 1, len(accel) - 1)]
        for part in range(FINE):
            push = accel[k] + (after - accel[k]) * (part + 0.5) / FINE
            spring = stiffness * angle * (1 + stiffening * (angle / 0.1) ** 2)
            rate += step * (lever * (push + GRAVITY * angle) - damping * rate - spring) / inertia
            angle += step * rate
    return x


def drive(
    theta: np.ndarray, offsets: bool, stiffening: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Measurements (n, 2) and acceleration (n,) of one vehicle."""
    accel = sine_with_dwell()
    noise = rng.standard_normal((SAMPLES, 3)) * [NOISE.roll_rad, NOISE.roll_rate_radps, NOISE.accel_mps2]
    if offsets:
        noise += rng.standard_normal(3) * [OFFSETS.roll_rad, OFFSETS.roll_rate_radps, OFFSETS.accel_mps2]
    return respond(theta, accel, stiffening) + noise[:, :2], accel + noise[:, 2]


def bound(theta: np.ndarray, offsets: bool) -> np.ndarray:
    """(3,) standard deviations of K, D, h that an unbiased estimate cannot go below."""
    accel = sine_with_dwell()
    y = respond(theta, accel, 0.0)
    size = 5 if offsets else 2

    def errors(at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        phi2, level, after = (part[0] for part in matrices(at[None]))
        phi, c, gain, push = np.eye(size), np.zeros((2, size)), np.zeros(size), np.zeros((SAMPLES, size))
        phi[:2, :2], c[0, 0], c[1, 1], gain[:2] = phi2, 1.0, 1.0, level
        p0 = np.array(
            [0.2**2, 0.5**2, OFFSETS.roll_rad**2, OFFSETS.roll_rate_radps**2, OFFSETS.accel_mps2**2]
        )
        if offsets:
            phi[:2, 4], c[0, 2], c[1, 3] = -level, 1.0, 1.0
        push[:-1, :2] = np.outer(accel[:-1], level) + np.outer(np.diff(accel), after)
        return innovations(
            y, push, np.zeros_like(y), (np.array([0]), np.array([SAMPLES])), phi=phi,
            q=NOISE.accel_mps2**2 * np.outer(gain, gain), c=c,
            r=np.array([NOISE.roll_rad**2, NOISE.roll_rate_radps**2]), x0=np.zeros((1, size)), p0=np.diag(p0[:size]),
        )  # fmt: skip

    _, spread = errors(theta)
    slopes = []
    for j in range(3):
        step = np.zeros(3)
        step[j] = 1e-4 * theta[j]
        (up, up_spread), (down, down_spread) = errors(theta + step), errors(theta - step)
        mean = (up - down) / (2 * step[j]) / np.sqrt(spread)
        wide = (up_spread - down_spread) / (2 * step[j]) / spread / np.sqrt(2)
        slopes.append(np.concatenate((mean.ravel(), wide.ravel())))
    slopes_ = np.array(slopes)
    return np.sqrt(np.diag(np.linalg.inv(slopes_ @ slopes_.T)))


def filters(runs: int) -> None:
    """The first table."""
    better = replace(BETTER, offsets=OFFSETS)
    cases: dict[str, tuple[ParticleSettings, int]] = {
        "as published, N* 1000": (PUBLISHED, 8000),
        "as published, above the mirror": (replace(PUBLISHED, above_mirror=True), 8000),
        "better, no offsets": (replace(BETTER, offsets=None), 8000),
        "better, offsets": (better, 8000),
        "better, offsets, refined": (better, 8000),
        "better, offsets, 1000 fixed": (fixed_size(better, 1000), 1000),
        "better, offsets, 1000, refined": (fixed_size(better, 1000), 1000),
    }
    known = UniformPrior(RANGES, MASS_KG, INERTIA_KGM2)
    print(f"{runs} runs each; K, D, h: coverage of 95 % | bias % | RMSE % | RMSE / bound | mean N")
    for name, (settings, count) in cases.items():
        off = settings.offsets is not None
        rng = np.random.default_rng(11)
        held, error, ratio, particles = [], [], [], []
        for _ in range(runs):
            theta = BOX.low + rng.random(3) * BOX.span
            y, accel = drive(theta, off, 0.0, rng)
            run = run_particles(y, accel, STEP_S, prior(count, rng), NOISE, settings, rng)
            if name.endswith("refined"):
                run = refine(y, accel, STEP_S, run.final, known, NOISE, settings, rng).run
            low, _, high = run.quantiles[-1].T
            held.append((low <= theta) & (theta <= high))
            error.append(run.mean[-1] / theta - 1)
            particles.append(run.particles.mean())
            if theta[2] > CLEAR * np.sqrt(INERTIA_KGM2 / MASS_KG):
                ratio.append((run.mean[-1] - theta) / bound(theta, off))
        figures = (
            np.round(np.mean(held, axis=0), 3),
            np.round(100 * np.mean(error, axis=0), 1),
            np.round(100 * np.sqrt(np.mean(np.square(error), axis=0)), 1),
            np.round(np.sqrt(np.mean(np.square(ratio), axis=0)), 2),
        )
        print(f"  {name:32s}", *figures, f"{np.mean(particles):.0f}", sep="  ")


def warm_starts(runs: int) -> None:
    """The second table."""
    plain = warm.PUBLISHED
    cases = {
        "published: whole history": plain,
        "weighted by cost": replace(plain, weighting="cost"),
        "tempered, surrogate": replace(warm.TEMPERED, exact=False),
        "tempered, by the cost itself": warm.TEMPERED,
    }
    print(
        "kept share of the box (mean, least, most) | planted in the 95 % box | outside the joint 95 % region"
    )
    for stiffening in (0.0, 0.1):
        print(f" springs stiffer at 0.1 rad by {stiffening:.0%}, {runs} runs each")
        for name, settings in cases.items():
            rng = np.random.default_rng(12)
            rows = []
            for _ in range(runs):
                theta = BOX.low + (0.15 + 0.7 * rng.random(3)) * BOX.span
                y, accel = drive(theta, False, stiffening, rng)
                scale = (
                    (1.0, 1.0)
                    if settings.weighting != "tempered"
                    else (NOISE.roll_rad, NOISE.roll_rate_radps)
                )
                cost = RollError(
                    y, accel, STEP_S, mass_kg=MASS_KG, roll_inertia_kgm2=INERTIA_KGM2, scale=scale
                )
                features = roll_features if settings.weighting == "tempered" else None
                started = warm.warm_start(
                    cost, BOX, None, settings, rng, features=features, power=cost.independent
                )
                levels = started.density.log_density(started.density.draw(1000, rng))
                above = np.mean(levels > started.density.log_density(theta[None])[0])
                rows.append((started.kept, started.inside.holds(theta[None])[0], above > 0.95))
            kept, inside, outside = np.array(rows, dtype=float).T
            print(
                f"  {name:34s} {kept.mean():.2f} ({kept.min():.2f}, {kept.max():.2f})   {inside.mean():.2f}   {outside.mean():.2f}"
            )


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    filters(count)
    warm_starts(max(count // 5, 4))
