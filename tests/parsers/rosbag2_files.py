"""ROS 2 bags for the tests: written by rosbags or as SQLite files by hand, then read whole."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from parsers.channels import FloatArray, IntArray
from parsers.importer import ImportLog, LogReader, ReadOptions
from parsers.registry import read_head
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
