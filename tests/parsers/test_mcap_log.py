"""MCAP files written by the format's own library: every layout and summary gives every value, by any number of threads."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import CompressionType, IndexType
from mcap_files import MS, N, check_values, open_log, read, write

import parsers.mcap_batches
import parsers.mcap_join
import parsers.mcap_toplevel
import parsers.ros.flow
from parsers.importer import ImportLog
from parsers.mcap_log import McapImporter
from parsers.mcap_records import MAGIC


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
    # the schema does not name it, and does not say that there is no other
    assert channels["vehicle.on"].kind == "number"
    closed = schema | {"additionalProperties": False}
    reader, _ = open_log(write(tmp_path / "b.mcap", json_schema=closed))
    assert "vehicle.on" not in {channel.name for channel in reader.channels}
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


def test_chunks_out_of_order_stay_in_file_order(tmp_path: Path) -> None:
    order = np.random.default_rng(3).permutation(N)
    path = write(tmp_path / "a.mcap", order=lambda k: int(order[k]))
    columns, times, log = read(path)
    check_values(columns, times, order)
    assert log.status == "complete"


def test_claims_by_content(tmp_path: Path) -> None:
    assert McapImporter().claims(Path("x.csv"), MAGIC + b"abc")
    assert not McapImporter().claims(Path("x.mcap"), b"t,a\n")


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
    for module in (parsers.mcap_batches, parsers.ros.flow):
        monkeypatch.setattr(module, "MAX_CELLS", 300)
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
