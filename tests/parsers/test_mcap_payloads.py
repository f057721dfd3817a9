"""Every payload of an MCAP file (protobuf, ROS 1, ROS 2) equals what the format's own libraries decode."""

from __future__ import annotations

import io
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto
from google.protobuf.timestamp_pb2 import DESCRIPTOR as TIMESTAMP_FILE
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from mcap_files import MS, START, N, imu_definition, open_log, read, write
from mcap_protobuf.decoder import DecoderFactory as ProtobufFactory
from mcap_protobuf.schema import build_file_descriptor_set
from mcap_ros1.decoder import DecoderFactory as Ros1Factory
from mcap_ros2.decoder import DecoderFactory as Ros2Factory
from mcap_ros2.writer import Writer as Ros2Writer
from rosbags.typesys import Stores, get_typestore


def imu_message(i: int) -> Any:
    stamp = START + i * 10 * MS
    return SimpleNamespace(
        header=SimpleNamespace(
            stamp=SimpleNamespace(sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id="base_link"[: i % 10]
        ),
        covariance=[float(k) for k in range(9)],
        angular_velocity=SimpleNamespace(x=i * 0.1, y=float(-i), z=1 / (i + 1)),
        temperature=i / 3,
    )


def test_one_topic_with_two_types(tmp_path: Path) -> None:
    stream = io.BytesIO()
    writer = Writer(stream)
    writer.start()
    for k, text in enumerate([b'{"a": 1}', b'{"b": 2}', b'{"a": 3}']):
        schema = writer.register_schema(f"S{k % 2}", "jsonschema", b"{}")
        writer.add_message(writer.register_channel("t", "json", schema), START + k, text, 0)
    writer.finish()
    path = tmp_path / "a.mcap"
    path.write_bytes(stream.getvalue())
    columns, _, _ = read(path)
    assert sorted(len(column) for column in columns.values()) == [1, 2]
    assert columns["t.a"].tolist() == [1, 3]


@pytest.mark.parametrize("chunk_size", [2_000, 1 << 20])
@pytest.mark.parametrize(("first", "every"), [(50, 1), (70, 2), (1000, 1)])
def test_a_key_of_json_messages_that_comes_up_late(
    first: int, every: int, chunk_size: int, tmp_path: Path
) -> None:
    stream = io.BytesIO()
    writer = Writer(stream, chunk_size=chunk_size)
    writer.start()
    schema = writer.register_schema("S", "jsonschema", b"{}")
    channel = writer.register_channel("t", "json", schema)
    for k in range(2000):
        late = f', "accel_y": {k}' if k >= first and k % every == 0 else ""
        writer.add_message(channel, START + k * MS, f'{{"speed": {k}{late}}}'.encode(), 0)
    writer.finish()
    path = tmp_path / "a.mcap"
    path.write_bytes(stream.getvalue())
    columns, _, log = read(path)
    ay = columns["t.accel_y"]
    assert ay[np.isfinite(ay)].tolist() == list(range(first, 2000, every))
    assert not log.notes


def vehicle_class() -> Any:
    file = FileDescriptorProto(name="v.proto", package="my", syntax="proto3")
    file.dependency.append("google/protobuf/timestamp.proto")
    message = file.message_type.add(name="Vehicle")
    kinds = FieldDescriptorProto
    message.field.add(
        name="timestamp", number=1, type=kinds.TYPE_MESSAGE, type_name=".google.protobuf.Timestamp", label=1
    )
    message.field.add(name="ax", number=2, type=kinds.TYPE_DOUBLE, label=1)
    message.field.add(name="wheels", number=3, type=kinds.TYPE_FLOAT, label=3)
    pool = descriptor_pool.DescriptorPool()
    stamp = FileDescriptorProto()
    TIMESTAMP_FILE.CopyToProto(stamp)
    pool.Add(stamp)
    pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName("my.Vehicle"))


