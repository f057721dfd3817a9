"""Algorithm 2 once more, in plain Python with whole matrices, one particle after the other: what the kernel has to equal."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from pipelines.filters.lanes import LANES
from pipelines.filters.marginalized_particle.records import Cloud, Noise, Offsets, ParticleSettings

FloatArray = NDArray[np.float64]


class PlainLanes:
    """The random numbers of `pipelines.filters.lanes`, all lanes at once in numpy, with numpy's own functions."""

    def __init__(self, rng: np.random.Generator):
        self.state = list(rng.integers(0, 2**64, 4 * LANES, dtype=np.uint64).reshape(4, LANES))

    def bits(self, lanes: int) -> NDArray[np.uint64]:
        """(lanes,) of the first by xoshiro256+, as its authors write it down."""
        s0, s1, s2, s3 = (part[:lanes] for part in self.state)
        with np.errstate(over="ignore"):
            found = s0 + s3
        s2, s3 = s2 ^ s0, s3 ^ s1
        new = (
            s0 ^ s3,
            s1 ^ s2,
            s2 ^ (s1 << np.uint64(17)),
            (s3 << np.uint64(45)) | (s3 >> np.uint64(19)),
        )
        for part, values in zip(self.state, new, strict=True):
            part[:lanes] = values
        return found

    def two_normals(self, lanes: int = LANES) -> FloatArray:
        """(2, lanes)"""
        bits = self.bits(lanes)
        share = (bits >> np.uint64(32)) / 2.0**32
        turn = 2 * np.pi * ((bits & np.uint64(0xFFFFFFFF)) / 2.0**32 - 0.5)
        radius = np.sqrt(-2 * np.log1p(-share))
        return np.array([radius * np.sin(turn), radius * np.cos(turn)])


@dataclass
class Particle:
    """θ with mass, inertia and input height, its model and its Kalman filter."""

    theta: FloatArray
    mean: FloatArray
    covariance: FloatArray
    model: tuple[FloatArray, FloatArray, FloatArray] = field(init=False)


