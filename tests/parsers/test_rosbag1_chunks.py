"""ROS 1 bags in odd shapes: every value against rosbags, other chunk orders, lying indexes, large unwanted topics."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag1 import Reader, Writer
from rosbags.typesys import Stores, get_typestore

from parsers.channels import FloatArray, IntArray
from parsers.importer import ImportLog, LogReader, ReadOptions
from parsers.ros import bag1_read
from parsers.ros.bag1_records import MAGIC, parse_fields
from parsers.rosbag1_log import RosBag1Importer

STORE = get_typestore(Stores.ROS1_NOETIC)
START = 1_700_000_000_000_000_000
STEP = 10_000_000
FORMATS = (None, Writer.CompressionFormat.BZ2, Writer.CompressionFormat.LZ4)
KINDS = {
    "/imu": "sensor_msgs/msg/Imu",
    "/odometry": "nav_msgs/msg/Odometry",
    "/joints": "sensor_msgs/msg/JointState",
    "/path": "nav_msgs/msg/Path",
    "/fix": "sensor_msgs/msg/NavSatFix",
    "/status": "diagnostic_msgs/msg/DiagnosticArray",
    "/plain": "geometry_msgs/msg/Twist",
}
Series = dict[str, tuple[IntArray, FloatArray]]


def value_of(desc: Any, rng: np.random.Generator, stamp_ns: int) -> Any:
    """A random value for one of rosbags' field descriptions; texts and sequences of varying length."""
    kind, what = desc[0].name, desc[1]
    if kind == "NAME":
        return message(what, rng, stamp_ns)
    if kind == "BASE":
        if what[0] == "string":
            return "x" * int(rng.integers(0, 6))
        return float(rng.standard_normal()) if what[0].startswith("float") else int(rng.integers(0, 100))
    inner, size = what
    values = [
        value_of(inner, rng, stamp_ns) for _ in range(size if kind == "ARRAY" else int(rng.integers(0, 4)))
    ]
    if inner[0].name == "BASE" and inner[1][0] != "string":
        return np.array(values, dtype=inner[1][0])
    return values


