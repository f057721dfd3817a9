"""One SQLite file of a ROS 2 bag, read on all cores: from its pages where that is possible, else with the library."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from parsers.importer import ImportLog
from parsers.parallel import in_order
from parsers.ros.bag2_database import TopicRow, beside, count_rows
from parsers.ros.bag2_decode import Chosen, Outcome, decode_rows
from parsers.ros.bag2_lost import LostMessages
from parsers.ros.bag2_pages import PageSource, Unread, count_from_pages, message_pages, page_source
from parsers.ros.bag2_rows import DAMAGED_MESSAGE, MessageTable, no_rows

MAX_ASKED = 500
"""So many damaged places are looked at with the library, which may go through all of a damaged table for each."""


def count_messages(connection: sqlite3.Connection, path: Path, topics: Sequence[TopicRow]) -> dict[int, int]:
    """Topic id -> number of messages; empty where that cannot be told. Goes through the table once."""
    pages = None if beside(path) else message_pages(connection, path)
    counts = None if pages is None else count_from_pages(pages, [row.id for row in topics])
    return count_rows(connection) if counts is None else counts


@dataclass
class DatabaseRead:
    """Reads the chosen topics. shown: the path that the user knows. cut: the file breaks off. done_bytes: so far."""

    connection: sqlite3.Connection
    path: Path
    shown: Path
    chosen: Chosen
    log: ImportLog
    cut: bool
    done_bytes: int = 0
    _asked: int = 0

    def outcomes(self) -> Iterator[Outcome]:
        """Yield all messages, decoded, in the order of their ids."""
        size = self.path.stat().st_size
        table = MessageTable(self.connection, self.shown, size, tuple(self.chosen), self.log, self.cut)
        # what is beside a database that was not closed goes before what is in it: only the library knows how
        pages = None if beside(self.path) else message_pages(self.connection, self.path)
        source = None if pages is None else page_source(pages, self.chosen)
        if source is None:
            yield from in_order(partial(decode_rows, chosen=self.chosen), table.batches())
            self.done_bytes = size
            return
        lost = LostMessages(table, self.log)
        try:
            yield from self._from_pages(source, table, lost)
        finally:
            source.close()

    def _from_pages(self, source: PageSource, table: MessageTable, lost: LostMessages) -> Iterator[Outcome]:
        paged, overflow = source.pages.paged, 0
        for batch in in_order(source.read, source.batches()):
            self.done_bytes = min(self.done_bytes + batch.size, paged.size)
            for part in batch.parts:
                if isinstance(part, Unread):
                    yield from self._around(part, table, lost)
                    continue
                if DAMAGED_MESSAGE in part.rejected:
                    self._damaged("pages of its messages")
                yield part
                overflow += part.overflow
            if overflow > paged.pages:
                # each belongs to one message: only a damaged file leads to some of them again and again
                self.log.worsen(
                    "malformed", f"{self.shown.name}: its messages share pages; reading stopped there"
                )
                return

    def _around(self, part: Unread, table: MessageTable, lost: LostMessages) -> Iterator[Outcome]:
        """Read the messages on damaged pages with the library, which gets at some of them.

        Not where the file breaks off: what is missing of its last page would be zeros to the library.
        """
        self._damaged("pages of its messages")
        self._asked += 1
        if self.cut or self._asked > MAX_ASKED:
            if not self.cut:
                lost.write_down(part.low, part.high, 0, looked=False)
            yield decode_rows(no_rows(lost=True), self.chosen)
            return
        counted = self.log.rejected[DAMAGED_MESSAGE]
        found = known = 0
        for rows in table.batches(part.low, part.high):
            found += 1
            known += len(rows.time_ns)
            yield decode_rows(rows, self.chosen)
        known += self.log.rejected[DAMAGED_MESSAGE] - counted
        lost.write_down(part.low, part.high, known, looked=True)
        if not found:
            # to the library a damaged page may look like an empty one
            yield decode_rows(no_rows(lost=True), self.chosen)

    def _damaged(self, what: str) -> None:
        if self.cut:
            self.log.worsen("truncated", f"{self.shown.name}: {what} are missing")
        else:
            self.log.worsen("malformed", f"{self.shown.name}: {what} are damaged")
