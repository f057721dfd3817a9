"""candump logs: python-can as writer and reader, both dialects by hand, and damaged files."""

from __future__ import annotations

import random
from pathlib import Path

import can
import numpy as np
import pytest
from frame_rows import Frame, text_frames

from parsers.can.frames import EXTENDED
from parsers.candump_log import CandumpImporter
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions


def open_frames(path: Path, log: ImportLog | None = None) -> list[Frame]:
    return text_frames(CandumpImporter(), path, log)


def claims(path: Path) -> bool:
    return CandumpImporter().claims(path, path.read_bytes()[:4096])


def random_messages(count: int, seed: int = 1) -> list[can.Message]:
    rng = random.Random(seed)
    messages = []
    for index in range(count):
        fd = rng.random() < 0.3
        extended = rng.random() < 0.5
        size = rng.choice([0, 1, 8, 12, 64] if fd else range(9))
        messages.append(
            can.Message(
                timestamp=1_700_000_000 + index * 0.010001,
                arbitration_id=rng.randrange(1 << (29 if extended else 11)),
                is_extended_id=extended,
                is_fd=fd,
                bitrate_switch=fd and rng.random() < 0.5,
                is_rx=rng.random() < 0.5,
                data=rng.randbytes(size),
                channel=rng.choice(["can0", "vcan1"]),
            )
        )
    return messages


def test_every_frame_equals_python_can(tmp_path: Path) -> None:
    path = tmp_path / "drive.log"
    with can.CanutilsLogWriter(path) as writer:
        for message in random_messages(500):
            writer.on_message_received(message)
    assert claims(path)
    got = open_frames(path)
    names = {"can0": 0, "vcan1": 0}
    peer = list(can.CanutilsLogReader(path))
    assert len(got) == len(peer) == 500
    for (time_ns, can_id, bus, payload), want in zip(got, peer, strict=True):
        names[str(want.channel)] = names[str(want.channel)] or bus
        assert time_ns == round(want.timestamp * 1e6) * 1000
        assert can_id == want.arbitration_id | (EXTENDED if want.is_extended_id else 0)
        assert bus == names[str(want.channel)]
        assert payload == bytes(want.data)
    assert sorted(names.values()) == [1, 2]


