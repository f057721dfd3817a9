"""Messages of a ROS 2 bag through SQLite's own library: read in bulk, and around damage."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.importer import ImportLog

PAGE_ROWS = 1 << 14
BATCH_BYTES = 1 << 24
MAX_FAILURES = 200
FIRST_KEY, LAST_KEY = -(1 << 63), (1 << 63) - 1
DAMAGED_MESSAGE = "message on a damaged page of the bag"


@dataclass(frozen=True)
class Rows:
    """Messages in bulk: topic id, receive time, payload's place and length in data; shape (n,) each.

    lost: something that was before these messages could not be read.
    """

    topic_id: IntArray
    time_ns: IntArray
    offset: IntArray
    length: IntArray
    data: ByteArray
    lost: bool = False


def no_rows(*, lost: bool) -> Rows:
    """No messages, to say that something was lost where none come after it."""
    none = np.zeros(0, dtype=np.int64)
    return Rows(none, none, none, none, np.zeros(0, dtype=np.uint8), lost)


@dataclass
class MessageTable:
    """Reads the messages of some topics in the order of their ids. size: of the file, in bytes. cut: it breaks off."""

    connection: sqlite3.Connection
    path: Path
    size: int
    topic_ids: tuple[int, ...]
    log: ImportLog
    cut: bool = False
    failures: int = 0

    def batches(self, low: int = FIRST_KEY, high: int = LAST_KEY) -> Iterator[Rows]:
        """Yield messages in bulk, at most BATCH_BYTES (or one message) at a time, around damaged pages.

        Only those whose ids are above `low` and not above `high`. Rowids, times and sizes of a page of rows come first,
        so that payloads are only fetched in known amounts.
        """
        last, limit, step, lost = low, PAGE_ROWS, 0, False
        while last + step < high:
            page = self._page(last + step, high, limit)
            if page is None:
                self.failures += 1
                if limit > 1 and self.failures <= MAX_FAILURES:
                    limit = max(1, limit // 16)
                    continue
                lost = True
                if step > 1 << 40 or self.failures > MAX_FAILURES:
                    break
                last, step = max(last, 0), max(1, step * 2)
                continue
            if not len(page):
                break
            last, step, limit = int(page[-1, 0]), 0, min(PAGE_ROWS, limit * 16)
            for rows in self._payloads(page):
                yield replace(rows, lost=rows.lost or lost)
                lost = False
        if lost:
            yield no_rows(lost=True)

    def _page(self, after: int, high: int, limit: int) -> IntArray | None:
        """(rowid, topic, time, size) of the next rows, shape (n, 4); None where they cannot be read."""
        query = (
            "SELECT rowid, topic_id, timestamp, length(data) FROM messages WHERE rowid > ? AND rowid <= ? AND +topic_id "
            f"IN ({self._marks}) AND {self._usable} ORDER BY rowid LIMIT ?"
        )
        try:
            rows = self.connection.execute(query, (after, high, *self.topic_ids, limit)).fetchall()
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
        lost = False
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
                    self.log.reject(DAMAGED_MESSAGE, stop - start)
                    lost = True
                continue
            length = np.ascontiguousarray(part[:, 3])
            if len(rows) != len(part) or len(data) != int(length.sum()):
                self.log.reject(DAMAGED_MESSAGE, len(part))
                lost = True
                continue
            yield Rows(part[:, 1], part[:, 2], np.cumsum(length) - length, length, data, lost)
            lost = False
        if lost:
            yield no_rows(lost=True)

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
