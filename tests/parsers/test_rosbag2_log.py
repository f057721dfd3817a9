"""ROS 2 bags: folders and files by rosbags' writer, split and compressed."""

from __future__ import annotations

import gc
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard
from rosbag2_files import (
    COUNT,
    IMU,
    SPEED,
    START,
    STORE,
    TABLES,
    TWIST,
    WHEEL,
    WHEELS,
    YAW,
    collect,
    imu,
    opened,
    twist,
    wheels,
    write_database,
)
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from parsers.importer import ImportLog, LogReader
from parsers.ros import bag2_decode, bag2_pages, bag2_read, bag2_rows
from parsers.ros.decoder import make_standard_decoder
from parsers.ros.packed import UnpackingDecoder


def write_bag(folder: Path, plugin: StoragePlugin = StoragePlugin.SQLITE3, mode: Any = None) -> Path:
    writer = Writer(folder, version=9, storage_plugin=plugin)
    if mode is not None:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connections = [
            writer.add_connection(topic, name, typestore=STORE)
            for topic, name in (("/imu", IMU), ("/cmd", TWIST), ("/wheels", WHEELS))
        ]
        for i in range(COUNT):
            now = START + i * 10_000_000
            for connection, make in zip(connections, (imu, twist, wheels), strict=True):
                writer.write(connection, now, make(i))
    return folder


def check_whole(reader: LogReader, log: ImportLog) -> None:
    got = collect(reader, YAW, SPEED, WHEEL)
    i = np.arange(COUNT)
    np.testing.assert_array_equal(got[YAW][1], [0.1 * k for k in range(COUNT)])
    np.testing.assert_array_equal(got[YAW][0], START + i * 10_000_000 - 5_000_000)
    np.testing.assert_array_equal(got[SPEED][1], 0.5 * i)
    np.testing.assert_array_equal(got[SPEED][0], START + i * 10_000_000)
    np.testing.assert_array_equal(got[WHEEL][1], np.where(i % 4 == 3, i + 2.0, np.nan))
    assert (log.status, log.messages, sum(log.rejected.values())) == ("complete", 3 * COUNT, 0)
    assert reader.absolute
    assert reader.start_utc_ns is None


@pytest.mark.parametrize("metadata", [True, False])
def test_messages_compressed_one_by_one_in_mcap(tmp_path: Path, metadata: bool) -> None:
    folder = write_bag(tmp_path / "bag", StoragePlugin.MCAP, CompressionMode.MESSAGE)
    if not metadata:
        (folder / "metadata.yaml").unlink()
    reader, log = opened(folder)
    check_whole(reader, log)


def test_a_damaged_message_among_compressed_ones_in_mcap_counts_alone() -> None:
    plain = make_standard_decoder("geometry_msgs/msg/Twist", "cdr")
    assert plain is not None
    frames = [zstandard.compress(twist(i)) for i in range(4)]
    frames[2] = frames[2][:-3]
    length = np.array([len(each) for each in frames])
    data = np.frombuffer(b"".join(frames), dtype=np.uint8)
    got = UnpackingDecoder(plain).decode(data, np.cumsum(length) - length, length, ("linear.x",))
    assert got.bad == 1
    np.testing.assert_array_equal(got.columns["linear.x"], [0.0, 0.5, np.nan, 1.5])


@pytest.mark.parametrize("mode", [None, CompressionMode.FILE, CompressionMode.MESSAGE])
@pytest.mark.parametrize("metadata", [True, False])
def test_database_in_a_folder(tmp_path: Path, mode: Any, metadata: bool) -> None:
    folder = write_bag(tmp_path / "bag", mode=mode)
    if not metadata:
        (folder / "metadata.yaml").unlink()
    reader, log = opened(folder)
    check_whole(reader, log)
    assert {info.count for info in reader.channels} == {COUNT}
    assert reader.clock == "header stamp (receive time for /cmd)"
    info = next(info for info in reader.channels if info.name == WHEEL)
    assert dict(info.tags) == {"topic": "/wheels", "type": "my_car/Wheels", "field": "wheels[2].speed"}


@pytest.mark.parametrize("mode", [None, CompressionMode.FILE])
def test_single_files(tmp_path: Path, mode: Any) -> None:
    folder = write_bag(tmp_path / "bag", mode=mode)
    file = next(path for path in folder.iterdir() if ".db3" in path.name)
    reader, log = opened(file)
    check_whole(reader, log)
    assert {info.count for info in reader.channels} == {COUNT}


