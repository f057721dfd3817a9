"""MCAP files written by the format's own libraries: every value equals theirs; broken files cost what is broken."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto
from google.protobuf.timestamp_pb2 import DESCRIPTOR as TIMESTAMP_FILE
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import CompressionType, IndexType, Writer
from mcap_protobuf.decoder import DecoderFactory as ProtobufFactory
from mcap_protobuf.schema import build_file_descriptor_set
from mcap_ros1.decoder import DecoderFactory as Ros1Factory
from mcap_ros2.decoder import DecoderFactory as Ros2Factory
from mcap_ros2.writer import Writer as Ros2Writer
from rosbags.typesys import Stores, get_typestore

import parsers.mcap_batches
import parsers.mcap_join
import parsers.mcap_toplevel
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions
from parsers.mcap_chunks import ChunkSpan, LooseSpan, McapFile, Scratch, load_chunk
from parsers.mcap_log import McapImporter
from parsers.mcap_pick import Picker, slot_table
from parsers.mcap_reader import McapReader
from parsers.mcap_records import MAGIC, Walker, find_messages

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


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunked", [True, False])
@pytest.mark.parametrize("summary", [True, False])
def test_every_layout_gives_every_value(
    tmp_path: Path, compression: CompressionType, chunked: bool, summary: bool
) -> None:
    path = write(
        tmp_path / "a.mcap", compression=compression, use_chunking=chunked, summary=summary, camera=5000
    )
    columns, times, log = read(path)
    check_values(columns, times, np.arange(N))
    assert log.status == "complete"
    assert log.messages == 2 * N
    assert not log.rejected
    assert any("'raw'" in note and "/camera" in note for note in log.notes)


@pytest.mark.parametrize("index", [IndexType.CHUNK, IndexType.MESSAGE, IndexType.NONE])
@pytest.mark.parametrize("repeat", [True, False])
@pytest.mark.parametrize("statistics", [True, False])
def test_partial_summaries(tmp_path: Path, index: IndexType, repeat: bool, statistics: bool) -> None:
    path = write(
        tmp_path / "a.mcap",
        index_types=index,
        repeat_channels=repeat,
        repeat_schemas=False,
        use_statistics=statistics,
    )
    columns, times, log = read(path)
    check_values(columns, times, np.arange(N))
    assert log.status == "complete"
    assert log.rejected == {}


def test_channels_say_what_a_profile_needs(tmp_path: Path) -> None:
    schema = {
        "type": "object",
        "properties": {"ax": {"type": "number", "description": "along [m/s^2]"}, "name": {"type": "string"}},
    }
    reader, _ = open_log(write(tmp_path / "a.mcap", json_schema=schema))
    channels = {channel.name: channel for channel in reader.channels}
    x = channels["/imu.angular_velocity.x"]
    assert (x.group, x.family, x.unit, x.count) == ("/imu", "ros", None, N)
    assert dict(x.tags) == {"topic": "/imu", "type": "sensor_msgs/Imu", "field": "angular_velocity.x"}
    ax = channels["vehicle.ax"]
    assert (ax.group, ax.family, ax.unit, ax.comment, ax.count) == (
        "vehicle",
        "json",
        "m/s^2",
        "along [m/s^2]",
        N,
    )
    assert dict(ax.tags) == {"topic": "vehicle", "type": "my.Vehicle", "field": "ax"}
    assert channels["vehicle.name"].kind == "text"
    assert "vehicle.on" not in channels
    assert reader.absolute
    assert reader.start_utc_ns is None
    assert reader.clock == "header stamp (receive time for vehicle)"


def test_what_is_not_wanted_is_not_in_the_chunks(tmp_path: Path) -> None:
    reader, log = open_log(write(tmp_path / "a.mcap"))
    chunks = list(reader.read(frozenset({"/imu.temperature", "vehicle.name"})))
    assert {name for chunk in chunks for name in chunk.columns} == {"/imu.temperature"}
    assert log.messages == N
    assert list(open_log(tmp_path / "a.mcap")[0].read(frozenset())) == []


def test_relative_stamps(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap", start=5 * MS)
    reader, _ = open_log(path)
    assert not reader.absolute


def test_many_small_chunks_come_as_few_large_batches(tmp_path: Path) -> None:
    reader, _ = open_log(write(tmp_path / "a.mcap", chunk_size=500))
    assert len(list(reader.read(frozenset({"/imu.temperature"})))) == 1


def test_batches_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parsers.mcap_batches, "PACKED_BYTES", 1)
    monkeypatch.setattr(parsers.mcap_join, "ENOUGH_ROWS", 50)
    path = write(tmp_path / "a.mcap")
    reader, _ = open_log(path)
    sizes = [chunk.time_ns.size for chunk in reader.read(frozenset({"/imu.temperature", "vehicle.ax"}))]
    assert sum(sizes) == 2 * N
    assert max(sizes) < 100
    columns, times, _ = read(path)
    check_values(columns, times, np.arange(N))


@pytest.fixture
def loaded(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """File offsets of the chunks that were unpacked."""
    offsets: list[int] = []

    def spy(file: McapFile, span: ChunkSpan, scratch: Scratch) -> int:
        offsets.append(span.offset)
        return load_chunk(file, span, scratch)

    for module in ("batches", "messages", "survey"):
        monkeypatch.setattr(f"parsers.mcap_{module}.load_chunk", spy)
    return offsets


@pytest.mark.parametrize("summary", [True, False])
def test_chunks_without_wanted_topics_are_not_unpacked(
    tmp_path: Path, loaded: list[int], summary: bool
) -> None:
    """Topics in chunks of their own, as recorders for cameras write them: the camera's stay packed."""
    stream = io.BytesIO()
    writer = Writer(stream, chunk_size=200_000, index_types=IndexType.ALL if summary else IndexType.MESSAGE,
                    repeat_channels=summary, repeat_schemas=summary, use_statistics=summary)  # fmt: skip
    writer.start()
    schema = writer.register_schema("sensor_msgs/Imu", "ros1msg", imu_definition(1).encode())
    imu = writer.register_channel("/imu", "ros1", schema)
    eye = writer.register_channel("/camera", "ros1", schema)
    for i in range(3000):
        writer.add_message(imu, START + i * 10 * MS, imu_ros1(i), 0)
        if i % 1000 == 999:
            for _ in range(10):
                writer.add_message(eye, START, bytes(200_000), 0)
    writer.finish()
    (tmp_path / "a.mcap").write_bytes(stream.getvalue())
    reader, log = open_log(tmp_path / "a.mcap")
    chunks = [span for span in reader._survey.spans if isinstance(span, ChunkSpan)]
    imu_chunks = [span.offset for span in chunks if span.channels is not None and imu in span.channels]
    assert len(chunks) > 25
    assert len(imu_chunks) <= 6
    at_open = len(loaded)
    assert at_open <= (0 if summary else 3)
    assert sum(c.time_ns.size for c in reader.read(frozenset({"/imu.temperature"}))) == 3000
    assert sorted(loaded[at_open:]) == imu_chunks
    assert log.status == "complete"