def model(theta: FloatArray, step: float, gravity: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A (2, 2), level and after (2,) from the matrix exponential."""
    stiffness, damping, height, mass, inertia, above = theta
    total = inertia + mass * height * (height - above)
    block = np.zeros((4, 4))
    block[0, 1] = 1.0
    block[1] = [
        -(stiffness - mass * gravity * height) / total,
        -damping / total,
        mass * height / total,
        0.0,
    ]
    block[2, 3] = 1.0
    moved = expm(block * step)
    return moved[:2, :2], moved[:2, 2], moved[:2, 3] / step


class PlainFilter:
    """One segment."""

    def __init__(
        self, prior: Cloud, noise: Noise, settings: ParticleSettings, step: float, rng: np.random.Generator
    ):
        self.settings, self.step, self.rng, self.noise = settings, step, rng, noise
        self.lanes = PlainLanes(rng)
        spreads = [settings.start_roll_rad, settings.start_rate_radps]
        if settings.offsets is not None or settings.sensed_input:
            offsets = settings.offsets or Offsets(0.0, 0.0, 0.0)
            spreads += [offsets.roll_rad, offsets.roll_rate_radps, offsets.accel_mps2]
        if settings.sensed_input:
            spreads += [noise.accel_mps2]
        self.states = len(spreads)
        self.output = np.zeros((2, self.states))
        self.output[0, 0] = self.output[1, 1] = 1.0
        if self.states >= 5:
            self.output[0, 2] = self.output[1, 3] = 1.0
        start = np.diag(np.square(spreads))
        self.cloud = [Particle(theta.copy(), np.zeros(self.states), start.copy()) for theta in prior.theta]
        self.weights = prior.weights / prior.weights.sum()
        self._model()

    def _model(self) -> None:
        for particle in self.cloud:
            particle.model = model(particle.theta, self.step, self.settings.gravity_mps2)

    def _bend(self, particle: Particle) -> FloatArray:
        return particle.model[2] if self.settings.first_order_hold else np.zeros(2)

    def weigh(self, y: FloatArray) -> float:
        """(7) and (8); returns log p(y), without the variances' logarithm where the input is a sensor's: its noise, the last state, is
        new at every sample, and the outputs hold what it did to the step that ends there."""
        seen = np.isfinite(y)
        logs = np.log(self.weights)
        r = np.diag([self.noise.roll_rad**2, self.noise.roll_rate_radps**2])[np.ix_(seen, seen)]
        c = self.output[seen]
        for i, particle in enumerate(self.cloud):
            if self.settings.sensed_input:
                particle.mean[5], particle.covariance[5], particle.covariance[:, 5] = 0.0, 0.0, 0.0
                particle.covariance[5, 5] = self.noise.accel_mps2**2
                c[:, 5] = self._bend(particle)[seen]
            s = c @ particle.covariance @ c.T + r
            error = y[seen] - c @ particle.mean
            gain = particle.covariance @ c.T @ np.linalg.inv(s)
            spread = np.eye(len(s)) if self.settings.sensed_input else s
            logs[i] -= 0.5 * (error @ np.linalg.solve(s, error) + np.log(np.linalg.det(2 * np.pi * spread)))
            particle.mean = particle.mean + gain @ error
            particle.covariance = particle.covariance - gain @ s @ gain.T
        total = float(np.logaddexp.reduce(logs))
        self.weights = np.exp(logs - total)
        return total

    def moments(self) -> tuple[FloatArray, FloatArray]:
        """Mean and standard deviation of K, D, h."""
        theta = np.array([particle.theta[:3] for particle in self.cloud])
        mean = self.weights @ theta
        return mean, np.sqrt(self.weights @ (theta - mean) ** 2)

    def resample(self) -> None:
        """Systematic, to the size of (10)."""
        settings, n = self.settings, len(self.cloud)
        squares = float((self.weights**2).sum())
        if settings.threshold < 1 and 1 / squares >= settings.threshold * n:
            return
        size = settings.fixed or n
        if settings.adaptive:
            variance = float(np.var(n * self.weights))
            size = min(math.ceil(settings.wanted * (1 + variance) - 1e-9), settings.most)
        places = (self.rng.random() + np.arange(size)) / size
        chosen = np.minimum(np.searchsorted(np.cumsum(self.weights), places), n - 1)
        old = self.cloud
        self.cloud = [
            Particle(old[i].theta.copy(), old[i].mean.copy(), old[i].covariance.copy()) for i in chosen
        ]
        for new, i in zip(self.cloud, chosen, strict=True):
            new.model = old[i].model
        self.weights = np.full(size, 1 / size)

    def forward(self, now: float, after: float) -> None:
        """(3) and (9)."""
        if any(self.settings.walk):
            for first in range(0, len(self.cloud), LANES):
                both = self.lanes.two_normals()
                heights = self.lanes.two_normals(LANES // 2).ravel()
                draws = np.column_stack((*both, heights))
                for particle, draw in zip(self.cloud[first : first + LANES], draws, strict=False):
                    particle.theta[:3] += np.array(self.settings.walk) * draw
            self._model()
        for particle in self.cloud:
            a, level, _ = particle.model
            move = np.eye(self.states)
            move[:2, :2] = a
            bend = self._bend(particle)
            push = level * now + bend * (after - now)
            if self.states >= 5:
                move[:2, 4] = -level
            gain = np.zeros(self.states)
            if self.settings.sensed_input:
                move[:2, 5] = level - bend + a @ bend
            else:
                gain[:2] = level
            particle.mean = move @ particle.mean
            particle.mean[:2] += push
            particle.covariance = move @ particle.covariance @ move.T
            particle.covariance += self.noise.accel_mps2**2 * np.outer(gain, gain)
