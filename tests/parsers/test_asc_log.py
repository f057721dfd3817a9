"""Vector ASC logs: python-can as writer and reader, layouts by hand, headers, and damaged files."""

from __future__ import annotations

import random
from datetime import datetime
from pathlib import Path

import can
import pytest
from frame_rows import Frame, text_frames

from parsers.asc_log import AscImporter, read_date, read_header
from parsers.can.frames import EXTENDED
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions

HEADER = "date Wed Sep 30 03:06:13.191 pm 2017\nbase hex  timestamps absolute\ninternal events logged\n"


def open_frames(path: Path, log: ImportLog | None = None) -> list[Frame]:
    return text_frames(AscImporter(), path, log)


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="latin-1")
    return path


def test_every_frame_equals_python_can(tmp_path: Path) -> None:
    path = tmp_path / "drive.asc"
    rng = random.Random(5)
    with can.ASCWriter(path) as writer:
        for index in range(400):
            fd = rng.random() < 0.4
            extended = rng.random() < 0.5
            writer.on_message_received(
                can.Message(
                    timestamp=1_700_000_000 + index * 0.0101,
                    arbitration_id=rng.randrange(1 << (29 if extended else 11)),
                    is_extended_id=extended,
                    is_fd=fd,
                    is_rx=rng.random() < 0.5,
                    data=rng.randbytes(rng.choice([1, 8, 12, 20, 64] if fd else range(9))),
                    channel=rng.randrange(3),
                )
            )
        writer.on_message_received(can.Message(is_error_frame=True, timestamp=1_700_000_005, channel=0))
        writer.on_message_received(
            can.Message(arbitration_id=5, is_remote_frame=True, dlc=3, timestamp=1_700_000_006, channel=0)
        )
    log = ImportLog()
    got = open_frames(path, log)
    peer = [m for m in can.ASCReader(path) if not m.is_error_frame and not m.is_remote_frame]
    assert len(got) == len(peer) == 400
    for (time_ns, can_id, bus, payload), want in zip(got, peer, strict=True):
        assert time_ns == round(want.timestamp * 1e6) * 1000
        assert can_id == want.arbitration_id | (EXTENDED if want.is_extended_id else 0)
        assert bus == int(str(want.channel)) + 1
        assert payload == bytes(want.data)
    assert dict(log.rejected) == {"error frame": 1, "remote frame": 1}
    assert log.status == "complete"


def test_lines_by_hand(tmp_path: Path) -> None:
    path = write(
        tmp_path / "a.asc",
        HEADER
        + "// version 9.0.0\n"
        + "Begin Triggerblock Wed Sep 30 03:06:13.191 pm 2017\n"
        + "   0.000000 Start of measurement\n"
        + "   0.015991 1  123x            Rx   d 8 00 11 22 33 44 55 66 ff  Length = 1 BitCount = 2 ID = 291x\n"
        + "   0.016000 2  7FF             Tx   d 3 aa BB 0c\r\n"
        + "   0.016100 2  7FF             TxRq d 3 aa BB 0c\n"
        + "   0.016200 1  100             Rx   r 8\n"
        + "   0.016300 1  ErrorFrame      ECC: 10100010\n"
        + "   0.016400 1  Statistic: D 0 R 0 XD 0 XR 0 E 0 O 0 B 0.00%\n"
        + "   0.016450 1  OverloadFrame\n"
        + "   0.016500 SV: 3 0 1 ::Chassis::Speed = 12\n"
        + "   0.016600 1  J1939TP FEE3p 6 0 0 - Rx d 23 A0 0F A6 60\n"
        + "   0.016700 1  200             Rx   d 15 1 2 3\n"
        + "   0.016800 CANFD   1 Rx        54x  Some_Name    1 0 9 12 00 01 02 03 04 05 06 07 08 09 0a 0b  0 0 1000 0\n"
        + "   0.016900 CANFD   2 Tx        55   0 0 2  2 aa bb  0 0 1000 0 0 0 0 0\n"
        + "   0.017000 CANFD   2 Rx ErrorFrame  Not Acknowledge error\n"
        + "   0.017100 1  300             Rx   d 0\n"
        + "End TriggerBlock\n",
    )
    log = ImportLog()
    assert open_frames(path, log) == [
        (15991000, 0x123 | EXTENDED, 1, bytes.fromhex("00112233445566ff")),
        (16000000, 0x7FF, 2, bytes.fromhex("aabb0c")),
        (16800000, 0x54 | EXTENDED, 1, bytes(range(12))),
        (16900000, 0x55, 2, b"\xaa\xbb"),
        (17100000, 0x300, 1, b""),
    ]
    assert dict(log.rejected) == {
        "request to send, not yet a frame on the bus": 1,
        "remote frame": 1,
        "error frame": 2,
        "bus statistic": 1,
        "event that is no CAN data frame": 3,
        "malformed line: payload incomplete or not a number": 1,
    }
    assert any("2017-09-30 15:06:13.191 (local time" in note for note in log.notes)


def test_decimal_numbers(tmp_path: Path) -> None:
    path = write(
        tmp_path / "dec.asc",
        "base dec timestamps absolute\n 0.5 1 291x Rx d 3 0 17 255\n 0.6 1 2047 Rx d 1 9\n 0.7 1 2048 Rx d 1 9\n",
    )
    log = ImportLog()
    assert open_frames(path, log) == [
        (500_000_000, 0x123 | EXTENDED, 1, b"\x00\x11\xff"),
        (600_000_000, 2047, 1, b"\x09"),
    ]
    assert log.rejected["malformed line: no identifier that can be read"] == 1


