"""Batch maximum likelihood of the same model on the same data, by the innovations of a Kalman filter, and its bound.

What Algorithm 2 does sample by sample with particles, on all samples at once: the least sum of e²/(2 s) over the innovations e and their
variances s, by scoring. That is the likelihood with the true lateral acceleration at its likeliest behind the measured one (a
sensor's noise never moves the body; with ln(s)/2 besides, K and h of long drives come out too large). Offsets of the sensors are
unknowns where asked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.filters.kalman import innovations
from pipelines.filters.marginalized_particle.records import BETTER, ParticleSettings
from pipelines.models.roll import discretise
from pipelines.reproduce.berntorp.setup import NOISE, RANGES, STEP_S, Motion, RollBody
from pipelines.results import FloatArray

STEPS = np.array([1e-4, 1e-4, 1e-4])
OFFSET_STEPS = np.array([1e-5, 1e-5, 1e-4])
MOST_STEPS = 30
START = ParticleSettings()
"""The first state's spread, as the filters have it."""


@dataclass(frozen=True)
class BatchFit:
    """theta (3,): K, D, h. std: (3,) by the expected information. misfit: RMS of the innovations in standard deviations."""

    theta: FloatArray
    std: FloatArray
    misfit: float


def _offset_stds(offsets: bool) -> FloatArray:
    known = BETTER.offsets
    assert known is not None
    return np.array([known.roll_rad, known.roll_rate_radps, known.accel_mps2]) if offsets else np.zeros(0)


class _Problem:
    """Innovations of one set of data as a function of K, D, h (relative to a scale) and offsets."""

    def __init__(self, y: FloatArray, accel: FloatArray, mass: float, inertia: float, offsets: bool) -> None:
        self.y, self.accel, self.mass, self.inertia = y, accel, mass, inertia
        self.scale = np.array([np.mean(RANGES[name]) for name in ("K", "D", "h")])
        self.offset_std = _offset_stds(offsets)
        self.step = np.concatenate((STEPS, OFFSET_STEPS[: len(self.offset_std)]))

    @property
    def weight(self) -> FloatArray:
        """(p,) prior information: of the offsets alone."""
        return np.concatenate((np.zeros(3), 1 / np.maximum(self.offset_std, 1e-12) ** 2))

    def innovations(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(n, 2) and their variances. x: K, D, h over `scale`, then offsets of roll, roll rate, acceleration."""
        stiffness, damping, height = (x[:3] * self.scale).tolist()
        body = RollBody(stiffness, damping, height, self.mass, self.inertia)
        phi, before, after = discretise(body.coefficients, STEP_S)
        shift = x[3:] if len(x) > 3 else np.zeros(3)
        accel = self.accel - shift[2]
        later = np.append(accel[1:], accel[-1])
        push = np.outer(accel, before) + np.outer(later, after)
        # a sample's noise is in the steps before and behind it: a third state, which the motion right at the sample has in it
        felt = np.zeros((3, 3))
        felt[:2, :2], felt[:2, 2] = phi, before + phi @ after
        shown = np.column_stack((np.eye(2), after))
        noise = NOISE.accel_mps2**2
        return innovations(
            self.y, np.column_stack((push, np.zeros(len(accel)))), np.tile(shift[:2], (len(accel), 1)),
            (np.array([0]), np.array([len(accel)])), phi=felt, q=np.diag([0.0, 0.0, noise]), c=shown,
            r=np.array([NOISE.roll_rad, NOISE.roll_rate_radps]) ** 2, x0=np.zeros((1, 3)),
            p0=np.diag([START.start_roll_rad**2, START.start_rate_radps**2, noise]),
        )  # fmt: skip

    def slopes(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Slopes (p, n, 2) of the normalised innovations, and these (n, 2)."""
        error, variance = self.innovations(x)
        normal = error / np.sqrt(variance)
        slope = np.empty((len(x), *error.shape))
        for i, step in enumerate(self.step):
            moved = x.copy()
            moved[i] += step
            other, wider = self.innovations(moved)
            slope[i] = (other / np.sqrt(wider) - normal) / step
        return slope, normal

    def information(self, slope: FloatArray) -> FloatArray:
        """(p, p) expected information with the offsets' priors."""
        flat = slope.reshape(len(slope), -1)
        return np.asarray(flat @ flat.T + np.diag(self.weight))

    def cost(self, x: FloatArray) -> float:
        """Minus the log-likelihood (and the offsets' prior), without constants."""
        if np.min(x[:3]) <= 0:
            return np.inf
        error, variance = self.innovations(x)
        return float(0.5 * np.sum(error**2 / variance) + 0.5 * self.weight @ x**2)


def fit_batch(
    y: FloatArray, accel: FloatArray, mass: float, inertia: float, *, offsets: bool = False
) -> BatchFit:
    """Maximum likelihood from the middle of the box. h is taken above sqrt(I_x / m): its mirror image fits as well."""
    problem = _Problem(y, accel, mass, inertia, offsets)
    x = np.concatenate((np.ones(3), np.zeros(len(problem.offset_std))))
    cost, damping = problem.cost(x), 1e-3
    slope, normal = problem.slopes(x)
    for _ in range(MOST_STEPS):
        gradient = -(slope * normal).sum(axis=(1, 2)) - problem.weight * x
        matrix = problem.information(slope)
        move = np.linalg.solve(matrix + damping * np.diag(np.diag(matrix)), gradient)
        trial = x + move
        lowered = cost - (trial_cost := problem.cost(trial))
        if lowered <= 0:
            damping *= 10
            if damping > 1e8:
                break
            continue
        x, cost, damping = trial, trial_cost, max(damping / 10, 1e-9)
        slope, normal = problem.slopes(x)
        if lowered < 1e-7:
            break
    covariance = np.linalg.inv(problem.information(slope))
    theta = x[:3] * problem.scale
    ratio = inertia / (mass * theta[2] ** 2)
    if ratio > 1:
        theta = theta * ratio
    std = np.sqrt(np.diag(covariance)[:3]) * problem.scale * max(ratio, 1.0)
    return BatchFit(theta, std, float(np.sqrt(np.mean(normal**2))))


def cramer_rao(motion: Motion, body: RollBody, *, offsets: bool = False) -> FloatArray:
    """(3,) least standard deviations of K, D, h on that manoeuvre, mass and inertia known."""
    y = np.column_stack((motion.roll, motion.rate))
    problem = _Problem(y, motion.accel, body.mass, body.inertia, offsets)
    x = np.concatenate((body.theta / problem.scale, np.zeros(len(problem.offset_std))))
    slope, _ = problem.slopes(x)
    covariance = np.linalg.inv(problem.information(slope))
    return np.asarray(np.sqrt(np.diag(covariance)[:3]) * problem.scale)
