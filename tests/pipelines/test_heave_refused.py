"""Why a heave that springs and dampers explain only in part tells no mass: causes that may be, and none that is not known."""

from __future__ import annotations

import numpy as np

from pipelines.estimators.base_excitation.batch_heave import NAMES, HeaveFit
from pipelines.estimators.base_excitation.batch_parts import HEAVE_EXPLAINED
from pipelines.estimators.base_excitation.batch_whole import refused
from pipelines.estimators.base_excitation.data import RideData
from pipelines.vehicles.vehicle import Vehicle

ROUGH = RideData((), {}, {}, {}, ((0, 100),), 200.0, np.ones(100, dtype=bool), 8.0)


def fit(explained: float) -> HeaveFit:
    zeros = np.zeros(len(NAMES))
    values = np.where(np.char.startswith(np.array(NAMES), "mass"), 500.0, 100.0)
    blocks: object = None
    return HeaveFit(
        values, np.eye(len(NAMES)), np.zeros((2, len(NAMES))), blocks, zeros, zeros, zeros, zeros, explained, 0.1, 1.0,  # type: ignore[arg-type]
    )  # fmt: skip


def test_aliasing_is_named_beside_other_motion_and_neither_is_stated_as_the_cause() -> None:
    reason = refused(ROUGH, fit(HEAVE_EXPLAINED - 0.08), Vehicle())
    assert "dry friction, bends or brakes may have too large a share" in reason
    assert "quicker than half the log's rate are folded into it" in reason


def test_a_heave_that_is_explained_is_not_refused_for_it() -> None:
    assert "share" not in refused(ROUGH, fit(0.99), Vehicle())
