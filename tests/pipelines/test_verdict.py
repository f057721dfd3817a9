"""One answer a parameter."""

from __future__ import annotations

from pipelines.results import Estimate, Identification, ParameterEstimate
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.verdict.combine import MISSING, combine


def answer(name: str, value: float, status: Identification, source: str) -> ParameterEstimate:
    return ParameterEstimate(
        name, value, 0.01, value - 0.02, value + 0.02, status, "because", None, None, (source,)
    )


def test_one_estimator_speaks_for_itself() -> None:
    height = answer("cg_height_m", 0.6, "identified", "roll_map")
    verdict = combine([Estimate("roll_map", "ran", "fine", {"cg_height_m": height})], Vehicle())
    assert verdict["cg_height_m"] is height
    assert set(MISSING) <= set(verdict)


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
    assert (mass.value, mass.std, mass.status, mass.reference) == (1800, 36, "not_identifiable", 1850)
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
