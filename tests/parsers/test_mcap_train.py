"""MCAP chunks collected in one go: the same as chunk by chunk, on whole files and on damaged ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mcap.writer import CompressionType
from mcap_files import N, check_values, read, write

from parsers import mcap_batches, mcap_train
from parsers.importer import ImportLog
from parsers.zstd_frames import ZstdContext

Outcome = tuple[dict[str, np.ndarray], dict[str, np.ndarray], ImportLog]


def both(path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Outcome, Outcome]:
    """Read in trains, and chunk by chunk."""
    done: list[int] = []
    kernel = mcap_train.take_chunks

    def spy(*args) -> None:
        kernel(*args)
        done.append(int(args[-1][mcap_train.NEXT]))

    with monkeypatch.context() as patch:
        patch.setattr(mcap_train, "take_chunks", spy)
        together = read(path)
    assert any(done)
    with monkeypatch.context() as patch:
        patch.setattr(mcap_train, "pread_address", lambda: 0)
        alone = read(path)
    return together, alone


def same(one: Outcome, other: Outcome) -> None:
    np.testing.assert_equal(one[0], other[0])
    np.testing.assert_equal(one[1], other[1])
    for field in ("status", "messages", "rejected", "lost_spans_ns", "notes"):
        assert getattr(one[2], field) == getattr(other[2], field), field


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("checksums", [True, False])
def test_chunks_in_one_go_are_chunks_one_by_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compression: CompressionType, checksums: bool
) -> None:
    path = write(tmp_path / "a.mcap", compression=compression, enable_crcs=checksums)
    together, alone = both(path, monkeypatch)
    same(together, alone)
    check_values(*together[:2], np.arange(N))
    assert together[2].status == "complete"


def test_the_kernel_does_all_chunks_that_recorders_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """None of them is left to the slower way, which is only slower: nothing else would show it."""
    monkeypatch.setattr(mcap_batches.Reader, "_alone", None)
    for compression in CompressionType:
        path = write(tmp_path / "a.mcap", compression=compression)
        check_values(*read(path)[:2], np.arange(N))


def test_little_room_at_first_and_a_library_without_addresses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path / "a.mcap", compression=CompressionType.ZSTD)
    whole = read(path)
    with monkeypatch.context() as patch:
        # records are decoded in the middle of a train
        patch.setattr(mcap_batches, "UNPACKED_BYTES", 5000)
        same(read(path), whole)
    with monkeypatch.context() as patch:
        patch.setattr(mcap_train, "MAX_PACKED", 1000)
        same(read(path), whole)
    with monkeypatch.context() as patch:
        patch.setattr(ZstdContext, "__init__", lambda self: vars(self).update(decompress=0, context=0))
        same(read(path), whole)
    with monkeypatch.context() as patch:
        patch.setattr(mcap_train, "crc32_address", lambda: 0)
        same(read(path), whole)


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("checksums", [True, False])
def test_damage_is_found_and_said_alike(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compression: CompressionType, checksums: bool
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
        together, alone = both(path, monkeypatch)
        same(together, alone)
        bad += together[2].status != "complete"
    assert bad > 10
