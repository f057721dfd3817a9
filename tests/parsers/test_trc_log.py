"""PEAK TRC logs: python-can as writer and reader, all versions by hand, and damaged files."""

from __future__ import annotations

import random
from datetime import datetime
from pathlib import Path

import can
import pytest
from frame_rows import Frame, text_frames

from parsers.can.frames import EXTENDED
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions
from parsers.trc_log import TrcImporter, read_header


def open_frames(path: Path, log: ImportLog | None = None) -> list[Frame]:
    return text_frames(TrcImporter(), path, log)


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="latin-1")
    return path


def against_python_can(path: Path, start: float = 0.0) -> list[Frame]:
    """Our frames, each compared with python-can's reading of the same file."""
    got = open_frames(path)
    peer = [m for m in can.TRCReader(path) if not m.is_error_frame and not m.is_remote_frame]
    assert len(got) == len(peer) > 0
    for (time_ns, can_id, bus, payload), want in zip(got, peer, strict=True):
        assert time_ns / 1e9 == pytest.approx(want.timestamp - start, abs=2e-6)
        assert can_id == want.arbitration_id | (EXTENDED if want.is_extended_id else 0)
        assert want.channel is None or int(want.channel) == bus
        assert payload == bytes(want.data)
    return got


@pytest.mark.parametrize("version", [can.TRCFileVersion.V1_0, can.TRCFileVersion.V2_1])
def test_every_frame_equals_python_can(tmp_path: Path, version: can.TRCFileVersion) -> None:
    path = tmp_path / "drive.trc"
    rng = random.Random(7)
    with can.TRCWriter(path) as writer:
        writer.file_version = version
        for index in range(300):
            extended = rng.random() < 0.5
            writer.on_message_received(
                can.Message(
                    timestamp=1_700_000_000 + index * 0.25,
                    arbitration_id=rng.randrange(1 << (29 if extended else 11)),
                    is_extended_id=extended,
                    is_rx=rng.random() < 0.5,
                    data=rng.randbytes(rng.randrange(9)),
                    channel=rng.randrange(3),
                )
            )
    assert TrcImporter().claims(path, path.read_bytes()[:4096])
    start = 0.0
    if version is can.TRCFileVersion.V2_1:
        # python-can adds the header's start; ours keeps the offsets
        start = list(can.TRCReader(path))[0].timestamp  # noqa: RUF015 (the reader closes its file at the end)
    assert len(against_python_can(path, start)) == 300


V10 = (
    ";##########################################################################\n;   C:\\a.trc\n"
    ";---+--   ----+---  --+--  + -+ --\n"
    "     1)      1841  0001  8  00 11 22 33 44 55 66 77 \n"
    "     2)      1842  18EFC034  8  01 23 45 67 89 AB CD EF \n"
    "     3)      1843  FFFFFFFF  4  00 00 00 08  BUSHEAVY \n"
    "     4)      1844  0002  3  RTR \n"
)
V11 = (
    ";$FILEVERSION=1.1\n;$STARTTIME=40044.7179637384\n;\n;---+--   ----+----  --+--  ----+---  +  -+\n"
    "     1)      1059.9  Rx         0300  7  00 00 00 00 04 00 00 \n"
    "     2)      1283.2  Tx     18EFC034  2  01 23 \n"
    "     3)      1298.9  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY \n"
    "     4)      1323.0  Error      0000  0  \n"
    "     5)      1424.0  Rx         0301  0  RTR \n"
)
V12 = ";$FILEVERSION=1.2\n;$STARTTIME=40044.7\n     1)      1059.900 2  Rx         0300  2  00 04 \n"
V13 = (
    ";$FILEVERSION=1.3\n;$STARTTIME=40044.7\n"
    "     1)      1059.900 1  Rx        0300 -  2    00 04 \n"
    "     2)      1283.231 2  Tx    18EFC034 -  1    01 \n"
)
V20 = (
    ";$FILEVERSION=2.0\n;$STARTTIME=43474.3408671177\n;$COLUMNS=N,O,T,I,d,l,D\n"
    "      1      1059.900 DT     0300 Rx 7  00 00 00 00 04 00 00 \n"
    "      2      1283.231 FD     0500 Tx 12 01 02 03 04 05 06 07 08 09 0A 0B 0C \n"
    "      3      1298.945 ST          Rx    00 00 00 08 \n"
    "      4      1323.201 ER          Rx    04 00 02 00 00 \n"
    "      5      1423.201 RR     0100 Rx 3 \n"
    "      6      1424.201 FB 18EFC034 Rx 1  FF \n"
    "      7      1425.201 EV  User-defined event \n"
)
V21 = (
    "\xef\xbb\xbf;$FILEVERSION=2.1\r\n;$STARTTIME=43474.3408671177\r\n;$COLUMNS=N,O,T,B,I,d,R,L,D\r\n"
    "      1      1059.900 DT 1      0300 Rx -  7    00 00 00 00 04 00 00 \r\n"
    "      2      1283.231 FE 2      0500 Tx -  9    01 02 03 04 05 06 07 08 09 0A 0B 0C \r\n"
    "      3      1323.201 ER 1         - Rx -  5    04 00 02 00 00 \r\n"
)


