"""Posteriors like bent sheets, which no low-order polynomial holds: by runs of the model itself, beside a grid's; roll, told by three of five."""

from __future__ import annotations

import numpy as np
from plant_described_roll import roll_drive

from pipelines.bayes.exact import exact
from pipelines.bayes.priors import Known, Normal, Priors
from pipelines.bayes.sequence import Choice, estimate
from pipelines.estimators.gpc_bayesian_map.estimator import DEFAULTS, GpcBayesianMap
from pipelines.results import FloatArray

THIN = 0.004


def bent(values: FloatArray, interval: int) -> FloatArray:
    """Only a + sin(1.5 b) is seen, to THIN."""
    return ((values[:, :1] + np.sin(1.5 * values[:, 1:])) - 0.3) / THIN


def test_a_bent_sheet_has_the_moments_of_its_grid() -> None:
    priors = Priors((Known("a", Normal(0.0, 1.0)), Known("b", Normal(0.1, 0.4))))
    found = estimate(priors, bent, 1, Choice(order=3, near_order=2), np.random.default_rng(0))
    told, close, _ = exact(priors, lambda c: bent(priors.values(c), 0), found.posterior)
    assert close
    # on the sheet a = 0.3 - sin(1.5 b), and so thin is it that its width hardly counts
    b = np.linspace(-2.4, 2.6, 20001)
    a = 0.3 - np.sin(1.5 * b)
    weight = np.exp(-0.5 * a**2 - 0.5 * ((b - 0.1) / 0.4) ** 2)
    weight /= weight.sum()
    mean = np.array([weight @ a, weight @ b])
    std = np.sqrt([weight @ (a - mean[0]) ** 2, weight @ (b - mean[1]) ** 2])
    assert np.all(np.abs(told.mean - mean) < 0.1 * std)
    np.testing.assert_allclose(told.std, std, rtol=0.1)
    assert np.abs(bent(told.map_value[None], 0)).max() < 0.5


def test_roll_parameters_that_only_come_together_are_as_wide_as_the_figures_that_part_them() -> None:
    method, settings = GpcBayesianMap("roll"), {**DEFAULTS, "model_error_scale": 0.0}
    off = []
    for seed in range(10):
        drive, vehicle, true = roll_drive(seed)
        found = method.estimate(method.prepare(drive, settings), vehicle, settings, np.random.default_rng(0))
        assert found.diagnostics["surrogate_error"] < 0.25
        for name, value in true.items():
            entry = found.parameters[name]
            assert entry.value is not None
            assert entry.std is not None
            off.append((entry.value - value) / entry.std)
    assert np.sqrt(np.mean(np.square(off))) < 1.5
    assert np.mean(np.abs(off) < 1.96) >= 0.85
