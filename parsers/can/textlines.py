"""What the text formats share: the way from a file through a format's kernel to frames and the log book."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from parsers.can.cut_frame import TAIL_BYTES, last_is_cut, without_last
from parsers.can.frames import CanFrames
from parsers.can.layouts import MOST_LAYOUTS, Layouts, no_layouts
from parsers.can.linebook import (
    BUSES,
    LAST_BAD_LINE,
    LINE,
    NO_CLOCK,
    Book,
    Rows,
    filled,
    new_book,
    payload_room,
    rows_for,
    with_more_room,
)
from parsers.can.pieces import Buffers, Piece, pieces, read_piece, tail_of, walk_piece
from parsers.can.tally import SINCE_FIRST, Tally
from parsers.can.words import hex_pairs
from parsers.channels import ByteArray, IntArray
from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.parallel import in_order

MOST_BUSES = 64
NAME_BYTES = 16
"""IFNAMSIZ of Linux: no interface name is longer."""


@dataclass
class Work:
    """What a format's kernel needs for one piece of a file.

    names, sizes: interface names met, NAME_BYTES bytes each; how many they are is in book.state[BUSES].
    """

    book: Book
    rows: Rows
    layouts: Layouts
    names: ByteArray
    sizes: IntArray

    def buses(self) -> list[bytes]:
        """The names of the interfaces met, in their order."""
        return [
            self.names[k * NAME_BYTES : k * NAME_BYTES + int(self.sizes[k])].tobytes()
            for k in range(int(self.book.state[BUSES]))
        ]


class LineParser(Protocol):
    """A text format's kernel and how the log at hand is written. Called by several threads at once.

    meaning: what stamps mean, of `parsers.can.tally`.
    """

    @property
    def meaning(self) -> int:
        """AS_WRITTEN, SUMMED or SINCE_FIRST."""
        ...

    def parse(self, text: ByteArray, begin: int, stop: int, ended: bool, work: Work) -> int:
        """Read the lines in [begin, stop) as long as there is room; where it stopped.

        ended: the last line has its line feed.
        """
        ...

    def walk(self, text: ByteArray, walk: IntArray, work: Work) -> bool:
        """Parse all that a walk (`parsers.can.blocks`) has left; whether it stopped for want of room."""
        ...


@dataclass(frozen=True)
class _Done:
    """A piece that was read. ended: its last line has its line feed."""

    piece: Piece
    work: Work
    ended: bool


class TextSource:
    """A `FrameSource` over a text file, whose pieces are read by as many threads as there are cores."""

    def __init__(
        self,
        path: Path,
        log: ImportLog,
        progress: Callable[[int, int], None],
        parser: LineParser,
        *,
        clock: str,
        absolute: bool,
    ) -> None:
        self._path = path
        self._log = log
        self._progress = progress
        self._parser = parser
        self._pairs = hex_pairs()
        self.clock = clock
        self.absolute = absolute
        self.start_utc_ns: int | None = None

    def frames(self, *, counting: bool, workers: int | None = None) -> Iterator[CanFrames]:
        """Batches of frames from the file's beginning, each good until the next is asked for; writes into the log book
        when `counting`."""
        size = max(self._path.stat().st_size, 1)
        tally, buffers, ended, cut = Tally(self._parser.meaning), Buffers(), True, False
        buses: list[bytes] = []

        spare: deque[Rows] = deque()

        def read(piece: Piece) -> _Done:
            return self._read(piece, buffers, spare, [])

        for done in in_order(read, pieces(self._path), workers=workers):
            work, lut = self._named(done, buffers, spare, buses)
            frames = filled(work.rows, work.book)
            if lut is not None:
                np.take(lut, frames.bus, out=frames.bus)
            tally.add(work.book, frames.time_ns)
            ended = done.ended
            if frames.time_ns.size and not ended and (cut := self._ends_in_a_cut_frame(buffers)):
                frames = without_last(frames)
            self._progress(min(done.piece.end, size), size)
            if counting:
                self._log.messages += frames.time_ns.size
            if frames.time_ns.size:
                yield frames
            spare.append(work.rows)
        if counting:
            tally.write_down(self._log, ended=ended, cut=cut)
            if buses:
                names = (f"bus {k} is {name.decode('latin-1')}" for k, name in enumerate(buses, start=1))
                self._log.note(", ".join(names))

    def _ends_in_a_cut_frame(self, buffers: Buffers) -> bool:
        """Whether the last line, which has no feed, is a frame that seems to have been longer."""
        done = self._read(tail_of(self._path, TAIL_BYTES), buffers, deque(), [])
        state = done.work.book.state
        return state[LAST_BAD_LINE] != state[LINE] and last_is_cut(filled(done.work.rows, done.work.book))

    def _read(self, piece: Piece, buffers: Buffers, spare: deque[Rows], buses: list[bytes]) -> _Done:
        """Read a piece of which the interfaces' names in `buses` are known. spare: rows that nobody uses."""
        names = np.zeros(MOST_BUSES * NAME_BYTES, dtype=np.uint8)
        sizes = np.zeros(MOST_BUSES, dtype=np.int64)
        for k, name in enumerate(buses):
            names[k * NAME_BYTES : k * NAME_BYTES + len(name)] = np.frombuffer(name, dtype=np.uint8)
            sizes[k] = len(name)
        book = new_book(NO_CLOCK if self._parser.meaning == SINCE_FIRST else 0)
        book.state[BUSES] = len(buses)
        rows = _rows(piece.end - piece.begin, spare)
        work = Work(book, rows, no_layouts(self._pairs, MOST_LAYOUTS), names, sizes)

        def parse(text: ByteArray, begin: int, stop: int, ended: bool) -> None:
            while (begin := self._parser.parse(text, begin, stop, ended, work)) < stop:
                work.rows = with_more_room(work.rows)

        def go_on(text: ByteArray, walk: IntArray) -> bool:
            if not self._parser.walk(text, walk, work):
                return False
            work.rows = with_more_room(work.rows)
            return True

        ended = walk_piece(self._path, piece, buffers, go_on)
        if ended is None:
            ended = read_piece(self._path, piece, buffers, parse)
        return _Done(piece, work, ended)

    def _named(
        self, done: _Done, buffers: Buffers, spare: deque[Rows], buses: list[bytes]
    ) -> tuple[Work, NDArray[np.int16] | None]:
        """Add the interfaces of a piece to the log's; the piece, and the log's number of each of the piece's buses.

        A piece with which there are more than can be told apart is read once more, knowing those before it.
        """
        met = done.work.buses()
        together = list(dict.fromkeys(buses + met))
        if buses and len(together) >= MOST_BUSES and together != buses:
            again = self._read(done.piece, buffers, spare, buses).work
            buses[:] = again.buses()
            return again, None
        buses[:] = together
        if met == buses[: len(met)]:
            return done.work, None
        return done.work, np.array([0, *(buses.index(name) + 1 for name in met)], dtype=np.int16)


def _rows(text_bytes: int, spare: deque[Rows]) -> Rows:
    """Room for the frames of a piece: used before, where there is any that is large enough."""
    try:
        rows = spare.pop()
    except IndexError:
        return rows_for(text_bytes)
    return rows if rows.data.size >= payload_room(text_bytes) else rows_for(text_bytes)


def first_lines(path: Path, size: int) -> list[str]:
    """The lines in a file's first `size` bytes. Raises LogError."""
    try:
        with path.open("rb") as file:
            return head_lines(file.read(size))
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror})", path=path) from error


_CONTROL = bytes([*range(9), *range(14, 27), *range(28, 32)])


def looks_like_text(head: bytes) -> bool:
    """Whether a file's first bytes can be a text log: no NUL and hardly any control characters."""
    control = len(head) - len(head.translate(None, _CONTROL))
    return bool(head) and b"\0" not in head and control * 100 <= len(head)


def head_lines(head: bytes) -> list[str]:
    """The whole lines of a file's first bytes as text, without byte order mark."""
    return head.decode("latin-1").removeprefix("ï»¿").splitlines()
