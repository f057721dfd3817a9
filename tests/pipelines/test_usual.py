"""What is taken for usual where a vehicle file is silent: by kind of vehicle and by its size."""

from __future__ import annotations

import pytest

from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.vehicles.usual import (
    usual_drag,
    usual_radius,
    usual_roll_center,
    usual_unsprung,
    usual_unsprung_share,
    usual_wheel_inertia,
)
from pipelines.vehicles.vehicle import Quantity, Vehicle


def vehicle(body: str | None, kilos: float) -> Vehicle:
    return Vehicle("test", body, {"mass_kg": Quantity(kilos, 0.02 * kilos, "test")})


def held(value: float, spread: tuple[float, float], by: float = 2.0) -> bool:
    return abs(value - spread[0]) < by * spread[1]


@pytest.mark.parametrize(
    ("body", "kilos", "radius_m"),
    [
        # 155/65 R14, 205/55 R16, 235/60 R18, 265/70 R17, 195/75 R16 C, 17.5", 22.5" and 22.5" wheels, rolling
        ("Hatchback", 950.0, 0.275),
        ("Sedan", 1500.0, 0.308),
        ("SUV", 1950.0, 0.36),
        ("Pickup", 2250.0, 0.40),
        ("Van", 2000.0, 0.34),
        ("Motorhome", 3300.0, 0.355),
        ("Truck", 4300.0, 0.38),
        ("Truck", 8500.0, 0.50),
        ("Bus", 11500.0, 0.48),
    ],
)
def test_wheels_are_as_large_as_the_vehicle_asks(body: str, kilos: float, radius_m: float) -> None:
    assert held(radius_m, usual_radius(vehicle(body, kilos)), 1.5)


def test_axles_of_lorries_weigh_what_they_do() -> None:
    """Steer axle 700 kg, drive axle with twin tyres 1 150 kg of an 18 t lorry; a rear-driven van's live axle 200 kg; a car's 75 kg."""
    lorry, van, car = vehicle("Truck", 8500.0), vehicle("Van", 2150.0), vehicle("Sedan", 1500.0)
    assert held(700.0, usual_unsprung(lorry, "front", 8500.0))
    assert held(1150.0, usual_unsprung(lorry, "rear", 8500.0))
    assert held(200.0, usual_unsprung(van, "rear", 2150.0))
    assert held(75.0, usual_unsprung(car, "rear", 1500.0))
    assert not held(75.0 / 1500.0 * 8500.0, usual_unsprung(lorry, "rear", 8500.0))
    assert usual_unsprung_share(lorry)[0] > 1.7 * usual_unsprung_share(car)[0]


def test_lorries_roll_about_their_springs_and_push_more_air() -> None:
    lorry, car, camper = vehicle("Truck", 8500.0), vehicle("Sedan", 1500.0), vehicle("Motorhome", 3000.0)
    assert usual_roll_center(lorry, "front", False)[0] > 0.35 > usual_roll_center(car, "front", False)[0]
    assert usual_roll_center(lorry, "rear", True)[0] > 0.5
    assert held(5.5, usual_drag(lorry))
    assert held(0.66, usual_drag(car))
    assert held(3.0, usual_drag(camper))
    assert usual_wheel_inertia(lorry, 0.5)[0] > 5 * usual_wheel_inertia(car, 0.33)[0]


def test_the_unknowns_are_of_them() -> None:
    known = before_the_log(vehicle("Truck", 8500.0))
    for name, spread in (
        ("radius", usual_radius(vehicle("Truck", 8500.0))),
        ("unsprung_rear", usual_unsprung(vehicle("Truck", 8500.0), "rear", 8500.0)),
        ("drag", usual_drag(vehicle("Truck", 8500.0))),
    ):
        row = known.index(name)
        assert (known.mean[row], known.std[row]) == pytest.approx(spread)
