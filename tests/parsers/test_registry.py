"""The registry: formats by content; what is no log is refused before anything is read from it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from parsers.errors import LogError
from parsers.importer import HEAD_BYTES
from parsers.registry import FORMATS, find_importer, importer_at, importers, read_head


def test_formats_have_names_of_their_own_and_load_once():
    names = [importer.name for importer in importers()]
    assert len(set(names)) == len(names) == len(FORMATS)
    assert importer_at(FORMATS[0]) is importers()[0]


def test_the_head_is_bounded_and_a_folder_has_none(tmp_path):
    path = tmp_path / "log.bin"
    path.write_bytes(bytes(range(256)) * 100)
    assert read_head(path) == path.read_bytes()[:HEAD_BYTES]
    assert read_head(tmp_path) == b""


def test_content_decides_before_the_suffix(samples, tmp_path):
    disguised = tmp_path / "drive.csv"
    disguised.write_bytes((samples / "can" / "drive.blf").read_bytes())
    assert find_importer(disguised).name == "blf"


def test_a_folder_that_is_no_bag_names_the_logs_in_it(tmp_path):
    with pytest.raises(
        LogError, match="neither a ROS 2 bag nor a folder of Parquet files alone; give a log file"
    ):
        find_importer(tmp_path)
    for name in ("b.MF4", "a.csv", "c.bag", "d.vbo", "readme.md"):
        (tmp_path / name).touch()
    with pytest.raises(LogError, match=r"it holds a\.csv, b\.MF4, c\.bag, …; give the log file itself"):
        find_importer(tmp_path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes as files on this system")
def test_pipes_and_devices_are_refused_and_not_waited_for(tmp_path):
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    for path in (pipe, tmp_path.__class__("/dev/zero")):
        with pytest.raises(
            LogError, match="is a pipe or a device, not a file; write the log to a file first"
        ):
            read_head(path)


def test_what_is_not_there_or_empty(tmp_path):
    with pytest.raises(LogError, match="no such file"):
        read_head(tmp_path / "none")
    with pytest.raises(LogError, match="cannot be opened"):
        read_head(tmp_path / ("n" * 400))
    with pytest.raises(LogError, match="cannot be opened"):
        read_head(tmp_path / "a\0b")
    (tmp_path / "empty").touch()
    with pytest.raises(LogError, match="empty"):
        read_head(tmp_path / "empty")


@pytest.mark.parametrize(
    ("text", "title"),
    [
        ("(1760000000.000000) can0 123#0011223344556677\n" * 5, "candump"),
        (
            "date Tue Oct 7 08:53:20.000 am 2025\nbase hex  timestamps absolute\n 0.1 1 123 Rx d 1 00\n",
            "Vector ASC",
        ),
        (";$FILEVERSION=1.1\n;\n 1) 10.0 Rx 0123 8 00 11 22 33 44 55 66 77\n", "PEAK TRC"),
    ],
)
@pytest.mark.parametrize("codec", ["utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_frames_saved_with_two_bytes_a_letter_are_known(
    text: str, title: str, codec: str, mark: str, tmp_path: Path
) -> None:
    path = tmp_path / "log.txt"
    path.write_bytes((mark + text).encode(codec))
    assert find_importer(path).title == title


def test_a_table_with_two_bytes_a_letter_is_read(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes("t,a\n0,1\n1,2\n".encode("utf-16"))
    assert find_importer(path).name == "csv"
