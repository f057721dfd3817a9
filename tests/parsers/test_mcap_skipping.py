"""What nobody asks for in an MCAP file (pictures, topics in chunks of their own) is stepped over, not read."""

from __future__ import annotations

import io
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import CompressionType, IndexType, Writer
from mcap_files import MS, START, N, check_values, imu_definition, imu_ros1, open_log, read, spans_of, write
from remote_files import with_camera

from parsers import mcap_flow, mcap_train
from parsers.importer import ImportLog
from parsers.mcap_chunks import ChunkSpan, LooseSpan, McapFile, Scratch, load_chunk
from parsers.mcap_messages import messages_in
from parsers.mcap_survey import Surveyor
from parsers.mcap_unpack import NEXT


@pytest.fixture
def loaded(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """File offsets of the chunks that were unpacked."""
    offsets: list[int] = []

    def spy(file: McapFile, span: ChunkSpan, scratch: Scratch) -> int:
        offsets.append(span.offset)
        return load_chunk(file, span, scratch)

    def spied(kernel: Callable[..., None]) -> Callable[..., None]:
        def train_spy(*args: Any) -> None:
            starts, state = args[0].starts, args[-1]
            before = int(state[NEXT])
            kernel(*args)
            offsets.extend(starts[before : int(state[NEXT])].tolist())

        return train_spy

    for module in ("batches", "messages", "survey"):
        monkeypatch.setattr(f"parsers.mcap_{module}.load_chunk", spy)
    monkeypatch.setattr(mcap_train, "take_chunks", spied(mcap_train.take_chunks))
    monkeypatch.setattr(mcap_flow, "decode_chunks", spied(mcap_flow.decode_chunks))
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


def test_messages_looked_at_are_the_same_with_pictures_stepped_over(
    tmp_path: Path, samples: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "camera.mcap"
    with_camera(samples / "mcap" / "drive_json.mcap", path, 0.1, 50, CompressionType.NONE)
    with path.open("rb", buffering=0) as raw:
        file = McapFile(path, raw)
        survey = Surveyor(file, ImportLog()).survey()
        names = {channel.id: channel.topic for channel in survey.definitions.channels.values()}
        keep = frozenset(number for number, name in names.items() if "camera" not in name)
        assert len(keep) == len(names) - 1

        def looked_at() -> list[tuple[int, int, bytes]]:
            found = [
                (
                    int(m.log_ns[i]),
                    int(m.channel[i]),
                    m.data[m.offset[i] : m.offset[i] + m.length[i]].tobytes(),
                )
                for span in survey.spans
                for m in messages_in(file, span, keep)
                for i in range(len(m.offset))
            ]
            return sorted(each for each in found if each[1] in keep)

        sparsely = looked_at()
        monkeypatch.setattr("parsers.mcap_messages.may_skip", lambda *_: False)
        assert sparsely == looked_at()
        assert {channel for _, channel, _ in sparsely} == keep
