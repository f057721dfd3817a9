"""What goes into the marginalised particle filter and what comes out.

A particle is a row of six numbers (`COLUMNS`): K, D, h, m, I_x, z. The paper's θ is the first three; mass, roll inertia and
the accelerometer's height over the roll axis are given, and may be given with a spread: then each particle has its own,
and the answer's interval holds their uncertainty too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from parsers.channels import IntArray
from pipelines.results import FloatArray

PARAMETERS = ("K", "D", "h")
"""Roll stiffness in N m/rad, roll damping in N m s/rad, CG's height above the roll axis in m: θ of (3)."""

COLUMNS = ("K", "D", "h", "m", "I_x", "z")
"""A particle's columns: θ, then rolling mass in kg, its roll inertia about its own CG in kg m², accelerometer's height in m."""

QUANTILES = (0.025, 0.5, 0.975)


@dataclass(frozen=True)
class Noise:
    """Standard deviations of one sample's white noise: R of (4c) and Q_a of (4b). All positive."""

    roll_rad: float
    roll_rate_radps: float
    accel_mps2: float

    def __post_init__(self) -> None:
        """Refuse what makes a weight infinite."""
        numbers = (self.roll_rad, self.roll_rate_radps, self.accel_mps2)
        if not all(np.isfinite(number) and number > 0 for number in numbers):
            raise ValueError(f"noise has positive standard deviations, not {numbers}")


@dataclass(frozen=True)
class Offsets:
    """Standard deviations, before the drive, of the constant offsets of the three sensors: three more states (mean zero)."""

    roll_rad: float
    roll_rate_radps: float
    accel_mps2: float


@dataclass(frozen=True)
class ParticleSettings:
    """How Algorithm 2 runs.

    wanted: N* of (10). most: the cap on N. adaptive: N by (10); otherwise `fixed` particles (None: as many as the prior
    cloud). threshold: resample when the effective size is below this share of N; 1 or more: at every sample, as published.
    walk: standard deviations of one sample's random walk of K, D, h, the root of Q_θ of (3). kernel: bandwidth of Liu and
    West's smoothed move after resampling, 0: none (0.4 shrinks by 0.917). above_mirror: keep h > sqrt(I_x / m).
    sensed_input: the input's noise is a sensor's, which the body never felt: the particles' variances count, but not their logarithms
    (`kernels.measure`), and a sample's noise is in the steps before and behind it (`sensed_step`). first_order_hold: the input runs straight between samples; otherwise it is held, as (4b) reads. gravity_mps2: g of
    (1); 0 where the input is what an accelerometer on the body reads (that has g sin φ in it already). start_roll_rad,
    start_rate_radps: standard deviation of the first state. quantiles_every: samples between quantiles (others are NaN).
    """

    wanted: int = 1000
    most: int = 8000
    adaptive: bool = True
    fixed: int | None = None
    threshold: float = 1.0
    walk: tuple[float, float, float] = (0.0, 0.0, 0.0)
    kernel: float = 0.0
    above_mirror: bool = True
    sensed_input: bool = False
    first_order_hold: bool = True
    gravity_mps2: float = 9.80665
    start_roll_rad: float = 0.2
    start_rate_radps: float = 0.5
    offsets: Offsets | None = None
    quantiles_every: int = 1


PUBLISHED = ParticleSettings(walk=(200.0, 30.0, 0.002), above_mirror=False)
"""Algorithm 2: resampling at every sample, a random walk of the parameters (the steps that NOTES found best), N by (10)."""

BETTER = ParticleSettings(threshold=0.5, kernel=0.4, sensed_input=True, offsets=Offsets(0.01, 0.01, 0.2))
"""Resampling below half the particles, a smoothed move that keeps mean and covariance, no random walk, sensor offsets, an input that
is measured.

Its N by (10) settles at about 2 600. A thousand from the whole of a wide box are few where noise is little (RMSE 1.5 to 1.8 times the
bound with 0.03 deg of roll, 1.1 with 0.1): `refine` mends that."""


def fixed_size(settings: ParticleSettings, particles: int) -> ParticleSettings:
    """NONADAP: the same settings with `particles` particles throughout."""
    return replace(settings, adaptive=False, fixed=particles, most=max(particles, settings.most))


@dataclass(frozen=True)
class Cloud:
    """Weighted particles. theta: (N, 6), `COLUMNS`. weights: (N,), positive sum."""

    theta: FloatArray
    weights: FloatArray

    def __post_init__(self) -> None:
        """Refuse what is no cloud."""
        fits = self.theta.ndim == 2 and self.theta.shape[1] == len(COLUMNS) and self.theta.shape[0] >= 1
        if not fits or self.weights.shape != (self.theta.shape[0],):
            raise ValueError(
                f"a cloud is (N, {len(COLUMNS)}) with (N,) weights, not {self.theta.shape} with {self.weights.shape}"
            )
        if not np.isfinite(self.theta).all():
            raise ValueError("every particle has finite numbers")
        if not (np.isfinite(self.weights).all() and (self.weights >= 0).all() and self.weights.sum() > 0):
            raise ValueError("weights are finite, not negative, and not all zero")


@dataclass(frozen=True)
class ParticleRun:
    """What the filter found; row k is after the measurements of sample k, before resampling.

    mean, std: (n, 3) of K, D, h. quantiles: (n, 3 parameters, 3 `QUANTILES`), NaN where not asked for. particles: (n,) N_k
    with which the sample was weighed. effective: (n,) 1 / Σ w². state, state_std: (n, 5) roll, roll rate, and the offsets of
    roll, roll rate and acceleration (zero without `Offsets`). log_likelihood: (n,) log p(y_k | y_0..k-1); its sum is the
    log evidence. innovation, innovation_std: (n, 2), NaN where not measured. resampled: (n,) whether. survivors: (n,) different
    particles that resampling left, 0 where there was none. lost: samples at which all weights were zero (the particles were
    then weighed alike and went on). final: the cloud after the last sample. snapshots: by sample.
    """

    mean: FloatArray
    std: FloatArray
    quantiles: FloatArray
    particles: IntArray
    effective: FloatArray
    state: FloatArray
    state_std: FloatArray
    log_likelihood: FloatArray
    innovation: FloatArray
    innovation_std: FloatArray
    survivors: IntArray
    lost: int
    final: Cloud
    snapshots: Mapping[int, Cloud]

    @property
    def evidence(self) -> float:
        """Log evidence of the whole drive under the prior cloud."""
        return float(self.log_likelihood.sum())

    @property
    def resampled(self) -> IntArray:
        """(r,) the samples after which it resampled."""
        return np.flatnonzero(self.survivors)

    @property
    def depleted(self) -> bool:
        """Whether at some sample fewer than ten particles carried the weight, or none."""
        return bool(self.lost > 0 or (self.effective < 10).any())
