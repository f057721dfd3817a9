"""How many messages a ROS 2 bag's damaged pages held, by the numbers that a recorder gives them one after the other."""

from __future__ import annotations

import sqlite3
from dataclasses import dataclass, field

from parsers.importer import ImportLog
from parsers.ros.bag2_rows import MessageTable

LOST_MESSAGE = "message of any topic on a damaged page of the bag"


@dataclass
class LostMessages:
    """Counts into the log book. table: of the topics that are read; the damaged pages hold messages of others as well."""

    table: MessageTable
    log: ImportLog
    _ends: tuple[int, int] | None = None
    _asked: bool = False
    _others: tuple[int, ...] = field(default=())

    def write_down(self, low: int, high: int, known: int, *, looked: bool) -> None:
        """Count the messages whose numbers are above `low` and not above `high`.

        known: those of the topics that are read which were found or counted already. looked: the pages were looked at with the library,
        which finds some of the other topics too.
        """
        if not self._asked:
            self._asked = True
            self._ends = self._numbers()
        if self._ends is None:
            self.log.note(
                f"{self.table.path.name}: how many messages were on its damaged pages cannot be told"
            )
            return
        first, last = self._ends
        lost = min(high, last) - max(low, first - 1) - known
        if looked and lost > 0 and self._others:
            aside = ImportLog()
            table = MessageTable(
                self.table.connection, self.table.path, self.table.size, self._others, aside, self.table.cut
            )
            lost -= sum(len(rows.time_ns) for rows in table.batches(low, high))
        self.log.reject(LOST_MESSAGE, lost)

    def _numbers(self) -> tuple[int, int] | None:
        """The first and last number, where none between them lacks: by the index of the times, which is whole in most damaged bags."""
        ask = self.table.connection.execute
        try:
            self._others = tuple(
                number for (number,) in ask("SELECT id FROM topics") if number not in self.table.topic_ids
            )
            ((first,),) = ask("SELECT min(rowid) FROM messages").fetchall()
            ((last,),) = ask("SELECT max(rowid) FROM messages").fetchall()
            ((count,),) = ask("SELECT count(*) FROM messages").fetchall()
        except sqlite3.Error:
            return None
        return (first, last) if count and count == last - first + 1 else None
