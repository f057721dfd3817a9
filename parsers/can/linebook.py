"""What the kernels of the text formats fill: rows of frames, and a book on the lines that were left out."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from parsers.allocator import Slab, room_of
from parsers.can.bytescan import holds_zeros, torn
from parsers.can.frames import CanFrames
from parsers.channels import ByteArray, IntArray
from parsers.jit import lean_kernel

# codes that the kernels count under; those below MALFORMED_END mean that the line is damaged
NO_TIME, NO_ID, NO_DATA, NO_BUS, NO_LAYOUT, TORN = 0, 1, 2, 3, 4, 5
MALFORMED_END = 6
ERROR_FRAME, REMOTE_FRAME, OTHER_EVENT, SENDING_REQUEST, STATISTIC = 6, 7, 8, 9, 10
REASONS = (
    "malformed line: no time stamp that can be read",
    "malformed line: no identifier that can be read",
    "malformed line: payload incomplete or not a number",
    "malformed line: no bus that can be read",
    "malformed line: not the format's layout",
    "malformed line: a damaged block, which may have held several lines",
    "error frame",
    "remote frame",
    "event that is no CAN data frame",
    "request to send, not yet a frame on the bus",
    "bus statistic",
)

# places in `Book.state`
LINE, CLOCK, LAST_BAD_LINE, LAST_BAD_CODE, BUSES, FRAMES, USED = 0, 1, 2, 3, 4, 5, 6
LEADING, DAMAGED, SPANS, LAYOUTS, OLDEST, CURRENT = 7, 8, 9, 10, 11, 12
STATE_SIZE = 13

# places in the array `found` in which a format's kernel describes a line that is a frame: what it says ...
TIME, ID, BUS = 0, 1, 2
# ... and, for `parsers.can.layouts`, the stamp before clocks are added up, and where in the text the parts stand
STAMP, STAMP_AT, STAMP_END, ID_AT, ID_END, COUNT_AT, COUNT_END, DATA_AT, NUMBER_AT, NUMBER_END = range(3, 13)
FOUND_SIZE = 13

NO_CLOCK = -(1 << 62)
"""`Book.state[CLOCK]` of a log whose stamps are counted from the first, before the first."""

LOST_FROM_NS = 250_000_000
"""A run of malformed lines that took less than this between two good stamps loses no time worth a record, unless a
damaged block is among them: of what stood in that nobody knows how many lines it was."""

ODD_LINES, BLOCK_LOST = 1, 2
"""In `Book.state[DAMAGED]` and `[LEADING]`: malformed lines, and a damaged block among them."""

MOST_SPANS = 1024
USUAL_FRAME = 32
"""Few logs take fewer characters for a frame; for those that do, there is more room when it is needed."""


class Book(NamedTuple):
    """What the kernels count over a piece of a file.

    state: line number; running clock in ns; line number and code of the last malformed line; buses met; frames and
    payload bytes written; whether malformed lines, or a damaged block, stand before the first frame; whether they stand
    behind the last frame so far; spans written; and three numbers of `parsers.can.layouts`.
    counts, first: number of lines and first line number for each of REASONS. spans: (MOST_SPANS, 2) stamps around
    runs of malformed lines.
    """

    state: IntArray
    counts: IntArray
    first: IntArray
    spans: NDArray[np.int64]


class Rows(NamedTuple):
    """Room for the frames of a piece; the first state[FRAMES] rows and state[USED] payload bytes are filled."""

    time_ns: IntArray
    can_id: NDArray[np.uint32]
    bus: NDArray[np.int16]
    length: NDArray[np.uint8]
    offset: IntArray
    data: ByteArray


def new_book(clock: int = 0) -> Book:
    """A book of a piece of which nothing is read yet."""
    book = Book(
        np.zeros(STATE_SIZE, dtype=np.int64),
        np.zeros(len(REASONS), dtype=np.int64),
        np.zeros(len(REASONS), dtype=np.int64),
        np.empty((MOST_SPANS, 2), dtype=np.int64),
    )
    book.state[CLOCK] = clock
    return book


def rows_for(text_bytes: int) -> Rows:
    """Room for the frames that so much text usually has, and for all payload bytes it can have."""
    # a payload byte takes at least two characters; the kernels look one frame ahead
    frames, payload = text_bytes // USUAL_FRAME + 16, payload_room(text_bytes)
    slab = Slab(23 * frames + payload + 6 * room_of(1))
    return Rows(
        slab.empty(frames, np.int64),
        slab.empty(frames, np.uint32),
        slab.empty(frames, np.int16),
        slab.empty(frames, np.uint8),
        slab.empty(frames, np.int64),
        slab.empty(payload, np.uint8),
    )


def payload_room(text_bytes: int) -> int:
    """The payload bytes that so much text can have at the most, and some for kernels that write ahead."""
    return text_bytes // 2 + 128


def with_more_room(rows: Rows) -> Rows:
    """The same rows with room for twice as many frames."""

    def longer(column: NDArray[Any]) -> NDArray[Any]:
        return np.concatenate([column, np.empty_like(column)])

    time_ns, can_id, bus, length, offset, data = rows
    return Rows(longer(time_ns), longer(can_id), longer(bus), longer(length), longer(offset), data)


def filled(rows: Rows, book: Book) -> CanFrames:
    """The filled rows."""
    n, used = int(book.state[FRAMES]), int(book.state[USED])
    return CanFrames(
        rows.time_ns[:n], rows.can_id[:n], rows.bus[:n], rows.length[:n], rows.offset[:n], rows.data[:used]
    )


@lean_kernel
def reject(book: Book, code: int) -> None:
    """Count the line just read under a code of REASONS."""
    state = book.state
    book.counts[code] += 1
    if book.first[code] == 0:
        book.first[code] = state[LINE]
    if code < MALFORMED_END:
        state[LAST_BAD_LINE] = state[LINE]
        state[LAST_BAD_CODE] = code
        state[DAMAGED] = max(state[DAMAGED], BLOCK_LOST if code == TORN else ODD_LINES)


@lean_kernel
def leave_out(text: ByteArray, begin: int, feed: int, code: int, book: Book) -> None:
    """Count the line just read, [begin, feed), under a code of REASONS, or as what a damaged block left."""
    lost = torn(text, begin, feed) if code < MALFORMED_END else holds_zeros(text, begin, feed)
    reject(book, TORN if lost else code)


@lean_kernel
def accept(book: Book, rows: Rows, found: IntArray, count: int) -> None:
    """Write the line just read down as a frame whose `count` payload bytes are in place already."""
    state = book.state
    n = state[FRAMES]
    if state[DAMAGED] != 0:
        least = 0 if state[DAMAGED] == BLOCK_LOST else LOST_FROM_NS
        if n == 0:
            state[LEADING] = state[DAMAGED]
        elif found[TIME] - rows.time_ns[n - 1] > least:
            last = min(state[SPANS], MOST_SPANS - 1)
            # a file with more spans than that is lost from here on
            if state[SPANS] < MOST_SPANS:
                book.spans[last, 0] = rows.time_ns[n - 1]
                state[SPANS] += 1
            book.spans[last, 1] = found[TIME]
        state[DAMAGED] = 0
    rows.time_ns[n] = found[TIME]
    rows.can_id[n] = found[ID]
    rows.bus[n] = found[BUS]
    rows.length[n] = count
    rows.offset[n] = state[USED]
    state[USED] += count
    state[FRAMES] = n + 1
