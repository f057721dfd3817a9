"""Damaged SQLite files: what is still found equals what SQLite's own library finds, and nothing is lost in silence."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
from sqlite_files import MESSAGES, damaged, database, read


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
