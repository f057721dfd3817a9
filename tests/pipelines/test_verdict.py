"""One answer a parameter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.joint.information import PRIOR_DRAWS
from pipelines.joint.vehicle.load_places import ROOF, ROOF_LOAD
from pipelines.results import Estimate, Identification, ParameterEstimate, Prior
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.verdict.combine import between_methods, combine
from pipelines.verdict.missing import WAYS


def answer(name: str, value: float, status: Identification, source: str) -> ParameterEstimate:
    return ParameterEstimate(
        name, value, 0.01, value - 0.02, value + 0.02, status, "because", None, None, (source,)
    )


def test_one_estimator_speaks_for_itself() -> None:
    height = answer("cg_height_m", 0.6, "identified", "roll_map")
    verdict = combine([Estimate("roll_map", "ran", "fine", {"cg_height_m": height})], Vehicle())
    assert replace(verdict["cg_height_m"], inner=()) == height
    assert set(WAYS) <= set(verdict)


def test_the_better_identified_one_speaks_and_names_the_other() -> None:
    weak, good = answer("mass_kg", 1800, "weak", "first"), answer("mass_kg", 1750, "identified", "second")
    estimates = [
        Estimate("first", "ran", "", {"mass_kg": weak}),
        Estimate("second", "ran", "", {"mass_kg": good}),
    ]
    verdict = combine(estimates, Vehicle())
    assert verdict["mass_kg"].value == 1750
    assert verdict["mass_kg"].sources == ("second", "first")
    assert combine(estimates[::-1], Vehicle())["mass_kg"].value == 1750


def test_what_nobody_gave_is_the_prior_with_a_reason() -> None:
    vehicle = Vehicle(
        body="SUV", quantities={"mass_kg": Quantity(1800, 36, "vehicle file")}, reference={"mass_kg": 1850}
    )
    estimates = [Estimate("roll_map", "skipped", "no lateral acceleration")]
    verdict = combine(estimates, vehicle)
    mass = verdict["mass_kg"]
    assert (mass.status, mass.reference) == ("not_identifiable", 1850)
    # the file tells the empty vehicle: what may be on it makes the loaded one heavier and less known
    assert mass.value == pytest.approx(1980, rel=0.01)
    rng = np.random.default_rng(8)
    on_roof = rng.random(100_000) < ROOF.chance
    load = rng.normal(180, np.where(on_roof, ROOF_LOAD[1], 0.12 * 1800), 100_000)
    drawn = rng.normal(1800, 36, 100_000) + load
    low, high = np.quantile(drawn, (0.025, 0.975))
    # by draws, whose quantiles scatter as those of so many draws of ours do
    lots = np.quantile(drawn.reshape(-1, PRIOR_DRAWS), (0.025, 0.975), axis=1)
    scatter = float(np.std((lots[1] - lots[0]) / 3.92))
    assert scatter < 0.03 * mass.std
    assert mass.std == pytest.approx((high - low) / 3.92, abs=4 * scatter)
    told = combine(estimates, replace(vehicle, load={"mass_kg": Quantity(0, 5, "vehicle file")}))["mass_kg"]
    # by draws, the median of which scatters by 1.25 times 36 kg over the root of their number
    assert told.value == pytest.approx(1800, abs=4 * 1.25 * 36 / np.sqrt(PRIOR_DRAWS))
    assert told.std == pytest.approx(np.hypot(36, 5), rel=0.03)
    assert "axle loads" in mass.reason
    assert "no lateral acceleration" in mass.reason
    assert verdict["cg_height_m"].prior is not None
    assert verdict["roll_stiffness_nmprad"].value is None


def test_with_nothing_known_there_are_no_figures() -> None:
    verdict = combine([], Vehicle())
    assert all(p.value is None and p.low is None and p.status == "not_identifiable" for p in verdict.values())
    assert all(p.reason for p in verdict.values())


def test_a_failed_estimator_says_nothing() -> None:
    estimates = [
        Estimate("bad", "failed", "broke", {"cg_height_m": answer("cg_height_m", 9.0, "identified", "bad")})
    ]
    assert combine(estimates, Vehicle())["cg_height_m"].value is None


def named(name: str, value: float, std: float, witness: bool = False, prior: Prior | None = None) -> Estimate:
    entry = ParameterEstimate(
        "cg_height_m",
        value,
        std,
        value - 1.96 * std,
        value + 1.96 * std,
        "identified",
        "seen",
        prior,
        None,
        (name,),
    )
    return Estimate(name, "ran", "", {"cg_height_m": entry}, witness=witness)


def test_the_narrowest_of_those_that_agree_speaks_and_is_not_narrowed() -> None:
    for estimates in (
        [named("a", 0.70, 0.02), named("b", 0.71, 0.01)],
        [named("b", 0.71, 0.01), named("a", 0.70, 0.02)],
    ):
        height = combine(estimates, Vehicle())["cg_height_m"]
        assert (height.value, height.std) == (0.71, 0.01)
        assert height.sources == ("b", "a")


def test_a_contradiction_widens_the_interval_to_hold_both_and_is_said() -> None:
    prior = Prior(0.7, 0.3, "measured vehicles")
    height = combine([named("a", 0.70, 0.005, prior=prior), named("b", 0.80, 0.005, prior=prior)], Vehicle())[
        "cg_height_m"
    ]
    assert height.value == pytest.approx(0.75)
    assert height.low is not None
    assert height.high is not None
    assert height.low < 0.70
    assert height.high > 0.80
    assert "disagree" in height.reason
    assert height.status == "identified"


@pytest.mark.parametrize(("before", "status"), [(0.1, "weak"), (0.06, "not_identifiable")])
def test_methods_that_disagree_by_more_than_was_known_tell_nothing(before: float, status: str) -> None:
    """0.70 and 0.80 leave ± 0.071."""
    prior = Prior(0.7, before, "measured vehicles")
    told = [named("a", 0.70, 0.005, prior=prior), named("b", 0.80, 0.005, prior=prior)]
    height = combine(told, Vehicle())["cg_height_m"]
    assert height.status == status
    assert "disagree" in height.reason
    if status == "not_identifiable":
        assert (height.value, height.std, height.sources) == (0.7, 0.06, ("prior",))


def test_one_that_stands_apart_from_four_is_held_as_well() -> None:
    """The variance between five methods leaves out the one that stands apart; the interval that is said to hold them holds it."""
    values = (5.00, 5.00, 5.02, 4.98, 5.35)
    stds = (0.10, 0.12, 0.12, 0.12, 0.12)
    told = [named(name, value, std) for name, value, std in zip("abcde", values, stds, strict=True)]
    found = combine(told, Vehicle())["cg_height_m"]
    assert "widened to hold them" in found.reason
    assert found.low is not None
    assert found.high is not None
    assert found.low < min(values)
    assert found.high >= max(values)


def test_a_published_method_speaks_only_where_nobody_else_does() -> None:
    alone = combine([named("published", 0.9, 0.001, witness=True)], Vehicle())["cg_height_m"]
    assert alone.value == 0.9
    both = combine([named("published", 0.9, 0.001, witness=True), named("batch", 0.7, 0.02)], Vehicle())
    assert both["cg_height_m"].value == 0.7
    assert both["cg_height_m"].sources == ("batch", "published")
    weak = answer("cg_height_m", 0.72, "weak", "batch")
    kept = combine(
        [named("published", 0.9, 0.001, witness=True), Estimate("batch", "ran", "", {"cg_height_m": weak})],
        Vehicle(),
    )
    assert kept["cg_height_m"].value == 0.72


def test_variance_between_methods_is_none_where_they_agree() -> None:
    assert between_methods(np.array([1.0, 1.1]), np.array([0.1, 0.1])) == 0
    # two figures 1 apart with small own spread: the variance of such pairs is half of their squared distance
    assert between_methods(np.array([0.0, 1.0]), np.array([1e-3, 1e-3])) == pytest.approx(0.5, rel=1e-3)
