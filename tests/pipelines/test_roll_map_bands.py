"""When the whole band may stand for the sure one, and when trying further models in it is no use."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.roll_map.choose import holds, hopeless
from pipelines.estimators.roll_map.fit import RollFit


def fit(*values: float, widened: float = 1.0, converged: bool = True) -> RollFit:
    """a, b, c with white-noise spreads of 1, 0.5 and 0.02, and honest ones so many times as wide."""
    white = np.diag(np.square([1.0, 0.5, 0.02]))
    return RollFit(
        known=(), values={}, covariance=widened**2 * white, white_covariance=white, edges=np.zeros(0, dtype=np.int64),
        information=np.zeros((0, 3, 3)), gradient=np.zeros((0, 3)), cost=0.0, normalised=np.zeros((0, 1)), explained=0.9,
        quickness=2.0, names=("a", "b", "c"), handed=np.array(values), jacobian=np.eye(3), steps=5,
        converged=converged,
    )  # fmt: skip


SURE = fit(110.0, 7.0, 0.8)


@pytest.mark.parametrize(
    ("whole", "held", "lost"),
    [
        (fit(110.5, 7.2, 0.81), True, False),
        (fit(110.5, 7.2, 0.81, converged=False), False, True),
        (fit(114.0, 7.0, 0.80), False, False),
        (fit(117.0, 7.0, 0.80), False, True),
        (fit(110.0, 7.0, 0.80, widened=2.0), False, False),
        (fit(110.0, 7.0, 0.80, widened=2.5), False, True),
        (fit(float("nan"), 7.0, 0.80), False, True),
    ],
)
def test_a_band_that_is_missed_by_far_is_given_up(whole: RollFit, held: bool, lost: bool) -> None:
    assert holds(SURE, whole) is held
    assert hopeless(SURE, whole) is lost
