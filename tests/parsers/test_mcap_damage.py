"""Damaged, cut and malformed MCAP files cost what is broken and nothing else."""

from __future__ import annotations

import io
import json
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, IndexType, Writer
from mcap_files import MS, START, N, check_values, open_log, read, spans_of, vehicle, write

from parsers.errors import LogError
from parsers.mcap_records import MAGIC


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
    # the head of the chunk says when it begins
    assert open_log(path)[0].absolute


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
