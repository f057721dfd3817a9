"""A CG where no measured vehicle of the body style has it is no answer to be sure of."""

from __future__ import annotations

import pytest

from pipelines.results import ParameterEstimate
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.verdict.beyond import beyond_measured

MASS = {"mass_kg": Quantity(3760, 38, "vehicle file")}


def answers(height: float, std: float) -> dict[str, ParameterEstimate]:
    return {
        "cg_height_m": ParameterEstimate("cg_height_m", height, std, height - 2 * std, height + 2 * std, "identified", "told"),
        "mass_kg": ParameterEstimate("mass_kg", 3700.0, 100.0, 3504.0, 3896.0, "identified", "told"),
        "roll_gradient_degpg": ParameterEstimate("roll_gradient_degpg", 6.0, 1.0, 4.0, 8.0, "weak", "told"),
    }  # fmt: skip


@pytest.mark.parametrize(
    ("body", "height", "std", "sure"),
    [
        ("SUV", 0.40, 0.02, False),
        ("SUV", 0.40, 0.20, True),
        ("SUV", 0.66, 0.02, True),
        ("SUV", 1.00, 0.02, True),
        ("SUV", 1.25, 0.02, False),
        ("Sedan", 0.46, 0.01, True),
        ("Convertible", 0.30, 0.01, True),
        ("city bus", 0.30, 0.01, True),
        (None, 0.30, 0.01, True),
    ],
)
def test_what_no_measured_vehicle_is_like(body: str | None, height: float, std: float, sure: bool) -> None:
    """Not asked of bodies that nobody, or hardly anybody, has measured, nor where the interval reaches those that were."""
    found = beyond_measured(answers(height, std), Vehicle(body=body, quantities=MASS))
    assert found["mass_kg"].status == ("identified" if sure else "weak")
    assert found["cg_height_m"].status == ("identified" if sure else "weak")
    assert found["roll_gradient_degpg"].reason == "told"
    assert ("no measured" in found["mass_kg"].reason) is not sure
    assert found["cg_height_m"].value == height
    # one that was weak already stays no more when drives are joined
    for entry in found.values():
        assert bool(entry.refused) is not sure
        assert (
            entry.status != "weak"
            or sure
            or entry.name == "roll_gradient_degpg"
            or entry.reason.startswith(entry.refused)
        )


@pytest.mark.parametrize(
    ("body", "front", "place", "sure"),
    [
        ("Hatchback", 1.0, 1.60, False),
        ("Hatchback", 1.0, 1.30, True),
        ("Hatchback", 0.0, 1.60, True),
        ("Hatchback", None, 1.60, True),
        ("Van", 1.0, 1.60, True),
    ],
)
def test_a_front_driven_car_with_its_weight_behind(
    body: str, front: float | None, place: float, sure: bool
) -> None:
    """Its file has the CG's place from the rear axle: what that goes into is weak, and nothing else."""
    told = {
        name: ParameterEstimate(name, 1.0, 0.01, 0.98, 1.02, "identified", "told")
        for name in ("cg_to_front_axle_m", "corner_mass_rl_kg", "mass_kg")
    }
    figures = {"cg_to_front_axle_m": place, "wheelbase_m": 2.6, "drive_front_share": front}
    quantities = {
        key: Quantity(value, 0.01, "vehicle file") for key, value in figures.items() if value is not None
    }
    found = beyond_measured(told, Vehicle(body=body, quantities=quantities))
    for name in ("cg_to_front_axle_m", "corner_mass_rl_kg"):
        assert found[name].status == ("identified" if sure else "weak")
        assert ("from the rear axle" in found[name].reason) is not sure
    assert found["mass_kg"].status == "identified"


def test_intervals_are_nested() -> None:
    """To each side by its own reach: one that ends at nought holds the narrower ones."""
    skew = ParameterEstimate("x", 1.0, 2.0, 0.2, 6.0, "weak", "")
    half, most, all_of_it = skew.interval(0.5), skew.interval(0.8), skew.interval(0.95)
    assert half is not None
    assert most is not None
    assert all_of_it == (0.2, 6.0)
    assert 0.2 < most[0] < half[0] < 1.0 < half[1] < most[1] < 6.0
    even = ParameterEstimate("x", 1.0, 0.5, 1 - 1.959964 * 0.5, 1 + 1.959964 * 0.5, "weak", "")
    assert even.interval(0.5) == pytest.approx((1 - 0.33724, 1 + 0.33724), abs=1e-4)
    inner = ParameterEstimate("x", 1.0, 0.5, 0.9, 1.2, "weak", "", inner=((0.8, 1.1), (0.7, 1.3)))
    assert inner.interval(0.8) == (0.9, 1.2)
