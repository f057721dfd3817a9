"""What the study runs on: the box, the noise, and a sine with dwell, on a plant as modelled or on a richer one.

Not printed in the paper, so ours: mass, inertia, noise, the sampling time and the vehicle. The box is the paper's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.filters.marginalized_particle.records import Noise
from pipelines.models.driven import driven
from pipelines.models.roll import GRAVITY, RollCoefficients, discretise
from pipelines.results import FloatArray

STEP_S = 0.01
DURATION_S = 2.0
NOISE = Noise(float(np.radians(0.1)), float(np.radians(0.3)), 0.1)
"""Roll 0.1 deg, roll rate 0.3 deg/s, lateral acceleration 0.1 m/s², each sample; not printed."""

RANGES = {"K": (5e4, 8e4), "D": (3e3, 1e4), "h": (0.5, 1.2)}
"""The paper's initial ranges."""

NAMES = ("K", "D", "h")
TITLES = ("roll stiffness K", "roll damping D", "CG height h")
UNITS = ("N·m/rad", "N·m·s/rad", "m")


@dataclass(frozen=True)
class RollBody:
    """What the model (1)-(2) needs: K, D, h, and mass and roll inertia, which the filter is told. SI."""

    stiffness: float
    damping: float
    height: float
    mass: float
    inertia: float

    @property
    def theta(self) -> FloatArray:
        """(3,) K, D, h."""
        return np.array([self.stiffness, self.damping, self.height])

    @property
    def coefficients(self) -> RollCoefficients:
        """c φ'' + b φ' + a φ = a_y of (1): gravity's part is in a."""
        moment = self.mass * self.height
        return RollCoefficients(
            self.stiffness / moment - GRAVITY, self.damping / moment, self.inertia / moment + self.height
        )


MATCHED = RollBody(65_000.0, 5_500.0, 0.74, 1800.0, 500.0)
"""A sport utility vehicle whose figures lie inside the paper's box, with the paper's average height."""


@dataclass(frozen=True)
class Motion:
    """One sine with dwell without noise, from the first turn of the wheel. All (n,), SI.

    accel: lateral acceleration of the point on the ground below the CG, as (1) has it (without gravity's part).
    steering: of the road wheels.
    """

    accel: FloatArray
    roll: FloatArray
    rate: FloatArray
    steering: FloatArray

    @property
    def time_s(self) -> FloatArray:
        """From the first turn of the wheel."""
        return np.asarray(np.arange(len(self.accel)) * STEP_S)


def as_modelled(motion: Motion, body: RollBody) -> Motion:
    """The same lateral acceleration on a vehicle that follows (1)-(2) exactly, with straight lines between samples."""
    phi, before, after = discretise(body.coefficients, STEP_S)
    whole = np.array([0]), np.array([len(motion.accel)])
    held = phi, before[:, None], after[:, None]
    state = driven(motion.accel[:, None], whole, held, np.eye(2), np.zeros((1, 2)))
    return Motion(motion.accel, state[:, 0], state[:, 1], motion.steering)


def measured(motion: Motion, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Roll and roll rate (n, 2) and lateral acceleration (n,) with fresh noise."""
    n = len(motion.accel)
    noise = np.array([NOISE.roll_rad, NOISE.roll_rate_radps])
    y = np.column_stack((motion.roll, motion.rate)) + noise * rng.standard_normal((n, 2))
    return y, motion.accel + NOISE.accel_mps2 * rng.standard_normal(n)