def message(name: str, rng: np.random.Generator, stamp_ns: int) -> Any:
    if name.endswith("/Time"):
        return STORE.types[name](stamp_ns // 10**9, stamp_ns % 10**9)
    return STORE.types[name](*[value_of(desc, rng, stamp_ns) for _, desc in STORE.fielddefs[name][1]])


def write_bag(
    path: Path,
    count: int,
    compression: Any = None,
    chunk: int = 6000,
    when: Callable[[int], int] = lambda i: START + i * STEP,
) -> Path:
    """`count` messages of each of KINDS."""
    rng = np.random.default_rng(count)
    writer = Writer(path)
    writer.chunk_threshold = chunk
    if compression is not None:
        writer.set_compression(compression)
    with writer:
        places = {topic: writer.add_connection(topic, kind, typestore=STORE) for topic, kind in KINDS.items()}
        for i in range(count):
            for k, (topic, kind) in enumerate(KINDS.items()):
                now = when(i) + k
                writer.write(places[topic], now, STORE.serialize_ros1(message(kind, rng, now - 1000), kind))
    return path


def read(
    path: Path, chosen: Callable[[str], bool] = lambda name: True
) -> tuple[Series, ImportLog, LogReader]:
    log = ImportLog()
    reader = RosBag1Importer().open(path, ReadOptions(), log)
    wanted = frozenset(info.name for info in reader.channels if info.kind == "number" and chosen(info.name))
    found: dict[str, list[tuple[IntArray, FloatArray]]] = {}
    for part in reader.read(wanted):
        assert set(part.columns) <= wanted
        for name, values in part.columns.items():
            found.setdefault(name, []).append((part.time_ns, values))
    series = {
        name: (np.concatenate([t for t, _ in parts]), np.concatenate([x for _, x in parts]))
        for name, parts in found.items()
    }
    return series, log, reader


def at_path(value: Any, path: str) -> float:
    for part in path.replace("[", ".[").split("."):
        if part.startswith("["):
            if int(part[1:-1]) >= len(value):
                return float("nan")
            value = value[int(part[1:-1])]
        else:
            value = getattr(value, part)
    return float(value.sec + value.nanosec * 1e-9) if hasattr(value, "nanosec") else float(value)


def assert_equal(one: Series, two: Series) -> None:
    assert one.keys() == two.keys()
    for name, (time_ns, values) in one.items():
        np.testing.assert_array_equal(time_ns, two[name][0], err_msg=name)
        np.testing.assert_array_equal(values, two[name][1], err_msg=name)


@pytest.mark.parametrize("compression", FORMATS)
def test_every_value_of_a_whole_bag_equals_the_peers(tmp_path: Path, compression: Any) -> None:
    path = write_bag(tmp_path / "a.bag", 60, compression)
    series, log, reader = read(path)
    assert (log.status, log.messages, sum(log.rejected.values())) == ("complete", 60 * len(KINDS), 0)
    checked = 0
    with Reader(path) as peer:
        for connection in peer.connections:
            rows = [
                (ns, STORE.deserialize_ros1(raw, connection.msgtype))
                for _, ns, raw in peer.messages([connection])
            ]
            stamps = [
                m.header.stamp.sec * 10**9 + m.header.stamp.nanosec if hasattr(m, "header") else ns
                for ns, m in rows
            ]
            for info in reader.channels:
                if info.group == connection.topic and info.kind == "number":
                    time_ns, values = series[info.name]
                    assert time_ns.tolist() == stamps
                    expected = [at_path(m, info.tags["field"]) for _, m in rows]
                    np.testing.assert_array_equal(values, expected, err_msg=info.name)
                    checked += 1
    assert checked > 200


def spoil(path: Path, where: bytes, count: int = 1) -> None:
    """Overwrite some bytes after the `count`-th place where `where` is found."""
    raw, at = bytearray(path.read_bytes()), 0
    for _ in range(count):
        at = raw.index(where, at + 1)
    raw[at : at + 64] = b"\xa5" * 64
    path.write_bytes(raw)


@pytest.mark.parametrize("compression", FORMATS)
@pytest.mark.parametrize("damaged", [False, True])
def test_threads_give_what_one_core_gives(
    tmp_path: Path, compression: Any, damaged: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_bag(tmp_path / "a.bag", 80, compression)
    if damaged:
        spoil(path, b"op=\x05", 4)
        spoil(path, b"op=\x04", 9)
    monkeypatch.setattr("parsers.ros.bag1_read.JOB_BYTES", 20_000)
    results = []
    for workers in (1, 2, 5):
        monkeypatch.setattr("parsers.parallel.cores", lambda workers=workers: workers)
        results.append(read(path))
    assert results[0][1].status == ("malformed" if damaged else "complete")
    for series, log, _ in results[1:]:
        assert_equal(series, results[0][0])
        assert log == results[0][1]


def test_chunks_out_of_order_come_as_they_lie_in_the_bag(tmp_path: Path) -> None:
    def when(i: int) -> int:
        return START + ((i // 10) ^ 1) * 10 * STEP + i % 10 * STEP

    path = write_bag(tmp_path / "a.bag", 60, None, 20_000, when)
    series, log, _ = read(path, lambda name: name == "/plain.linear.x")
    time_ns, _ = series["/plain.linear.x"]
    assert log.status == "complete"
    assert sorted(time_ns.tolist()) == sorted(when(i) + 6 for i in range(60))
    assert (np.diff(time_ns) < 0).any()


IMAGE, TWIST = "sensor_msgs/msg/CompressedImage", "geometry_msgs/msg/Twist"


def camera_bag(path: Path, size: int, chunk: int, count: int = 200) -> Path:
    """`count` twists, and every fifth time an image of `size` bytes between them, in the same chunks."""
    writer = Writer(path)
    writer.chunk_threshold = chunk
    with writer:
        twist = writer.add_connection("/cmd", TWIST, typestore=STORE)
        image = writer.add_connection("/camera", IMAGE, typestore=STORE)
        vector, header = STORE.types["geometry_msgs/msg/Vector3"], STORE.types["std_msgs/msg/Header"]
        stamp = STORE.types["builtin_interfaces/msg/Time"](START // 10**9, 0)
        for i in range(count):
            now = START + i * STEP
            if i % 5 == 0:
                picture = STORE.types[IMAGE](
                    header(i, stamp, "camera"), "jpeg", np.full(size, 7, dtype=np.uint8)
                )
                writer.write(image, now, STORE.serialize_ros1(picture, IMAGE))
            moved = STORE.types[TWIST](vector(float(i), 0.0, 0.0), vector(0.0, 0.0, 0.5))
            writer.write(twist, now + 1, STORE.serialize_ros1(moved, TWIST))
    return path


def test_large_messages_that_nobody_wants_are_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Images of 100 times the bytes of all that is wanted, in the very same chunks: their bytes stay on the disk."""
    path = camera_bag(tmp_path / "a.bag", 200_000, 1_000_000)
    wanted_bytes = 200 * 94
    assert path.stat().st_size > 100 * wanted_bytes * 4
    seen = 0
    window = bag1_read._Job.window

    def counted(self: Any, file: Any, at: int, size: int) -> Any:
        nonlocal seen
        data = window(self, file, at, size)
        seen += len(data)
        return data

    monkeypatch.setattr(bag1_read._Job, "window", counted)
    series, log, _ = read(path, lambda name: name == "/cmd.linear.x")
    assert series["/cmd.linear.x"][1].tolist() == [float(i) for i in range(200)]
    assert (log.status, log.messages) == ("complete", 200)
    assert seen < path.stat().st_size / 10


@pytest.mark.parametrize("size", [10, 3000, 70_000, 400_000])
@pytest.mark.parametrize("first", [64, 1000, 1 << 16])
def test_windows_of_any_size_give_the_same(
    tmp_path: Path, size: int, first: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bag1_read, "FIRST_WINDOW", first)
    path = camera_bag(tmp_path / "a.bag", size, 900_000, 60)
    series, log, _ = read(path, lambda name: name.startswith("/cmd."))
    assert series["/cmd.linear.x"][1].tolist() == [float(i) for i in range(60)]
    series, log, _ = read(path, lambda name: name.startswith("/camera."))
    assert series["/camera.header.seq"][1].tolist() == [float(i) for i in range(0, 60, 5)]
    assert (log.status, log.messages) == ("complete", 12)


def test_damage_after_a_skipped_message_costs_the_rest_of_its_chunk(tmp_path: Path) -> None:
    path = camera_bag(tmp_path / "a.bag", 200_000, 1_500_000)
    whole, _, _ = read(path, lambda name: name == "/cmd.linear.x")
    raw = bytearray(path.read_bytes())
    at = raw.index(struct.pack("<d", 33.0)) - 40
    raw[at : at + 30] = b"\xff" * 30
    path.write_bytes(raw)
    series, log, _ = read(path, lambda name: name == "/cmd.linear.x")
    left = series["/cmd.linear.x"][1].tolist()
    assert log.status == "malformed"
    assert log.rejected["damaged part of the bag"] == 1
    lost = sorted(set(whole["/cmd.linear.x"][1].tolist()) - set(left))
    assert lost[0] == 33.0
    assert lost == [float(i) for i in range(33, 33 + len(lost))]
    ((begin, end),) = log.lost_spans_ns
    assert begin == START + 32 * STEP + 1
    assert end >= START + int(lost[-1]) * STEP + 1


def records(raw: bytes) -> list[tuple[int, bytes, bytes]]:
    """(op, header, data) of the records of a bag or of a chunk's data."""
    found, at = [], len(MAGIC) if raw.startswith(MAGIC) else 0
    while at < len(raw):
        head = int.from_bytes(raw[at : at + 4], "little")
        header = raw[at + 4 : at + 4 + head]
        size = int.from_bytes(raw[at + 4 + head : at + 8 + head], "little")
        fields = parse_fields(header)
        assert fields is not None
        found.append((fields["op"][0], header, raw[at + 8 + head : at + 8 + head + size]))
        at += 8 + head + size
    return found


def joined(parts: list[tuple[int, bytes, bytes]]) -> bytes:
    return b"".join(struct.pack("<I", len(h)) + h + struct.pack("<I", len(d)) + d for _, h, d in parts)


@pytest.mark.parametrize("indexed", [True, False])
def test_messages_outside_chunks_are_read(
    tmp_path: Path, indexed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A bag without chunks: its messages lie in the file itself."""
    path = write_bag(tmp_path / "a.bag", 40)
    whole, _, _ = read(path)
    head, *rest = records(path.read_bytes())
    inside = b"".join(data for op, _, data in rest if op == 5)
    tail = joined([part for part in rest if part[0] == 7])
    place = len(MAGIC) + len(joined([head])) + len(inside)
    fields = parse_fields(head[1]) or {}
    fields |= {"index_pos": struct.pack("<Q", place if indexed else 0), "chunk_count": bytes(4)}
    header = b"".join(
        struct.pack("<I", len(name) + 1 + len(value)) + name.encode() + b"=" + value
        for name, value in fields.items()
    )
    path.write_bytes(MAGIC + joined([(3, header, head[2])]) + inside + (tail if indexed else b""))
    monkeypatch.setattr("parsers.ros.bag1_index._BARE_BYTES", 5000)
    series, log, reader = read(path)
    assert_equal(series, whole)
    assert log.messages == 40 * len(KINDS)
    assert log.status == ("complete" if indexed else "truncated")
    assert {info.count for info in reader.channels} == {40}


@pytest.mark.parametrize("claimed", [1, 7, 2**32 - 1])
def test_counts_of_the_index_are_only_a_hint(tmp_path: Path, claimed: int) -> None:
    """Too few or absurdly many messages in the index: all that the chunks hold is read, none is made up."""
    path = write_bag(tmp_path / "a.bag", 50, None, 40_000)
    whole, _, _ = read(path, lambda name: name.startswith(("/imu", "/plain")))
    changed = []
    for op, header, data in records(path.read_bytes()):
        if op == 6:
            pairs = np.frombuffer(data, dtype="<u4").reshape(-1, 2).copy()
            pairs[:, 1] = claimed
            data = pairs.tobytes()
        changed.append((op, header, data))
    path.write_bytes(MAGIC + joined(changed))
    series, log, _ = read(path, lambda name: name.startswith(("/imu", "/plain")))
    assert_equal(series, whole)
    assert (log.status, log.messages) == ("complete", 100)


@pytest.mark.parametrize("window", [1, 200, 1 << 18])
def test_index_is_read_in_windows(tmp_path: Path, window: int, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_bag(tmp_path / "a.bag", 40, None, 2000)
    whole, _, _ = read(path)
    monkeypatch.setattr("parsers.ros.bag1_index._WINDOW", window)
    series, log, _ = read(path)
    assert_equal(series, whole)
    assert log.status == "complete"


def test_topics_with_long_names_and_connections_with_any_number(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    topic = "/car" * 60
    with Writer(path) as writer:
        place = writer.add_connection(topic, TWIST, typestore=STORE)
        vector = STORE.types["geometry_msgs/msg/Vector3"]
        for i in range(5):
            moved = STORE.types[TWIST](vector(float(i), 0.0, 0.0), vector(0.0, 0.0, 0.0))
            writer.write(place, START + i, STORE.serialize_ros1(moved, TWIST))
    raw = path.read_bytes().replace(b"conn=\0\0\0\0", b"conn=\xfe\xff\xff\xff")
    parts = [
        (op, header, data.replace(bytes(4), b"\xfe\xff\xff\xff", 1) if op == 6 else data)
        for op, header, data in records(raw)
    ]
    path.write_bytes(MAGIC + joined(parts))
    series, log, _ = read(path)
    assert series[f"{topic}.linear.x"][1].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert log.status == "complete"
