"""The verdict's entry of a parameter that a drive does not tell."""

from __future__ import annotations

import numpy as np

from pipelines.joint.answers import Told, digits_of, estimate_of
from pipelines.joint.information import Spread
from pipelines.results import ParameterEstimate


def entry(name: str, std: float) -> ParameterEstimate:
    """Before: 90 000 ± 2 500; after: 94 000 ± std."""
    told = Told(94e3, std, 94e3 - 1.96 * std, 94e3 + 1.96 * std, None)
    prior = Spread(90e3, 2500.0, np.full(10, 90e3))
    return estimate_of(name, told, prior, (), None, ())


def test_a_stiffness_that_the_load_leaves_open_is_given_for_that_load() -> None:
    found = entry("roll_stiffness_nmprad", 4e3)
    assert (found.value, found.std, found.status) == (94e3, 4e3, "not_identifiable")
    assert found.low is not None
    assert found.low < 90e3
    assert found.prior is not None
    assert found.prior.value == 90e3


def test_what_nothing_opened_is_given_with_what_was_known_before() -> None:
    for name, std in (("roll_stiffness_nmprad", 2400.0), ("cg_height_m", 4e3)):
        found = entry(name, std)
        assert (found.value, found.std, found.status) == (90e3, 2500.0, "not_identifiable")


def test_words_have_the_digits_that_a_spread_needs() -> None:
    assert {n: digits_of(n) for n in ("cg_height_m", "mass_kg", "drag_area_m2", "roll_inertia_kgm2")} == {
        "cg_height_m": 4, "mass_kg": 0, "drag_area_m2": 2, "roll_inertia_kgm2": 0,
    }  # fmt: skip
