"""The set-up of 3.8-3.9: the simple roll-plane model driven by sums of sines, and noise on its channels.

Frequencies, amplitudes, distances and true values are not printed. Ours: true values inside the printed priors (77), and
sines whose lateral and longitudinal acceleration have a variance of 2 m²/s⁴, so that noise of variance 0.2 is a tenth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.models.roll_plane import SIMPLE, Plane, simple_regressors
from pipelines.results import FloatArray

STEP_S, DURATION_S = 0.01, 100.0
PLANE = Plane(0.75, 0.75, 1.3, 1.5)
TRUTH = np.array([2950.0, 2250.0, 650.0, 0.5])
MIDDLE = np.array([2850.0, 2000.0, 600.0, 0.4])
HALF = np.array([200.0, 400.0, 100.0, 0.2])
"""(77): first and second coefficients of mass, pitch inertia, roll inertia, height. TRUTH is ours."""

NAMES = ("mass", "pitch inertia", "roll inertia", "CG height")
UNITS = ("kg", "kg·m²", "kg·m²", "m")
NOISE = 0.2
FORCE_RMS_N, ACCEL_RMS = 1200.0, 2.0**0.5
SINES, BAND_HZ = 6, (0.1, 2.5)
SPACING = 0.12
"""The noise's variance, the paper's on outputs; rms of each strut force and of both accelerations; sines a channel, their
band, and the least share by which frequencies of one channel differ."""

INPUT_NOISE = np.zeros((3, 5))
INPUT_NOISE[0, 0] = 4 * NOISE
INPUT_NOISE[1, 1] = 2 * (PLANE.left**2 + PLANE.right**2) * NOISE
INPUT_NOISE[2, 2] = 2 * (PLANE.front**2 + PLANE.rear**2) * NOISE
INPUT_NOISE[1, 3] = INPUT_NOISE[2, 4] = NOISE
"""Variance of the noise on each regressor where all channels have `NOISE`."""


@dataclass(frozen=True)
class Drive:
    """forces (n, 4), accel_x, accel_y (n,), and the model's outputs z'', roll'', pitch'' (n, 3)."""

    forces: FloatArray
    accel_x: FloatArray
    accel_y: FloatArray
    outputs: FloatArray

    @property
    def regressors(self) -> FloatArray:
        """(84), corrected: (n, 3, 5)."""
        return simple_regressors(self.forces, self.accel_x, self.accel_y, PLANE)


def _sines(rng: np.random.Generator, time_s: FloatArray, rms: float) -> FloatArray:
    """A sum of sines at frequencies of its own, (n,)."""
    low, high = BAND_HZ
    steps = (np.arange(SINES) + SPACING + (1 - 2 * SPACING) * rng.random(SINES)) / SINES
    frequencies = low + (high - low) * steps
    phases = 2 * np.pi * rng.random(SINES)
    waves = np.sin(2 * np.pi * np.outer(time_s, frequencies) + phases)
    return np.asarray(rms * np.sqrt(2 / SINES) * waves.sum(axis=1))


def clean_drive(rng: np.random.Generator, truth: FloatArray = TRUTH) -> Drive:
    """The excitation and the true outputs, without noise. truth: (4,), or (n, 4) where it changes on the way."""
    time_s: FloatArray = np.asarray(np.arange(round(DURATION_S / STEP_S)) * STEP_S, dtype=np.float64)
    forces = np.column_stack([_sines(rng, time_s, FORCE_RMS_N) for _ in range(4)])
    accel_x, accel_y = (_sines(rng, time_s, ACCEL_RMS) for _ in range(2))
    phi = simple_regressors(forces, accel_x, accel_y, PLANE)
    if truth.ndim == 1:
        return Drive(forces, accel_x, accel_y, np.asarray(phi @ SIMPLE.coefficients(truth)))
    changing = np.prod(truth[:, None, :] ** SIMPLE.exponents, axis=2)
    return Drive(forces, accel_x, accel_y, np.asarray(np.einsum("tmc,tc->tm", phi, changing)))


def noisy(drive: Drive, rng: np.random.Generator, *, inputs: bool) -> Drive:
    """White noise of variance `NOISE` on the outputs; on all channels with `inputs`."""
    std = NOISE**0.5
    outputs = drive.outputs + std * rng.standard_normal(drive.outputs.shape)
    if not inputs:
        return Drive(drive.forces, drive.accel_x, drive.accel_y, outputs)
    n = len(outputs)
    return Drive(
        drive.forces + std * rng.standard_normal((n, 4)),
        drive.accel_x + std * rng.standard_normal(n),
        drive.accel_y + std * rng.standard_normal(n),
        outputs,
    )
