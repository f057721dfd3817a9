"""Zero bytes in a text log of CAN frames: what a lost disk block leaves of the lines that stood there is damage, wherever it begins."""

from __future__ import annotations

import itertools
import random
from pathlib import Path

import pytest
from frame_rows import Frame, text_frames

from parsers.asc_log import AscImporter
from parsers.candump_log import CandumpImporter
from parsers.importer import ImportLog
from parsers.trc_log import TrcImporter

COUNT = 400
PAYLOAD = "11 22 33 44 55 66 77 88"


def asc(k: int) -> str:
    return f"{k / 1000:11.6f} 1  123             Rx   d 8 {PAYLOAD}  Length = 240015 BitCount = 124 ID = 291"


def console(k: int) -> str:
    return f" ({k // 1000:03d}.{k % 1000:03d}000)  can0  123   [8]  {PAYLOAD} "


def trc(k: int) -> str:
    return f"{k + 1:6d}){k + 0.5:11.1f}  Rx         0123  8  {PAYLOAD} "


FORMATS = [
    (AscImporter(), "date Mon Jan 01 10:00:00.123 am 2024\nbase hex  timestamps absolute\n", asc),
    (CandumpImporter(), "", console),
    (TrcImporter(), ";$FILEVERSION=1.1\n;$STARTTIME=43000.0\n", trc),
]


@pytest.mark.parametrize("quick", [False, True])
@pytest.mark.parametrize(("importer", "head", "line"), FORMATS)
def test_lines_that_a_block_of_zeros_swallows_are_damage(
    tmp_path: Path, importer: object, head: str, line: object, quick: bool
) -> None:
    """The block begins behind a frame's payload, in its line, and ends in the middle of a later line."""
    assert callable(line)
    text = head + "".join(line(k) + "\n" for k in range(COUNT))
    first = 250 if quick else 0
    payload = text.index(PAYLOAD, text.index(line(first))) + len(PAYLOAD) + 1
    end = text.index(line(first + 100)) + 20
    raw = text.encode()
    path = tmp_path / "a.log"
    path.write_bytes(raw[:payload] + bytes(end - payload) + raw[end:])
    log = ImportLog()
    frames: list[Frame] = text_frames(importer, path, log)
    assert len(frames) == COUNT - 100
    assert log.status == "malformed"
    assert sum(log.rejected.values()) == 1


def test_long_lines_without_zeros_are_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.asc"
    text = FORMATS[0][1] + "".join(asc(k) + " " + "x" * 600 + "\n" for k in range(50))
    path.write_text(text)
    log = ImportLog()
    assert len(text_frames(FORMATS[0][0], path, log)) == 50
    assert log.status == "complete"


@pytest.mark.parametrize("where", ["payload", "behind the payload", "stamp"])
@pytest.mark.parametrize("size", [90, 2000])
@pytest.mark.parametrize(("importer", "head", "line"), FORMATS)
def test_a_short_stretch_of_zeros_is_damage_and_its_time_is_said(
    tmp_path: Path, importer: object, head: str, line: object, size: int, where: str
) -> None:
    """Too short to last a quarter of a second, and one line of 400: still a damaged block, between two known stamps."""
    assert callable(line)
    text = head + "".join(line(k) + "\n" for k in range(COUNT))
    begin = text.index(line(200)) + line(200).index(PAYLOAD)
    begin += {"payload": 4, "behind the payload": len(PAYLOAD) + 1, "stamp": 0}[where]
    if where == "stamp":
        begin = text.index(line(200)) + len(line(200).split(PAYLOAD)[0].split("  1")[0].rstrip())
    end = begin + size
    raw = text.encode()
    path = tmp_path / "a.log"
    path.write_bytes(raw[:begin] + bytes(size) + raw[end:])
    log = ImportLog()
    frames: list[Frame] = text_frames(importer, path, log)
    assert log.status == "malformed"
    assert dict(log.rejected) == {"malformed line: a damaged block, which may have held several lines": 1}
    (span,) = log.lost_spans_ns
    at = [frame[0] for frame in frames]
    k = at.index(span[0])
    assert span == (at[k], at[k + 1])
    assert at[k + 1] - at[k] == max(b - a for a, b in itertools.pairwise(at))


@pytest.mark.parametrize(("importer", "head", "line"), FORMATS)
def test_noise_in_the_middle_is_damage(tmp_path: Path, importer: object, head: str, line: object) -> None:
    assert callable(line)
    raw = (head + "".join(line(k) + "\n" for k in range(COUNT))).encode()
    noise = random.Random(4).randbytes(1500)
    path = tmp_path / "a.log"
    path.write_bytes(raw[:12000] + noise + raw[13500:])
    log = ImportLog()
    text_frames(importer, path, log)
    assert log.status == "malformed"
    assert log.lost_spans_ns
    assert all(a / 1e6 + 1 > 12000 / 110 and b / 1e6 < COUNT for a, b in log.lost_spans_ns)


@pytest.mark.parametrize(("importer", "head", "line"), FORMATS)
def test_one_odd_line_of_text_is_counted_and_no_damage(
    tmp_path: Path, importer: object, head: str, line: object
) -> None:
    assert callable(line)
    rows = [line(k) + "\n" for k in range(COUNT)]
    path = tmp_path / "a.log"
    path.write_text(head + "".join(rows[:200]) + "*** buffer overrun\n" + "".join(rows[200:]))
    log = ImportLog()
    assert len(text_frames(importer, path, log)) == COUNT
    assert log.status == "complete"
    assert sum(log.rejected.values()) == 1
    assert not log.lost_spans_ns
