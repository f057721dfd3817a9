"""drive.toml: what can be said, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pipelines.fleet.drive_file import DriveFileError, parse_drive_file


def test_one_drive_and_several():
    said = parse_drive_file(
        'logs = ["can.blf", "gps/a.vbo"]\nstart_utc = 2024-05-01T12:00:00+02:00\n', "drive.toml"
    )
    assert said.drives[0].logs == ("can.blf", "gps/a.vbo")
    assert said.drives[0].start_utc == "2024-05-01T10:00:00.000+00:00"
    both = parse_drive_file(
        '[[drive]]\nlogs = "a.csv"\n[[drive]]\nname = "second"\nlogs = ["b.csv", "c.csv"]\n', "d"
    )
    assert [drive.name for drive in both.drives] == [None, "second"]
    assert both.drives[0].logs == ("a.csv",)


def test_what_is_left_out_and_separate():
    said = parse_drive_file('separate = true\nleave_out = ["*.tmp.csv", "old/*"]\n', "drive.toml")
    assert said.separate
    assert said.leaves_out("x.tmp.csv")
    assert said.leaves_out("old/x.csv")
    assert not said.leaves_out("x.csv")


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("logs = [", "TOML"),
        ('log = ["a"]', "unknown key 'log'"),
        ("logs = []", "names nothing"),
        ("logs = [3]", "list of names"),
        ('logs = ["../a.csv"]', "below this folder"),
        ('logs = ["/etc/passwd"]', "below this folder"),
        ('logs = ["C:\\\\a.csv"]', "below this folder"),
        ('logs = ["a", "a"]', "twice"),
        ('name = "x"', "`logs`"),
        ('logs = ["a"]\nstart_utc = "yesterday"', "date and a time"),
        ('logs = ["a"]\n[[drive]]\nlogs = ["a"]', "two drives"),
        ("separate = 1", "true or false"),
        ("drive = 3", "list of tables"),
        ('logs = ["a"]\nname = "x/y"', "without a slash"),
    ],
)
def test_what_is_wrong_is_said(text, found):
    with pytest.raises(DriveFileError, match=r"drive\.toml") as caught:
        parse_drive_file(text, "drive.toml")
    assert found in str(caught.value)


def test_the_examples_of_the_page_can_be_used():
    page = (Path(__file__).resolve().parents[3] / "docs" / "fleet_folder.md").read_text(encoding="utf-8")
    first, second = re.findall(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    assert parse_drive_file(first, "drive.toml").drives[0].name == "monday"
    said = parse_drive_file(second, "drive.toml")
    assert said.separate
    assert len(said.drives) == 2
    for key in ("logs", "name", "start_utc", "separate", "leave_out"):
        assert re.search(rf"^{key} = ", page, re.MULTILINE)
