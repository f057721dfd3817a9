"""The vehicle file: what it says, and how it says no."""

from __future__ import annotations

from pathlib import Path

import pytest

from parsers.errors import VehicleError
from pipelines.vehicles.vehicle_file import parse_vehicle, read_vehicle

FILE = Path("car.toml")


def test_numbers_and_spreads() -> None:
    vehicle = parse_vehicle(
        """
        [vehicle]
        name = "Test car"
        body = "Sedan"
        mass_kg = 1500
        cg_height_m = {value = 0.55, std = 0.01}
        [load]
        mass_kg = {value = 150, std = 10}
        [trailer]
        mass_kg = 750
        [sensors]
        imu_above_ground_m = 0.6
        [reference]
        cg_height_m = 0.571
        """,
        FILE,
    )
    mass, height = vehicle.get("mass_kg"), vehicle.get("cg_height_m")
    assert mass is not None
    assert (mass.value, mass.std, mass.std_stated) == (1500, pytest.approx(30), False)
    assert height is not None
    assert (height.value, height.std, height.std_stated) == (0.55, 0.01, True)
    assert vehicle.load["mass_kg"].std == 10
    assert (vehicle.trailer["mass_kg"].value, vehicle.trailer["mass_kg"].std) == (750, pytest.approx(15))
    assert vehicle.reference == {"cg_height_m": 0.571}
    assert vehicle.load_stated
    assert vehicle.get("roll_stiffness_nmprad") is None


@pytest.mark.parametrize(
    ("text", "fragments"),
    [
        ("[vehicle]\nmas_kg = 1500", ["mas_kg", "did you mean 'mass_kg'"]),
        ("[vehicle]\nmass_kg = -3", ["[vehicle] mass_kg", "more than 0"]),
        ("[vehicle]\nmass_kg = '1500'", ["'1500'", "finite number"]),
        ("[vehicle]\nmass_kg = nan", ["finite number"]),
        ("[vehicle]\nmass_kg = true", ["finite number"]),
        ("[vehicle]\nmass_kg = {value = 1500, sd = 3}", ["sd"]),
        ("[vehicle]\nmass_kg = {std = 3}", ["no `value`"]),
        ("[vehicle]\nmass_kg = {value = 1500, std = -1}", ["0 or more"]),
        ("[vehicle]\nname = 3", ["expected text"]),
        ("[vehicle]\nbody = 'Hatchbak'", ["'Hatchbak'", "did you mean 'Hatchback'"]),
        ("[vehicle]\nbody = 'Convertable'", ["did you mean 'Convertible'"]),
        ("[vehicl]\nmass_kg = 1", ["vehicl", "did you mean 'vehicle'"]),
        ("vehicle = 3", ["no table"]),
        ("[vehicle", ["not valid TOML"]),
        ("[trailer]\nmass_kg = -1", ["[trailer] mass_kg", "0 or more"]),
        ("[trailer]\nheight_m = 1", ["unknown key 'height_m'", "[trailer]"]),
        ("[reference]\ncg_hight_m = 0.5", ["did you mean 'cg_height_m'"]),
        ("[vehicle]\nbrake_front_share = 1.2", ["share from 0 to 1"]),
        (
            "[vehicle]\nmass_kg = 1867\nunsprung_mass_front_kg = 900\nunsprung_mass_rear_kg = 10",
            ["910 kg", "45%"],
        ),
        ("[vehicle]\nmass_kg = 100\nunsprung_mass_front_kg = 60\nunsprung_mass_rear_kg = 60", ["120 kg"]),
        ("[vehicle]\nwheelbase_m = 2.5\ncg_to_front_axle_m = 2.6", ["wheelbase"]),
    ],
)
def test_errors_name_the_place_and_the_next_step(text: str, fragments: list[str]) -> None:
    with pytest.raises(VehicleError) as caught:
        parse_vehicle(text, FILE)
    for fragment in ["car.toml", *fragments]:
        assert fragment in str(caught.value)


def test_an_empty_load_may_be_stated() -> None:
    vehicle = parse_vehicle("[load]\nmass_kg = {value = 0, std = 0}\nheight_m = 0", FILE)
    assert vehicle.load["mass_kg"].value == 0
    with pytest.raises(VehicleError, match=r"0 or more|more than 0"):
        parse_vehicle("[load]\nmass_kg = -1", FILE)


def test_unreadable_files(tmp_path: Path) -> None:
    with pytest.raises(VehicleError, match="cannot be read"):
        read_vehicle(tmp_path / "absent.toml")
    latin = tmp_path / "latin.toml"
    latin.write_bytes(b'[vehicle]\nname = "Citro\xebn"\n')
    with pytest.raises(VehicleError, match="not UTF-8"):
        read_vehicle(latin)
