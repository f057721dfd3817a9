"""The map file: back to the same record, and refusals that name the place and the right key."""

from __future__ import annotations

import random
import re
from pathlib import Path

import numpy as np
import pytest

from parsers.errors import CogestError, VehicleError
from parsers.signals import WHEELS
from pipelines.suspension_mapping.file import MOST_BYTES, map_text, read_map_text, read_suspension_map
from pipelines.suspension_mapping.record import SuspensionMap
from pipelines.vehicles.vehicle_file import parse_vehicle, read_vehicle

FILE = Path("suspension.toml")


@pytest.fixture(scope="module")
def text(suspension_map: SuspensionMap) -> str:
    return map_text(suspension_map)


def test_there_and_back(suspension_map: SuspensionMap, text: str) -> None:
    back = read_map_text(text, FILE)
    assert (back.vehicle, back.training, back.shape) == (
        suspension_map.vehicle, suspension_map.training, suspension_map.shape
    )  # fmt: skip
    for kind, part in suspension_map.parts.items():
        assert back.parts[kind].form == part.form
        for wheel in WHEELS:
            one, two = part.wheels[wheel], back.parts[kind].wheels[wheel]
            assert list(one.coefficients) == list(two.coefficients)
            assert list(two.coefficients.values()) == pytest.approx(list(one.coefficients.values()), rel=1e-9)
            assert np.allclose(two.covariance, one.covariance, rtol=1e-9)
            assert two.seen["carried" if kind == "struts" else "deflection"].low == pytest.approx(
                one.seen["carried" if kind == "struts" else "deflection"].low, rel=1e-9
            )
    assert map_text(back) == text


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("format = 1", "format = 7", "format 7, this cogest reads 1"),
        ("band_hz", "bandhz", "'band_hz' is missing.*'bandhz'"),
        ("track_m", "note = 1\ntrack_m", "unknown key 'note'"),
        ("friction_travel_m = ", "friction_travel_m = -", "expected 1e-05 to 0.1"),
        ("[struts]", "[strut]\n[struts]", r"unknown key 'strut'; did you mean 'struts'"),
        ('unit = "kg"', 'unit = "lb"', "found 'lb', expected 'kg'"),
        ("own_lateral = {", "own_latteral = {", "unknown key 'own_latteral'; did you mean 'own_lateral'"),
        ("factor = ", "factor = 1000", "expected 0.1 to 10"),
        ("carried_n = ", "carried_n = nan #", "expected a finite number"),
        ("covariance = [\n", "covariance = [\n  [1.0],\n", "covariance"),
        ('sha256 = "00', 'sha256 = "zz', "64 hexadecimal digits"),
        ("[suspension_map]", "[suspension_map", "not valid TOML"),
        ("[suspension_map]", "[map]", "no suspension map"),
        ("spread = {constant = ", "spread = {constant = -", "constant.*expected 0"),
    ],
)
def test_refuses(text: str, old: str, new: str, words: str) -> None:
    assert old in text
    with pytest.raises(VehicleError, match=words) as caught:
        read_map_text(text.replace(old, new, 1), FILE)
    assert str(FILE) in str(caught.value)


def test_a_covariance_that_is_none_is_refused(text: str) -> None:
    start = text.index("covariance = [\n") + len("covariance = [\n")
    end = text.index("]", start)
    with pytest.raises(VehicleError, match="not positive"):
        read_map_text(text[:start] + "  [-1.0" + text[end:], FILE)


def test_hostile_names_stay_text(suspension_map: SuspensionMap) -> None:
    from dataclasses import replace

    hostile = replace(suspension_map, vehicle='a"\n[struts]\x1b[31m\ud800')
    back = read_map_text(map_text(hostile), FILE)
    assert "\n" not in back.vehicle
    assert "\x1b" not in back.vehicle


def test_any_damage_is_a_known_error_or_still_a_map(text: str) -> None:
    draw = random.Random(5)
    refused = 0
    for _ in range(150):
        place = draw.randrange(len(text))
        cut = draw.choice((0, 1, 5, 400))
        damaged = text[:place] + draw.choice(("", "x", "9", "=", "[", "nan", "\x00")) + text[place + cut :]
        try:
            read_map_text(damaged, FILE)
        except CogestError:
            refused += 1
    assert refused > 60


def test_too_large_or_absent(tmp_path: Path) -> None:
    big = tmp_path / "big.toml"
    big.write_bytes(b"#" * (MOST_BYTES + 1))
    with pytest.raises(VehicleError, match="larger than"):
        read_suspension_map(big)
    with pytest.raises(VehicleError, match="cannot be read"):
        read_suspension_map(tmp_path / "none.toml")


def test_the_vehicle_file_names_it(tmp_path: Path, text: str) -> None:
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "s.toml").write_text(text, encoding="utf-8")
    file = tmp_path / "vehicle.toml"
    file.write_text('[vehicle]\nmass_kg = 2000\nsuspension_map = "maps/s.toml"\n', encoding="utf-8")
    vehicle = read_vehicle(file)
    assert vehicle.suspension_map is not None
    assert vehicle.suspension_map_path == tmp_path / "maps" / "s.toml"
    assert read_vehicle(file, with_map=False).suspension_map is None
    with pytest.raises(VehicleError, match=re.escape("[vehicle] suspension_map")):
        parse_vehicle('[vehicle]\nsuspension_map = " "\n', file)
    with pytest.raises(VehicleError, match="did you mean 'suspension_map'"):
        parse_vehicle('[vehicle]\nsuspensionmap = "x"\n', file)
