"""Messages straight from the pages of SQLite files, against SQLite's own library on the same files."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlite_files import MESSAGES, WANTED, Found, damaged, database, fill, read

import parsers.parallel
import parsers.ros.bag2_pages
import parsers.ros.bag2_read
import parsers.sqlite_scan
from parsers.ros.bag2_database import TopicRow, connect, count_rows
from parsers.ros.bag2_files import Scratch
from parsers.ros.bag2_pages import count_from_pages, message_pages
from parsers.ros.bag2_read import count_messages


def from_pages(path: Path) -> bool:
    with closing(connect(path, Scratch())) as connection:
        return message_pages(connection, path) is not None


def same(path: Path) -> Found:
    """Both ways give the same, the pages are really used, and so does a single thread; what they give."""
    assert from_pages(path)
    found, expected = read(path, pages=True), read(path, pages=False)
    assert found.messages == expected.messages
    assert found.log == expected.log
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parsers.parallel, "cores", lambda: 1)
        patch.setattr(parsers.ros.bag2_pages, "LEAF_BYTES", 1 << 12)
        patch.setattr(parsers.ros.bag2_pages, "CHAIN_BYTES", 1 << 12)
        patch.setattr(parsers.ros.bag2_pages, "BATCH_BYTES", 1 << 14)
        patch.setattr(parsers.sqlite_scan, "LEAST_ROWS", 1)
        single = read(path, pages=True)
    assert (single.messages, single.log) == (found.messages, found.log)
    return found


@pytest.mark.parametrize("page_size", [512, 1024, 2048, 4096, 8192, 16384, 32768, 65536])
@pytest.mark.parametrize("vacuum", ["NONE", "FULL", "INCREMENTAL"])
def test_page_sizes_and_pointer_maps(tmp_path: Path, page_size: int, vacuum: str) -> None:
    path = database(
        tmp_path / "a.db3",
        page_size=page_size,
        largest=5 * page_size,
        count=120,
        before=[f"PRAGMA auto_vacuum={vacuum}"],
    )
    found = same(path)
    assert found.whole
    assert max(size for rows in found.messages.values() for _, _, size in rows) > 3 * page_size


@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    seed=st.integers(0, 1 << 30),
    page_size=st.sampled_from([512, 1024, 4096]),
    largest=st.sampled_from([1, 40, 500, 3000, 20_000]),
    count=st.integers(0, 400),
    first=st.sampled_from([None, -700, 5, (1 << 56) - 9, (1 << 63) - 2000]),
    deleted=st.sampled_from([None, "id % 3 = 0", "id % 100 < 90", "length(data) > 400", "1"]),
    vacuumed=st.booleans(),
)
def test_any_database_gives_what_the_library_gives(
    tmp_path: Path,
    seed: int,
    page_size: int,
    largest: int,
    count: int,
    first: int | None,
    deleted: str | None,
    vacuumed: bool,
) -> None:
    path = tmp_path / "any.db3"
    path.unlink(missing_ok=True)
    after = []
    if deleted:
        # the pages of deleted messages are used again, out of order
        after = [f"DELETE FROM messages WHERE {deleted}", "CREATE TABLE other (x)"]
        after += ["INSERT INTO other VALUES (zeroblob(900))"] * 5
        after += ["INSERT INTO messages VALUES (NULL, 7, 5, zeroblob(1500))"] * (0 if first else 40)
    after += ["VACUUM"] if vacuumed else []
    database(path, seed, page_size=page_size, count=count, largest=largest, first=first, after=after)
    assert same(path).whole


def test_deep_trees_and_many_pages(tmp_path: Path) -> None:
    path = database(tmp_path / "a.db3", page_size=512, count=6000, largest=30)
    found = same(path)
    assert sum(map(len, found.messages.values())) > 3000


def test_order_is_that_of_the_ids_not_of_the_pages(tmp_path: Path) -> None:
    path = tmp_path / "a.db3"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute(MESSAGES)
        ids = np.random.default_rng(3).permutation(3000).tolist()
        rows = [(i, 7, 10 * i, bytes(i % 300)) for i in ids]
        connection.executemany("INSERT INTO messages VALUES (?, ?, ?, ?)", rows)
        connection.commit()
    times = [time for time, _, _ in same(path).messages["/7"]]
    assert times == [10 * i for i in range(3000)]


@pytest.mark.parametrize(
    ("tables", "direct"),
    [
        ([MESSAGES.replace("id INTEGER PRIMARY KEY", "id INTEGER")], True),
        ([MESSAGES.replace("data BLOB", "data BLOB, more TEXT DEFAULT 'x', y REAL")], True),
        ([MESSAGES.replace("topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL", "timestamp INT, topic_id BIGINT")], True),
        ([MESSAGES, "ALTER TABLE messages ADD COLUMN more INTEGER DEFAULT 4"], True),
        ([MESSAGES.replace("messages", "Messages")], True),
        ([MESSAGES.replace("data BLOB", "data BLOB DEFAULT x'00'")], False),
        ([MESSAGES.replace("data BLOB", "data BLOB" + "".join(f", c{k} TEXT DEFAULT 'abc'" for k in range(150)))], False),
        ([MESSAGES + " WITHOUT ROWID"], False),
        ([MESSAGES.replace("timestamp INTEGER", "timestamp REAL")], False),
        ([MESSAGES.replace("(id", "(name TEXT, id")], False),
        ([MESSAGES.replace("topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB", "data BLOB, topic_id INTEGER, timestamp INTEGER")], False),
        ([MESSAGES.replace("data BLOB", "data BLOB, twice INTEGER AS (topic_id * 2) STORED")], False),
        ([MESSAGES.replace("topic_id INTEGER", "twice INTEGER AS (timestamp * 2), topic_id INTEGER")], False),
    ],
)  # fmt: skip
def test_other_schemas(tmp_path: Path, tables: list[str], direct: bool) -> None:
    first = 1 if "PRIMARY KEY" not in tables[0] or "WITHOUT ROWID" in tables[0] else None
    path = database(tmp_path / "a.db3", tables=tables, first=first)
    assert from_pages(path) == direct
    found, expected = read(path, pages=True), read(path, pages=False)
    assert found.messages == expected.messages
    assert found.log == expected.log
    if "WITHOUT ROWID" not in tables[0]:  # the library's way needs rowids as well
        assert found.whole
        assert bool(found.messages) == ("REAL NOT NULL" not in tables[0])  # times are integers in a bag


def test_counts_are_the_library_s(tmp_path: Path) -> None:
    path = database(
        tmp_path / "a.db3", count=1000, after=["DELETE FROM messages WHERE typeof(data) <> 'blob'"]
    )
    topics = [TopicRow(n, f"/{n}", "t", "cdr") for n in (*WANTED, 3, 12345)]
    with closing(connect(path, Scratch())) as connection:
        pages = message_pages(connection, path)
        assert pages is not None
        found = count_from_pages(pages, [row.id for row in topics])
        assert found == count_messages(connection, path, topics)
        expected = count_rows(connection)
    assert found == {n: expected.get(n, 0) for n in (*WANTED, 3, 12345)}
    damaged(path, lambda raw: raw.__setitem__(slice(len(raw) // 2, None), bytes(len(raw) - len(raw) // 2)))
    assert count_from_pages(pages, WANTED) is None


def test_a_view_is_left_to_the_library(tmp_path: Path) -> None:
    tables = [MESSAGES.replace("messages", "inner"), "CREATE VIEW messages AS SELECT id, id AS rowid, 7 AS topic_id, 8 AS "
              "timestamp, x'00' AS data FROM \"inner\""]  # fmt: skip
    with closing(sqlite3.connect(tmp_path / "a.db3")) as connection:
        for statement in (tables[0].replace("inner", '"inner"'), tables[1]):
            connection.execute(statement)
    assert not from_pages(tmp_path / "a.db3")


def test_utf16_texts_and_reserved_bytes(tmp_path: Path) -> None:
    assert same(database(tmp_path / "a.db3", before=["PRAGMA encoding = 'UTF-16'"])).whole
    path = tmp_path / "b.db3"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA page_size = 512")
        connection.execute("PRAGMA user_version = 1")
    raw = bytearray(path.read_bytes())
    raw[20], raw[105:107] = 32, (480).to_bytes(2, "big")  # extensions keep checksums at the end of each page
    path.write_bytes(raw)
    found = same(database(path, page_size=512, count=500))
    assert found.whole
    assert path.read_bytes()[20] == 32


def test_count_of_pages_that_an_old_writer_left_behind(tmp_path: Path) -> None:
    path = database(tmp_path / "a.db3")
    raw = bytearray(path.read_bytes())
    raw[28:32], raw[92:96] = (3).to_bytes(4, "big"), (0).to_bytes(4, "big")
    path.write_bytes(raw)
    assert same(path).whole


def test_write_ahead_log(tmp_path: Path) -> None:
    path = tmp_path / "a.db3"
    database(path, before=["PRAGMA journal_mode = WAL"])
    assert path.read_bytes()[18:20] == b"\x02\x02"
    whole = same(path)  # closed, so that all of it is in the file
    with closing(sqlite3.connect(path)) as live:
        live.execute("PRAGMA wal_autocheckpoint = 0")
        fill(live, np.random.default_rng(5), 100, 900)
        live.commit()
        other = tmp_path / "copy"
        other.mkdir()
        for name in ("a.db3", "a.db3-wal"):
            (other / name).write_bytes((tmp_path / name).read_bytes())
    found = read(other / "a.db3", pages=True)
    assert found.whole
    assert len(found.rows()) > len(whole.rows()) + 40
    assert found.messages == read(other / "a.db3", pages=False).messages == same(path).messages


def test_pages_of_unwanted_large_messages_are_not_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.db3"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA page_size = 4096")
        connection.execute(MESSAGES)
        for i in range(200):
            connection.execute("INSERT INTO messages VALUES (NULL, 4, ?, zeroblob(200000))", (i,))
            connection.execute("INSERT INTO messages VALUES (NULL, 7, ?, zeroblob(300))", (i,))
        connection.commit()
    counted = 0
    inner = parsers.ros.bag2_pages.PageReader._read

    def counting(reader: Any, at: int, view: memoryview) -> int:
        nonlocal counted
        counted += len(view)
        return inner(reader, at, view)

    monkeypatch.setattr(parsers.ros.bag2_pages.PageReader, "_read", counting)
    assert len(read(path, pages=True).messages["/7"]) == 200
    assert counted < path.stat().st_size / 40


def test_interleaved_chains(tmp_path: Path) -> None:
    """Chains whose pages are scattered: the free pages of small deleted messages are used again."""
    path = database(
        tmp_path / "a.db3",
        page_size=512,
        count=3000,
        largest=400,
        after=["DELETE FROM messages WHERE id % 2"],
    )
    with closing(sqlite3.connect(path)) as connection:
        fill(connection, np.random.default_rng(2), 60, 40_000)
        connection.commit()
    assert same(path).whole
