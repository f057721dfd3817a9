"""Figures of a vehicle file in the wrong unit are refused, with the span and the unit that the key has."""

from __future__ import annotations

from pathlib import Path

import pytest

from parsers.errors import VehicleError
from pipelines.vehicles.keys import LOAD_KEYS, SENSOR_KEYS, SHARES, TRAILER_KEYS, VEHICLE_KEYS, ZERO_OR_MORE
from pipelines.vehicles.plausible import SPANS
from pipelines.vehicles.vehicle_file import parse_vehicle

FILE = Path("car.toml")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[vehicle]\nwheelbase_m = 2550", ("[vehicle] wheelbase_m", "found 2550", "0.1 to 20", "not in mm")),
        ("[vehicle]\ncg_height_m = 56", ("cg_height_m", "not in mm or cm")),
        ('[vehicle]\nbody = "SUV"\nmass_kg = 18673', ("mass_kg", "found 18673", "body SUV", "5500 kg")),
        ('[vehicle]\nbody = "van"\nmass_kg = 21000', ("mass_kg", "body Van", "a lorry's body")),
        ("[vehicle]\nmass_kg = 1e30", ("mass_kg", "5 to 200000")),
        ("[vehicle]\nspring_rate_front_npm = 28", ("spring_rate_front_npm", "not in N/mm")),
        ("[vehicle]\nmass_kg = 1500\nspring_rate_rear_npm = 150", ("would sink", "not in N/mm")),
        ("[vehicle]\nmass_kg = 1500\nanti_roll_stiffness_front_nmprad = 450", ("so thin", "not per degree")),
        (
            "[vehicle]\nmass_kg = 1900\ntrack_front_m = 1.6\nroll_inertia_kgm2 = 84",
            ("radius of gyration of 0.21 m", "kg·m²"),
        ),
        (
            "[vehicle]\nmass_kg = 1900\nwheelbase_m = 2.8\npitch_inertia_kgm2 = 29000",
            ("radius of gyration", "kg·m²"),
        ),
        ("[vehicle]\nmass_kg = 1900\nroll_damping_nmsprad = 84", ("stop rocking", "not per degree")),
        ("[vehicle]\nmass_kg = 1355\nroll_stiffness_nmprad = 1082", ("would fall over", "not per degree")),
        (
            "[vehicle]\ntire_vertical_rate_npm = 250",
            ("tire_vertical_rate_npm", "1000 to 1e+12", "not in N/mm"),
        ),
        ("[vehicle]\nrolling_resistance = 1.2", ("rolling_resistance", "not in %")),
        ("[vehicle]\nbrake_gain_nmppa = 40", ("brake_gain_nmppa", "not per bar")),
        ("[sensors]\nimu_above_ground_m = 650", ("[sensors] imu_above_ground_m", "not in mm")),
        ("[load]\nheight_m = 75", ("[load] height_m", "expected 0 to 8")),
        ("[vehicle]\nwheelbase_m = 2.7\ntrack_rear_m = 0.78", ("track_rear_m", "not half of it")),
        (
            "[vehicle]\nmass_kg = {value = 1800, std = 5000}",
            ("mass_kg", "std 5000 is not less than the value 1800"),
        ),
        ("[vehicle]\nmass_kg = 1800\n[load]\nmass_kg = 50000", ("[load] mass_kg", "3 times its own mass")),
        (
            "[vehicle]\ncg_height_m = 0.69\nroll_center_height_front_m = 0.9\nroll_center_height_rear_m = 0.9",
            ("roll_center_height_rear_m", "hangs under its roll axis"),
        ),
        ("mass_kg = 1500", ("write [vehicle] on a line above it",)),
    ],
)
def test_other_units_are_refused(text: str, words: tuple[str, ...]) -> None:
    with pytest.raises(VehicleError) as refused:
        parse_vehicle(text, FILE)
    assert all(word in str(refused.value) for word in ("car.toml", *words))


@pytest.mark.parametrize(
    "text",
    [
        "mass_kg = 50\nwheelbase_m = 0.51\ntrack_front_m = 0.55\nwheel_radius_m = 0.16",
        "mass_kg = 160\nwheelbase_m = 1.05\nroll_stiffness_nmprad = 5000\nspring_rate_front_npm = 5e5",
        "mass_kg = 1900\nwheelbase_m = 2.1\ntrack_front_m = 0.85",
        "mass_kg = 40000\nwheelbase_m = 6\nspring_rate_rear_npm = 900000\nroll_stiffness_nmprad = 2e6",
        "roll_center_height_front_m = -0.05\ncg_lateral_offset_m = -0.01\nanti_roll_stiffness_front_nmprad = 0",
    ],
)
def test_robots_karts_and_trucks_are_vehicles(text: str) -> None:
    vehicle = parse_vehicle(f"[vehicle]\n{text}\n[load]\nmass_kg = 0", FILE)
    assert len(vehicle.quantities) >= 3


def test_every_key_has_a_span() -> None:
    keys = VEHICLE_KEYS - SHARES
    for table, known in (("load", LOAD_KEYS), ("sensors", SENSOR_KEYS), ("trailer", TRAILER_KEYS)):
        keys |= {f"{table}.{key}" for key in known}
    assert set(SPANS) == keys
    assert all(low < high for low, high, _ in SPANS.values())


@pytest.mark.parametrize("key", sorted(ZERO_OR_MORE))
def test_none_at_all_is_no_mistaken_unit(key: str) -> None:
    stated = parse_vehicle(f"[vehicle]\n{key} = 0", FILE).get(key)
    assert stated is not None
    assert (stated.value, stated.std) == (0.0, 0.0)
    with pytest.raises(VehicleError, match="expected 0 or more"):
        parse_vehicle(f"[vehicle]\n{key} = -1", FILE)
