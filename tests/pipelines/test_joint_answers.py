"""The verdict's entry of a parameter that a drive does not tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.evidence import Evidence
from pipelines.joint.answers import Told, digits_of, estimate_of
from pipelines.joint.information import Spread
from pipelines.results import ParameterEstimate
from tests.pipelines.joint_parts import linear


def pitch() -> list[Evidence]:
    """A relation of the pitch balance."""
    return [replace(linear({"load_h": 1.0}, 0.8, 0.1), kind="pitch")]


def rolling() -> list[Evidence]:
    """A relation of the roll balance."""
    return [replace(linear({"load_h": 1.0}, 0.8, 0.1), kind="roll")]


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


def test_a_stiffness_that_the_drive_does_not_tell_is_given_for_the_load_that_it_does() -> None:
    prior = Spread(90e3, 2500.0, np.full(10, 90e3))
    told = Told(94e3, 2400.0, 89.3e3, 98.7e3, None)
    upright = [replace(linear({"load": 1.0}, 60.0, 5.0), kind="vertical"), *rolling()]
    found = estimate_of("roll_stiffness_nmprad", told, prior, (), None, upright)
    assert (found.value, found.std, found.status, found.sources) == (
        94e3,
        2400.0,
        "not_identifiable",
        ("prior",),
    )
    assert "under the load that this drive shows" in found.reason
    assert estimate_of("roll_stiffness_nmprad", told, prior, (), None, rolling()).value == 90e3


def test_what_nothing_opened_is_given_with_what_was_known_before() -> None:
    for name, std in (("roll_stiffness_nmprad", 2400.0), ("cg_height_m", 4e3)):
        found = entry(name, std)
        assert (found.value, found.std, found.status) == (90e3, 2500.0, "not_identifiable")


@pytest.mark.parametrize(
    ("std", "status"),
    [
        (900.0, "identified"),
        (1800.0, "identified"),
        (1900.0, "weak"),
        (2650.0, "weak"),
        (2900.0, "not_identifiable"),
    ],
)
def test_a_status_is_by_what_is_left_of_the_interval_before(std: float, status: str) -> None:
    """Loads leave long tails: the interval before is wider than 1.96 of its middle's spread."""
    draws = 90e3 + 2300.0 * np.random.default_rng(4).standard_t(3.0, 200_000)
    prior = Spread(90e3, 2750.0, draws)
    before = prior.interval[1] - prior.interval[0]
    assert before == pytest.approx(2 * 3.182 * 2300.0, rel=0.02)
    told = Told(90e3, std, 90e3 - 1.96 * std, 90e3 + 1.96 * std, None)
    assert estimate_of("cg_height_m", told, prior, (), None, pitch()).status == status


def test_what_was_known_before_has_the_interval_of_its_draws() -> None:
    draws = 90e3 + 2500.0 * np.random.default_rng(2).exponential(1.0, 20_000)
    told = Told(94e3, 4e3, 86e3, 102e3, None)
    found = estimate_of("cg_height_m", told, Spread(92e3, 2300.0, draws), (), None, ())
    assert (found.low, found.high) == pytest.approx((90e3 + 2500 * 0.0253, 90e3 + 2500 * 3.689), rel=2e-3)


def test_words_have_the_digits_that_a_spread_needs() -> None:
    assert {n: digits_of(n) for n in ("cg_height_m", "mass_kg", "drag_area_m2", "roll_inertia_kgm2")} == {
        "cg_height_m": 4, "mass_kg": 0, "drag_area_m2": 2, "roll_inertia_kgm2": 0,
    }  # fmt: skip
