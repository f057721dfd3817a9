"""Messages of a ROS 2 bag from the leaf pages of its SQLite file to columns: one call of a kernel for many pages.

Some pages at a time are read, searched and decoded while they are near the core. What is not plain (damaged pages, messages that go
on over other pages, are compressed, or do not fit their type) is left to the slower way, a few pages at a time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from io import FileIO

import numpy as np

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel
from parsers.jit_foreign import pread_address, read_at
from parsers.ros.flow import Filled, Into, Plan, RowRoom, decode_found, has_rows
from parsers.sqlite_kernels import FIELDS, LENGTH, MARK, NEXT, PLACE, SLACK, TIME, TOPIC, BoolArray, leaf_rows
from parsers.sqlite_pages import PagedFile
from parsers.sqlite_scan import Query
from parsers.sqlite_tree import Nodes

STEP_BYTES = 1 << 18
"""Pages that are read and decoded together."""
MOST_ROWS = 1 << 14
"""Of so many pages; of those with more the slower way makes less."""
DONE, NO_ROW, ODD = range(3)
"""Why the kernel stopped: all pages are done; a topic has too few rows left; the pages to go on with are for the slower way."""
AT, WHY, FOUND, SEEN, FIRST_NS, LAST_NS = range(6)
STATE = 6
"""The page to go on with; why it stopped; messages on the pages that wait for rows, else -1; how many were decoded, and the times of the
first and the last of them."""


@kernel
def _load(
    pread: int, file: int, page: IntArray, page_size: int, last: int, buffer: ByteArray, place: IntArray
) -> None:
    """Read pages one behind the other into the buffer; place: where each is in it, -1 where it could not be read."""
    at = 0
    while at < page.size:
        end = at + 1
        while end < page.size and page[end] == page[end - 1] + 1:
            end += 1
        read = 0
        if page[at] >= 1 and page[end - 1] <= last:
            size = (end - at) * page_size
            read = read_at(pread, file, (page[at] - 1) * page_size, size, buffer, at * page_size)
        for k in range(at, end):
            place[k] = k * page_size if (k + 1 - at) * page_size <= read else -1
        at = end


@kernel
def decode_pages(
    pread: int,
    file: int,
    page: IntArray,
    low: IntArray,
    high: IntArray,
    page_size: int,
    usable: int,
    last: int,
    limit: int,
    step: int,
    mark: int,
    columns: IntArray,
    ids: IntArray,
    buffer: ByteArray,
    place: IntArray,
    bad: BoolArray,
    table: IntArray,
    into: Into,
    state: IntArray,
) -> None:
    """Decode the wanted messages of leaf pages from state[AT] on, until some of them are not to be done here.

    page, low, high: see `parsers.sqlite_tree.Nodes`. last: the file's last page. limit: no record is longer. step: pages that are
    done together. mark: the first four bytes of what is compressed. columns, ids, table: see `leaf_rows`; a topic's place in ids is its number in
    the program. buffer, place, bad: room for `step` pages. into: see `parsers.ros.flow`. state: (STATE,), see above.
    """
    while state[AT] < page.size:
        begin, end = state[AT], min(state[AT] + step, page.size)
        if state[FOUND] < 0:
            state[WHY] = ODD
            places, spoilt = place[: end - begin], bad[: end - begin]
            _load(pread, file, page[begin:end], page_size, last, buffer, places)
            found = leaf_rows(
                buffer, places, usable, low[begin:end], high[begin:end], limit, columns, ids, table, spoilt
            )
            odd = found < 0
            for k in range(end - begin):
                odd |= spoilt[k]
            for i in range(found):
                odd |= table[NEXT, i] != 0 or table[MARK, i] == mark
            if odd:
                return
            state[FOUND] = found
        found = state[FOUND]
        if not has_rows(table[TOPIC], found, into):
            state[WHY] = NO_ROW
            return
        if not decode_found(buffer, table[TOPIC], table[PLACE], table[LENGTH], table[TIME], found, into):
            state[WHY] = ODD
            return
        if found:
            if state[SEEN] == 0:
                state[FIRST_NS] = table[TIME, 0]
            state[LAST_NS] = table[TIME, found - 1]
            state[SEEN] += found
        state[AT], state[FOUND] = end, -1
    state[WHY] = DONE


@dataclass(frozen=True)
class Stretch:
    """What pages up to `end` gave. span_ns: times of their first and last message. more: the pages at `end` are for the slower way."""

    end: int
    filled: list[Filled]
    span_ns: tuple[int, int] | None
    more: bool


class LeafFlow:
    """Leaf pages on their way to columns; of one thread. `close` it."""

    def __init__(
        self, paged: PagedFile, query: Query, plan: Plan, cells: Callable[[int], FloatArray], mark: int
    ) -> None:
        """plan: of the topics `query.ids`. cells: gives memory for numbers. mark: of messages for the slower way. Raises OSError."""
        self.step = max(1, STEP_BYTES // paged.page_size)
        self._paged, self._query, self._mark = paged, query, mark
        self._room = RowRoom(plan, cells)
        self._file = FileIO(paged.path, "rb")
        self._buffer = np.empty(self.step * paged.page_size + SLACK, np.uint8)
        self._place, self._bad = np.empty(self.step, np.int64), np.empty(self.step, np.bool_)
        self._table = np.empty((FIELDS, MOST_ROWS), np.int64)
        self._state = np.zeros(STATE, np.int64)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def decode(self, nodes: Nodes, begin: int) -> Stretch:
        """Decode pages from `begin` on, as far as that can be done here."""
        state, rows, paged = self._state, self._room, self._paged
        state[AT], state[SEEN], state[FOUND] = begin, 0, -1
        filled: list[Filled] = []
        while True:
            decode_pages(
                pread_address(),
                self._file.fileno(),
                nodes.page,
                nodes.low,
                nodes.high,
                paged.page_size,
                paged.usable,
                paged.pages,
                paged.size,
                self.step,
                self._mark,
                self._query.columns,
                self._query.ids,
                self._buffer,
                self._place,
                self._bad,
                self._table,
                rows.into,
                state,
            )
            filled += rows.take()
            steps = -(-(len(nodes.page) - int(state[AT])) // self.step)
            if state[WHY] != NO_ROW or not rows.renew(steps):
                break
        span = (int(state[FIRST_NS]), int(state[LAST_NS])) if state[SEEN] else None
        return Stretch(int(state[AT]), filled, span, more=bool(state[WHY] != DONE))
