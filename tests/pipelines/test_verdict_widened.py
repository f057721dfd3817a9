"""What a doubt leaves of an answer: weak, or what was known before, or nothing."""

from __future__ import annotations

import pytest

from pipelines.parameters import PARAMETERS, is_positive
from pipelines.prepare.lateral_scale import HANG_ON_IT
from pipelines.prepare.load_change import LoadStep
from pipelines.prepare.scale_doubt import ScaleDoubt, as_sure_as_the_scale
from pipelines.results import ParameterEstimate, Prior
from pipelines.vehicles.vehicle import Vehicle
from pipelines.verdict.combine import _Given, as_sure_as_its_relation
from pipelines.verdict.two_loads import holding_both_loads
from pipelines.verdict.widened import not_told, widened

GRADIENT = "roll_gradient_degpg"


def told(name: str, value: float, std: float, prior: Prior | None = None) -> ParameterEstimate:
    low, high = value - 1.96 * std, value + 1.96 * std
    return ParameterEstimate(name, value, std, low, high, "identified", "seen", prior, None, ("one",))


@pytest.mark.parametrize(
    ("std", "status"), [(0.1, "weak"), (1.0, "weak"), (1.3, "not_identifiable"), (17.0, "not_identifiable")]
)
def test_without_a_prior_a_share_of_the_value_is_the_limit(std: float, status: str) -> None:
    """30 % of 4 deg/g."""
    found = widened(told(GRADIENT, 4.0, 0.1), std, "doubt")
    assert found.status == status
    assert found.reason.startswith("doubt")
    assert (found.value is None) is (status == "not_identifiable")


@pytest.mark.parametrize(("std", "fair", "status"), [(110, 0.75, "weak"), (130, 0.75, "not_identifiable"), (130, 0.9, "weak")])  # fmt: skip
def test_with_a_prior_a_share_of_it_is(std: float, fair: float, status: str) -> None:
    found = widened(told("mass_kg", 2000.0, 20.0, Prior(2050.0, 160.0, "file")), std, "doubt", fair=fair)
    assert found.status == status
    assert (found.value, found.sources) == ((2000.0, ("one",)) if status == "weak" else (2050.0, ("prior",)))


def test_lengths_about_nought_have_limits_in_metres() -> None:
    aside = told("cg_lateral_offset_m", 0.01, 0.005)
    assert widened(aside, 0.05, "doubt").status == "weak"
    assert widened(aside, 0.12, "doubt").status == "not_identifiable"


@pytest.mark.parametrize("name", [n for n in PARAMETERS if is_positive(n)])
def test_what_is_positive_never_has_a_negative_end(name: str) -> None:
    for prior in (None, Prior(1.0, 0.9, "file"), Prior(1.0, 5.0, "file")):
        for opens in (True, False):
            for std in (0.2, 0.6, 3.0):
                found = widened(told(name, 1.0, 0.1, prior), std, "doubt", opens=opens)
                assert found.low is None or found.low >= 0
                assert found.status == "weak" or std > 0.2


def test_what_is_not_told_stays_as_it_is() -> None:
    nothing = ParameterEstimate(GRADIENT, None, None, None, None, "not_identifiable", "nobody")
    assert widened(nothing, 3.0, "doubt") is nothing


def test_where_no_spread_would_do_the_prior_stands() -> None:
    found = not_told(told("mass_kg", 2000.0, 20.0, Prior(2050.0, 160.0, "file")), "doubt")
    assert (found.status, found.value, found.std) == ("not_identifiable", 2050.0, 160.0)


def test_a_relation_widened_beyond_its_value_tells_no_gradient() -> None:
    """3.3 deg/g with a spread that its contradiction makes 14."""
    entry = told(GRADIENT, 3.3, 0.1)
    found = as_sure_as_its_relation(_Given("one", False, entry), entry, 140.0)
    assert (found.status, found.value, found.low) == ("not_identifiable", None, None)
    assert "140.0 times as wide: too wide" in found.reason


def test_another_channel_leaves_no_gradient() -> None:
    doubt = ScaleDoubt(1.0, "accel_y does not follow", "correlation 0.1")
    assert (
        as_sure_as_the_scale({GRADIENT: told(GRADIENT, 5.0, 0.1)}, doubt, HANG_ON_IT)[GRADIENT].value is None
    )


def test_a_load_that_changes_by_more_than_was_known_opens_it() -> None:
    """Half a change of 300 kg is no more than 160 kg of a prior; half of 900 kg is: there the prior holds neither load."""
    verdict = {
        e.name: e
        for e in (
            told("mass_kg", 2000.0, 20.0, Prior(2050.0, 160.0, "file")),
            told("corner_mass_rl_kg", 500.0, 8.0, Prior(510.0, 60.0, "file")),
            told("pitch_inertia_kgm2", 3000.0, 100.0, Prior(3050.0, 300.0, "file")),
        )
    }
    some, much = (
        holding_both_loads(verdict, LoadStep(100.0, 120.0, kg, 30.0, 0.8, 0.5, "deflections"), Vehicle())
        for kg in (300.0, 900.0)
    )
    assert (some["mass_kg"].status, some["mass_kg"].value) == ("not_identifiable", 2050.0)
    mass, corner = much["mass_kg"], much["corner_mass_rl_kg"]
    assert (mass.status, mass.value, mass.sources) == ("not_identifiable", 2000.0, ("prior",))
    assert mass.std == pytest.approx(450.0, rel=0.01)
    assert corner.low == 0.0
    assert some["pitch_inertia_kgm2"].status == "weak"
    assert "half of what that changes" in mass.reason
