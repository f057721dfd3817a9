"""Noise of a model's inputs in the fit of its outputs: its size from above the band, and intervals that hold what it does."""

from __future__ import annotations

import numpy as np
import pytest
from plant_described_roll import roll_drive

from pipelines.estimators.gpc_bayesian_map.data import collect
from pipelines.estimators.gpc_bayesian_map.estimator import DEFAULTS, GpcBayesianMap
from pipelines.estimators.gpc_bayesian_map.inputs_noise import noise_of_inputs
from pipelines.models.described.roll import MODEL


def test_the_size_of_the_noise_is_found_above_the_band() -> None:
    drive, _, _ = roll_drive(1, noise=0.15)
    prepared = GpcBayesianMap("roll").prepare(drive, {})
    data = collect(
        prepared, MODEL, band_hz=MODEL.band_hz, block_s=5.0, intervals=6, least_input=0.3, most_blocks=60
    )
    # white noise at 50 Hz has so much less on the grid after the low-pass
    expected = 0.15 * np.sqrt(data.rate_hz / 50.0)
    assert noise_of_inputs(data, prepared.cutoff_hz)[0] == pytest.approx(expected, rel=0.15)


def test_an_accelerometers_noise_does_not_leave_roll_surer_than_it_is() -> None:
    method, settings = GpcBayesianMap("roll"), {**DEFAULTS, "model_error_scale": 0.0}
    off = []
    for seed in range(12):
        drive, vehicle, true = roll_drive(seed, noise=0.15, quick_hz=0.6)
        found = method.estimate(method.prepare(drive, settings), vehicle, settings, np.random.default_rng(0))
        for name, value in true.items():
            entry = found.parameters[name]
            assert entry.value is not None
            assert entry.std is not None
            off.append((entry.value - value) / entry.std)
    # what twelve drives may come to by chance; without the noise's shift it is 1.6, and 0.72 of the intervals hold
    assert np.sqrt(np.mean(np.square(off))) < 1.35
    assert np.mean(np.abs(off) < 1.96) >= 0.8
