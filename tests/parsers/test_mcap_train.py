"""MCAP chunks collected, or decoded, in one go: the same as chunk by chunk, on whole files and on damaged ones."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import CompressionType, Writer
from mcap_files import MS, START, N, check_values, imu_definition, imu_ros1, read, write

from parsers import mcap_batches, mcap_flow, mcap_train, mcap_unpack
from parsers.importer import ImportLog
from parsers.ros import flow
from parsers.zstd_frames import ZstdContext

Outcome = tuple[dict[str, np.ndarray], dict[str, np.ndarray], ImportLog]
WAYS = {"": (mcap_train, "take_chunks"), "/imu": (mcap_flow, "decode_chunks")}
"""What is read, and the kernel that is to do it: JSON beside ROS messages, ROS messages alone."""


def both(path: Path, only: str, monkeypatch: pytest.MonkeyPatch) -> tuple[Outcome, Outcome]:
    """Read in one go, and chunk by chunk."""
    done: list[int] = []
    module, name = WAYS[only]
    kernel: Callable[..., None] = getattr(module, name)

    def spy(*args) -> None:
        kernel(*args)
        done.append(int(args[-1][mcap_unpack.NEXT]))

    with monkeypatch.context() as patch:
        patch.setattr(module, name, spy)
        together = read(path, only)
    assert any(done)
    with monkeypatch.context() as patch:
        patch.setattr(mcap_unpack, "pread_address", lambda: 0)
        patch.setattr(mcap_batches, "plan_of", lambda wanted: None)
        alone = read(path, only)
    return together, alone


def same(one: Outcome, other: Outcome) -> None:
    np.testing.assert_equal(one[0], other[0])
    np.testing.assert_equal(one[1], other[1])
    for field in ("status", "messages", "rejected", "lost_spans_ns", "notes"):
        assert getattr(one[2], field) == getattr(other[2], field), field


@pytest.mark.parametrize("only", WAYS)
@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("checksums", [True, False])
def test_chunks_in_one_go_are_chunks_one_by_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compression: CompressionType, checksums: bool, only: str
) -> None:
    path = write(tmp_path / "a.mcap", compression=compression, enable_crcs=checksums)
    together, alone = both(path, only, monkeypatch)
    same(together, alone)
    assert together[2].status == "complete"
    assert len(together[1]["/imu"]) == N
    if not only:
        check_values(*together[:2], np.arange(N))


@pytest.mark.parametrize("only", WAYS)
def test_the_kernels_do_all_chunks_that_recorders_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, only: str
) -> None:
    """None of them is left to the slower way, which is only slower: nothing else would show it."""
    monkeypatch.setattr(mcap_batches.Reader, "_alone", None)
    for compression in CompressionType:
        path = write(tmp_path / "a.mcap", compression=compression)
        assert len(read(path, only)[1]["/imu"]) == N


@pytest.mark.parametrize("only", WAYS)
def test_little_room_at_first_and_a_library_without_addresses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, only: str
) -> None:
    path = write(tmp_path / "a.mcap", compression=CompressionType.ZSTD)
    whole = read(path, only)
    assert len(whole[1]["/imu"]) == N
    for module, name, value in (
        # records are decoded in the middle of a train
        (mcap_batches, "UNPACKED_BYTES", 5000),
        # rows run out with every chunk; a chunk is more than is decoded at once
        (flow, "SPARE_ROWS", 0),
        (flow, "MAX_CELLS", 40),
        (mcap_unpack, "MAX_PACKED", 1000),
        (mcap_unpack, "crc32_address", lambda: 0),
        (ZstdContext, "__init__", lambda self: vars(self).update(decompress=0, context=0)),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(module, name, value)
            same(read(path, only), whole)


@pytest.mark.parametrize("only", WAYS)
@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("checksums", [True, False])
def test_damage_is_found_and_said_alike(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compression: CompressionType, checksums: bool, only: str
) -> None:
    raw = write(tmp_path / "a.mcap", compression=compression, enable_crcs=checksums).read_bytes()
    rng = np.random.default_rng(7)
    bad = 0
    for trial in range(40):
        damaged = bytearray(raw)
        at, size = int(rng.integers(2000, len(raw) * 3 // 4)), int(rng.choice([1, 2, 30, 3000]))
        damaged[at : at + size] = rng.integers(0, 256, size, np.uint8).tobytes()
        path = tmp_path / f"{trial}.mcap"
        path.write_bytes(damaged)
        together, alone = both(path, only, monkeypatch)
        same(together, alone)
        bad += together[2].status != "complete"
    assert bad > 10


def test_messages_that_do_not_fit_their_type_are_counted_alike(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stream = io.BytesIO()
    writer = Writer(stream, chunk_size=4096)
    writer.start()
    schema = writer.register_schema("sensor_msgs/Imu", "ros1msg", imu_definition(1).encode())
    imu = writer.register_channel("/imu", "ros1", schema)
    for i in range(N):
        payload = imu_ros1(i)
        writer.add_message(imu, START + i * 10 * MS, payload[: 50 if i % 97 == 3 else None], 0)
    writer.finish()
    path = tmp_path / "a.mcap"
    path.write_bytes(stream.getvalue())
    together, alone = both(path, "/imu", monkeypatch)
    same(together, alone)
    assert len(together[1]["/imu"]) == N
    assert sum(together[2].rejected.values()) == len(range(3, N, 97))
    assert int(np.isnan(together[0]["/imu.temperature"]).sum()) == len(range(3, N, 97))
