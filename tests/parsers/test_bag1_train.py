"""ROS 1 bags' chunks decoded in one go: the same as chunk by chunk, on whole bags and on damaged ones."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag1 import Writer
from test_rosbag1_log import COUNT, FORMATS, collect, make_bag, opened

from parsers.importer import ImportLog
from parsers.lz4_frames import Addresses, FrameUnpacker
from parsers.ros import bag1_read

WANTED = {"/imu/data.angular_velocity.x", "/imu/data.linear_acceleration.z", "/cmd.angular.z"}
Outcome = tuple[dict[str, tuple[list[int], list[float]]], ImportLog]


def read(path: Path) -> Outcome:
    reader, log = opened(path)
    found = collect(reader, WANTED)
    return {name: (times.tolist(), values.tolist()) for name, (times, values) in found.items()}, log


def both(path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Outcome, Outcome]:
    """Read in trains, and chunk by chunk."""
    calls: list[int] = []
    kernel = bag1_read.decode_chunks
    with monkeypatch.context() as patch:
        patch.setattr(bag1_read, "decode_chunks", lambda *args: (calls.append(1), kernel(*args)))
        together = read(path)
    assert calls
    with monkeypatch.context() as patch:
        patch.setattr(bag1_read, "pread_address", lambda: 0)
        patch.setattr(bag1_read, "decode_chunks", None)
        alone = read(path)
    return together, alone


def same(one: Outcome, other: Outcome) -> None:
    np.testing.assert_equal(one[0], other[0])
    for field in ("status", "messages", "rejected", "lost_spans_ns", "notes"):
        assert getattr(one[1], field) == getattr(other[1], field), field


@pytest.mark.parametrize("compression", FORMATS)
def test_chunks_in_one_go_are_chunks_one_by_one(tmp_path: Path, monkeypatch, compression: Any) -> None:
    together, alone = both(make_bag(tmp_path / "a.bag", compression, chunk=4000), monkeypatch)
    same(together, alone)
    assert len(together[0]["/cmd.angular.z"][0]) == COUNT


def test_more_messages_than_the_index_says_and_a_library_without_addresses(
    tmp_path: Path, monkeypatch
) -> None:
    path = make_bag(tmp_path / "a.bag", Writer.CompressionFormat.LZ4, chunk=4000)
    whole, _ = read(path)
    with monkeypatch.context() as patch:
        # room for one row of each topic: the kernel comes back for more in the middle of a chunk
        patch.setattr(bag1_read, "_SPARE_ROWS", 1)
        patch.setattr(
            bag1_read.Wanted, "rows_of", lambda self, refs: np.ones(len(self.program.spec), np.int64)
        )
        assert read(path)[0] == whole
    with monkeypatch.context() as patch:
        patch.setattr(FrameUnpacker, "addresses", property(lambda self: Addresses()))
        assert read(path)[0] == whole


@pytest.mark.parametrize("compression", [None, Writer.CompressionFormat.LZ4])
def test_damage_is_found_and_said_alike(tmp_path: Path, monkeypatch, compression: Any) -> None:
    raw = make_bag(tmp_path / "a.bag", compression, chunk=4000).read_bytes()
    rng = np.random.default_rng(5)
    bad = 0
    for trial in range(60):
        damaged = bytearray(raw)
        at, size = int(rng.integers(5000, len(raw) * 3 // 4)), int(rng.choice([1, 2, 30, 3000]))
        damaged[at : at + size] = rng.integers(0, 256, size, np.uint8).tobytes()
        path = tmp_path / f"{trial}.bag"
        path.write_bytes(damaged)
        together, alone = both(path, monkeypatch)
        same(together, alone)
        bad += together[1].status != "complete"
    assert bad > 20
