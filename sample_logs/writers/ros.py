"""ROS 1 bag, ROS 2 bags (sqlite3, mcap), MCAP with ROS 1, ROS 2, JSON and protobuf messages."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Bag1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Bag2Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from sample_logs.writers.common import SampleDrive, quaternion, stamps_ns

CHASSIS = "vehicle_msgs/msg/ChassisState"
CHASSIS_DEFINITION = """std_msgs/Header header
string mode
float64 steering_wheel_angle
float32[4] suspension_deflection
float32[4] wheel_speed
float32 brake_pressure
float32 brake_torque
float32 drive_torque
"""

WHEELS = ("fl", "fr", "rl", "rr")


def _entry(signal: str, field: str, unit: str) -> str:
    return f'[signals.{signal}]\nchannel = "/chassis.{field}"\nunit = "{unit}"\n\n'


MAP = (
    _entry("steering_wheel_angle", "steering_wheel_angle", "rad")
    + "".join(
        _entry(f"{name}_{w}", f"{name}[{i}]", unit)
        for name, unit in (("suspension_deflection", "m"), ("wheel_speed", "m/s"))
        for i, w in enumerate(WHEELS)
    )
    + _entry("brake_pressure", "brake_pressure", "Pa")
    + _entry("brake_torque", "brake_torque", "N·m")
    + _entry("drive_torque", "drive_torque", "N·m")
)


def _store(kind: Stores) -> Typestore:
    store = get_typestore(kind)
    store.register(get_types_from_msg(CHASSIS_DEFINITION, CHASSIS))
    return store


def _messages(store: Typestore, drive: SampleDrive, *, ros1: bool) -> list[tuple[str, str, int, Any]]:
    """(topic, type, stamp, message) in time order; received 3 ms after the header's stamp."""
    t = store.types
    header, time = t["std_msgs/msg/Header"], t["builtin_interfaces/msg/Time"]
    imu, vector = t["sensor_msgs/msg/Imu"], t["geometry_msgs/msg/Vector3"]
    turn, twist, stamped = (
        t["geometry_msgs/msg/Quaternion"],
        t["geometry_msgs/msg/Twist"],
        t["geometry_msgs/msg/TwistStamped"],
    )
    s = drive.signals
    attitude = quaternion(s["roll"], s["pitch"])
    unknown = np.zeros(9)
    out: list[tuple[str, str, int, Any]] = []
    for i, stamp in enumerate(stamps_ns(drive)):
        sec, nanosec = divmod(int(stamp), 1_000_000_000)
        extra = {"seq": i} if ros1 else {}
        head = header(stamp=time(sec=sec, nanosec=nanosec), frame_id="base_link", **extra)
        x, y, z, w = (float(v) for v in attitude[i])
        rates = vector(x=float(s["roll_rate"][i]), y=float(s["pitch_rate"][i]), z=float(s["yaw_rate"][i]))
        accel = vector(x=float(s["accel_x"][i]), y=float(s["accel_y"][i]), z=float(s["accel_z"][i]))
        out.append(
            (
                "/imu",
                "sensor_msgs/msg/Imu",
                int(stamp),
                imu(head, turn(x=x, y=y, z=z, w=w), unknown, rates, unknown, accel, unknown),
            )
        )
        linear = vector(x=float(s["speed"][i]), y=0.0, z=0.0)
        out.append(
            (
                "/speed",
                "geometry_msgs/msg/TwistStamped",
                int(stamp),
                stamped(head, twist(linear=linear, angular=vector(x=0.0, y=0.0, z=0.0))),
            )
        )
        travel, wheels = (
            np.array([s[f"{name}_{w}"][i] for w in WHEELS], dtype=np.float32)
            for name in ("suspension_deflection", "wheel_speed")
        )
        rest = [float(s[name][i]) for name in ("brake_pressure", "brake_torque", "drive_torque")]
        mode, angle = "auto" if i % 3 else "manual", float(s["steering_wheel_angle"][i])
        chassis = t[CHASSIS](head, mode, angle, travel, wheels, *rest)
        out.append(("/chassis", CHASSIS, int(stamp), chassis))
    return out


RECEIVE_NS = 3_000_000


def write_bag1(drive: SampleDrive, path: Path) -> None:
    """A ROS 1 bag, lz4 chunks, with a custom type."""
    store = _store(Stores.ROS1_NOETIC)
    path.unlink(missing_ok=True)
    writer = Bag1Writer(path)
    writer.set_compression(Bag1Writer.CompressionFormat.LZ4)
    with writer:
        connections = {}
        for topic, kind, stamp, message in _messages(store, drive, ros1=True):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], stamp + RECEIVE_NS, store.serialize_ros1(message, kind))


def write_bag2(drive: SampleDrive, path: Path, plugin: StoragePlugin) -> None:
    """A ROS 2 bag folder with sqlite3 or mcap storage."""
    store = _store(Stores.ROS2_HUMBLE)
    shutil.rmtree(path, ignore_errors=True)
    with Bag2Writer(path, version=9, storage_plugin=plugin) as writer:
        connections = {}
        for topic, kind, stamp, message in _messages(store, drive, ros1=False):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], stamp + RECEIVE_NS, store.serialize_cdr(message, kind))