@pytest.mark.parametrize(
    ("text", "frames", "rejected"),
    [
        (
            V10,
            [(1841000000, 1, 1, "0011223344556677"), (1842000000, 0x98EFC034, 1, "0123456789abcdef")],
            {"event that is no CAN data frame": 1, "remote frame": 1},
        ),
        (
            V11,
            [(1059900000, 0x300, 1, "00000000040000"), (1283200000, 0x98EFC034, 1, "0123")],
            {"event that is no CAN data frame": 1, "remote frame": 1, "error frame": 1},
        ),
        (V12, [(1059900000, 0x300, 2, "0004")], {}),
        (V13, [(1059900000, 0x300, 1, "0004"), (1283231000, 0x98EFC034, 2, "01")], {}),
        (
            V20,
            [
                (1059900000, 0x300, 1, "00000000040000"),
                (1283231000, 0x500, 1, "0102030405060708090a0b0c"),
                (1424201000, 0x98EFC034, 1, "ff"),
            ],
            {"event that is no CAN data frame": 2, "remote frame": 1, "error frame": 1},
        ),
        (
            V21,
            [(1059900000, 0x300, 1, "00000000040000"), (1283231000, 0x500, 2, "0102030405060708090a0b0c")],
            {"error frame": 1},
        ),
    ],
)
def test_all_versions_by_hand(
    tmp_path: Path, text: str, frames: list[tuple[int, int, int, str]], rejected: dict[str, int]
) -> None:
    path = write(tmp_path / "a.trc", text)
    assert TrcImporter().claims(path, path.read_bytes())
    log = ImportLog()
    assert open_frames(path, log) == [(t, i, b, bytes.fromhex(p)) for t, i, b, p in frames]
    assert dict(log.rejected) == rejected
    assert (log.status, log.messages) == ("complete", len(frames))


def test_start_is_said_without_pretending_a_zone(tmp_path: Path) -> None:
    log = ImportLog()
    reader = TrcImporter().open(write(tmp_path / "a.trc", V20), ReadOptions(), log)
    assert (reader.start_utc_ns, reader.absolute) == (None, False)
    assert any("2019-01-09 08:10:50.919 (clock" in note and "zone unknown" in note for note in log.notes)


@pytest.mark.parametrize(
    ("words", "start"),
    [
        ("18.12.2021 14:28:07.062", datetime(2021, 12, 18, 14, 28, 7, 62000)),
        ("18.12.2021 14:28:07.062.1", datetime(2021, 12, 18, 14, 28, 7, 62000)),
        ("12/18/2021 2:28:07 PM", datetime(2021, 12, 18, 14, 28, 7)),
        ("18/12/2021 14:28:07", datetime(2021, 12, 18, 14, 28, 7)),
        ("2021-12-18 14:28:07+00:00", datetime(2021, 12, 18, 14, 28, 7)),
        ("05/06/2021 14:28:07", None),
        ("18.18.2021 14:28:07", None),
        ("this morning", None),
    ],
)
def test_version_1_0_says_its_start_in_words(words: str, start: datetime | None, tmp_path: Path) -> None:
    lines = [
        ";##########",
        f";   Start time: {words}",
        ";",
        "     1)      1841  0001  8  00 00 00 00 00 00 00 00",
    ]
    assert read_header(lines, tmp_path / "a.trc").start == start
    # the line that later versions have says it in numbers
    numbers = read_header([";$FILEVERSION=1.1", ";$STARTTIME=40044.5", *lines[1:]], tmp_path / "a.trc")
    assert numbers.start == datetime(2009, 8, 19, 12)


def test_unknown_version_and_columns_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "a.trc", ";$FILEVERSION=9.7\n 1 1.0 DT 1 0300 Rx - 0\n")
    with pytest.raises(LogError, match=r"version 9.7 is not known"):
        open_frames(path)
    write(path, ";$FILEVERSION=2.1\n;$COLUMNS=N,O,T,B,d\n 1 1.0 DT 1 Rx\n")
    with pytest.raises(LogError, match="lacks what a frame needs"):
        open_frames(path)


def test_truncation_and_damage(tmp_path: Path) -> None:
    line = "      2      1283.231 DT 2  18EFC034 Tx -  2    01 02\n"
    head = V21.removeprefix("\xef\xbb\xbf").split("      1", maxsplit=1)[0].replace("\r", "")
    for cut in range(7, len(line) - 1):
        log = ImportLog()
        assert len(open_frames(write(tmp_path / "cut.trc", head + line + line[:cut]), log)) == 1
        assert log.status == "truncated", line[:cut]
    log = ImportLog()
    bad = [
        "\x00\x01\n",
        "  x 1.0 DT\n",
        " 2 1.0x DT 2 0300 Rx - 0\n",
        " 2 1.0 DT 2 0900 Rx - 0\n",
        " 2 1.0 QQ 2 0\n",
    ]
    path = write(tmp_path / "bad.trc", head + line + "".join(bad) + line)
    assert len(open_frames(path, log)) == 2
    assert log.status == "malformed"
    assert sum(log.rejected.values()) == len(bad)


def test_other_files_are_not_claimed(tmp_path: Path) -> None:
    claims = TrcImporter().claims
    assert not claims(tmp_path, b"; a comment\ntime;speed\n1;2\n")
    assert not claims(tmp_path, b";$FILEVERSION=2.1\n\x00\x00")
    assert not claims(tmp_path, b"")
