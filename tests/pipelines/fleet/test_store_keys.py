"""Keys: content counts, places and times do not; what did not change is not read again."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest

from parsers import places
from parsers.errors import LogError
from parsers.places_text import FileFacts
from pipelines.fleet import keys
from pipelines.fleet.keys import Keys, key_of
from pipelines.fleet.records import Choices, Facts, FoundDrive
from tests.pipelines.fleet.stored_drives import found_drive

LONG_AGO = 1_700_000_000_000_000_000
CHOICES = Choices(version="1.0")


def write(path: Path, content: str, when: int = LONG_AGO) -> str:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content)
    os.utime(path, ns=(when, when))
    return str(path)


@pytest.fixture
def drive(tmp_path: Path) -> FoundDrive:
    """A drive with one of everything; its vehicle file names a suspension map."""
    return replace(
        found_drive(1),
        logs=(write(tmp_path / "v/a.csv", "log a"), write(tmp_path / "v/b.csv", "log b")),
        vehicle=write(tmp_path / "vehicle.toml", '[vehicle]\nsuspension_map = "maps/s.toml"\n'),
        map=write(tmp_path / "map.toml", "map"),
        settings=write(tmp_path / "settings.toml", "settings"),
        dbc=(write(tmp_path / "v/one.dbc", "dbc"),),
    )


def key(drive: FoundDrive, seen: Mapping[str, Facts] | None = None) -> str:
    return key_of(drive, CHOICES, seen or {})[0]


@pytest.fixture
def reads(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The places whose content was hashed."""
    read: list[str] = []
    hashed = keys._hashed

    def watched(stat: keys._Stat) -> str:
        read.extend(Path(place).name for _, place in stat.files)
        return hashed(stat)

    monkeypatch.setattr(keys, "_hashed", watched)
    return read


@pytest.mark.parametrize(
    "name", ["v/a.csv", "v/b.csv", "vehicle.toml", "map.toml", "settings.toml", "v/one.dbc"]
)
def test_every_input_counts(drive: FoundDrive, tmp_path: Path, name: str) -> None:
    first, seen = key_of(drive, CHOICES, {})
    text = (tmp_path / name).read_text()
    write(tmp_path / name, text + " ", LONG_AGO + 1)
    assert key(drive, seen) != first
    write(tmp_path / name, text, LONG_AGO + 2)
    assert key(drive, seen) == first


def test_the_suspension_map_that_the_vehicle_file_names_counts(drive: FoundDrive, tmp_path: Path) -> None:
    absent = key(drive)
    write(tmp_path / "maps/s.toml", "map 1")
    first = key(drive)
    write(tmp_path / "maps/s.toml", "map 2")
    assert len({absent, first, key(drive)}) == 3


@pytest.mark.parametrize("text", ["\ufeff{}", "# made by hand\r{}"], ids=["byte order mark", "old line ends"])
def test_the_suspension_map_counts_however_the_vehicle_file_was_saved(
    drive: FoundDrive, tmp_path: Path, text: str
) -> None:
    saved = text.format('[vehicle]\nsuspension_map = "maps/s.toml"\n').encode()
    (tmp_path / "vehicle.toml").write_bytes(saved)
    write(tmp_path / "maps/s.toml", "map 1")
    first = key(drive)
    write(tmp_path / "maps/s.toml", "map 2")
    assert key(drive) != first


@pytest.mark.parametrize(
    "other", [{"estimators": "roll_map"}, {"seed": 1}, {"fix": False}, {"version": "1.1"}], ids=str
)
def test_choices_count(drive: FoundDrive, other: dict[str, object]) -> None:
    assert key_of(drive, replace(CHOICES, **other), {})[0] != key(drive)  # type: ignore[arg-type]


def test_what_does_not_change_results_does_not_count(drive: FoundDrive, tmp_path: Path) -> None:
    moved = tmp_path / "elsewhere"
    names = {"map": drive.map, "vehicle": drive.vehicle, "settings": drive.settings}
    there = {
        what: write(moved / Path(str(place)).name, Path(str(place)).read_text())
        for what, place in names.items()
    }
    logs = tuple(
        write(moved / Path(place).name, Path(place).read_text(), LONG_AGO + 5) for place in drive.logs
    )
    other = replace(drive, logs=logs, name="other", notes=("x",), **there)  # type: ignore[arg-type]
    assert key(other) == key(drive)
    assert key_of(drive, replace(CHOICES, formats=("html", "pdf")), {})[0] == key(drive)
    one = key_of(drive, replace(CHOICES, estimators="a, b"), {})[0]
    assert one == key_of(drive, replace(CHOICES, estimators="a,b"), {})[0]