def _definition(store: Typestore, kind: str, ros_version: int) -> str:
    text, _ = store.generate_msgdef(kind, ros_version=ros_version)
    return text


def write_mcap_ros(drive: SampleDrive, path: Path, *, ros1: bool) -> None:
    """MCAP with ROS 1 or CDR payloads, zstd chunks."""
    store = _store(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    with path.open("wb") as stream:
        writer = McapWriter(stream, compression=CompressionType.ZSTD)
        writer.start(profile="ros1" if ros1 else "ros2", library="cogest sample")
        channels: dict[str, int] = {}
        for number, (topic, kind, stamp, message) in enumerate(_messages(store, drive, ros1=ros1)):
            if topic not in channels:
                text = _definition(store, kind, 1 if ros1 else 2)
                name = kind.replace("/msg/", "/") if ros1 else kind
                schema = writer.register_schema(name, "ros1msg" if ros1 else "ros2msg", text.encode())
                channels[topic] = writer.register_channel(topic, "ros1" if ros1 else "cdr", schema)
            data = store.serialize_ros1(message, kind) if ros1 else store.serialize_cdr(message, kind)
            writer.add_message(channels[topic], stamp + RECEIVE_NS, bytes(data), stamp + RECEIVE_NS, number)
        writer.finish()


JSON_SCHEMA = {
    "type": "object",
    "properties": {
        "timestamp": {
            "type": "object",
            "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}},
        },
    },
}


def write_mcap_json(drive: SampleDrive, path: Path) -> None:
    """MCAP with JSON payloads, lz4 chunks: one topic, canonical names."""
    schema = json.loads(json.dumps(JSON_SCHEMA))
    schema["properties"] |= {name: {"type": "number"} for name in drive.signals}
    with path.open("wb") as stream:
        writer = McapWriter(stream, compression=CompressionType.LZ4)
        writer.start(library="cogest sample")
        number = writer.register_schema("vehicle.State", "jsonschema", json.dumps(schema).encode())
        channel = writer.register_channel("/vehicle", "json", number)
        for i, stamp in enumerate(stamps_ns(drive)):
            sec, nsec = divmod(int(stamp), 1_000_000_000)
            body = {"timestamp": {"sec": sec, "nsec": nsec}}
            body |= {name: round(float(values[i]), 6) for name, values in drive.signals.items()}
            writer.add_message(channel, int(stamp) + RECEIVE_NS, json.dumps(body).encode(), int(stamp), i)
        writer.finish()


def _proto_file(names: list[str]) -> descriptor_pb2.FileDescriptorSet:
    stamp = descriptor_pb2.FileDescriptorProto(
        name="google/protobuf/timestamp.proto", package="google.protobuf", syntax="proto3"
    )
    kind = descriptor_pb2.FieldDescriptorProto
    message = stamp.message_type.add(name="Timestamp")
    message.field.add(name="seconds", number=1, type=kind.TYPE_INT64, label=kind.LABEL_OPTIONAL)
    message.field.add(name="nanos", number=2, type=kind.TYPE_INT32, label=kind.LABEL_OPTIONAL)
    own = descriptor_pb2.FileDescriptorProto(
        name="vehicle.proto",
        package="vehicle",
        syntax="proto3",
        dependency=["google/protobuf/timestamp.proto"],
    )
    state = own.message_type.add(name="State")
    state.field.add(
        name="timestamp",
        number=1,
        type=kind.TYPE_MESSAGE,
        type_name=".google.protobuf.Timestamp",
        label=kind.LABEL_OPTIONAL,
    )
    for number, name in enumerate(names, start=2):
        state.field.add(name=name, number=number, type=kind.TYPE_DOUBLE, label=kind.LABEL_OPTIONAL)
    return descriptor_pb2.FileDescriptorSet(file=[stamp, own])


def write_mcap_protobuf(drive: SampleDrive, path: Path) -> None:
    """MCAP with protobuf payloads, uncompressed chunks: one topic, canonical names."""
    files = _proto_file(list(drive.signals))
    pool = descriptor_pool.DescriptorPool()
    for file in files.file:
        pool.Add(file)
    state = message_factory.GetMessageClass(pool.FindMessageTypeByName("vehicle.State"))
    with path.open("wb") as stream:
        writer = McapWriter(stream, compression=CompressionType.ZSTD)
        writer.start(library="cogest sample")
        schema = writer.register_schema("vehicle.State", "protobuf", files.SerializeToString())
        channel = writer.register_channel("/vehicle", "protobuf", schema)
        for i, stamp in enumerate(stamps_ns(drive)):
            message = state(**{name: float(values[i]) for name, values in drive.signals.items()})
            message.timestamp.seconds, message.timestamp.nanos = divmod(int(stamp), 1_000_000_000)
            writer.add_message(channel, int(stamp) + RECEIVE_NS, message.SerializeToString(), int(stamp), i)
        writer.finish()