def test_relative_stamps_add_up_over_all_events(tmp_path: Path) -> None:
    path = write(
        tmp_path / "rel.asc",
        "base hex timestamps relative\n 0.100 1 1 Rx d 0\n 0.010 1 ErrorFrame\n 0.001 1 1 Rx d 0\n",
    )
    assert [frame[0] for frame in open_frames(path)] == [100_000_000, 111_000_000]


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("date Wed Sep 30 03:06:13.191 pm 2017", datetime(2017, 9, 30, 15, 6, 13, 191000)),
        ("date Sam Sep 30 15:06:13.191 2017", datetime(2017, 9, 30, 15, 6, 13, 191000)),
        ("date Sat Sep 30 12:06:13 AM 2017", datetime(2017, 9, 30, 0, 6, 13)),
        ("date Die Mär 7 10:00:01.007 2023", datetime(2023, 3, 7, 10, 0, 1, 7000)),
        ("date Son Dez 24 18:00:00 2023", datetime(2023, 12, 24, 18, 0, 0)),
        ("date Mon Mai 1 08:00:00.7 2023", datetime(2023, 5, 1, 8, 0, 0, 7000)),
        ("date Fri Okt 31 25:00:00 2023", None),
        ("date of manufacture", None),
    ],
)
def test_dates_of_several_locales(line: str, expected: datetime | None) -> None:
    assert read_date(line) == expected
    mangled = line.encode("utf-8").decode("latin-1")
    assert read_date(mangled) == expected


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("date 16.03.2024 14:05:22", datetime(2024, 3, 16, 14, 5, 22)),
        ("date 03/04/2024 14:05:22.5", datetime(2024, 4, 3, 14, 5, 22, 5000)),
        ("date 3/16/2024 2:05:22 PM", datetime(2024, 3, 16, 14, 5, 22)),
        ("date 03/04/2024 2:05:22 pm", datetime(2024, 3, 4, 14, 5, 22)),
        ("date 2024-03-16 14:05:22.250", datetime(2024, 3, 16, 14, 5, 22, 250000)),
        ("date 16.13.2024 14:05:22", None),
    ],
)
def test_dates_in_numbers(line: str, expected: datetime | None) -> None:
    assert read_date(line) == expected


def test_a_date_that_is_not_understood_is_said() -> None:
    header = read_header(["date Zat Mrt 16 14:05:22 2024", "base hex  timestamps absolute"])
    assert header.start is None
    assert "the date in the ASC header is not understood ('Zat Mrt 16 14:05:22 2024')" in header.notes


def test_symbolic_names_in_place_of_identifiers(tmp_path: Path) -> None:
    named = "   0.0{:05d} 1  {}          Rx   d 2 00 11\n"
    rows = [named.format(k, ("Chassis1", "Susp")[k % 2]) for k in range(40)]
    path = write(tmp_path / "a.asc", HEADER + "".join(rows))
    with pytest.raises(LogError, match=r"symbolic names \(Chassis1, Susp\) in place of identifiers"):
        AscImporter().open(path, ReadOptions(), ImportLog())
    log = ImportLog()
    path = write(path, HEADER + "".join(rows) + named.format(50, "123x") * 3)
    assert len(open_frames(path, log)) == 3
    assert "symbolic names" in " ".join(log.notes)


def test_no_wall_clock_is_invented(tmp_path: Path) -> None:
    reader = AscImporter().open(write(tmp_path / "a.asc", HEADER), ReadOptions(), ImportLog())
    assert (reader.start_utc_ns, reader.absolute, reader.channels) == (None, False, ())


def test_truncation_and_damage(tmp_path: Path) -> None:
    good = "   0.015991 1  123x            Rx   d 2 00 11\n"
    for cut in range(1 + good.index("0"), len(good) - 1):
        log = ImportLog()
        path = write(tmp_path / "cut.asc", HEADER + good + good[:cut])
        assert len(open_frames(path, log)) == 1, cut
        assert log.status == "truncated", good[:cut]
    log = ImportLog()
    path = write(
        tmp_path / "bad.asc", HEADER + good + "\x00\x01\x02\n0.1x 1 1 Rx d 0\n 0.1 1 1 Rx d 2 0 11\n" + good
    )
    assert len(open_frames(path, log)) == 2
    assert log.status == "malformed"
    assert sum(log.rejected.values()) == 3
    log = ImportLog()
    path = write(tmp_path / "dec.asc", "base dec timestamps absolute\n 0.5 1 291x Rx d 2 0 17")
    assert open_frames(path, log) == []
    assert log.status == "truncated"


def test_claims_by_content(tmp_path: Path) -> None:
    claims = AscImporter().claims
    assert claims(tmp_path, HEADER.encode())
    assert claims(tmp_path, b"   0.015991 1  123x            Rx   d 2 00 11\n")
    assert not claims(tmp_path, b"date;speed;base\n2020-01-01;1;2\n")
    assert not claims(tmp_path, b"time,ax\n0.1,2\n")
    assert not claims(tmp_path, HEADER.encode() + b"\x00\x00")


@pytest.mark.parametrize(
    ("trigger", "hour"),
    [("Tue Nov 14 10:13:20.000 PM 2023", 22), ("Tue Nov 14 11:50:00.000 PM 2023", 23), ("", 23)],
)
def test_a_file_that_was_written_later_was_recorded_when_its_trigger_block_began(
    trigger: str, hour: int
) -> None:
    lines = [
        "date Tue Nov 14 11:20:00 PM 2023",
        "base hex  timestamps absolute",
        f"Begin Triggerblock {trigger}",
    ]
    start = read_header(lines).start
    assert start is not None
    assert (start.day, start.hour, start.minute) == (14, hour, 13 if hour == 22 else 20)
