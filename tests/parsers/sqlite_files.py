"""SQLite files with messages for the tests: filled at random, read from their pages and by SQLite's own library."""

from __future__ import annotations

import sqlite3
import zlib
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import parsers.parallel
import parsers.ros.bag2_pages
import parsers.ros.bag2_read
import parsers.sqlite_scan
from parsers.channels import ByteArray, IntArray
from parsers.importer import ImportLog
from parsers.ros.bag2_database import connect
from parsers.ros.bag2_decode import Collector
from parsers.ros.bag2_files import Scratch
from parsers.ros.bag2_read import DatabaseRead
from parsers.ros.contract import Cells, Decoded, FieldInfo
from parsers.ros.stamps import StampChooser
from parsers.ros.topics import Topic

MESSAGES = "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB)"
INDEX = "CREATE INDEX timestamp_idx ON messages (timestamp ASC)"
WANTED = (2, 7, 300, 70_000)
LIMITS = (-(1 << 63), (1 << 63) - 1, 0, 1, -1, 255, -129, 1 << 15, -(1 << 23), 1 << 31, -(1 << 47), 1 << 60)


@dataclass(frozen=True)
class Checksums:
    """A decoder that tells payloads apart whatever is in them."""

    fields: Sequence[FieldInfo] = ()
    has_header: bool = False

    def decode(
        self,
        data: ByteArray,
        offset: IntArray,
        length: IntArray,
        wanted: Sequence[str],
        cells: Cells = np.empty,
    ) -> Decoded:
        blobs = [data[a : a + n].tobytes() for a, n in zip(offset.tolist(), length.tolist(), strict=True)]
        assert [len(blob) for blob in blobs] == length.tolist()
        columns = {"crc": np.array([float(zlib.crc32(blob)) for blob in blobs]), "size": length.astype(float)}
        return Decoded(columns, None, 0)


@dataclass(frozen=True)
class Found:
    """What was read of a file: topic -> (time, checksum, size) of each message; and the log book."""

    messages: dict[str, list[tuple[int, float, float]]]
    log: ImportLog

    @property
    def whole(self) -> bool:
        return self.log.status == "complete" and not self.log.rejected

    def rows(self) -> list[tuple[str, tuple[int, float, float]]]:
        return [(topic, row) for topic in sorted(self.messages) for row in self.messages[topic]]


def read(path: Path, *, pages: bool, cut: bool = False) -> Found:
    """Read all wanted topics, from the pages or with the library alone."""
    log, scratch = ImportLog(), Scratch()
    chosen = {n: (Topic(f"/{n}", f"/{n}", "t", Checksums()), ("crc", "size")) for n in WANTED}
    collector = Collector(StampChooser(), log)
    messages: dict[str, list[tuple[int, float, float]]] = {}
    with pytest.MonkeyPatch.context() as patch, closing(connect(path, scratch)) as connection:
        if not pages:
            patch.setattr(parsers.ros.bag2_read, "message_pages", lambda *_: None)
        for outcome in DatabaseRead(connection, path, path, chosen, log, cut).outcomes():
            for chunk in collector.chunks(outcome):
                columns = [chunk.columns[f"{chunk.group}.{name}"].tolist() for name in ("crc", "size")]
                messages.setdefault(chunk.group, []).extend(
                    zip(chunk.time_ns.tolist(), *columns, strict=True)
                )
    return Found(messages, log)


def fill(
    connection: sqlite3.Connection,
    rng: np.random.Generator,
    count: int,
    largest: int,
    first: int | None = None,
) -> None:
    """Add messages of all sizes and topics, with times of all widths; some with ids of their own."""
    for k in range(count):
        topic = int(rng.choice([*WANTED, 3, 1 << 40, -5]))
        time = int(rng.choice(LIMITS)) if rng.random() < 0.3 else 10**18 + k
        data = rng.bytes(int(rng.integers(0, largest)) if rng.random() < 0.7 else int(rng.integers(0, 60)))
        value: Any = data if rng.random() < 0.95 else [None, "text", 5, 2.5][int(rng.integers(4))]
        rowid = None if first is None else first + 3 * k
        connection.execute(
            "INSERT INTO messages (id, topic_id, timestamp, data) VALUES (?, ?, ?, ?)",
            (rowid, topic, time, value),
        )


def database(
    path: Path,
    seed: int = 1,
    *,
    page_size: int = 1024,
    count: int = 300,
    largest: int = 900,
    before: Sequence[str] = (),
    tables: Sequence[str] = (MESSAGES, INDEX),
    after: Sequence[str] = (),
    first: int | None = None,
) -> Path:
    """A file with random messages; statements before the tables are made, and after they were filled."""
    rng = np.random.default_rng(seed)
    with closing(sqlite3.connect(path)) as connection:
        connection.isolation_level = None
        for statement in (f"PRAGMA page_size = {page_size}", *before, *tables, "BEGIN"):
            connection.execute(statement)
        fill(connection, rng, count, largest, first)
        for statement in ("COMMIT", *after):
            connection.execute(statement)
    return path


def damaged(path: Path, change: Callable[[bytearray], object]) -> Path:
    raw = bytearray(path.read_bytes())
    change(raw)
    path.write_bytes(raw)
    return path
