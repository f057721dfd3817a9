"""A fit of the roll motion that ended where no vehicle is tells neither damping nor inertia."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.estimators.roll_map.answers import Coefficients, quick_enough, spreads_in_words
from pipelines.estimators.roll_map.model import WEAK_PRIOR
from pipelines.estimators.roll_map.vehicle import before_the_log, usable
from pipelines.vehicles.vehicle import Vehicle

NAMES = ("a", "b", "c")
WEAK = np.array([WEAK_PRIOR[name] for name in NAMES])


def _fit(a: float, b: float, c: float, spread: tuple[float, float, float] = (2.0, 1.0, 0.1)) -> Coefficients:
    return Coefficients(NAMES, np.array([a, b, c]), np.diag(np.square(spread)), *WEAK.T)


@pytest.mark.parametrize(
    ("a", "b", "c", "told"),
    [
        (116.0, 5.1, 1.05, True),  # a ratio of 0.23
        (116.0, 2.2, 1.05, True),  # dampers that are worn out: 0.10
        (116.0, 0.44, 1.03, False),  # a delay of 64 ms, and 0.02
        (98.0, 0.304, 1.53, False),  # just off the fit's bound of 0.3
        (110.0, 5.0, 0.1, False),  # a body without inertia
    ],
)
def test_a_motion_without_dampers_or_inertia_tells_neither(a: float, b: float, c: float, told: bool) -> None:
    before = before_the_log(Vehicle(), np.random.default_rng(0), 100)
    found, sentences = usable(before, _fit(a, b, c), against_axles=True)
    assert quick_enough(found) == (told, told)
    assert (found.mean[0], found.covariance[0, 0]) == (a, 4.0), "the steady part stays"
    assert sentences == (
        []
        if told
        else ["The roll motion shows inertia and damping too little: only its steady part is used."]
    )


@pytest.mark.parametrize(
    ("spread", "words"),
    [
        ((2.0, 600.0, 60.0), "tells neither inertia nor damping"),
        ((2.0, 9.0, 0.2), "leaves inertia to ± 20% and damping open"),
        ((2.0, 2.5, 1.4), "leaves inertia open and damping to ± 50%"),
        ((2.0, 2.5, 0.2), "leaves inertia to ± 20% and damping to ± 50%"),
    ],
)
def test_a_spread_beyond_the_figure_itself_is_said_in_words(
    spread: tuple[float, float, float], words: str
) -> None:
    assert spreads_in_words(_fit(100.0, 5.0, 1.0, spread)) == words