def test_which_log_comes_first_and_which_file_is_what_count(drive: FoundDrive) -> None:
    assert key(replace(drive, logs=drive.logs[::-1])) != key(drive)
    assert key(replace(drive, map=drive.settings, settings=drive.map)) != key(drive)
    assert key(replace(drive, vehicle=None)) != key(drive)


def test_unchanged_files_are_not_read_again(drive: FoundDrive, reads: list[str]) -> None:
    first, seen = key_of(drive, CHOICES, {})
    assert sorted(reads) == ["a.csv", "b.csv", "map.toml", "one.dbc", "settings.toml", "vehicle.toml"]
    reads.clear()
    assert key_of(drive, CHOICES, seen) == (first, seen)
    assert reads == []


def test_a_touched_file_is_read_and_keeps_its_key(drive: FoundDrive, reads: list[str]) -> None:
    first, seen = key_of(drive, CHOICES, {})
    os.utime(drive.logs[0], ns=(LONG_AGO + 9, LONG_AGO + 9))
    reads.clear()
    again, now = key_of(drive, CHOICES, seen)
    assert again == first
    assert reads == ["a.csv"]
    assert now != seen
    reads.clear()
    assert key_of(drive, CHOICES, now) == (first, now)
    assert reads == []


def test_a_file_just_written_is_not_believed(drive: FoundDrive, reads: list[str]) -> None:
    log = Path(drive.logs[0])
    write(log, "old 1", time.time_ns())
    first, seen = key_of(drive, CHOICES, {})
    stamp = log.stat().st_mtime_ns
    write(log, "new 2", stamp)
    assert key(drive, seen) != first
    assert "a.csv" in reads


def test_what_drives_share_is_read_once(drive: FoundDrive, tmp_path: Path, reads: list[str]) -> None:
    many = Keys(CHOICES)
    made = set()
    for number in range(3):
        log = write(tmp_path / f"{number}.csv", str(number))
        made.add(many.key_of(replace(drive, logs=(log,)), {})[0])
    assert len(made) == 3
    assert reads.count("vehicle.toml") == 1
    assert reads.count("one.dbc") == 1


def test_a_folder_is_a_log_too(drive: FoundDrive, tmp_path: Path, reads: list[str]) -> None:
    write(tmp_path / "bag/metadata.yaml", "m")
    write(tmp_path / "bag/part_0.db3", "p")
    bag = replace(drive, logs=(str(tmp_path / "bag"),))
    first, seen = key_of(bag, CHOICES, {})
    reads.clear()
    assert key(bag, seen) == first
    assert reads == []
    os.rename(tmp_path / "bag/part_0.db3", tmp_path / "bag/part_1.db3")
    renamed, seen = key_of(bag, CHOICES, seen)
    assert renamed != first
    write(tmp_path / "bag/part_2.db3", "")
    assert key(bag, seen) != renamed


def test_a_log_that_is_gone_is_an_error_of_that_drive(drive: FoundDrive) -> None:
    with pytest.raises(LogError, match="cannot be read"):
        key(replace(drive, logs=("/no/such/log.csv",)))


def test_an_etag_is_a_stamp(monkeypatch: pytest.MonkeyPatch, drive: FoundDrive, reads: list[str]) -> None:
    tag, drive = "one", replace(drive, vehicle=None)

    def facts(place: str) -> FileFacts:
        return FileFacts(place, 5, None, tag)

    first, seen = key_of(drive, CHOICES, {})
    monkeypatch.setattr(places, "facts", facts)
    _, seen = key_of(drive, CHOICES, seen)
    reads.clear()
    assert key(drive, seen) == first
    assert reads == []
    tag = "two"
    assert key(drive, seen) == first
    assert "a.csv" in reads


def test_thousands_of_unchanged_drives_share_a_key(drive: FoundDrive, tmp_path: Path) -> None:
    drives = [replace(drive, logs=(write(tmp_path / f"logs/{n}.csv", "x"),)) for n in range(2000)]
    many, seen = Keys(CHOICES), {}
    for one in drives:
        seen.update(many.key_of(one, {})[1])
    again = Keys(CHOICES)
    made = {again.key_of(one, seen)[0] for one in drives}
    assert len(made) == 1
