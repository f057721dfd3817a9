"""MCAP files for the tests: written by the format's own library, read and compared here."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import IndexType, Writer

from parsers.importer import ImportLog, ReadOptions
from parsers.mcap_chunks import ChunkSpan
from parsers.mcap_log import McapImporter
from parsers.mcap_reader import McapReader

START = 1_700_000_000_000_000_000
MS = 1_000_000
N = 400
IMU_DEFINITION = """std_msgs/Header header
float64[9] covariance
geometry_msgs/Vector3 angular_velocity
float32 temperature
================================================================================
MSG: std_msgs/Header
{sequence}{time} stamp
string frame_id
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""


def imu_definition(ros: int) -> str:
    text = IMU_DEFINITION.replace("{sequence}", "uint32 seq\n" if ros == 1 else "")
    if ros == 1:
        return text.replace("{time}", "time")
    return text.replace("{time}", "builtin_interfaces/Time") + (
        "=" * 80 + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
    )


def imu_ros1(i: int) -> bytes:
    frame = b"base_link"[: i % 10]
    stamp = START + i * 10 * MS
    head = struct.pack("<IIII", i, stamp // 10**9, stamp % 10**9, len(frame)) + frame
    return head + struct.pack("<12df", *range(9), i * 0.1, -i, 1 / (i + 1), i / 3)


def vehicle(i: int) -> dict[str, Any]:
    return {
        "ax": i / 7,
        "wheels": [i, i + 0.5],
        "on": i % 2 == 0,
        "name": "x" * (i % 5),
        "inner": {"k": None if i % 3 else i},
    }


def write(
    path: Path,
    *,
    start: int = START,
    camera: int = 0,
    order: Callable[[int], int] = lambda i: i,
    json_schema: dict[str, Any] | None = None,
    summary: bool = True,
    **options: Any,
) -> Path:
    """A file with a ROS 1 topic "/imu", a JSON topic "vehicle", and with camera > 0 a topic of so many bytes each."""
    if not summary:
        options |= {"index_types": IndexType.NONE, "repeat_channels": False, "repeat_schemas": False}
        options |= {"use_statistics": False, "use_summary_offsets": False}
    stream = io.BytesIO()
    writer = Writer(stream, **({"chunk_size": 4096} | options))
    writer.start(profile="", library="test")
    schema = json.dumps(json_schema or {"type": "object"}).encode()
    definition = imu_definition(1).encode()
    imu = writer.register_channel(
        "/imu", "ros1", writer.register_schema("sensor_msgs/Imu", "ros1msg", definition)
    )
    car = writer.register_channel(
        "vehicle", "json", writer.register_schema("my.Vehicle", "jsonschema", schema)
    )
    eye = -1
    if camera:
        eye = writer.register_channel("/camera", "raw", 0)
    for k in range(N):
        i = order(k)
        t = start + i * 10 * MS
        writer.add_message(imu, t + 3 * MS, imu_ros1(i), t)
        writer.add_message(car, t + 4 * MS, json.dumps(vehicle(i), indent=i % 2 or None).encode(), t)
        if camera and i % 10 == 0:
            writer.add_message(eye, t, bytes(camera), t)
    writer.finish()
    path.write_bytes(stream.getvalue())
    return path


def open_log(path: Path) -> tuple[McapReader, ImportLog]:
    log = ImportLog()
    return McapImporter().open(path, ReadOptions(), log), log


def read(path: Path, only: str = "") -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], ImportLog]:
    """All columns by name, all times by group (both joined over the chunks), and the log book."""
    reader, log = open_log(path)
    wanted = frozenset(c.name for c in reader.channels if c.kind == "number" and c.name.startswith(only))
    columns: dict[str, list[np.ndarray]] = {}
    times: dict[str, list[np.ndarray]] = {}
    for chunk in reader.read(wanted):
        times.setdefault(chunk.group, []).append(chunk.time_ns)
        for name, column in chunk.columns.items():
            assert column.shape == chunk.time_ns.shape
            columns.setdefault(name, []).append(column)
    joined = {name: np.concatenate(parts) for name, parts in columns.items()}
    return joined, {group: np.concatenate(parts) for group, parts in times.items()}, log


def check_values(columns: dict[str, np.ndarray], times: dict[str, np.ndarray], rows: np.ndarray) -> None:
    """Both topics of `write` hold exactly the messages `rows`, in that order."""
    imu = [struct.unpack("<12df", imu_ros1(i)[-100:]) for i in rows]
    for k, name in enumerate(["covariance[0]"] + [f"covariance[{j}]" for j in range(1, 9)]):
        np.testing.assert_array_equal(columns[f"/imu.{name}"], [m[k] for m in imu])
    for k, axis in enumerate("xyz"):
        np.testing.assert_array_equal(columns[f"/imu.angular_velocity.{axis}"], [m[9 + k] for m in imu])
    np.testing.assert_array_equal(columns["/imu.temperature"], [m[12] for m in imu])
    np.testing.assert_array_equal(times["/imu"], START + rows * 10 * MS)
    cars = [vehicle(i) for i in rows]
    np.testing.assert_array_equal(columns["vehicle.ax"], [m["ax"] for m in cars])
    np.testing.assert_array_equal(columns["vehicle.wheels[1]"], [m["wheels"][1] for m in cars])
    np.testing.assert_array_equal(columns["vehicle.on"], [m["on"] for m in cars])
    np.testing.assert_array_equal(
        columns["vehicle.inner.k"], np.array([m["inner"]["k"] for m in cars], dtype=np.float64)
    )
    np.testing.assert_array_equal(times["vehicle"], START + rows * 10 * MS + 4 * MS)


def spans_of(path: Path) -> list[ChunkSpan]:
    return [span for span in open_log(path)[0]._survey.spans if isinstance(span, ChunkSpan)]
