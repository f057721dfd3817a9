"""ROS 1 bags: values against rosbags' reader, containers made by its writer, and damage of all kinds."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag1 import Reader, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from parsers.channels import FloatArray, IntArray
from parsers.errors import LogError
from parsers.importer import ImportLog, LogReader, ReadOptions
from parsers.registry import read_head
from parsers.ros.bag1_records import parse_fields
from parsers.rosbag1_log import RosBag1Importer

HUSKY = Path(__file__).parents[2].parent / "shared" / "real_logs" / "husky_imu_odometry.bag"
STORE = get_typestore(Stores.ROS1_NOETIC)
START = 1_700_000_000_000_000_000
COUNT = 400
IMU, TWIST, TEXT = "sensor_msgs/msg/Imu", "geometry_msgs/msg/Twist", "std_msgs/msg/String"
FORMATS = (None, Writer.CompressionFormat.BZ2, Writer.CompressionFormat.LZ4)


def imu(i: int, stamp_ns: int) -> Any:
    t = STORE.types
    vector, zero9 = t["geometry_msgs/msg/Vector3"], np.arange(9.0)
    stamp = t["builtin_interfaces/msg/Time"](stamp_ns // 10**9, stamp_ns % 10**9)
    header = t["std_msgs/msg/Header"](seq=i, stamp=stamp, frame_id="imu" * (i % 4))
    turn = t["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    return t[IMU](header, turn, zero9, vector(0.1 * i, 0.2, 0.3), zero9 + 1, vector(1.0, 2.0, 9.8 + i), zero9)


def twist(i: int) -> Any:
    vector = STORE.types["geometry_msgs/msg/Vector3"]
    return STORE.types[TWIST](vector(i * 0.5, 0.0, 0.0), vector(0.0, 0.0, -0.25 * i))


def make_bag(path: Path, compression: Any = None, chunk: int = 8192, delay_ns: int = 20_000_000) -> Path:
    """400 Imu (header stamps `delay_ns` before the receive time) and 400 Twist messages at 100 Hz, and some texts."""
    writer = Writer(path)
    writer.chunk_threshold = chunk
    if compression is not None:
        writer.set_compression(compression)
    with writer:
        first = writer.add_connection("/imu/data", IMU, typestore=STORE)
        second = writer.add_connection("/cmd", TWIST, typestore=STORE)
        third = writer.add_connection("/said", TEXT, typestore=STORE)
        for i in range(COUNT):
            now = START + i * 10_000_000
            writer.write(first, now, STORE.serialize_ros1(imu(i, now - delay_ns), IMU))
            writer.write(second, now + 1, STORE.serialize_ros1(twist(i), TWIST))
            if i % 10 == 0:
                said = STORE.types[TEXT]("word " * i)
                writer.write(third, now + 2, STORE.serialize_ros1(said, TEXT))
    return path


def opened(path: Path) -> tuple[LogReader, ImportLog]:
    log = ImportLog()
    importer = RosBag1Importer()
    assert importer.claims(path, read_head(path))
    return importer.open(path, ReadOptions(), log), log


def collect(reader: LogReader, wanted: set[str]) -> dict[str, tuple[IntArray, FloatArray]]:
    found: dict[str, list[tuple[IntArray, FloatArray]]] = {}
    for chunk in reader.read(frozenset(wanted)):
        for name, values in chunk.columns.items():
            assert name in wanted
            assert len(values) == len(chunk.time_ns)
            found.setdefault(name, []).append((chunk.time_ns, values))
    return {
        k: (np.concatenate([t for t, _ in v]), np.concatenate([x for _, x in v])) for k, v in found.items()
    }


def all_numbers(reader: LogReader) -> set[str]:
    return {info.name for info in reader.channels if info.kind == "number"}


def test_real_bag_equals_the_peer_value_by_value() -> None:
    if not HUSKY.exists():
        pytest.skip("the real log husky_imu_odometry.bag is not here")
    reader, log = opened(HUSKY)
    got = collect(reader, all_numbers(reader))
    store = get_typestore(Stores.EMPTY)
    messages = 0
    with Reader(HUSKY) as peer:
        for connection in peer.connections:
            store.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
        for connection in peer.connections:
            raw: list[Any] = [
                store.deserialize_ros1(m[2], connection.msgtype) for m in peer.messages([connection])
            ]
            messages += len(raw)
            stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in raw]
            infos = [c for c in reader.channels if c.group == connection.topic and c.kind == "number"]
            assert len(infos) > 30
            for info in infos:
                path = info.tags["field"]
                times, values = got[info.name]
                assert times.tolist() == stamps
                assert info.count == len(raw)
                if path != "header.stamp":
                    np.testing.assert_array_equal(values, [value_at(m, path) for m in raw], err_msg=info.name)
    assert (log.status, log.messages, sum(log.rejected.values())) == ("complete", messages, 0)
    assert not reader.absolute  # recorded on simulated time
    assert any("no wall clock (it begins at 47.6 s" in note for note in log.notes)
    assert {c.tags["type"] for c in reader.channels} == {"sensor_msgs/Imu", "nav_msgs/Odometry"}


def value_at(message: Any, path: str) -> float:
    for part in path.replace("[", ".[").split("."):
        message = message[int(part[1:-1])] if part.startswith("[") else getattr(message, part)
    return float(message)


@pytest.mark.parametrize("compression", FORMATS)
def test_every_compression_gives_the_same(tmp_path: Path, compression: Any) -> None:
    reader, log = opened(make_bag(tmp_path / "a.bag", compression))
    wanted = {"/imu/data.angular_velocity.x", "/imu/data.angular_velocity_covariance[8]", "/cmd.angular.z"}
    got = collect(reader, wanted)
    assert set(got) == wanted
    i = np.arange(COUNT)
    np.testing.assert_array_equal(got["/imu/data.angular_velocity.x"][1], [0.1 * k for k in range(COUNT)])
    np.testing.assert_array_equal(got["/imu/data.angular_velocity.x"][0], START - 20_000_000 + i * 10_000_000)
    np.testing.assert_array_equal(got["/imu/data.angular_velocity_covariance[8]"][1], np.full(COUNT, 9.0))
    np.testing.assert_array_equal(got["/cmd.angular.z"][1], -0.25 * i)
    np.testing.assert_array_equal(got["/cmd.angular.z"][0], START + 1 + i * 10_000_000)
    assert (log.status, log.messages) == ("complete", 2 * COUNT)
    assert reader.clock == "header stamp (receive time for /cmd)"
    assert reader.absolute


def test_checksums_of_compressed_chunks_are_compared(tmp_path: Path) -> None:
    """A wrong bit that still unpacks to the right number of bytes must not pass for data."""
    raw = make_bag(tmp_path / "a.bag", Writer.CompressionFormat.BZ2).read_bytes()
    _, _, begin, end = chunks(raw)[0]
    rng = np.random.default_rng(2)
    for trial in range(40):
        bad = bytearray(raw)
        bad[int(rng.integers(begin + 30, end - 8))] ^= 1 << int(rng.integers(0, 8))
        path = tmp_path / f"{trial}.bag"
        path.write_bytes(bad)
        reader, log = opened(path)
        values = collect(reader, {"/imu/data.angular_velocity.x"})["/imu/data.angular_velocity.x"][1]
        assert log.status == "malformed"
        assert set(values) <= {0.1 * k for k in range(COUNT)}


def test_channels_name_topic_type_and_field(tmp_path: Path) -> None:
    reader, _ = opened(make_bag(tmp_path / "a.bag"))
    by_name = {info.name: info for info in reader.channels}
    info = by_name["/imu/data.angular_velocity.z"]
    assert (info.family, info.group, info.kind, info.count) == ("ros", "/imu/data", "number", COUNT)
    assert dict(info.tags) == {"topic": "/imu/data", "type": "sensor_msgs/Imu", "field": "angular_velocity.z"}
    assert by_name["/said.data"].kind == "text"
    assert by_name["/imu/data.header.frame_id"].kind == "text"


def test_unwanted_chunks_are_not_read(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    with Writer(path) as writer:
        writer.chunk_threshold = 10
        first = writer.add_connection("/a", TWIST, typestore=STORE)
        second = writer.add_connection("/b", TEXT, typestore=STORE)
        for i in range(10):
            writer.write(first, START + i, STORE.serialize_ros1(twist(i), TWIST))
            writer.write(second, START + i, STORE.serialize_ros1(STORE.types[TEXT]("MARK"), TEXT))
    raw = bytearray(path.read_bytes())
    at = raw.find(b"MARK")
    assert at > 0
    for k in range(
        raw.count(b"MARK")
    ):  # lengths before the texts are destroyed: reading them would be noticed
        raw[at - 12 : at] = b"\xff" * 12
        at = raw.find(b"MARK", at + 1)
        assert at > 0 or k == 9
    path.write_bytes(raw)
    reader, log = opened(path)
    got = collect(reader, {"/a.linear.x"})
    assert got["/a.linear.x"][1].tolist() == [0.5 * i for i in range(10)]
    assert log.status == "complete"


def test_delay_between_header_and_receive_time_is_said(tmp_path: Path) -> None:
    reader, log = opened(make_bag(tmp_path / "a.bag", delay_ns=1_500_000_000))
    collect(reader, {"/imu/data.angular_velocity.x"})
    assert any("1.50 s before the receive time" in note for note in log.notes)


def test_clock_of_another_kind_gives_way_to_receive_time(tmp_path: Path) -> None:
    reader, log = opened(make_bag(tmp_path / "a.bag", delay_ns=START - 10**9))
    got = collect(reader, {"/imu/data.angular_velocity.x"})
    assert got["/imu/data.angular_velocity.x"][0][0] == START
    assert any("another clock" in note for note in log.notes)
    assert reader.clock == "receive time"


def test_one_topic_with_two_types_and_two_publishers(tmp_path: Path) -> None:
    path = tmp_path / "a.bag"
    with Writer(path) as writer:
        a = writer.add_connection("/x", TWIST, typestore=STORE, callerid="/one")
        b = writer.add_connection("/x", TWIST, typestore=STORE, callerid="/two")
        c = writer.add_connection("/x", "std_msgs/msg/Float64", typestore=STORE)
        for i in range(4):
            writer.write(a if i % 2 else b, START + i, STORE.serialize_ros1(twist(i), TWIST))
        payload = STORE.serialize_ros1(STORE.types["std_msgs/msg/Float64"](7.0), "std_msgs/msg/Float64")
        writer.write(c, START, payload)
    reader, _ = opened(path)
    got = collect(reader, all_numbers(reader))
    assert got["/x.linear.x"][1].tolist() == [0.0, 0.5, 1.0, 1.5]
    assert got["/x (std_msgs/Float64).data"][1].tolist() == [7.0]


def records(raw: bytes) -> list[tuple[int, int, int, int]]:
    """(op, start, data start, end) of the records of a bag."""
    found, at = [], 13
    while at < len(raw):
        head = struct.unpack_from("<I", raw, at)[0]
        fields = parse_fields(raw[at + 4 : at + 4 + head])
        assert fields is not None
        size = struct.unpack_from("<I", raw, at + 4 + head)[0]
        found.append((fields["op"][0], at, at + 8 + head, at + 8 + head + size))
        at = found[-1][3]
    return found


def chunks(raw: bytes) -> list[tuple[int, int, int, int]]:
    return [record for record in records(raw) if record[0] == 5]


@pytest.mark.parametrize("compression", FORMATS)
@pytest.mark.parametrize("part", [0.5, 0.95])
def test_bag_that_breaks_off_gives_all_that_is_whole(tmp_path: Path, compression: Any, part: float) -> None:
    path = make_bag(tmp_path / "a.bag", compression)
    raw = path.read_bytes()
    _, _, begin, end = chunks(raw)[-3]
    path.write_bytes(raw[: begin + int((end - begin) * part)])
    reader, log = opened(path)
    values = collect(reader, {"/imu/data.angular_velocity.x"})["/imu/data.angular_velocity.x"][1]
    assert log.status == "truncated"
    assert any("breaks off at byte" in note and "s were found" in note for note in log.notes)
    np.testing.assert_array_equal(values, [0.1 * k for k in range(len(values))])
    before = b"".join(raw[b:e] for _, _, b, e in chunks(raw)[:-3])
    if compression is None:
        assert len(values) > before.count(b"imuimu")
    assert len(values) > COUNT * 0.7
    assert not log.rejected


def test_bag_without_index(tmp_path: Path) -> None:
    path = make_bag(tmp_path / "a.bag")
    raw = path.read_bytes()
    index = next(start for op, start, _, _ in records(raw)[2:] if op == 7)
    head = raw[:index].replace(b"index_pos=" + struct.pack("<Q", index), b"index_pos=" + bytes(8))
    path.write_bytes(head)
    reader, log = opened(path)
    assert len(collect(reader, {"/cmd.linear.x"})["/cmd.linear.x"][1]) == COUNT
    assert log.status == "truncated"
    assert any("has no index" in note for note in log.notes)
    assert {info.count for info in reader.channels if info.group == "/cmd"} == {COUNT}


@pytest.mark.parametrize("compression", FORMATS)
def test_damaged_middle_costs_a_chunk_not_the_bag(tmp_path: Path, compression: Any) -> None:
    path = make_bag(tmp_path / "a.bag", compression)
    raw = bytearray(path.read_bytes())
    _, _, begin, end = chunks(bytes(raw))[2]
    middle = (begin + end) // 2
    raw[middle : middle + 300] = b"\xee" * 300
    path.write_bytes(raw)
    reader, log = opened(path)
    values = collect(reader, {"/imu/data.angular_velocity.x"})["/imu/data.angular_velocity.x"][1]
    assert log.status == "malformed"
    assert log.rejected["damaged part of the bag"] == 1
    assert len(log.lost_spans_ns) == 1
    (start, stop) = log.lost_spans_ns[0]
    assert START <= start < stop <= START + COUNT * 10_000_000
    lost = COUNT - len(values)
    assert 0 < lost <= (stop - start) // 10_000_000 + 2
    assert set(values) <= {0.1 * k for k in range(COUNT)}


@pytest.mark.parametrize("indexed", [True, False])
def test_damaged_record_headers_are_passed(tmp_path: Path, indexed: bool) -> None:
    path = make_bag(tmp_path / "a.bag")
    raw = bytearray(path.read_bytes())
    every = chunks(bytes(raw))
    raw[every[3][1] : every[3][1] + 40] = b"\x7f" * 40
    if not indexed:
        raw = raw[: every[-1][1]]
    path.write_bytes(raw)
    reader, log = opened(path)
    values = collect(reader, {"/imu/data.angular_velocity.x"})["/imu/data.angular_velocity.x"][1]
    assert log.status == "malformed"
    assert log.lost_spans_ns
    assert COUNT * 0.6 < len(values) < COUNT
    assert 0.1 * 0 in values
    assert values[-1] > 0.1 * COUNT * 0.85


def test_damaged_index_is_replaced_by_a_search(tmp_path: Path) -> None:
    path = make_bag(tmp_path / "a.bag")
    raw = bytearray(path.read_bytes())
    raw[records(bytes(raw))[-1][1] : records(bytes(raw))[-1][1] + 30] = b"\xff" * 30
    path.write_bytes(raw)
    reader, log = opened(path)
    assert len(collect(reader, {"/cmd.linear.x"})["/cmd.linear.x"][1]) == COUNT
    assert log.status == "malformed"


def test_lying_sizes_are_refused_before_allocating(tmp_path: Path) -> None:
    path = make_bag(tmp_path / "a.bag", Writer.CompressionFormat.LZ4)
    raw = path.read_bytes()
    at = raw.find(b"size=")
    path.write_bytes(raw[: at + 5] + b"\xff\xff\xff\xff" + raw[at + 9 :])
    reader, log = opened(path)
    assert len(collect(reader, {"/cmd.linear.x"})["/cmd.linear.x"][1]) > COUNT // 2
    assert log.status == "malformed"
    assert any("which cannot be right" in note for note in log.notes)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"#ROSBAG V1.2\n" + bytes(100), "rosbag migrate"),
        (b"#ROSBAG V2.0\n", "no messages were found"),
        (b"#ROSBAG V2.0\n" + b"\xff" * 5000, "no messages were found"),
        (b"#ROSBAG V2.0\n" + bytes(5000), "no messages were found"),
    ],
)
def test_unusable_bags_end_with_one_line(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "a.bag"
    path.write_bytes(content)
    with pytest.raises(LogError, match=words) as caught:
        opened(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_unknown_types_are_left_out_by_name(tmp_path: Path) -> None:
    path = make_bag(tmp_path / "a.bag")
    raw = path.read_bytes()
    old = b"geometry_msgs/Vector3 linear\n"
    path.write_bytes(raw.replace(old, b"geometry_msgs/Unknown linear\n"))
    reader, log = opened(path)
    assert not [info for info in reader.channels if info.group == "/cmd"]
    assert any("geometry_msgs/Twist was left out" in note for note in log.notes)
    assert len(collect(reader, {"/imu/data.header.seq"})["/imu/data.header.seq"][1]) == COUNT


def test_no_random_damage_crashes(tmp_path: Path) -> None:
    raw = make_bag(tmp_path / "a.bag").read_bytes()
    rng = np.random.default_rng(3)
    for trial in range(60):
        bad = bytearray(raw[: int(rng.integers(13, len(raw)))] if trial % 3 == 0 else raw)
        for _ in range(30):
            at = int(rng.integers(13, len(bad)))
            bad[at : at + 4] = rng.integers(0, 256, 4, dtype=np.uint8).tobytes()
        path = tmp_path / f"{trial}.bag"
        path.write_bytes(bad)
        try:
            reader, log = opened(path)
            collect(reader, all_numbers(reader))
        except LogError:
            continue
        assert log.messages <= 2 * COUNT + COUNT // 10


def test_batches_stay_small_for_types_with_many_fields(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("parsers.ros.topics.MAX_CELLS", 300)
    reader, log = opened(make_bag(tmp_path / "a.bag"))
    sizes = []
    for chunk in reader.read(frozenset(all_numbers(reader))):
        sizes.append(len(chunk.time_ns) * len(chunk.columns))
    assert max(sizes) <= 300
    assert log.messages == 2 * COUNT
