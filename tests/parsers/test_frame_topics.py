"""CAN frames that travel as ROS messages: the signals that the same frames give as a CAN log, in each container."""

from __future__ import annotations

import sqlite3
import struct
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer as McapWriter
from rosbag2_files import START, TABLES, imu
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from parsers.errors import DatabaseError
from parsers.load import LoadOptions, load_drive

TYPE = "can_msgs/msg/Frame"
TEXT = "std_msgs/Header header\nuint32 id\nbool is_rtr\nbool is_extended\nbool is_error\nuint8 dlc\nuint8[8] data\n"
HEADER = "=" * 80 + "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
TIME = "=" * 80 + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
DBC = (
    'VERSION ""\nBU_: E\nBO_ 291 Wheels: 4 E\n SG_ VehicleSpeed : 0|16@1+ (0.01,0) [0|0] "km/h" E\n'
    f'BO_ {0x98FF03FE} Yaw: 8 E\n SG_ YawRate : 7|16@0- (0.001,0) [0|0] "rad/s" E\n'
)
COUNT = 200
Row = tuple[int, int, bool, bool, bool, bytes]
"""Stamp, id, remote, 29 bits, error, payload."""


def rows() -> list[Row]:
    found: list[Row] = []
    for k in range(COUNT):
        now = START + k * 10_000_000
        found.append((now, 291, False, False, False, struct.pack("<HH", 5000 + 7 * k, k)))
        found.append((now + 1_000_000, 0x18FF03FE, False, True, False, struct.pack(">h6x", k - 100)))
        if k % 50 == 0:
            found.append((now + 2_000_000, 291, True, False, False, b""))
            found.append((now + 3_000_000, 291, False, False, True, struct.pack("<HH", 0, 0)))
    return found


def cdr(row: Row) -> bytes:
    stamp, number, remote, long, error, data = row
    head = struct.pack("<iI", stamp // 10**9, stamp % 10**9) + struct.pack("<I5s", 5, b"can0\0")
    body = struct.pack("<I???B8s", number, remote, long, error, len(data), data)
    return b"\0\1\0\0" + head + b"\0" * (-len(head) % 4) + body


def write_sqlite(path: Path) -> Path:
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript(TABLES)
        connection.execute("INSERT INTO topics VALUES (1, '/can_rx', ?, 'cdr', '')", (TYPE,))
        connection.execute("INSERT INTO topics VALUES (2, '/imu', 'sensor_msgs/msg/Imu', 'cdr', '')")
        for row in rows():
            connection.execute(
                "INSERT INTO messages (topic_id, timestamp, data) VALUES (1, ?, ?)", (row[0], cdr(row))
            )
        for k in range(COUNT):
            now = START + k * 10_000_000
            connection.execute(
                "INSERT INTO messages (topic_id, timestamp, data) VALUES (2, ?, ?)", (now, imu(k))
            )
        connection.commit()
    return path


def write_mcap(path: Path) -> Path:
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        schema = writer.register_schema(TYPE, "ros2msg", (TEXT + HEADER + TIME).encode())
        channel = writer.register_channel("/can_rx", "cdr", schema)
        for row in rows():
            writer.add_message(channel, row[0], cdr(row), row[0])
        writer.finish()
    return path


def write_bag(path: Path) -> Path:
    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg(TEXT, TYPE))
    types = store.types
    with BagWriter(path) as writer:
        connection = writer.add_connection("/can_rx", TYPE, typestore=store)
        for stamp, number, remote, long, error, data in rows():
            time = types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
            head = types["std_msgs/msg/Header"](0, time, "can0")
            eight = np.frombuffer(data.ljust(8, b"\0"), np.uint8)
            message = types[TYPE](head, number, remote, long, error, len(data), eight)
            writer.write(connection, stamp, store.serialize_ros1(message, TYPE))
    return path


def write_candump(path: Path) -> Path:
    def line(row: Row) -> str:
        stamp, number, remote, long, error, data = row
        name = f"{number | 0x20000000 if error else number:0{8 if long or error else 3}X}"
        return f"({stamp // 10**9}.{stamp % 10**9 // 1000:06d}) can0 {name}#{'R' if remote else data.hex().upper()}"

    path.write_text("\n".join(line(row) for row in rows()) + "\n")
    return path


@pytest.mark.parametrize(
    ("name", "write"),
    [("a.db3", write_sqlite), ("a.mcap", write_mcap), ("a.bag", write_bag)],
)
def test_frames_in_messages_are_the_frames_of_a_can_log(tmp_path, name, write):
    base = tmp_path / "car.dbc"
    base.write_text(DBC)
    wanted = load_drive([write_candump(tmp_path / "a.log")], LoadOptions(dbc=(base,), fix=False))
    found = load_drive([write(tmp_path / name)], LoadOptions(dbc=(base,), fix=False))
    assert {"speed", "yaw_rate"} <= set(wanted.signals)
    # the gyro's topic in one of them is the better yaw rate
    for signal in ("speed",) if name == "a.db3" else ("speed", "yaw_rate"):
        one, other = wanted.signals[signal], found.signals[signal]
        np.testing.assert_array_equal(one.values, other.values)
        np.testing.assert_array_equal(one.time_ns, other.time_ns)
        assert len(one.values) == COUNT
    assert found.record.rejected["error frame"] == found.record.rejected["remote frame"] == COUNT // 50
    assert not any("was not used" in note for note in found.record.notes)
    if name == "a.db3":
        assert len(found.signals["accel_x"].values) == COUNT
        assert found.record.messages == len(rows()) + COUNT


def test_without_a_database_it_is_said_what_one_would_be_of_use_for(tmp_path):
    drive = load_drive([write_sqlite(tmp_path / "a.db3")], LoadOptions(fix=False))
    assert "speed" not in drive.signals
    assert "accel_x" in drive.signals
    assert any("/can_rx" in note and "--dbc" in note for note in drive.record.notes)
    assert drive.record.messages == COUNT


def test_a_damaged_bag_and_a_wrong_database_are_said(tmp_path):
    base, other = tmp_path / "car.dbc", tmp_path / "other.dbc"
    base.write_text(DBC)
    other.write_bytes(b"\0\0")
    path = write_bag(tmp_path / "a.bag")
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) * 2 // 3])
    drive = load_drive([path], LoadOptions(dbc=(base,), fix=False))
    assert drive.record.status == "truncated"
    with pytest.raises(DatabaseError, match=r"other\.dbc"):
        load_drive([path], LoadOptions(dbc=(other,)))


def test_two_topics_are_two_buses(tmp_path):
    base = tmp_path / "car.dbc"
    base.write_text(DBC)
    path = tmp_path / "a.db3"
    write_sqlite(path)
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("INSERT INTO topics VALUES (3, '/can_tx', ?, 'cdr', '')", (TYPE,))
        for row in rows()[:20]:
            connection.execute(
                "INSERT INTO messages (topic_id, timestamp, data) VALUES (3, ?, ?)", (row[0], cdr(row))
            )
        connection.commit()
    drive = load_drive([path], LoadOptions(dbc=(base,), fix=False))
    assert len(drive.signals["speed"].values) == COUNT
    assert any("bus 1 is /can_rx, bus 2 is /can_tx" in note for note in drive.record.notes)
