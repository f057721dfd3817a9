"""The SQLite storage of a ROS 2 bag: opened without touching it, read in bulk, and around damage.

Tables: topics (id, name, type, serialization_format), messages (id, topic_id, timestamp, data) and, since Iron,
message_definitions (topic_type, encoding, encoded_message_definition).
"""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.ros.bag2_files import Scratch

MAGIC = b"SQLite format 3\x00"
PAGE_ROWS = 1 << 14
BATCH_BYTES = 1 << 24
MAX_FAILURES = 200
MAX_DEFINITION = 1 << 22


@dataclass(frozen=True)
class TopicRow:
    """A row of the table of topics."""

    id: int
    name: str
    type_name: str
    serialization: str


@dataclass(frozen=True)
class Rows:
    """Messages in bulk: topic id, receive time, payload's place and length in data; shape (n,) each."""

    topic_id: IntArray
    time_ns: IntArray
    offset: IntArray
    length: IntArray
    data: ByteArray


def connect(path: Path, scratch: Scratch) -> sqlite3.Connection:
    """Open a database for reading, without leaving a trace beside it.

    One that was not closed has a -wal or -journal file beside it, which SQLite must work in: it is copied first.
    """
    beside = [path.with_name(path.name + end) for end in ("-wal", "-journal")]
    beside = [extra for extra in beside if extra.is_file() and extra.stat().st_size > 0]
    if beside:
        size = sum(each.stat().st_size for each in (path, *beside))
        copy = scratch.place(path.name, size)
        if not copy.exists():
            for each in (path, *beside):
                shutil.copyfile(each, copy.with_name(each.name))
        connection = sqlite3.connect(copy)
    else:
        connection = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)
    # opens a file that is shorter than it says, so that what is there can be read
    connection.execute("PRAGMA writable_schema = ON")
    connection.execute("PRAGMA query_only = ON")
    connection.execute("PRAGMA trusted_schema = OFF")
    return connection


def is_bag(path: Path) -> bool:
    """Whether an SQLite file has the tables of a bag; a damaged one counts by its suffix."""
    try:
        uri = f"{path.resolve().as_uri()}?mode=ro&immutable=1"
        with closing(sqlite3.connect(uri, uri=True)) as connection:
            connection.execute("PRAGMA writable_schema = ON")
            tables = {
                row[0] for row in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
            }
    except sqlite3.Error:
        return path.suffix.lower() == ".db3"
    # with an unfinished -wal beside it, the tables themselves may not be in the file yet
    return {"topics", "messages"} <= tables or path.suffix.lower() == ".db3"


def missing_bytes(path: Path) -> int:
    """How many bytes a database file lacks of what its header says; 0 where it is whole or says nothing."""
    with path.open("rb") as file:
        head = file.read(100)
    page = int.from_bytes(head[16:18], "big")
    declared = int.from_bytes(head[28:32], "big") * (1 << 16 if page == 1 else page)
    told = head[24:28] == head[92:96]  # else the count of pages is out of date
    return max(0, declared - path.stat().st_size) if told else 0


def read_topics(connection: sqlite3.Connection, path: Path) -> list[TopicRow]:
    """The bag's topics. Raises LogError where there is no such table, or it cannot be read."""
    try:
        rows = connection.execute(
            "SELECT id, name, type, serialization_format FROM topics ORDER BY id"
        ).fetchall()
    except sqlite3.Error as error:
        raise LogError(
            f"its table of topics cannot be read ({error})",
            path=path,
            hint="check that the bag was copied whole; `ros2 bag info` says what it should hold",
        ) from error
    return [
        TopicRow(*row) for row in rows if isinstance(row[0], int) and all(isinstance(x, str) for x in row[1:])
    ]