def test_file_dialect_by_hand(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    path.write_text(
        "(1436509052.249713) vcan0 044#2A366C2BBA\n"
        "(1436509052.449847) vcan0 18FEF1FE#FFFF00\n"
        "(1436509052.500000) can1 123#R8\n"
        "(1436509052.600000) can1 20000080#0000000000000000\n"
        "(1436509052.650000) can1 7FF##5112233 T\r\n"
        "\n"
        "(1436509052.700000) can1 123#1122334455667788_B R\n"
    )
    log = ImportLog()
    assert open_frames(path, log) == [
        (1436509052249713000, 0x044, 1, bytes.fromhex("2A366C2BBA")),
        (1436509052449847000, 0x98FEF1FE, 1, bytes.fromhex("FFFF00")),
        (1436509052650000000, 0x7FF, 2, bytes.fromhex("112233")),
        (1436509052700000000, 0x123, 2, bytes.fromhex("1122334455667788")),
    ]
    assert log.messages == 4
    assert dict(log.rejected) == {"remote frame": 1, "error frame": 1}
    assert "bus 1 is vcan0, bus 2 is can1" in log.notes
    assert log.status == "complete"


def test_console_dialect_by_hand(tmp_path: Path) -> None:
    path = tmp_path / "console.txt"
    path.write_text(
        " (1436509052.249713)  vcan0  123   [8]  11 22 33 44 55 66 77 88   '.\"3DUfw.'\n"
        " (1436509052.249714)  vcan0  RX - -  18FEF1FE   [2]  AA BB\n"
        " (1436509052.249715)  vcan0  TX B E  123  [03]  01 02 03\n"
        " (1436509052.249716)  vcan0  123   [0]  remote request\n"
        " (1436509052.249717)  vcan0  20000004   [8]  00 01 00 00 00 00 00 00   ERRORFRAME\n"
        " (1436509052.249718)  vcan0  124   [0] \n"
    )
    log = ImportLog()
    assert claims(path)
    base = 1436509052249713000
    assert open_frames(path, log) == [
        (base, 0x123, 1, bytes.fromhex("1122334455667788")),
        (base + 1000, 0x98FEF1FE, 1, b"\xaa\xbb"),
        (base + 2000, 0x123, 1, b"\x01\x02\x03"),
        (base + 5000, 0x124, 1, b""),
    ]
    assert dict(log.rejected) == {"remote frame": 1, "error frame": 1}


@pytest.mark.parametrize(
    ("stamps", "expected_ms", "clock"),
    [
        (["000.000000", "000.010000", "000.010500", "000.009000"], [0, 10, 20.5, 29.5], "sum"),
        (["000.000000", "000.010000", "000.010000", "000.010000"], [0, 10, 20, 30], "sum"),
        (["000.000000", "000.010000", "000.020500", "000.029500"], [0, 10, 20.5, 29.5], "own zero"),
        (
            ["2015-07-10 23:59:59.990000", "2015-07-11 00:00:00.000000", "2015-07-11 00:00:00.010500"],
            [0, 10, 20.5],
            "local time",
        ),
    ],
)
def test_kinds_of_console_stamps(
    tmp_path: Path, stamps: list[str], expected_ms: list[float], clock: str
) -> None:
    path = tmp_path / "t.txt"
    path.write_text("".join(f" ({stamp})  can0  123   [1]  11\n" for stamp in stamps))
    reader = CandumpImporter().open(path, ReadOptions(), ImportLog())
    assert clock in reader.clock
    assert not reader.absolute
    assert [frame[0] / 1e6 for frame in open_frames(path)] == expected_ms


def test_console_without_stamps_is_refused_with_the_next_step(tmp_path: Path) -> None:
    path = tmp_path / "console.txt"
    path.write_text("  vcan0  123   [2]  11 22\n  vcan0  123   [2]  11 22\n")
    assert claims(path)
    with pytest.raises(LogError, match=r"line 1: .*without time stamps.*candump -t a"):
        CandumpImporter().open(path, ReadOptions(), ImportLog())


def test_one_line_that_lost_its_stamp_is_not_a_log_without_stamps(tmp_path: Path) -> None:
    path = tmp_path / "console.txt"
    line = " (1436509052.249713)  vcan0  123   [2]  11 22\n"
    path.write_text(line + "  vcan0  123   [2]  11 22\n" + line)
    log = ImportLog()
    assert len(open_frames(path, log)) == 2
    assert dict(log.rejected) == {"malformed line: no time stamp that can be read": 1}


def test_truncated_last_line_is_said_and_the_rest_kept(tmp_path: Path) -> None:
    path = tmp_path / "cut.log"
    path.write_text("(1436509052.1) can0 123#1122\n(1436509052.2) can0 123#112")
    log = ImportLog()
    assert len(open_frames(path, log)) == 1
    assert log.status == "truncated"
    assert any("line 2" in note for note in log.notes)
    assert not log.rejected


@pytest.mark.parametrize("payload", ["", "11", "112233"])
@pytest.mark.parametrize("piece", [1 << 22, 90])
def test_a_cut_between_two_bytes_of_the_last_frame_is_a_cut(
    payload: str, piece: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("parsers.can.pieces.PIECE_BYTES", piece)
    rows = [f"(14365090{k}.1) can0 {name}\n" for k in range(10, 30) for name in ("123#11223344", "124#11")]
    path = tmp_path / "cut.log"
    path.write_text("".join(rows) + f"(1436509052.2) can0 123#{payload}")
    log = ImportLog()
    assert len(open_frames(path, log)) == 40
    assert (log.status, log.messages) == ("truncated", 40)
    assert any("line 41" in note and "breaks off" in note for note in log.notes)


@pytest.mark.parametrize("last", ["123#11223344", "125#11", "124#11"])
def test_a_last_frame_without_line_end_that_may_be_whole_stays(last: str, tmp_path: Path) -> None:
    rows = [f"(14365090{k}.1) can0 {name}\n" for k in range(10, 30) for name in ("123#11223344", "124#11")]
    path = tmp_path / "cut.log"
    path.write_text("".join(rows) + f"(1436509052.2) can0 {last}")
    log = ImportLog()
    assert len(open_frames(path, log)) == 41
    assert log.status == "complete"
    assert any("no line end" in note for note in log.notes)


def test_damaged_middle_counts_each_kind(tmp_path: Path) -> None:
    good = "(1436509052.1) can0 123#1122\n"
    bad = [
        "\x00\x00\x07garbage\n",
        "(14365x9052.1) can0 123#11\n",
        "(1436509052.1) can0 12G#11\n",
        "(1436509052.1) can0 123#11223\n",
        "(1436509052.1) can0 123#112233445566778899\n",
        "(1436509052.1) averyveryverylongname 123#11\n",
        "(1436509052.1) can0\n",
        "(1436509052.1\n",
        "(\n",
    ]
    path = tmp_path / "damaged.log"
    path.write_text(good * 3 + "".join(bad) + good * 2)
    log = ImportLog()
    assert len(open_frames(path, log)) == 5
    assert sum(log.rejected.values()) == len(bad)
    assert log.status == "malformed"
    assert any("the first is line 4" in note for note in log.notes)


def test_blocks_do_not_change_the_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "drive.log"
    with can.CanutilsLogWriter(path) as writer:
        for message in random_messages(200, seed=3):
            writer.on_message_received(message)
    whole = open_frames(path)
    monkeypatch.setattr("parsers.can.pieces.PIECE_BYTES", 333)
    assert open_frames(path) == whole


def test_cut_anywhere_never_fails(tmp_path: Path) -> None:
    text = b" (1436509052.249713)  vcan0  RX - -  18FEF1FE   [2]  AA BB\n(1436509052.2) can0 123##1AABB R\n"
    path = tmp_path / "cut.log"
    for size in range(40, len(text)):
        path.write_bytes(text[:size])
        assert len(open_frames(path)) <= 2


def test_other_text_and_binary_are_not_claimed(tmp_path: Path) -> None:
    importer = CandumpImporter()
    assert not importer.claims(tmp_path, b"time,accel\n0.0,1.0\n")
    assert not importer.claims(tmp_path, b"(1436509052.1) can0 123#11\n\x00\x01\x02")
    assert not importer.claims(tmp_path, b"")


def test_stamps_far_out_of_range_are_malformed_not_wrapped(tmp_path: Path) -> None:
    path = tmp_path / "far.log"
    path.write_text("(1436509052.1) can0 123#11\n(99999999999999999999.0) can0 123#11\n")
    log = ImportLog()
    frames = open_frames(path, log)
    assert [np.int64(frame[0]) for frame in frames] == [1436509052100000000]
    assert sum(log.rejected.values()) == 1


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_colours_are_passed_over(tmp_path: Path, newline: str) -> None:
    """candump -c on a console, saved to a file."""
    plain = [
        f" (1710597922.{k:06d})  can0  {0x100 + k % 5:03X}   [8]  00 00 00 10 02 00 {k % 256:02X} 00"
        for k in range(3000)
    ]
    (tmp_path / "plain.log").write_text(newline.join(plain) + newline, newline="")
    coloured = tmp_path / "coloured.log"
    coloured.write_text(
        newline.join(f"\x1b[{31 + k % 7}m{line}\x1b[0m" for k, line in enumerate(plain)) + newline, newline=""
    )
    assert claims(coloured)
    log = ImportLog()
    found = open_frames(coloured, log)
    assert found == open_frames(tmp_path / "plain.log")
    assert len(found) == 3000
    assert log.status == "complete"
    assert "colours" in " ".join(log.notes)
