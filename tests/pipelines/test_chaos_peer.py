"""Our expansions beside chaospy's on the same basis: its terms stand in another order, and are matched by their powers."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from pipelines.chaos.collocation import collocate
from pipelines.chaos.expansion import expand
from tests.pipelines.chaos_peer import KEPT, SPACES, figures, fresh_points, model

Figures = dict[str, dict[str, Any]]


@pytest.fixture(scope="module")
def kept() -> Figures:
    """chaospy's figures, kept in a file."""
    return json.loads(KEPT.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", SPACES)
def test_basis_coefficients_moments_and_sensitivities_agree(name: str, kept: Figures) -> None:
    space, order = SPACES[name]
    peer = kept[name]
    points = collocate(space, order)
    ours = expand(points, model(points.points)[:, None])
    basis = np.array(peer["basis"])
    assert (
        np.abs(space.matrix(fresh_points(space), points.indices) - basis).max() < 1e-10 * np.abs(basis).max()
    )
    assert np.abs(ours.coefficients[:, 0] - peer["coefficients"]).max() < 1e-10
    assert ours.variance[0] == pytest.approx(peer["variance"], rel=1e-9)
    assert np.abs(ours.sobol_first[:, 0] - peer["sobol_first"]).max() < 1e-9
    assert np.abs(ours.sobol_total[:, 0] - peer["sobol_total"]).max() < 1e-9


def test_the_kept_figures_are_what_chaospy_says(kept: Figures) -> None:
    pytest.importorskip("chaospy")
    for name, now in figures().items():
        for key, value in now.items():
            assert np.allclose(value, kept[name][key], rtol=1e-9, atol=1e-10), f"{name} {key}"
