"""ROS 2 bags: folders and files by rosbags' writer, split, compressed, unfinished and damaged."""

from __future__ import annotations

import gc
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from parsers.channels import FloatArray, IntArray
from parsers.errors import LogError
from parsers.importer import ImportLog, LogReader, ReadOptions
from parsers.registry import read_head
from parsers.ros import bag2_decode, bag2_pages, bag2_read, bag2_rows
from parsers.rosbag2_log import RosBag2Importer

STORE = get_typestore(Stores.ROS2_HUMBLE)
STORE.register(
    get_types_from_msg("std_msgs/Header header\nWheel[] wheels\nstring name\n", "my_car/msg/Wheels")
)
STORE.register(get_types_from_msg("float64 speed\nstring corner\n", "my_car/msg/Wheel"))
START = 1_700_000_000_000_000_000
COUNT = 300
IMU, TWIST, WHEELS = "sensor_msgs/msg/Imu", "geometry_msgs/msg/Twist", "my_car/msg/Wheels"
TABLES = """
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
  serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
"""


def header(stamp_ns: int) -> Any:
    stamp = STORE.types["builtin_interfaces/msg/Time"](stamp_ns // 10**9, stamp_ns % 10**9)
    return STORE.types["std_msgs/msg/Header"](stamp, "base")


def imu(i: int) -> bytes:
    t = STORE.types
    vector, nine = t["geometry_msgs/msg/Vector3"], np.arange(9.0)
    turn = t["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    rate, force = vector(0.0, 0.0, 0.1 * i), vector(1.0, 2.0, 9.8)
    message = t[IMU](header(START + i * 10_000_000 - 5_000_000), turn, nine, rate, nine, force, nine)
    return bytes(STORE.serialize_cdr(message, IMU, little_endian=i % 2 == 0))


def twist(i: int) -> bytes:
    vector = STORE.types["geometry_msgs/msg/Vector3"]
    return bytes(
        STORE.serialize_cdr(STORE.types[TWIST](vector(0.5 * i, 0.0, 0.0), vector(0.0, 0.0, 1.0)), TWIST)
    )


def wheels(i: int) -> bytes:
    wheel = STORE.types["my_car/msg/Wheel"]
    message = STORE.types[WHEELS](
        header(START + i * 10_000_000), [wheel(float(i + k), "fl" * k) for k in range(i % 4)], "w" * (3 * i)
    )
    return bytes(STORE.serialize_cdr(message, WHEELS))


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


def write_database(path: Path, first: int = 0, count: int = COUNT, extra: bytes = b"") -> Path:
    """A database as ROS 2 Humble wrote it: no definitions. Every message is followed by one of /blob."""
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript(TABLES)
        topics = [
            (5, "/cmd", TWIST),
            (2, "/imu", IMU),
            (9, "/blob", "std_msgs/msg/ByteMultiArray"),
            (3, "/w", WHEELS),
        ]
        connection.executemany("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", topics)
        for i in range(first, first + count):
            now = START + i * 10_000_000
            rows = [(2, now, imu(i)), (5, now, twist(i)), (3, now, wheels(i)), (9, now, extra)]
            connection.executemany("INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)", rows)
        connection.commit()
    return path


def opened(path: Path) -> tuple[LogReader, ImportLog]:
    log = ImportLog()
    importer = RosBag2Importer()
    assert importer.claims(path, read_head(path))
    return importer.open(path, ReadOptions(), log), log


def collect(reader: LogReader, *wanted: str) -> dict[str, tuple[IntArray, FloatArray]]:
    found: dict[str, list[tuple[IntArray, FloatArray]]] = {}
    for chunk in reader.read(frozenset(wanted)):
        for name, values in chunk.columns.items():
            found.setdefault(name, []).append((chunk.time_ns, values))
    return {
        k: (np.concatenate([t for t, _ in v]), np.concatenate([x for _, x in v])) for k, v in found.items()
    }


YAW, SPEED, WHEEL = "/imu.angular_velocity.z", "/cmd.linear.x", "/wheels.wheels[2].speed"


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


@pytest.mark.parametrize("mode", [None, CompressionMode.FILE])
def test_mcap_in_a_folder(tmp_path: Path, mode: Any) -> None:
    pytest.importorskip("parsers.mcap_log")
    folder = write_bag(tmp_path / "bag", StoragePlugin.MCAP, mode)
    reader, log = opened(folder)
    check_whole(reader, log)


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


def test_database_that_breaks_off(tmp_path: Path) -> None:
    path = write_database(tmp_path / "a.db3")
    raw = path.read_bytes()
    path.write_bytes(raw[: len(raw) * 6 // 10])
    reader, log = opened(path)
    values = collect(reader, YAW)[YAW][1]
    assert log.status == "truncated"
    assert any("breaks off" in note for note in log.notes)
    assert len(values) > COUNT * 0.3
    assert values.tolist() == [0.1 * i for i in range(len(values))]


def test_damaged_middle_of_a_database(tmp_path: Path) -> None:
    path = write_database(tmp_path / "a.db3")
    raw = bytearray(path.read_bytes())
    page = 4096
    for number in (len(raw) // page // 2, len(raw) // page // 2 + 3):
        raw[number * page : (number + 1) * page] = b"\xa5" * page
    path.write_bytes(raw)
    reader, log = opened(path)
    values = collect(reader, YAW)[YAW][1]
    assert log.status == "malformed"
    assert COUNT * 0.8 < len(values) < COUNT
    assert set(values) <= {0.1 * i for i in range(COUNT)}
    assert values[-1] == 0.1 * (COUNT - 1)


def test_messages_that_do_not_fit_are_counted(tmp_path: Path) -> None:
    path = write_database(tmp_path / "a.db3")
    with closing(sqlite3.connect(path)) as connection:
        connection.execute(
            "UPDATE messages SET data = substr(data, 1, 60) WHERE topic_id = 2 AND id % 40 = 1"
        )
        connection.execute("UPDATE messages SET data = 'text' WHERE topic_id = 2 AND id % 40 = 5")
        connection.commit()
    reader, log = opened(path)
    values = collect(reader, YAW)[YAW][1]
    assert np.isnan(values).sum() == COUNT // 10
    assert len(values) == COUNT - COUNT // 10
    assert log.rejected["message that does not fit its type's definition"] == COUNT // 10


def test_damaged_compressed_messages(tmp_path: Path) -> None:
    path = write_database(tmp_path / "a.db3")
    packer = zstandard.ZstdCompressor()
    with closing(sqlite3.connect(path)) as connection:
        rows = connection.execute("SELECT id, data FROM messages WHERE topic_id = 5").fetchall()
        packed = [(packer.compress(data), number) for number, data in rows]
        packed[3] = (packed[3][0][:-3], packed[3][1])
        packed[5] = (packed[5][0][:4] + b"\xe0" + b"\xff" * 8, packed[5][1])
        packed[7] = (rows[7][1], rows[7][0])
        connection.executemany("UPDATE messages SET data = ? WHERE id = ?", packed)
        connection.commit()
    reader, log = opened(path)
    values = collect(reader, SPEED)[SPEED][1]
    assert values.tolist() == [0.5 * i for i in range(COUNT) if i not in (3, 5, 7)]
    assert sum(log.rejected.values()) == 3


def test_compressed_file_that_breaks_off(tmp_path: Path) -> None:
    noise = np.random.default_rng(1).bytes(3000)
    whole = zstandard.ZstdCompressor().compress(write_database(tmp_path / "a.db3", extra=noise).read_bytes())
    packed = tmp_path / "b.db3.zstd"
    packed.write_bytes(whole[: len(whole) * 7 // 10])
    reader, log = opened(packed)
    assert log.status == "truncated"
    values = collect(reader, YAW)[YAW][1]
    assert values.tolist() == [0.1 * i for i in range(len(values))]
    assert COUNT > len(values) > COUNT * 0.4


def outcome(path: Path) -> str:
    """Read all of a bag: its status, or the error's line."""
    try:
        reader, log = opened(path)
        collect(reader, *[info.name for info in reader.channels if info.kind == "number"])
    except LogError as error:
        return str(error)
    return log.status


@pytest.mark.parametrize("size", [16, 100, 4000, 5000, 20_000])
def test_stumps_end_with_one_line_or_say_that_they_break_off(tmp_path: Path, size: int) -> None:
    path = write_database(tmp_path / "a.db3")
    path.write_bytes(path.read_bytes()[:size])
    line = outcome(path)
    assert line == "truncated" or line.startswith(f"{path}: ")
    assert "\n" not in line


def test_what_is_no_bag(tmp_path: Path) -> None:
    importer = RosBag2Importer()
    path = tmp_path / "x.sqlite"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("CREATE TABLE other (a)")
        connection.commit()
    assert not importer.claims(path, read_head(path))
    (tmp_path / "metadata.yaml").write_text("something: else\n")
    assert not importer.claims(tmp_path, b"")
    wrong = tmp_path / "y.db3"
    wrong.write_bytes(b"time,speed\n1,2\n")
    assert not importer.claims(wrong, read_head(wrong))


def test_folders_that_cannot_be_used(tmp_path: Path) -> None:
    (tmp_path / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  relative_file_paths:\n    - ../../etc/bag_0.db3\n"
    )
    with pytest.raises(LogError, match=r"names bag_0.db3, which is not there"):
        opened(tmp_path)
    (tmp_path / "metadata.yaml").unlink()
    write_database(tmp_path / "one_0.db3", 0, 5)
    write_database(tmp_path / "two_0.db3", 0, 5)
    with pytest.raises(LogError, match="2 different recordings"):
        opened(tmp_path)
    (tmp_path / "two_0.db3").unlink()
    (tmp_path / "one_1.db3").write_bytes(b"not a database at all")
    reader, log = opened(tmp_path)
    assert len(collect(reader, SPEED)[SPEED][1]) == 5
    assert log.status == "malformed"


def test_no_random_damage_crashes(tmp_path: Path) -> None:
    raw = write_database(tmp_path / "a.db3", count=60).read_bytes()
    rng = np.random.default_rng(7)
    for trial in range(40):
        bad = bytearray(raw)
        for _ in range(40):
            at = int(rng.integers(16, len(bad)))
            bad[at : at + 4] = rng.integers(0, 256, 4, dtype=np.uint8).tobytes()
        path = tmp_path / f"b{trial}.db3"
        path.write_bytes(bad)
        line = outcome(path)
        assert line in ("complete", "truncated", "malformed") or line.startswith(f"{path}: ")
        assert "\n" not in line
