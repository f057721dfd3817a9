"""BLF against python-can's reader and writer, and against objects built byte by byte."""

from __future__ import annotations

import struct
from pathlib import Path

import can
import numpy as np
import pytest
from blf_files import (
    NUMBERED,
    START,
    classic,
    container,
    fd,
    frames_of,
    header_bytes,
    obj,
    write_containers,
)
from frame_rows import Frame

from parsers.blf_containers import read_header
from parsers.blf_log import BlfImporter
from parsers.can.frames import EXTENDED
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions


def peer_frames(path: Path) -> list[Frame]:
    """The same by python-can."""
    rows = []
    with can.BLFReader(path) as reader:
        for m in reader:
            if m.is_error_frame or m.is_remote_frame:
                continue
            ident = m.arbitration_id | (EXTENDED if m.is_extended_id else 0)
            rows.append((round(m.timestamp * 1e6) * 1000, ident, m.channel + 1, bytes(m.data)))
    return rows


def to_us(rows: list[Frame]) -> list[Frame]:
    """python-can's stamps are floats: good to a microsecond."""
    return [((t + 500) // 1000 * 1000, i, b, p) for t, i, b, p in rows]


def message(k: int) -> can.Message:
    rng = np.random.default_rng(k)
    fd = k % 7 == 3
    size = [0, 1, 8, 12, 48, 64][k % 6] if fd else k % 9
    data = b"LOBJLOBJ"[:size] if k % 50 == 8 and not fd else rng.bytes(size)
    return can.Message(
        timestamp=START + k * 0.001,
        arbitration_id=0x18FEF100 + k % 256 if k % 3 == 0 else 0x100 + k % 512,
        is_extended_id=k % 3 == 0,
        is_fd=fd,
        data=data,
        channel=k % 2,
    )


def write(path: Path, count: int, **options: int) -> Path:
    with can.BLFWriter(path, **options) as writer:
        for k in range(count):
            writer.on_message_received(message(k))
    return path


@pytest.mark.parametrize("options", [{}, {"compression_level": 0}], ids=["zlib", "stored"])
def test_every_frame_equals_python_can(tmp_path: Path, options: dict[str, int]) -> None:
    path = write(tmp_path / "a.blf", 9000, **options)
    rows, log = frames_of(path)
    assert len(rows) == 9000
    assert to_us(rows) == peer_frames(path)
    assert log.messages == 9000
    assert log.status == "complete"
    assert not log.rejected


def test_stamps_are_exact_nanoseconds(tmp_path: Path) -> None:
    path = tmp_path / "a.blf"
    path.write_bytes(header_bytes() + container(obj(1, classic(2, 0x123, b"abc"), 1_234_567_891)))
    rows, log = frames_of(path)
    start = START * 1_000_000_000 + 250_000_000
    assert rows == [(start + 1_234_567_891, 0x123, 2, b"abc")]
    assert log.status == "complete"


def test_objects_that_python_can_does_not_write(tmp_path: Path) -> None:
    fd = struct.pack("<HBBLLBBB5x", 3, 0, 9, 0x80000123, 0, 0, 1, 12) + bytes(range(64))
    fd64 = struct.pack("<BBBBLLLLLLLHBBL", 4, 15, 8, 0, 0x55, 0, 0x1000, 0, 0, 0, 0, 0, 0, 0, 0) + b"12345"
    content = b"".join(
        [
            obj(86, classic(1, 0x7FF, b"ABCDEFGH") + b"\0" * 8, 100, flags=1),
            obj(86, classic(1, 0x700, b"AB"), 5_000_000, version=2),
            obj(100, fd, 6_000_000),
            obj(101, fd64, 7_000_000, version=2),
            obj(65, b"some text", 0),
            obj(1, classic(1, 0x80000010, b"12345678", dlc=15), 8_000_000),
        ]
    )
    path = tmp_path / "a.blf"
    path.write_bytes(header_bytes(start=(0,) * 8) + container(content))
    rows, log = frames_of(path)
    assert rows == [
        (1_000_000, 0x7FF, 1, b"ABCDEFGH"),
        (5_000_000, 0x700, 1, b"AB"),
        (6_000_000, EXTENDED | 0x123, 3, bytes(range(12))),
        (7_000_000, 0x55, 4, b"12345\0\0\0"),
        (8_000_000, EXTENDED | 0x10, 1, b"12345678"),
    ]
    # python-can takes a full length for a dlc above 8 too, and needs whole FD fields
    assert rows == peer_frames(path)
    assert any("1 objects" in note for note in log.notes)


def test_remote_and_error_frames_are_counted(tmp_path: Path) -> None:
    content = (
        obj(1, classic(1, 5, b"", flags=0x80), 1)
        + obj(73, b"\0" * 40, 2)
        + obj(2, b"\0" * 8, 3)
        + NUMBERED[7]
    )
    path = tmp_path / "a.blf"
    path.write_bytes(header_bytes() + container(content))
    rows, log = frames_of(path)
    assert [row[1] for row in rows] == [7]
    assert log.rejected == {"CAN remote frame": 1, "CAN error frame": 2}


@pytest.mark.parametrize("cut", [1, 7, 15, 16, 17, 31, 33, 47, 48, 49, 51, 95])
def test_an_object_may_straddle_containers_anywhere(tmp_path: Path, cut: int) -> None:
    content = b"".join(NUMBERED)
    path = tmp_path / "a.blf"
    pieces = [content[:cut], content[cut : cut + 10], content[cut + 10 :]]
    path.write_bytes(header_bytes() + b"".join(container(piece) for piece in pieces))
    rows, log = frames_of(path)
    assert [row[1] for row in rows] == list(range(40))
    assert log.status == "complete"


def test_objects_outside_a_container(tmp_path: Path) -> None:
    path = tmp_path / "a.blf"
    path.write_bytes(header_bytes() + b"".join(NUMBERED[:10]) + container(b"".join(NUMBERED[10:])))
    rows, log = frames_of(path)
    assert [row[1] for row in rows] == list(range(40))
    assert log.status == "complete"


@pytest.mark.parametrize("size", [0, 1, 31, 40, 2_000_000_000, 0xFFFFFFFF, 100])
def test_a_wrong_object_size_ends_and_says_what_it_cost(tmp_path: Path, size: int) -> None:
    bad = obj(1, classic(1, 99, b"x"), 20_000, size=size)
    content = b"".join(NUMBERED[:20]) + bad + b"".join(NUMBERED[21:])
    path = tmp_path / "a.blf"
    path.write_bytes(header_bytes() + container(content))
    rows, log = frames_of(path)
    got = [row[1] for row in rows]
    assert got[:20] == list(range(20))
    assert set(got) - {99} >= set(range(23, 40))
    assert log.status == "malformed"
    assert log.rejected["damaged object in the BLF file"] >= 1


def test_a_damaged_container_is_left_out_with_its_time(tmp_path: Path) -> None:
    parts = [container(b"".join(NUMBERED[k : k + 10])) for k in range(0, 40, 10)]
    broken = bytearray(parts[1])
    broken[40:60] = b"\xff" * 20
    path = tmp_path / "a.blf"
    path.write_bytes(header_bytes() + parts[0] + bytes(broken) + parts[2] + parts[3])
    rows, log = frames_of(path)
    assert [row[1] for row in rows] == [*range(10), *range(20, 40)]
    assert log.status == "malformed"
    start = START * 1_000_000_000 + 250_000_000
    assert log.lost_spans_ns == [(start + 9_000, start + 20_000)]


@pytest.mark.parametrize("size", [0, 5, 0x7FFFFFFF])
def test_a_wrong_container_size_costs_that_container_only(tmp_path: Path, size: int) -> None:
    parts = [
        container(b"".join(NUMBERED[k : k + 10]), size=size if k == 10 else None) for k in range(0, 40, 10)
    ]
    path = tmp_path / "a.blf"
    path.write_bytes(header_bytes() + b"".join(parts))
    rows, log = frames_of(path)
    assert [row[1] for row in rows] == [*range(10), *range(20, 40)]
    assert log.status == "malformed"


def test_a_truncated_file_gives_what_is_whole(tmp_path: Path) -> None:
    path = write(tmp_path / "a.blf", 9000)
    whole, _ = frames_of(path)
    short = tmp_path / "b.blf"
    short.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
    rows, log = frames_of(short)
    assert 3000 < len(rows) < 9000
    assert rows == whole[: len(rows)]
    assert log.status == "truncated"


def test_an_unfinished_file_is_read_to_its_end(tmp_path: Path) -> None:
    path = tmp_path / "a.blf"
    path.write_bytes(header_bytes(objects=0) + container(b"".join(NUMBERED)))
    rows, log = frames_of(path)
    assert len(rows) == 40
    assert log.status == "complete"
    assert any("never finalised" in note for note in log.notes)


def test_signals_come_out_of_the_importer(tmp_path: Path) -> None:
    dbc = tmp_path / "a.dbc"
    dbc.write_text(
        'VERSION ""\nBU_: A\nBO_ 256 Motion: 8 A\n SG_ Yaw : 0|16@1- (0.01,0) [0|0] "deg/s" A\n',
        encoding="latin-1",
    )
    raw = [-300, -1, 0, 5, 1200]
    content = b"".join(
        obj(1, classic(1, 256, struct.pack("<h6x", value)), k * 1_000_000) for k, value in enumerate(raw)
    )
    path = tmp_path / "a.blf"
    path.write_bytes(header_bytes() + container(content))
    log = ImportLog()
    told: list[tuple[int, int]] = []
    options = ReadOptions(dbc=(dbc,), progress=lambda done, total: told.append((done, total)))
    reader = BlfImporter().open(path, options, log)
    assert [(c.name, c.unit, c.family) for c in reader.channels] == [("Motion.Yaw", "deg/s", "can")]
    assert reader.absolute
    chunks = list(reader.read(frozenset({"Motion.Yaw"})))
    values = np.concatenate([chunk.columns["Motion.Yaw"] for chunk in chunks])
    np.testing.assert_allclose(values, [-3.0, -0.01, 0.0, 0.05, 12.0], rtol=1e-12)
    times = np.concatenate([chunk.time_ns for chunk in chunks])
    np.testing.assert_array_equal(times, START * 1_000_000_000 + 250_000_000 + np.arange(5) * 1_000_000)
    assert log.messages == 5
    assert told[-1][0] == told[-1][1]


def test_random_damage_never_hangs_or_raises(tmp_path: Path) -> None:
    whole = header_bytes() + b"".join(container(b"".join(NUMBERED), method=0) for _ in range(3))
    rng = np.random.default_rng(1)
    for k in range(150):
        broken = bytearray(whole)
        for at in rng.integers(144, len(whole), 12):
            broken[at] = rng.integers(256)
        path = tmp_path / f"{k}.blf"
        path.write_bytes(bytes(broken[: rng.integers(144, len(whole) + 1)]))
        rows, _ = frames_of(path)
        assert len(rows) <= 120


def test_one_id_as_classic_and_fd_with_signals_beyond_byte_8(tmp_path: Path) -> None:
    dbc = tmp_path / "a.dbc"
    dbc.write_text(
        'VERSION ""\nBU_: A\nBO_ 256 M: 24 A\n SG_ Near : 0|16@1- (1,0) [0|0] "" A\n'
        ' SG_ Far : 151|24@0+ (1,0) [0|0] "" A\n SG_ Across : 60|8@1+ (1,0) [0|0] "" A\n',
        encoding="latin-1",
    )
    long = bytes(range(100, 124))
    content = obj(1, classic(1, 256, long[:8]), 1) + obj(100, fd(1, 256, long), 2)
    content += obj(1, classic(1, 256, long[:1]), 3) + obj(100, fd(1, 256, long + bytes(8)), 4)
    path = write_containers(tmp_path / "a.blf", content, 70)
    log = ImportLog()
    reader = BlfImporter().open(path, ReadOptions(dbc=(dbc,)), log)
    (chunk,) = reader.read(frozenset(channel.name for channel in reader.channels))
    near, far = int.from_bytes(long[:2], "little"), int.from_bytes(long[18:21], "big")
    across = int.from_bytes(long[7:9], "little") >> 4 & 0xFF
    nan = np.nan
    np.testing.assert_array_equal(chunk.columns["M.Near"], [near, near, nan, near])
    np.testing.assert_array_equal(chunk.columns["M.Far"], [nan, far, nan, far])
    np.testing.assert_array_equal(chunk.columns["M.Across"], [nan, across, nan, across])
    assert dict(log.rejected) == {"M: frame shorter than the DBC says": 2}


def test_too_short_for_a_header(tmp_path: Path) -> None:
    path = tmp_path / "a.blf"
    path.write_bytes(b"LOGG" + b"\0" * 20)
    importer = BlfImporter()
    assert importer.claims(path, path.read_bytes())
    assert not importer.claims(path, b"LOBJ")
    with pytest.raises(LogError, match="header of 72"):
        read_header(path)
