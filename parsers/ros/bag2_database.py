"""The SQLite storage of a ROS 2 bag: opened without touching it, and its smaller tables.

Tables: topics (id, name, type, serialization_format), messages (id, topic_id, timestamp, data) and, since Iron,
message_definitions (topic_type, encoding, encoded_message_definition).
"""

from __future__ import annotations

import shutil
import sqlite3
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from parsers.errors import LogError
from parsers.places import remote
from parsers.ros.bag2_files import Scratch, unfinished

MAGIC = b"SQLite format 3\x00"
MAX_DEFINITION = 1 << 22
_SCHEMA_BYTES = 1 << 16


@dataclass(frozen=True)
class TopicRow:
    """A row of the table of topics."""

    id: int
    name: str
    type_name: str
    serialization: str


def beside(path: Path) -> list[Path]:
    """Files that a recorder left beside a database which it did not close: it is not complete without them."""
    found = [path.with_name(name) for name in unfinished(path.name)]
    return [each for each in found if each.is_file() and each.stat().st_size > 0]


def connect(path: Path, scratch: Scratch) -> sqlite3.Connection:
    """Open a database for reading, without leaving a trace beside it.

    One that was not closed has a -wal or -journal file beside it, which SQLite must work in: it is copied first.
    """
    extra = beside(path)
    if extra:
        size = sum(each.stat().st_size for each in (path, *extra))
        copy = scratch.place(path.name, size)
        if not copy.exists():
            for each in (path, *extra):
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
    if remote(path) is not None:
        # the library opens files of a disk only; a schema stands in the first pages
        with path.open("rb", buffering=0) as file:
            head = file.read(_SCHEMA_BYTES)
        return path.suffix.lower() == ".db3" or (b"topics" in head and b"messages" in head)
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


def count_rows(connection: sqlite3.Connection) -> dict[int, int]:
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