def test_protobuf_topic(tmp_path: Path) -> None:
    peer = vehicle_class()
    stream = io.BytesIO()
    writer = Writer(stream, chunk_size=3000)
    writer.start()
    schema = writer.register_schema(
        "my.Vehicle", "protobuf", build_file_descriptor_set(peer).SerializeToString()
    )
    channel = writer.register_channel("/vehicle", "protobuf", schema)
    for i in range(N):
        message = peer(ax=i / 9, wheels=[i, 2 * i], timestamp={"seconds": START // 10**9, "nanos": i})
        writer.add_message(channel, START + i * MS, message.SerializeToString(), 0)
    writer.finish()
    path = tmp_path / "a.mcap"
    path.write_bytes(stream.getvalue())
    columns, times, log = read(path)
    np.testing.assert_array_equal(columns["/vehicle.ax"], np.arange(N) / 9)
    np.testing.assert_array_equal(columns["/vehicle.wheels[1]"], 2.0 * np.arange(N))
    np.testing.assert_array_equal(times["/vehicle"], START + np.arange(N))
    reader, _ = open_log(path)
    assert reader.clock == "header stamp"
    channel_info = next(c for c in reader.channels if c.name == "/vehicle.ax")
    assert (channel_info.family, channel_info.tags["type"]) == ("json", "my.Vehicle")
    assert log.status == "complete"


def test_ros2_topic_equals_the_library(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = Ros2Writer(file, chunk_size=5000)
        schema = writer.register_msgdef("sensor_msgs/msg/Imu", imu_definition(2))
        for i in range(N):
            writer.write_message("/imu", schema, imu_message(i), START + i * 10 * MS + 7, START)
        writer.finish()
    columns, times, _ = read(path)
    with path.open("rb") as file:
        peers = [
            m.decoded_message
            for m in make_reader(file, decoder_factories=[Ros2Factory()]).iter_decoded_messages()
        ]
    np.testing.assert_array_equal(columns["/imu.angular_velocity.z"], [m.angular_velocity.z for m in peers])
    np.testing.assert_array_equal(columns["/imu.temperature"], [m.temperature for m in peers])
    np.testing.assert_array_equal(columns["/imu.covariance[8]"], [m.covariance[8] for m in peers])
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in peers]
    np.testing.assert_array_equal(times["/imu"], stamps)
    imu = next(c for c in open_log(path)[0].channels if c.name == "/imu.temperature")
    assert imu.tags["type"] == "sensor_msgs/Imu"


def test_ros1_topic_equals_the_library(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap")
    columns, _, _ = read(path, "/imu")
    with path.open("rb") as file:
        found = make_reader(file, decoder_factories=[Ros1Factory()]).iter_decoded_messages(topics=["/imu"])
        peers = [m.decoded_message for m in found]
    np.testing.assert_array_equal(columns["/imu.angular_velocity.z"], [m.angular_velocity.z for m in peers])
    np.testing.assert_array_equal(columns["/imu.temperature"], [m.temperature for m in peers])


@pytest.mark.parametrize("little", [True, False])
def test_cdr_of_both_byte_orders_equals_rosbags(tmp_path: Path, little: bool) -> None:
    """A frame name of every length moves the numbers behind it over all alignments."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    kind = "geometry_msgs/msg/TwistStamped"
    t = store.types
    stream = io.BytesIO()
    writer = Writer(stream, chunk_size=6000)
    writer.start(profile="ros2")
    text = store.generate_msgdef(kind, ros_version=2)[0].encode()
    channel = writer.register_channel("/speed", "cdr", writer.register_schema(kind, "ros2msg", text))
    rows = np.random.default_rng(6).normal(size=(N, 6))
    vector = t["geometry_msgs/msg/Vector3"]
    peers = []
    for i, row in enumerate(rows.tolist()):
        stamp = t["builtin_interfaces/msg/Time"](sec=START // 10**9, nanosec=i)
        head = t["std_msgs/msg/Header"](stamp=stamp, frame_id="f" * (i % 11))
        twist = t["geometry_msgs/msg/Twist"](vector(*row[:3]), vector(*row[3:]))
        raw = bytes(store.serialize_cdr(t[kind](head, twist), kind, little_endian=little))
        peers.append(store.deserialize_cdr(raw, kind))
        writer.add_message(channel, START + i, raw, START)
    writer.finish()
    path = tmp_path / "a.mcap"
    path.write_bytes(stream.getvalue())
    columns, times, log = read(path)
    for part in ("linear", "angular"):
        for axis in "xyz":
            expected = [getattr(getattr(m.twist, part), axis) for m in peers]
            np.testing.assert_array_equal(columns[f"/speed.twist.{part}.{axis}"], expected)
    np.testing.assert_array_equal(times["/speed"], START // 10**9 * 10**9 + np.arange(N))
    assert not log.rejected


def test_protobuf_equals_the_library(tmp_path: Path) -> None:
    peer = vehicle_class()
    stream = io.BytesIO()
    writer = Writer(stream, chunk_size=2000, compression=CompressionType.LZ4)
    writer.start()
    definition = build_file_descriptor_set(peer).SerializeToString()
    channel = writer.register_channel(
        "/vehicle", "protobuf", writer.register_schema("my.Vehicle", "protobuf", definition)
    )
    rng = np.random.default_rng(9)
    for i in range(N):
        message = peer(
            ax=rng.normal() if i % 3 else 0.0, wheels=rng.normal(size=i % 5), timestamp={"seconds": i}
        )
        writer.add_message(channel, START + i, message.SerializeToString(), 0)
    writer.finish()
    path = tmp_path / "a.mcap"
    path.write_bytes(stream.getvalue())
    columns, _, _ = read(path)
    with path.open("rb") as file:
        found = make_reader(file, decoder_factories=[ProtobufFactory()]).iter_decoded_messages()
        peers = [m.decoded_message for m in found]
    np.testing.assert_array_equal(columns["/vehicle.ax"], [m.ax for m in peers])
    for k in range(4):
        expected = [m.wheels[k] if len(m.wheels) > k else np.nan for m in peers]
        np.testing.assert_array_equal(columns[f"/vehicle.wheels[{k}]"], expected)
