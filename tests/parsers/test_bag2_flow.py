"""Leaf pages of a ROS 2 bag decoded in one go: the same as with several calls, on whole files and on odd and damaged ones."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import zstandard
from rosbag2_files import COUNT, IMU, SPEED, STORE, YAW, collect, imu, opened, write_database

from parsers.importer import ImportLog
from parsers.ros import bag2_flow, bag2_pages, flow

Outcome = tuple[dict[str, tuple[list[int], list[float]]], ImportLog]
WANTED = (YAW, SPEED)


def read(path: Path, *wanted: str) -> Outcome:
    reader, log = opened(path)
    found = collect(reader, *wanted)
    return {name: (times.tolist(), values.tolist()) for name, (times, values) in found.items()}, log


def both(path: Path, monkeypatch: pytest.MonkeyPatch, *wanted: str) -> tuple[Outcome, Outcome, int]:
    """Read in one go, and with several calls; how many pages the kernel did."""
    pages = 0
    kernel = bag2_flow.decode_pages

    def spy(*args) -> None:
        nonlocal pages
        before = int(args[-1][bag2_flow.AT])
        kernel(*args)
        pages += int(args[-1][bag2_flow.AT]) - before

    with monkeypatch.context() as patch:
        patch.setattr(bag2_flow, "decode_pages", spy)
        together = read(path, *wanted)
    with monkeypatch.context() as patch:
        patch.setattr(bag2_pages, "plan_of", lambda wanted: None)
        alone = read(path, *wanted)
    return together, alone, pages


def same(one: Outcome, other: Outcome) -> None:
    np.testing.assert_equal(one[0], other[0])
    for name in ("status", "messages", "rejected", "lost_spans_ns", "notes"):
        assert getattr(one[1], name) == getattr(other[1], name), name


@pytest.mark.parametrize("extra", [b"", bytes(9000)])
def test_pages_in_one_go_are_pages_one_by_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, extra: bytes
) -> None:
    """extra: what nobody wants, on pages of its own where it is large."""
    path = write_database(tmp_path / "a.db3", extra=extra)
    together, alone, pages = both(path, monkeypatch, *WANTED)
    same(together, alone)
    assert pages > 20
    assert together[0][YAW][1] == [0.1 * i for i in range(COUNT)]
    assert together[1].status == "complete"


def test_little_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_database(tmp_path / "a.db3")
    whole = read(path, *WANTED)
    assert len(whole[0][YAW][1]) == COUNT
    for module, name, value in (
        # a page at a time, no spare rows, more numbers on some pages than are decoded at once, more rows than expected
        (bag2_flow, "STEP_BYTES", 1),
        (flow, "SPARE_ROWS", 0),
        (flow, "MAX_CELLS", 3),
        (bag2_flow, "MOST_ROWS", 5),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(module, name, value)
            same(read(path, *WANTED), whole)
    monkeypatch.setattr(bag2_pages, "pread_address", lambda: 0)
    same(read(path, *WANTED), whole)


def test_messages_that_go_on_over_other_pages_are_left_to_the_slower_way(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_database(tmp_path / "a.db3")
    monkeypatch.setattr(bag2_flow, "STEP_BYTES", 1 << 14)
    with closing(sqlite3.connect(path)) as connection:
        for i in (40, 41, 200):
            message = STORE.deserialize_cdr(imu(i), IMU)
            message.header.frame_id = "base" * 2000
            data = bytes(STORE.serialize_cdr(message, IMU))
            connection.execute("UPDATE messages SET data = ? WHERE id = ?", (data, 4 * i + 1))
        connection.commit()
    together, alone, pages = both(path, monkeypatch, *WANTED)
    same(together, alone)
    assert pages > 10
    assert together[0][YAW][1] == [0.1 * i for i in range(COUNT)]
    assert together[1].status == "complete"
    # where most are so, the pages are not read twice
    monkeypatch.setattr(bag2_pages, "MOST_ODD", 1)
    same(read(path, *WANTED), alone)


def test_compressed_messages_and_some_that_do_not_fit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bag2_flow, "STEP_BYTES", 1 << 14)
    path = write_database(tmp_path / "a.db3")
    with closing(sqlite3.connect(path)) as connection:
        connection.execute(
            "UPDATE messages SET data = substr(data, 1, 60) WHERE topic_id = 2 AND id % 400 = 1"
        )
        connection.commit()
    together, alone, pages = both(path, monkeypatch, *WANTED)
    same(together, alone)
    assert pages > 20
    assert sum(together[1].rejected.values()) == COUNT // 100
    with closing(sqlite3.connect(path)) as connection:
        pack = zstandard.ZstdCompressor().compress
        rows = connection.execute("SELECT id, data FROM messages WHERE topic_id IN (2, 5)").fetchall()
        connection.executemany(
            "UPDATE messages SET data = ? WHERE id = ?", [(pack(data), key) for key, data in rows]
        )
        connection.commit()
    together, alone, _ = both(path, monkeypatch, *WANTED)
    same(together, alone)
    assert len(together[0][YAW][1]) == COUNT


def test_damage_is_found_and_said_alike(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bag2_flow, "STEP_BYTES", 1 << 14)
    raw = write_database(tmp_path / "a.db3").read_bytes()
    rng = np.random.default_rng(11)
    bad = done = 0
    for trial in range(50):
        damaged = bytearray(raw)
        at, size = int(rng.integers(9000, len(raw) * 3 // 4)), int(rng.choice([1, 2, 30, 3000, 9000]))
        damaged[at : at + size] = rng.integers(0, 256, size, np.uint8).tobytes()
        path = tmp_path / f"{trial}.db3"
        path.write_bytes(damaged[: len(raw) * (3 if trial % 5 else 2) // 3])
        together, alone, pages = both(path, monkeypatch, *WANTED)
        same(together, alone)
        done += pages > 0
        bad += together[1].status != "complete"
    assert bad > 10
    assert done > 30