def test_large_loose_messages_are_stepped_over(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap", use_chunking=False, camera=300_000)
    reader, _ = open_log(path)
    assert all(isinstance(span, LooseSpan) for span in reader._survey.spans)
    columns, times, log = read(path)
    check_values(columns, times, np.arange(N))
    assert log.messages == 2 * N


def test_chunks_out_of_order_stay_in_file_order(tmp_path: Path) -> None:
    order = np.random.default_rng(3).permutation(N)
    path = write(tmp_path / "a.mcap", order=lambda k: int(order[k]))
    columns, times, log = read(path)
    check_values(columns, times, order)
    assert log.status == "complete"


def spans_of(path: Path) -> list[ChunkSpan]:
    return [span for span in open_log(path)[0]._survey.spans if isinstance(span, ChunkSpan)]


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("index", [IndexType.ALL, IndexType.MESSAGE, IndexType.NONE])
def test_a_damaged_chunk_costs_only_itself(
    tmp_path: Path, compression: CompressionType, index: IndexType
) -> None:
    path = write(tmp_path / "a.mcap", compression=compression, index_types=index)
    span = spans_of(path)[3]
    data = bytearray(path.read_bytes())
    for k in range(span.offset + 200, span.offset + 260):
        data[k] ^= 0x5A
    path.write_bytes(data)
    columns, times, log = read(path)
    kept = np.flatnonzero(np.isin(START + np.arange(N) * 10 * MS, times["/imu"]))
    assert N - 60 < kept.size < N
    gone = np.setdiff1d(np.arange(N), kept)
    np.testing.assert_array_equal(columns["/imu.temperature"], [np.float32(i / 3) for i in kept])
    assert log.status == "malformed"
    assert log.rejected == {"damaged chunk": 1}
    assert sum(f"chunk at byte {span.offset} is damaged" in note for note in log.notes) == 1
    ((start, end),) = log.lost_spans_ns
    assert start <= START + gone[1] * 10 * MS + 3 * MS
    assert end >= START + gone[-2] * 10 * MS + 3 * MS


def test_damaged_chunk_framing_with_an_index(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap")
    span = spans_of(path)[3]
    data = bytearray(path.read_bytes())
    data[span.offset : span.offset + 9] = b"\xff" * 9
    path.write_bytes(data)
    columns, _, log = read(path)
    assert N - 60 < columns["vehicle.ax"].size < N
    assert log.status == "malformed"
    assert log.lost_spans_ns == [(span.start_ns, span.end_ns)]


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4])
@pytest.mark.parametrize("new", [b"\xff" * 60, bytes(60), b""])
def test_reading_goes_on_behind_damaged_framing_without_an_index(
    tmp_path: Path, compression: CompressionType, new: bytes
) -> None:
    path = write(tmp_path / "a.mcap", compression=compression, index_types=IndexType.NONE)
    spans = spans_of(path)
    data = bytearray(path.read_bytes())
    data[spans[3].offset : spans[3].offset + 60] = new
    path.write_bytes(data)
    columns, _, log = read(path)
    assert N - 60 < columns["/imu.temperature"].size < N
    assert columns["/imu.temperature"][-1] == np.float32((N - 1) / 3)
    assert log.status == "malformed"
    assert log.lost_spans_ns == [(spans[2].end_ns, spans[4].start_ns)]
    assert len([note for note in log.notes if note.startswith(f"bytes {spans[3].offset} to")]) == 1