def read_definitions(connection: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Type -> (encoding "ros2msg" or "ros2idl", text); empty for bags older than Iron."""
    query = (
        "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions "
        f"WHERE length(encoded_message_definition) < {MAX_DEFINITION}"
    )
    try:
        rows = connection.execute(query).fetchall()
    except sqlite3.Error:
        return {}
    return {str(row[0]): (str(row[1]), str(row[2])) for row in rows}


def count_messages(connection: sqlite3.Connection) -> dict[int, int]:
    """Topic id -> number of messages; empty where that cannot be told. Goes through the table once."""
    try:
        return dict(
            connection.execute("SELECT topic_id, count(*) FROM messages GROUP BY topic_id").fetchall()
        )
    except sqlite3.Error:
        return {}


def first_time(connection: sqlite3.Connection) -> int | None:
    """The earliest receive time, None where that cannot be told; the database keeps an index of it."""
    try:
        value = connection.execute("SELECT min(timestamp) FROM messages").fetchone()[0]
    except sqlite3.Error:
        return None
    return value if isinstance(value, int) else None


@dataclass
class MessageTable:
    """Reads the messages of some topics in the order of their ids."""

    connection: sqlite3.Connection
    path: Path
    size: int
    topic_ids: tuple[int, ...]
    log: ImportLog
    cut: bool = False
    failures: int = 0

    def batches(self) -> Iterator[Rows]:
        """Yield messages in bulk, at most BATCH_BYTES (or one message) at a time, around damaged pages.

        Rowids, times and sizes of a page of rows come first, so that payloads are only fetched in known amounts.
        """
        last, limit, step = -(1 << 63), PAGE_ROWS, 0
        last_time: int | None = None
        while True:
            page = self._page(last + step, limit)
            if page is None:
                self.failures += 1
                if step > 1 << 40 or self.failures > MAX_FAILURES:
                    break
                if limit > 1:
                    limit = max(1, limit // 16)
                else:
                    last, step = max(last, 0), max(1, step * 2)
                continue
            if not len(page):
                break
            if step and last_time is not None:
                self.log.lost_spans_ns.append((last_time, int(page[0, 2])))
            last, step, limit, last_time = int(page[-1, 0]), 0, min(PAGE_ROWS, limit * 16), int(page[-1, 2])
            yield from self._payloads(page)

    def _page(self, after: int, limit: int) -> IntArray | None:
        """(rowid, topic, time, size) of the next rows, shape (n, 4); None where they cannot be read."""
        query = (
            f"SELECT rowid, topic_id, timestamp, length(data) FROM messages WHERE rowid > ? AND +topic_id IN "
            f"({self._marks}) AND {self._usable} ORDER BY rowid LIMIT ?"
        )
        try:
            rows = self.connection.execute(query, (after, *self.topic_ids, limit)).fetchall()
        except sqlite3.Error as error:
            self._damaged(error)
            return None
        page = np.array(rows, dtype=np.int64).reshape(-1, 4)
        rowid = page[:, 0]
        if len(page) and not (rowid[0] > after and (np.diff(rowid) > 0).all()):
            # only a damaged tree gives rows out of order: going on from them could go round in circles
            self._damaged(sqlite3.DatabaseError("rows out of order"))
            return None
        return page

    def _payloads(self, page: IntArray) -> Iterator[Rows]:
        """Fetch the payloads of a page of rows, a bounded amount at a time; halved where they cannot be read."""
        filled = np.cumsum(page[:, 3]) // BATCH_BYTES
        cuts = np.flatnonzero(np.diff(filled)) + 1
        spans = [(int(a), int(b)) for a, b in zip([0, *cuts], [*cuts, len(page)], strict=True)][::-1]
        query = (
            f"SELECT data FROM messages WHERE rowid BETWEEN ? AND ? AND +topic_id IN ({self._marks}) "
            f"AND {self._usable} ORDER BY rowid"
        )
        while spans:
            start, stop = spans.pop()
            part = page[start:stop]
            try:
                rows = self.connection.execute(
                    query, (int(part[0, 0]), int(part[-1, 0]), *self.topic_ids)
                ).fetchall()
                data = np.frombuffer(b"".join(chain.from_iterable(rows)), dtype=np.uint8)
            except (sqlite3.Error, MemoryError) as error:
                self._damaged(error)
                self.failures += 1
                if stop - start > 1 and self.failures <= MAX_FAILURES:
                    middle = (start + stop) // 2
                    spans += [(middle, stop), (start, middle)]
                else:
                    self.log.reject("message on a damaged page of the bag", stop - start)
                continue
            length = np.ascontiguousarray(part[:, 3])
            if len(rows) != len(part) or len(data) != int(length.sum()):
                self.log.reject("message on a damaged page of the bag", len(part))
                continue
            yield Rows(part[:, 1], part[:, 2], np.cumsum(length) - length, length, data)

    @property
    def _usable(self) -> str:
        # a payload that is larger than its file is damage, and would be allocated before SQLite notices
        return f"typeof(data) = 'blob' AND typeof(timestamp) = 'integer' AND length(data) <= {self.size}"

    @property
    def _marks(self) -> str:
        return ",".join("?" * len(self.topic_ids))

    def _damaged(self, error: Exception) -> None:
        what = "missing" if self.cut else "damaged"
        self.log.worsen(
            "truncated" if self.cut else "malformed",
            f"{self.path.name}: {what} pages were left out ({error})",
        )