@pytest.mark.parametrize("mode", [None, CompressionMode.FILE])
def test_mcap_in_a_folder(tmp_path: Path, mode: Any) -> None:
    pytest.importorskip("parsers.mcap_log")
    folder = write_bag(tmp_path / "bag", StoragePlugin.MCAP, mode)
    reader, log = opened(folder)
    check_whole(reader, log)
    assert reader.clock == "header stamp (receive time for /cmd)"


def test_unpacked_files_are_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(scratch))
    reader, log = opened(write_bag(tmp_path / "bag", mode=CompressionMode.FILE))
    assert len(list(scratch.rglob("*.db3"))) == 1
    check_whole(reader, log)
    del reader
    gc.collect()
    assert not list(scratch.iterdir())


def test_split_bag_in_its_natural_order(tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    folder.mkdir()
    for k in range(12):
        write_database(folder / f"bag_{k}.db3", 10 * k, 10)
    reader, log = opened(folder)
    times, values = collect(reader, SPEED)[SPEED]
    assert values.tolist() == [0.5 * i for i in range(120)]
    assert (np.diff(times) > 0).all()
    assert {info.count for info in reader.channels if info.group == "/cmd"} == {120}
    assert log.status == "complete"


def test_metadata_says_which_files_and_which_are_missing(tmp_path: Path) -> None:
    folder = tmp_path / "bag"
    folder.mkdir()
    for k in (0, 2):
        write_database(folder / f"bag_{k}.db3", 10 * k, 10)
    write_database(folder / "old.db3")
    names = "".join(f"    - bag/bag_{k}.db3\n" for k in (2, 1, 0))
    text = f"rosbag2_bagfile_information:\n  version: 4\n  relative_file_paths:\n{names}  duration:\n    nanoseconds: 1\n"
    (folder / "metadata.yaml").write_text(text)
    reader, log = opened(folder)
    values = collect(reader, SPEED)[SPEED][1]
    assert values.tolist() == [0.5 * i for i in [*range(20, 30), *range(10)]]
    assert log.status == "truncated"
    assert any("bag_1.db3" in note for note in log.notes)
    assert any("old.db3" in note for note in log.notes)


def test_humble_bag_takes_standard_types_and_names_the_others(tmp_path: Path) -> None:
    reader, log = opened(write_database(tmp_path / "a.db3"))
    assert collect(reader, YAW)[YAW][1].tolist() == [0.1 * i for i in range(COUNT)]
    assert log.messages == COUNT
    assert not [info for info in reader.channels if info.group == "/w"]
    assert any("my_car/Wheels was left out" in note for note in log.notes)
    assert log.status == "complete"


def test_reads_a_database_with_its_wal_and_leaves_the_folder_alone(tmp_path: Path) -> None:
    path = tmp_path / "a.db3"
    live = sqlite3.connect(path)
    live.execute("PRAGMA journal_mode = WAL")
    live.execute("PRAGMA wal_autocheckpoint = 0")
    live.executescript(TABLES)
    live.execute("INSERT INTO topics VALUES (1, '/cmd', ?, 'cdr', '')", (TWIST,))
    rows = [(START + i, twist(i)) for i in range(50)]
    live.executemany("INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?, ?)", rows)
    live.commit()
    other = tmp_path / "copy"
    other.mkdir()
    for name in ("a.db3", "a.db3-wal"):
        (other / name).write_bytes((tmp_path / name).read_bytes())
    live.close()
    assert (other / "a.db3-wal").stat().st_size > 0
    reader, log = opened(other / "a.db3")
    assert collect(reader, SPEED)[SPEED][1].tolist() == [0.5 * i for i in range(50)]
    assert log.status == "complete"
    assert {p.name for p in other.iterdir()} == {"a.db3", "a.db3-wal"}


@pytest.mark.parametrize("direct", [True, False])
def test_large_messages_come_in_bounded_batches(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, direct: bool
) -> None:
    """From pages as through the library: payloads on overflow pages are gathered a few at a time."""
    path = write_bag(tmp_path / "bag") / "bag.db3"
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript("PRAGMA page_size = 512; VACUUM")
    module = bag2_pages if direct else bag2_rows
    monkeypatch.setattr(module, "BATCH_BYTES", 4000)
    if not direct:
        monkeypatch.setattr(bag2_read, "message_pages", lambda *_: None)
    sizes = []

    def watched(rows: bag2_rows.Rows, chosen: bag2_decode.Chosen) -> bag2_decode.Outcome:
        sizes.append(len(rows.data))
        return bag2_decode.decode_rows(rows, chosen)

    monkeypatch.setattr(bag2_pages if direct else bag2_read, "decode_rows", watched)
    reader, log = opened(path)
    check_whole(reader, log)
    assert len(sizes) > 20
    assert max(sizes) < 6000
