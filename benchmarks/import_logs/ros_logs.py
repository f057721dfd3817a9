"""ROS and MCAP logs of a drive: an IMU, an odometry and a speed topic, 472 messages a second in all."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Bag1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Bag2Writer
from rosbags.typesys import Stores, get_typestore

RATES = {"/imu": 300, "/odometry": 100, "/speed": 72}
TYPES = {
    "/imu": "sensor_msgs/msg/Imu",
    "/odometry": "nav_msgs/msg/Odometry",
    "/speed": "geometry_msgs/msg/TwistStamped",
}
WANTED = (
    *(f"/imu.{group}.{axis}" for group in ("linear_acceleration", "angular_velocity") for axis in "xyz"),
    "/odometry.twist.twist.linear.x",
    "/odometry.pose.pose.position.x",
    "/odometry.pose.pose.position.y",
    "/speed.twist.linear.x",
)
START_NS = 1_760_000_000_000_000_000


def schedule(seconds: float, seed: int) -> Iterator[tuple[str, int, int, np.ndarray]]:
    """(topic, number, stamp, 12 values) in time order."""
    rng = np.random.default_rng(seed)
    topics = [(topic, np.arange(0, seconds, 1 / rate)) for topic, rate in RATES.items()]
    times = np.concatenate([t for _, t in topics])
    names = np.concatenate([np.full(len(t), k) for k, (_, t) in enumerate(topics)])
    order = np.argsort(times, kind="stable")
    values = rng.standard_normal((len(times), 12))
    for number, row in enumerate(order.tolist()):
        yield topics[int(names[row])][0], number, START_NS + round(times[row] * 1e9), values[row]


def _maker(kind: Stores) -> tuple[Any, Callable[[str, int, int, np.ndarray], Any]]:
    store = get_typestore(kind)
    t = store.types
    header, time = t["std_msgs/msg/Header"], t["builtin_interfaces/msg/Time"]
    vector, point = t["geometry_msgs/msg/Vector3"], t["geometry_msgs/msg/Point"]
    quaternion, pose, twist = (t[f"geometry_msgs/msg/{name}"] for name in ("Quaternion", "Pose", "Twist"))
    pose_cov, twist_cov = (
        t["geometry_msgs/msg/PoseWithCovariance"],
        t["geometry_msgs/msg/TwistWithCovariance"],
    )
    nine, many = np.zeros(9), np.zeros(36)
    extra = {"seq": 0} if kind is Stores.ROS1_NOETIC else {}

    def make(topic: str, number: int, stamp: int, v: np.ndarray) -> Any:
        x = v.tolist()
        head = header(stamp=time(sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id="base_link", **extra)
        turn = quaternion(x=0.0, y=0.0, z=0.0, w=1.0)
        linear, angular = vector(x=x[0], y=x[1], z=x[2]), vector(x=x[3], y=x[4], z=x[5])
        if topic == "/imu":
            return t[TYPES[topic]](head, turn, nine, angular, nine, linear, nine)
        motion = twist(linear=linear, angular=angular)
        if topic == "/speed":
            return t[TYPES[topic]](head, motion)
        place = pose(position=point(x=x[6], y=x[7], z=x[8]), orientation=turn)
        return t[TYPES[topic]](head, "base_link", pose_cov(place, many), twist_cov(motion, many))

    return store, make


def write_bag1(seconds: float, seed: int, path: Path, *, lz4: bool) -> None:
    """ROS 1 bag."""
    store, make = _maker(Stores.ROS1_NOETIC)
    path.unlink(missing_ok=True)
    writer = Bag1Writer(path)
    if lz4:
        writer.set_compression(Bag1Writer.CompressionFormat.LZ4)
    with writer:
        places = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in TYPES.items()}
        for topic, number, stamp, values in schedule(seconds, seed):
            data = store.serialize_ros1(make(topic, number, stamp, values), TYPES[topic])
            writer.write(places[topic], stamp, data)


def write_bag2(seconds: float, seed: int, path: Path) -> None:
    """ROS 2 bag, sqlite3."""
    store, make = _maker(Stores.ROS2_HUMBLE)
    shutil.rmtree(path, ignore_errors=True)
    with Bag2Writer(path, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        places = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in TYPES.items()}
        for topic, number, stamp, values in schedule(seconds, seed):
            writer.write(
                places[topic], stamp, store.serialize_cdr(make(topic, number, stamp, values), TYPES[topic])
            )


def write_mcap_ros2(seconds: float, seed: int, path: Path) -> None:
    """MCAP with CDR payloads, zstd."""
    store, make = _maker(Stores.ROS2_HUMBLE)
    with path.open("wb") as stream:
        writer = McapWriter(stream, compression=CompressionType.ZSTD)
        writer.start(profile="ros2")
        places = {}
        for topic, kind in TYPES.items():
            text, _ = store.generate_msgdef(kind, ros_version=2)
            places[topic] = writer.register_channel(
                topic, "cdr", writer.register_schema(kind, "ros2msg", text.encode())
            )
        for topic, number, stamp, values in schedule(seconds, seed):
            data = bytes(store.serialize_cdr(make(topic, number, stamp, values), TYPES[topic]))
            writer.add_message(places[topic], stamp, data, stamp, number)
        writer.finish()


FIELDS = tuple(f"value{k}" for k in range(12))


def write_mcap_json(seconds: float, seed: int, path: Path) -> None:
    """MCAP with JSON payloads, zstd."""
    schema = {"type": "object", "properties": {name: {"type": "number"} for name in FIELDS}}
    with path.open("wb") as stream:
        writer = McapWriter(stream, compression=CompressionType.ZSTD)
        writer.start()
        number = writer.register_schema("State", "jsonschema", json.dumps(schema).encode())
        places = {topic: writer.register_channel(topic, "json", number) for topic in TYPES}
        for topic, count, stamp, values in schedule(seconds, seed):
            body = json.dumps(dict(zip(FIELDS, values.round(6).tolist(), strict=True)))
            writer.add_message(places[topic], stamp, body.encode(), stamp, count)
        writer.finish()


def write_mcap_protobuf(seconds: float, seed: int, path: Path) -> None:
    """MCAP with protobuf payloads, zstd."""
    kind = descriptor_pb2.FieldDescriptorProto
    file = descriptor_pb2.FileDescriptorProto(name="state.proto", package="bench", syntax="proto3")
    message = file.message_type.add(name="State")
    for number, name in enumerate(FIELDS, start=1):
        message.field.add(name=name, number=number, type=kind.TYPE_DOUBLE, label=kind.LABEL_OPTIONAL)
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    state = message_factory.GetMessageClass(pool.FindMessageTypeByName("bench.State"))
    with path.open("wb") as stream:
        writer = McapWriter(stream, compression=CompressionType.ZSTD)
        writer.start()
        files = descriptor_pb2.FileDescriptorSet(file=[file]).SerializeToString()
        schema = writer.register_schema("bench.State", "protobuf", files)
        places = {topic: writer.register_channel(topic, "protobuf", schema) for topic in TYPES}
        for topic, count, stamp, values in schedule(seconds, seed):
            data = state(**dict(zip(FIELDS, values.tolist(), strict=True))).SerializeToString()
            writer.add_message(places[topic], stamp, data, stamp, count)
        writer.finish()
