"""What a single method makes of a drive, against the masses and lengths in the vehicle file."""

from __future__ import annotations

import pytest

from pipelines.estimators.against_file import held_against
from pipelines.results import Estimate, Identification, ParameterEstimate
from pipelines.vehicles.vehicle import Quantity, Vehicle

CAR = Vehicle(
    body="Passenger Car",
    quantities={"mass_kg": Quantity(1500.0, 20.0, "sheet"), "wheelbase_m": Quantity(2.7, 0.01, "sheet")},
)


def _estimate(status: Identification = "identified", **values: tuple[float, float]) -> Estimate:
    told = {
        name: ParameterEstimate(name, value, std, value - 1.96 * std, value + 1.96 * std, status, "as read")
        for name, (value, std) in values.items()
    }
    return Estimate("a_method", "ok", "", told)


@pytest.mark.parametrize(
    ("name", "value", "std"),
    [
        ("mass_kg", 194.0, 2.0), ("mass_kg", 953.0, 10.0), ("mass_kg", 4000.0, 50.0), ("sprung_mass_kg", 235.0, 5.0),
        ("corner_mass_fl_kg", 4000.0, 30.0), ("corner_mass_rr_kg", 30.0, 2.0), ("cg_to_front_axle_m", 3.4, 0.1),
        ("cg_to_front_axle_m", -0.3, 0.02),
    ],
)  # fmt: skip
def test_no_such_vehicle_makes_everything_weak_that_hangs_on_a_scale(
    name: str, value: float, std: float
) -> None:
    estimate = _estimate(
        **{name: (value, std)}, roll_inertia_kgm2=(267.0, 4.0), roll_gradient_degpg=(5.0, 0.1)
    )
    held = held_against(estimate, CAR).parameters
    for told in (name, "roll_inertia_kgm2"):
        assert held[told].status == "weak"
        assert held[told].refused
        assert held[told].reason.startswith(
            f"{name} {value:.0f} kg" if name.endswith("kg") else f"{name} {value:.2f} m"
        )
        assert held[told].reason.endswith("as read")
        assert (held[told].value, held[told].std) == (
            estimate.parameters[told].value,
            estimate.parameters[told].std,
        )
    # an angle a lateral acceleration holds no force
    assert held["roll_gradient_degpg"].status == "identified"


@pytest.mark.parametrize(
    ("name", "value", "std"),
    [
        ("mass_kg", 1500.0, 5.0), ("mass_kg", 1420.0, 5.0), ("mass_kg", 2300.0, 10.0), ("mass_kg", 900.0, 150.0),
        ("sprung_mass_kg", 1100.0, 5.0), ("corner_mass_fl_kg", 700.0, 10.0), ("corner_mass_rl_kg", 200.0, 5.0),
        ("cg_to_front_axle_m", 2.0, 0.01), ("cg_to_front_axle_m", 2.9, 0.1),
    ],
)  # fmt: skip
def test_what_may_be_stays(name: str, value: float, std: float) -> None:
    estimate = _estimate(**{name: (value, std)}, roll_inertia_kgm2=(500.0, 4.0))
    assert held_against(estimate, CAR) is estimate


def test_what_is_not_told_contradicts_nothing_and_stays_untold() -> None:
    estimate = _estimate("not_identifiable", mass_kg=(194.0, 2.0))
    assert held_against(estimate, CAR) is estimate
    both = (
        _estimate(sprung_mass_kg=(235.0, 5.0)).parameters
        | _estimate("not_identifiable", cg_height_m=(0.5, 0.1)).parameters
    )
    held = held_against(Estimate("a_method", "ok", "", both), CAR)
    assert held.parameters["cg_height_m"] is both["cg_height_m"]


def test_a_file_without_a_mass_limits_no_mass() -> None:
    estimate = _estimate(mass_kg=(194.0, 2.0))
    assert held_against(estimate, Vehicle()) is estimate