def test_many_damaged_chunks_do_not_fill_the_log_book(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap", chunk_size=1000)
    data = bytearray(path.read_bytes())
    spans = spans_of(path)
    for span in spans[1::2]:
        data[span.offset + 100] ^= 0x55
    path.write_bytes(data)
    _, _, log = read(path)
    assert log.rejected == {"damaged chunk": len(spans) // 2}
    assert len(log.lost_spans_ns) == len(spans) // 2
    assert len(log.notes) < 10


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("chunked", [True, False])
@pytest.mark.parametrize("part", [0.97, 0.613, 0.31])
def test_truncated_files_give_all_that_is_whole(
    tmp_path: Path, compression: CompressionType, chunked: bool, part: float
) -> None:
    path = write(tmp_path / "a.mcap", compression=compression, use_chunking=chunked, chunk_size=30_000)
    whole = path.read_bytes()
    chunks = spans_of(path)
    cut = int((chunks[-1].offset if chunked else len(whole) - 1000) * part)
    path.write_bytes(whole[:cut])
    columns, times, log = read(path)
    rows = np.arange(columns["vehicle.ax"].size)
    imu_rows = columns["/imu.temperature"].size
    assert imu_rows - rows.size in (0, 1)
    check_values(
        {name: column[: rows.size] for name, column in columns.items()},
        {group: time[: rows.size] for group, time in times.items()},
        rows,
    )
    assert log.status == "truncated"
    assert any("breaks off" in note for note in log.notes)
    payloads = [json.dumps(vehicle(i), indent=i % 2 or None).encode() for i in range(N)]
    if compression is CompressionType.NONE or not chunked:
        assert rows.size == sum(payload in whole[:cut] for payload in payloads)
    else:
        last = max((chunk.end_ns for chunk in chunks if chunk.offset + chunk.length <= cut), default=0)
        assert rows.size >= (last - START) // (10 * MS)


@pytest.mark.parametrize("compression", list(CompressionType))
def test_the_beginning_of_a_cut_chunk_is_read(tmp_path: Path, compression: CompressionType) -> None:
    """Of a chunk of several compressed blocks the first ones are there. Random payloads, so that they are large."""
    stream = io.BytesIO()
    writer = Writer(stream, chunk_size=10_000_000, compression=compression)
    writer.start()
    car = writer.register_channel("vehicle", "json", 0)
    rng = np.random.default_rng(1)
    for i in range(500):
        text = json.dumps({"ax": i, "noise": rng.bytes(1000).hex()})
        writer.add_message(car, START + i, text.encode(), 0)
    writer.finish()
    path = tmp_path / "a.mcap"
    path.write_bytes(stream.getvalue()[: len(stream.getvalue()) * 2 // 3])
    columns, times, log = read(path)
    count = columns["vehicle.ax"].size
    assert 200 < count < 340
    np.testing.assert_array_equal(columns["vehicle.ax"], np.arange(count))
    np.testing.assert_array_equal(times["vehicle"], START + np.arange(count))
    assert log.status == "truncated"


def test_every_cut_is_survived(tmp_path: Path) -> None:
    whole = write(tmp_path / "a.mcap", chunk_size=20_000).read_bytes()
    path = tmp_path / "b.mcap"
    sizes: list[int] = []
    said: list[str] = []
    for cut in range(8, len(whole), len(whole) // 60):
        path.write_bytes(whole[:cut])
        try:
            columns, _, log = read(path)
        except LogError as error:
            said.append(str(error))
            sizes.append(0)
        else:
            assert log.status == "truncated"
            sizes.append(columns["/imu.temperature"].size if columns else 0)
    assert sizes == sorted(sizes)
    assert sizes[-1] == N
    assert said
    assert all("b.mcap" in line and "\n" not in line for line in said)


def test_a_damaged_index_is_not_used(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap")
    data = bytearray(path.read_bytes())
    data[-200] ^= 0xFF
    path.write_bytes(data)
    columns, times, log = read(path)
    check_values(columns, times, np.arange(N))
    assert log.status == "malformed"
    assert any("index at the end is damaged" in note for note in log.notes)


def test_malformed_messages_are_counted(tmp_path: Path) -> None:
    stream = io.BytesIO()
    writer = Writer(stream)
    writer.start()
    car = writer.register_channel("vehicle", "json", 0)
    for i in range(30):
        writer.add_message(car, START + i, b'{"ax": 1}' if i % 3 else b'{"ax": ', 0)
    writer.finish()
    path = tmp_path / "a.mcap"
    path.write_bytes(stream.getvalue())
    columns, _, log = read(path)
    assert np.isnan(columns["vehicle.ax"]).sum() == 10
    assert sum(log.rejected.values()) == 10


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


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (MAGIC, "ends after 8 bytes"),
        (MAGIC + bytes(100), "whole up to byte 8"),
        (MAGIC + b"\x01" + b"\xff" * 30, "breaks off.*whole up to byte 8"),
    ],
)
def test_files_with_nothing_in_them(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(content)
    with pytest.raises(LogError, match=words) as caught:
        open_log(path)
    assert caught.value.path == path


def test_files_without_a_usable_topic(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    for topics, words in (([], "holds no messages"), (["/camera"], "'h264'.*/camera")):
        stream = io.BytesIO()
        writer = Writer(stream)
        writer.start()
        for topic in topics:
            writer.add_message(writer.register_channel(topic, "h264", 0), START, b"123", START)
        writer.finish()
        path.write_bytes(stream.getvalue())
        with pytest.raises(LogError, match=words):
            open_log(path)


def test_claims_by_content(tmp_path: Path) -> None:
    assert McapImporter().claims(Path("x.csv"), MAGIC + b"abc")
    assert not McapImporter().claims(Path("x.mcap"), b"t,a\n")


def test_sizes_that_lie_are_not_believed(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap", compression=CompressionType.ZSTD)
    span = spans_of(path)[2]
    data = bytearray(path.read_bytes())
    struct.pack_into("<Q", data, span.offset + 9 + 16, 1 << 60)
    path.write_bytes(data)
    columns, _, log = read(path)
    assert log.rejected == {"damaged chunk": 1}
    assert columns["vehicle.ax"].size < N


_SMALL: list[bytes] = []


@settings(max_examples=120, deadline=None)
@given(st.data())
def test_overwritten_bytes_never_crash(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    folder = tmp_path_factory.getbasetemp()
    if not _SMALL:
        for chunked in (True, False):
            for summary in (True, False):
                made = write(folder / "s.mcap", chunk_size=9000, use_chunking=chunked, summary=summary)
                _SMALL.append(made.read_bytes())
    whole = bytearray(data.draw(st.sampled_from(_SMALL)))
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.integers(8, len(whole) - 1) | st.integers(len(whole) - 1500, len(whole) - 1))
        new = data.draw(st.binary(min_size=1, max_size=9))
        whole[place : place + len(new)] = new
    path = folder / "fuzz.mcap"
    path.write_bytes(whole)
    try:
        columns, times, _ = read(path)
    except LogError:
        return
    assert all(column.dtype == np.float64 for column in columns.values())
    assert all(time.dtype == np.int64 for time in times.values())


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 255), st.binary(max_size=40), st.integers(-2, 2)), max_size=20))
def test_walker_stays_inside(records: list[tuple[int, bytes, int]]) -> None:
    raw = b"".join(
        bytes([op]) + struct.pack("<Q", max(0, len(body) + lie)) + body for op, body, lie in records
    )
    data = np.frombuffer(bytearray(raw), dtype=np.uint8)
    walker = Walker()
    total = 0
    for found in walker.walk(data):
        assert (found.offset >= 9).all()
        assert (found.offset + found.length <= data.size).all()
        messages, short = find_messages(data, found)
        assert messages.channel.size + short == (found.opcode == 5).sum()
        assert (messages.channel >= 0).all()
        total += found.opcode.size
    assert 0 <= walker.at <= data.size
    if all(op not in (0, 15) and lie == 0 for op, _, lie in records):
        assert total == len(records)


def lines_of(log: ImportLog) -> tuple[Any, ...]:
    return log.messages, log.rejected, log.notes, log.status, log.lost_spans_ns


@pytest.mark.parametrize("damaged", [False, True])
@pytest.mark.parametrize("chunked", [True, False])
def test_two_threads_give_what_one_gives(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, damaged: bool, chunked: bool
) -> None:
    monkeypatch.setattr(parsers.mcap_batches, "PACKED_BYTES", 3000)
    monkeypatch.setattr(parsers.mcap_toplevel, "FIRST_WINDOW", 5000)
    monkeypatch.setattr(parsers.mcap_toplevel, "LAST_WINDOW", 5000)
    path = write(tmp_path / "a.mcap", chunk_size=1500, use_chunking=chunked)
    if damaged:
        data = bytearray(path.read_bytes())
        for place in range(5000, len(data) - 30_000, 9000):
            data[place] ^= 0x41
        path.write_bytes(data)
    found = []
    for workers in (1, 2, 3):
        monkeypatch.setattr("parsers.parallel.cores", lambda workers=workers: workers)
        found.append(read(path))
    assert found[0][2].status == ("malformed" if damaged and chunked else "complete")
    for columns, times, log in found[1:]:
        assert lines_of(log) == lines_of(found[0][2])
        assert columns.keys() == found[0][0].keys()
        for name, column in columns.items():
            np.testing.assert_array_equal(column, found[0][0][name])
        for group, time in times.items():
            np.testing.assert_array_equal(time, found[0][1][group])


def test_types_with_many_fields_are_decoded_little_by_little(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path / "a.mcap", chunk_size=100_000)
    whole, times, _ = read(path)
    monkeypatch.setattr(parsers.mcap_batches, "MAX_CELLS", 300)
    monkeypatch.setattr(parsers.mcap_join, "ENOUGH_CELLS", 1)
    parts, part_times, log = read(path)
    assert log.messages == 2 * N
    for name, column in whole.items():
        np.testing.assert_array_equal(parts[name], column)
    np.testing.assert_array_equal(part_times["/imu"], times["/imu"])
    reader, _ = open_log(path)
    names = frozenset(name for name in whole if name.startswith("/imu"))
    sizes = [chunk.time_ns.size for chunk in reader.read(names)]
    assert max(sizes) * len(names) <= 300
    assert sum(sizes) == N


@pytest.fixture
def bytes_read(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many bytes each access to the file read."""
    sizes: list[int] = []
    fill = McapFile.fill

    def spy(self: McapFile, offset: int, out: np.ndarray) -> int:
        sizes.append(fill(self, offset, out))
        return sizes[-1]

    monkeypatch.setattr(McapFile, "fill", spy)
    return sizes


@pytest.mark.parametrize("chunk_size", [700_000, 5_000_000])
@pytest.mark.parametrize("summary", [True, False])
def test_pictures_in_the_same_uncompressed_chunk_are_stepped_over(
    tmp_path: Path, bytes_read: list[int], chunk_size: int, summary: bool
) -> None:
    options: dict[str, Any] = {} if summary else {"index_types": IndexType.MESSAGE}
    path = write(
        tmp_path / "a.mcap",
        camera=300_000,
        compression=CompressionType.NONE,
        chunk_size=chunk_size,
        **options,
    )
    size = path.stat().st_size
    assert size > 100 * N * 250 / 2
    reader, log = open_log(path)
    wanted = frozenset(c.name for c in reader.channels if c.kind == "number")
    bytes_read.clear()
    chunks = list(reader.read(wanted))
    assert sum(bytes_read) < size / 10
    assert sum(chunk.time_ns.size for chunk in chunks) == 2 * N
    columns, times, log = read(path)
    check_values(columns, times, np.arange(N))
    assert log.status == "complete"


def test_damage_in_sparsely_read_chunks(tmp_path: Path) -> None:
    """A picture's length that lies costs what stands behind it in its chunk; a picture's content costs nothing."""
    path = write(tmp_path / "a.mcap", camera=300_000, compression=CompressionType.NONE, chunk_size=700_000)
    span = spans_of(path)[2]
    whole = path.read_bytes()
    chunk = whole[span.offset : span.offset + span.length]
    picture = span.offset + chunk.index(struct.pack("<BQ", 5, 300_022))
    data = bytearray(whole)
    data[picture + 100_000] ^= 0xFF
    path.write_bytes(data)
    columns, times, log = read(path)
    check_values(columns, times, np.arange(N))
    assert log.status == "complete"
    data[picture + 1 : picture + 9] = struct.pack("<Q", 1 << 40)
    path.write_bytes(data)
    columns, _, log = read(path)
    assert N - 40 < columns["vehicle.ax"].size < N
    assert log.status == "malformed"
    assert sum(f"the chunk at byte {span.offset} is damaged from its byte" in note for note in log.notes) == 1


def test_the_checksum_holds_where_nothing_was_stepped_over(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mcap", camera=3000, compression=CompressionType.NONE, chunk_size=40_000)
    span = spans_of(path)[1]
    data = bytearray(path.read_bytes())
    data[span.offset + 20_000] ^= 0xFF
    path.write_bytes(data)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("parsers.mcap_sparse.SPARSE_BYTES", 1000)
        columns, _, log = read(path)
    assert log.rejected == {"damaged chunk": 1}
    assert log.lost_spans_ns == [(span.start_ns, span.end_ns)]
    assert columns["vehicle.ax"].size < N


def test_camera_chunks_may_be_garbage_when_nobody_asks_for_them(tmp_path: Path) -> None:
    """Topics in chunks of their own: the camera's are not even looked at."""
    stream = io.BytesIO()
    writer = Writer(stream, chunk_size=50_000)
    writer.start()
    car = writer.register_channel("vehicle", "json", 0)
    eye = writer.register_channel("/camera", "json", 0)
    for i in range(20):
        for k in range(500):
            writer.add_message(car, START + i * MS, b'{"ax": %d, "text": "%s"}' % (k, b"x" * 90), 0)
        for _ in range(10):
            writer.add_message(eye, START + i * MS, b'{"picture": 1}' + bytes(500_000), 0)
    writer.finish()
    path = tmp_path / "a.mcap"
    path.write_bytes(stream.getvalue())
    spans = [span for span in spans_of(path) if span.channels == {eye}]
    assert len(spans) > 50
    data = bytearray(path.read_bytes())
    for span in spans[1:-1]:
        data[span.offset : span.offset + span.length] = b"\xee" * span.length
    path.write_bytes(data)
    columns, _, log = read(path, "vehicle")
    assert columns["vehicle.ax"].tolist() == [*range(500)] * 20
    assert log.status == "complete"


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


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 255), st.binary(max_size=40), st.integers(-2, 2)), max_size=20))
def test_picker_agrees_with_the_walker(records: list[tuple[int, bytes, int]]) -> None:
    raw = b"".join(
        bytes([op]) + struct.pack("<Q", max(0, len(body) + lie)) + body for op, body, lie in records
    )
    data = np.frombuffer(bytearray(raw), dtype=np.uint8)
    walker = Walker()
    found = [find_messages(data, part) for part in walker.walk(data)]
    picker = Picker(slot_table([(0, 5), (2, 1), tuple(range(10, 1 << 16))]), 3)
    at, state, short = picker.walk(data, 0, data.size)
    assert (at, state, short) == (walker.at, walker.state, sum(part[1] for part in found))
    picks = {part.number: part for part in picker.take()}
    for number, ids in enumerate([[0, 5], [1, 2], range(10, 1 << 16)]):
        rows = [np.isin(part.channel, ids) for part, _ in found]
        offset = np.concatenate([part.offset[row] for (part, _), row in zip(found, rows, strict=True)])
        log_ns = np.concatenate([part.log_ns[row] for (part, _), row in zip(found, rows, strict=True)])
        got = picks.get(number)
        assert offset.tolist() == ([] if got is None else got.offset.tolist())
        assert log_ns.tolist() == ([] if got is None else got.log_ns.tolist())
