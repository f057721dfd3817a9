"""Files that people write are read up to a size that none of them has."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from parsers.errors import CogestError
from parsers.mapping import read_map
from parsers.small_text import MOST_BYTES, read_small_text
from pipelines.fleet.belongings import read_vehicle_facts
from pipelines.fleet.find import find_drives
from pipelines.vehicles.vehicle_file import read_vehicle

LARGE = "# \n" * (MOST_BYTES // 3 + 1)


@pytest.mark.parametrize("read", [read_vehicle, read_map])
def test_a_large_file_is_a_known_error(read: Callable[[Path], object], tmp_path: Path) -> None:
    path = tmp_path / "file.toml"
    path.write_text(LARGE)
    with pytest.raises(CogestError, match="larger than"):
        read(path)


def test_a_fleet_says_which_one_is_too_large(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("time_s,speed_mps\n0,1\n1,2\n2,3\n")
    for name in ("vehicle.toml", "drive.toml"):
        (tmp_path / name).write_text(LARGE)
    assert "larger than" in read_vehicle_facts(str(tmp_path / "vehicle.toml")).problem
    (drive,) = find_drives(str(tmp_path)).drives
    assert sum("larger than" in lack for lack in drive.lacks) == 2


@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
def test_marks_and_line_ends_are_of_no_matter(ends: str, tmp_path: Path) -> None:
    path = tmp_path / "file.toml"
    path.write_bytes(f"\ufeffa = 1{ends}b = 2{ends}".encode())
    assert read_small_text(path) == "a = 1\nb = 2\n"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_a_pipe_is_refused_and_not_waited_for(tmp_path: Path) -> None:
    pipe = tmp_path / "map.toml"
    os.mkfifo(pipe)
    with pytest.raises(CogestError, match="no plain file"):
        read_map(pipe)
