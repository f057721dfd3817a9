"""Messages straight from the pages of SQLite files, against SQLite's own library on the same files, whole and damaged."""

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
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import parsers.parallel
import parsers.ros.bag2_pages
import parsers.ros.bag2_read
import parsers.sqlite_scan
from parsers.channels import ByteArray, IntArray
from parsers.importer import ImportLog
from parsers.ros.bag2_database import TopicRow, connect, count_rows
from parsers.ros.bag2_decode import Collector
from parsers.ros.bag2_files import Scratch
from parsers.ros.bag2_pages import count_from_pages, message_pages
from parsers.ros.bag2_read import DatabaseRead, count_messages
from parsers.ros.contract import Decoded, FieldInfo
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

    def decode(self, data: ByteArray, offset: IntArray, length: IntArray, wanted: Sequence[str]) -> Decoded:
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


def from_pages(path: Path) -> bool:
    with closing(connect(path, Scratch())) as connection:
        return message_pages(connection, path) is not None


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


def damaged(path: Path, change: Callable[[bytearray], object]) -> Path:
    raw = bytearray(path.read_bytes())
    change(raw)
    path.write_bytes(raw)
    return path


def test_broken_chain_costs_its_message_and_says_when(tmp_path: Path) -> None:
    path = tmp_path / "a.db3"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute(MESSAGES)
        rows = [(7, 100 * i, bytes([i]) * 10_000) for i in range(20)]
        connection.executemany("INSERT INTO messages VALUES (NULL, ?, ?, ?)", rows)
        connection.commit()
    raw = path.read_bytes()
    at = raw.index(bytes([9]) * 4092) - 4
    damaged(path, lambda data: data.__setitem__(slice(at, at + 4), (1 << 30).to_bytes(4, "big")))
    found = read(path, pages=True)
    assert [time for time, _, _ in found.messages["/7"]] == [100 * i for i in range(20) if i != 9]
    assert found.log.status == "malformed"
    assert dict(found.log.rejected) == {"message on a damaged page of the bag": 1}
    assert found.log.lost_spans_ns == [(800, 1000)]
    library = read(path, pages=False)
    assert (library.messages, library.log.lost_spans_ns) == (found.messages, found.log.lost_spans_ns)


def test_chains_that_go_round_in_circles_end(tmp_path: Path) -> None:
    path = database(tmp_path / "a.db3", page_size=512, count=400, largest=20_000)

    def tie(raw: bytearray) -> None:
        for at in range(512 * 20, len(raw), 512):
            if raw[at] == 0:  # an overflow page, by the high byte of its number
                raw[at : at + 4] = (21).to_bytes(4, "big")

    found = read(damaged(path, tie), pages=True)
    assert found.log.messages > 0


def varint(value: int) -> bytes:
    return bytes([value >> 14 & 127 | 128, value >> 7 & 127 | 128, value & 127])


def test_messages_that_share_their_pages_are_damage(tmp_path: Path) -> None:
    """Messages that all claim to be as large as half the file, in chains that go round: reading them takes for ever."""
    path = tmp_path / "a.db3"
    size, claimed = 17_000, 17_000 + 508 * 1900
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA page_size = 512")
        connection.execute(MESSAGES)
        rows = [(100_000 + i, 7, i, bytes(size)) for i in range(120)]
        connection.executemany("INSERT INTO messages VALUES (?, ?, ?, ?)", rows)
        connection.commit()
    raw = path.read_bytes()
    for at in range(512, len(raw), 512):
        if not any(raw[at : at + 512]):  # the last page of a chain now leads to itself
            raw = raw[:at] + (at // 512 + 1).to_bytes(4, "big") + raw[at + 4 :]
    lengths = {n: varint(n) for n in range(size, size + 20)}
    for n, text in lengths.items():
        raw = raw.replace(text + varint(100_000)[:1], varint(n + claimed - size) + varint(100_000)[:1])
    raw = raw.replace(varint(2 * size + 12), varint(2 * claimed + 12))
    path.write_bytes(raw)
    assert read(path, pages=False).messages["/7"][0][2] == claimed
    found = read(path, pages=True)
    assert found.log.status == "malformed"
    assert any("share pages" in note for note in found.log.notes)
    assert 0 < len(found.messages["/7"]) < 10
    assert found.log.rejected["message on a damaged page of the bag"] > 100


def test_every_kind_of_damage_to_the_tree(tmp_path: Path) -> None:
    path = database(tmp_path / "a.db3", page_size=512, count=3000, largest=60)
    raw = path.read_bytes()
    expected = read(path, pages=True).rows()
    leaves = [at for at in range(512, len(raw), 512) if raw[at] == 13]
    interior = [at for at in range(512, len(raw), 512) if raw[at] == 5]
    assert len(interior) > 3
    middle, inner = leaves[len(leaves) // 2], interior[2]
    other = (leaves[3] // 512 + 1).to_bytes(4, "big")
    changes: dict[str, tuple[int, bytes]] = {
        "no page": (middle, b"\x00"),
        "index page": (middle, b"\x0a"),
        "cells": (middle + 3, b"\xff\xff"),
        "cell outside": (middle + 8, b"\xff\xf0"),
        "cell in the header": (middle + 8, b"\x00\x01"),
        "interior gone": (inner, b"\x00"),
        "interior cells": (inner + 3, b"\xff\xff"),
        "child twice": (inner + 8, other),
        "child outside": (inner + 8, b"\x7f\xff\xff\xff"),
    }
    for what, (at, new) in changes.items():
        found = read(
            damaged(path, lambda data, at=at, new=new: data.__setitem__(slice(at, at + len(new)), new)),
            pages=True,
        )  # type: ignore[misc]
        path.write_bytes(raw)
        assert found.log.status == "malformed", what
        rows = found.rows()
        assert set(rows) <= set(expected), what
        assert len(rows) > len(expected) * (0.97 if at == middle else 0.5), what


def test_file_that_is_cut(tmp_path: Path) -> None:
    path = database(tmp_path / "a.db3", count=800)
    raw = path.read_bytes()
    expected = read(path, pages=True)
    for part in (0.95, 0.6, 0.3):
        path.write_bytes(raw[: int(len(raw) * part)])
        found, library = read(path, pages=True, cut=True), read(path, pages=False, cut=True)
        assert found.log.status == "truncated"
        assert set(found.rows()) <= set(expected.rows())
        # the library gives zeros for what is missing of the last page
        assert len(found.rows()) >= len(library.rows()) * 0.98


def test_random_damage_never_crashes_and_is_never_silent(tmp_path: Path) -> None:
    rng = np.random.default_rng(11)
    path = tmp_path / "a.db3"
    equal = 0
    for trial in range(60):
        path.unlink(missing_ok=True)
        database(
            path, trial, page_size=[512, 1024, 4096][trial % 3], count=150, largest=[40, 700, 6000][trial % 3]
        )
        raw = np.frombuffer(path.read_bytes(), dtype=np.uint8).copy()
        for _ in range(int(rng.integers(1, 30))):
            at = int(rng.integers(100, len(raw)))
            raw[at] = rng.integers(0, 256) if trial % 2 else raw[at] ^ (1 << int(rng.integers(8)))
        path.write_bytes(raw.tobytes())
        try:
            library = read(path, pages=False)
        except sqlite3.Error:
            continue
        found = read(path, pages=True)
        if found.whole or library.whole:
            equal += 1
        if found.whole:
            assert found.messages == library.messages
        elif library.whole:
            # the pages' rules are kept more strictly: what is left out then is said to be
            assert set(found.rows()) <= set(library.rows())
    assert equal > 10
