"""The fit behind load_transfer_batch on short drives of the papers' equations: no bias by the weight's bounce, and honest spreads."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.load_transfer.batch import ACROSS, fit
from pipelines.estimators.load_transfer.data import StrutData
from pipelines.estimators.load_transfer.noise import with_noise
from pipelines.models.load_transfer import Motion, Size, ltm_forces
from pipelines.prepare.lowpass import lowpass
from pipelines.results import FloatArray

G = 9.80665
RATE_HZ, CUTOFF_HZ, NOISE_N, SIZE = 12.0, 3.0, 20.0, Size(2.8, 1.6)
MASS, BEHIND, LEFT, ROLL_ARM = 1600.0, 1.35, 0.8, 0.52
LEVER = 0.5 * SIZE.track * np.array([-1.0, 1.0, -1.0, 1.0])


def short_drive(seconds: float, seed: int, turns: float = 2.5, noise: float = 0.0) -> StrutData:
    """A few slalom gates (turns: m/s²) and brakes on a rough road by (106)-(110). noise: of the lateral accelerometer, m/s² at the filter's rate."""
    rng = np.random.default_rng(seed)
    n = round(seconds * RATE_HZ)
    t = np.arange(n) / RATE_HZ
    gates = np.clip((t - 20) / 2, 0, 1) * np.clip((seconds - 6 - t) / 2, 0, 1)
    across = turns * gates * np.sin(2 * np.pi * 0.5 * (t + 0.3 * np.sin(0.4 * t)))
    along = lowpass(
        np.where((t > 4) & (t < 9), 2.0, 0.0) - np.where((t > 13) & (t < 17), 3.0, 0.0), RATE_HZ, 1.5
    )
    vertical = G + lowpass(rng.normal(0, 1, n), RATE_HZ, 2.5) * 0.5
    roll = 0.0088 * across
    turning = np.gradient(np.gradient(roll, 1 / RATE_HZ), 1 / RATE_HZ)
    motion = Motion(along, across, vertical, 0 * t, 0 * t, 0 * t)
    forces = ltm_forces(motion, SIZE, MASS, BEHIND, LEFT, ROLL_ARM, 0.5, 0.0)
    forces = forces + rng.normal(0, NOISE_N, (n, 4))
    felt = across + lowpass(rng.normal(0, noise, n), RATE_HZ, CUTOFF_HZ)
    zero, starts = np.zeros(n), np.zeros(n)
    starts[0] = 1.0
    return StrutData(
        t, RATE_HZ, forces, np.tile(vertical[:, None], 4), vertical, along, felt, (0.1, 0.1), zero, zero,
        np.full(n, 15.0), zero, turning, zero, (along < -0.7).astype(float), starts, np.arange(n), n, True, (),
    )  # fmt: skip


def arm_of(data: StrutData) -> tuple[float, float]:
    moment, spread = with_noise(fit(data), data, CUTOFF_HZ).combine(LEVER, ACROSS)
    return moment / MASS, spread / MASS


def arms(
    seconds: float, turns: float = 2.5, noise: float = 0.0, drives: int = 60
) -> tuple[FloatArray, FloatArray]:
    """Error and stated spread of the roll arm over drives, m."""
    found = np.array([arm_of(short_drive(seconds, seed, turns, noise)) for seed in range(drives)])
    return found[:, 0] - ROLL_ARM, found[:, 1]


def test_the_weight_that_bounces_in_a_turn_is_not_taken_for_roll_acceleration() -> None:
    """All of a lateral force's moment goes with A_z in (106): left out, single drives read 1 to 2 % off."""
    error, _ = arms(180.0)
    assert np.sqrt(np.mean(error**2)) < 0.003


@pytest.mark.parametrize("seconds", [40.0, 60.0, 180.0])
def test_a_roll_arm_of_few_stretches_is_no_surer_than_it_is(seconds: float) -> None:
    """Six stretches of 8 s for fourteen columns: the scatter of the stretches alone says hardly anything of most directions."""
    error, spread = arms(seconds)
    assert np.sqrt(np.mean((error / spread) ** 2)) < 1.25
    assert np.mean(np.abs(error) < 1.96 * spread) >= 0.9
    # and no wider than three times what it is wrong by
    assert spread.mean() < 3 * np.sqrt(np.mean(error**2))


def test_a_drive_that_hardly_turns_leaves_the_arm_to_its_accelerometers_noise() -> None:
    """Noise in what the forces are fitted on makes a coefficient smaller: of this drive's, a tenth and more."""
    error, spread = arms(60.0, turns=0.15, noise=0.04)
    assert error.mean() < -0.05
    assert np.mean(np.abs(error) < 1.96 * spread) >= 0.9
    # of a slalom the same noise takes little, and the interval says so
    error, spread = arms(60.0, noise=0.04)
    assert np.mean(np.abs(error) < 1.96 * spread) >= 0.9
    assert spread.mean() < 2 * np.sqrt(np.mean(error**2)) < 0.02
