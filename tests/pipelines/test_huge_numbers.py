"""Whole numbers that no float can hold, or that Python does not read, in the files that users write: known errors, no crash."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from parsers.errors import CogestError
from parsers.mapping import read_map
from pipelines.estimators.registry import estimators
from pipelines.fleet.belongings import read_vehicle_facts
from pipelines.fleet.drive_file import parse_drive_file
from pipelines.settings import read_settings
from pipelines.suspension_mapping.file import read_suspension_map
from pipelines.vehicles.vehicle_file import read_vehicle

READERS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "vehicle": ("[vehicle]\nmass_kg = {}\n", read_vehicle),
    "std": ("[vehicle]\nmass_kg = {{value = 1500, std = {}}}\n", read_vehicle),
    "map": ('[signals.speed]\nchannel = "a"\nscale = {}\n', read_map),
    "settings": ("[roll_map]\ncutoff_hz = {}\n", lambda path: read_settings(path, estimators())),
    "suspension map": ("[suspension_map]\nformat = {}\nband_hz = {}\n", read_suspension_map),
    "drive": ('logs = ["a"]\nstart_utc = {}\n', lambda path: parse_drive_file(path.read_text(), str(path))),
}


@pytest.mark.parametrize("digits", [400, 5000])
@pytest.mark.parametrize("kind", READERS)
def test_a_huge_number_is_a_known_error(kind: str, digits: int, tmp_path: Path) -> None:
    text, read = READERS[kind]
    path = tmp_path / "file.toml"
    path.write_text(text.format("1" * digits, "1" * digits))
    with pytest.raises(CogestError):
        read(path)


@pytest.mark.parametrize("digits", [400, 5000])
def test_a_vehicle_file_with_one_costs_its_own_drives(digits: int, tmp_path: Path) -> None:
    path = tmp_path / "vehicle.toml"
    path.write_text(f"[vehicle]\nmass_kg = {'1' * digits}\n")
    assert read_vehicle_facts(str(path)).problem
