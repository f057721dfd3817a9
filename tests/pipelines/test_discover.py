"""Files that belong to a log are found where they may lie, and nothing stops the search."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipelines.discover import databases_beside, nearest


@pytest.fixture
def log(tmp_path):
    folder = tmp_path / "fleet" / "car"
    folder.mkdir(parents=True)
    path = folder / "drive.csv"
    path.touch()
    return path


def test_the_nearest_file_up_the_folders(log):
    assert nearest("vehicle.toml", log) is None
    far, near = log.parent.parent / "vehicle.toml", log.parent / "vehicle.toml"
    far.touch()
    assert nearest("vehicle.toml", log) == far
    near.touch()
    assert nearest("vehicle.toml", log) == near


def test_a_file_of_the_logs_own_goes_first(log):
    (log.parent / "vehicle.toml").touch()
    (log.parent / "other.vehicle.toml").touch()
    assert nearest("vehicle.toml", log) == log.parent / "vehicle.toml"
    own = log.parent / f"{log.stem}.vehicle.toml"
    own.touch()
    assert nearest("vehicle.toml", log) == own
    assert nearest("map.toml", log) is None


def test_a_log_that_is_a_folder_may_hold_its_own(log):
    bag = log.parent / "bag"
    bag.mkdir()
    (log.parent / "vehicle.toml").touch()
    assert nearest("vehicle.toml", bag) == log.parent / "vehicle.toml"
    (bag / "vehicle.toml").touch()
    assert nearest("vehicle.toml", bag) == bag / "vehicle.toml"
    (bag / "b.dbc").touch()
    (log.parent / "a.dbc").touch()
    assert databases_beside(bag) == (bag / "b.dbc", log.parent / "a.dbc")


def test_a_folder_of_that_name_is_no_file(log):
    (log.parent / "vehicle.toml").mkdir()
    (log.parent / "x.dbc").mkdir()
    assert nearest("vehicle.toml", log) is None
    assert databases_beside(log) == ()


def test_databases_by_name_whatever_their_case(log):
    for name in ("b.dbc", "A.DBC", "c.txt"):
        (log.parent / name).touch()
    (log.parent.parent / "above.dbc").touch()
    assert [path.name for path in databases_beside(log)] == ["A.DBC", "b.dbc"]


def test_a_log_is_looked_up_where_a_link_leads(log, tmp_path):
    (log.parent / "vehicle.toml").touch()
    link = tmp_path / "link.csv"
    link.symlink_to(log)
    assert nearest("vehicle.toml", link) == log.parent / "vehicle.toml"


def test_what_is_not_there_has_nothing_beside_it(tmp_path):
    loop = tmp_path / "loop"
    loop.symlink_to(loop)
    for path in (tmp_path / "none" / "deep" / "x.csv", loop, tmp_path / ("n" * 400)):
        assert nearest("vehicle.toml", path) is None
        assert databases_beside(path) == ()


def test_the_root_folder_has_no_file_of_its_own():
    root = Path(Path.cwd().anchor)
    assert nearest("vehicle.toml-that-nobody-has", root) is None


def test_another_programs_settings_above_the_log_are_passed_over(tmp_path: Path) -> None:
    """Many programs keep a settings.toml: one above the log's folder counts where it names an estimator, or cannot be read."""
    log = tmp_path / "trips" / "may" / "drive.csv"
    log.parent.mkdir(parents=True)
    log.write_text("t\n", encoding="utf-8")
    theirs, ours = tmp_path / "trips" / "settings.toml", tmp_path / "settings.toml"
    theirs.write_text("[default]\ndebug = true\n", encoding="utf-8")
    assert nearest("settings.toml", log) is None
    ours.write_text("[roll_map]\ncutoff_hz = 6\n", encoding="utf-8")
    assert nearest("settings.toml", log) == ours
    theirs.write_text("[roll_map\n", encoding="utf-8")
    assert nearest("settings.toml", log) == theirs
    # beside the log it is meant, and a wrong name in it is said
    here = log.parent / "settings.toml"
    here.write_text("[rollmap]\n", encoding="utf-8")
    assert nearest("settings.toml", log) == here
