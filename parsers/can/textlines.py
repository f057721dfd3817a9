"""What the text formats share: a file in blocks of whole lines, and the tally of lines that were left out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from parsers.can.frames import CanFrames
from parsers.channels import ByteArray, IntArray
from parsers.errors import LogError
from parsers.importer import ImportLog

BLOCK_BYTES = 8 << 20

# codes that the kernels count under; those below MALFORMED_END mean that the line is damaged
NO_TIME, NO_ID, NO_DATA, NO_BUS, NO_LAYOUT = 0, 1, 2, 3, 4
MALFORMED_END = 5
ERROR_FRAME, REMOTE_FRAME, OTHER_EVENT, SENDING_REQUEST, STATISTIC = 5, 6, 7, 8, 9
REASONS = (
    "malformed line: no time stamp that can be read",
    "malformed line: no identifier that can be read",
    "malformed line: payload incomplete or not a number",
    "malformed line: no bus that can be read",
    "malformed line: not the format's layout",
    "error frame",
    "remote frame",
    "event that is no CAN data frame",
    "request to send, not yet a frame on the bus",
    "bus statistic",
)

# places in `Tally.state`
LINE, CLOCK, LAST_BAD_LINE, LAST_BAD_CODE, BUSES = 0, 1, 2, 3, 4


def _zeros(size: int) -> Callable[[], IntArray]:
    return lambda: np.zeros(size, dtype=np.int64)


@dataclass(frozen=True)
class Tally:
    """What the kernels carry from block to block.

    state: line number, running clock in ns, line number and code of the last malformed line, buses met.
    counts, first: number of lines and first line number for each of REASONS.
    """

    state: IntArray = field(default_factory=_zeros(5))
    counts: IntArray = field(default_factory=_zeros(len(REASONS)))
    first: IntArray = field(default_factory=_zeros(len(REASONS)))


@dataclass(frozen=True)
class Columns:
    """Room for the frames of one block; a kernel fills the first n rows and the first m payload bytes."""

    time_ns: IntArray
    can_id: NDArray[np.uint32]
    bus: NDArray[np.int16]
    length: NDArray[np.uint8]
    offset: IntArray
    data: ByteArray

    @classmethod
    def for_block(cls, block: ByteArray) -> Columns:
        """Room for as many frames as there are lines; a payload byte takes at least two characters of text."""
        lines = int(np.count_nonzero(block == 10)) + 1
        return cls(
            np.empty(lines, dtype=np.int64),
            np.empty(lines, dtype=np.uint32),
            np.empty(lines, dtype=np.int16),
            np.empty(lines, dtype=np.uint8),
            np.empty(lines, dtype=np.int64),
            np.empty(block.size // 2 + 64, dtype=np.uint8),
        )

    def first_frames(self, n: int) -> CanFrames:
        """The filled rows."""
        used = int(self.offset[n - 1]) + int(self.length[n - 1]) if n else 0
        return CanFrames(
            self.time_ns[:n],
            self.can_id[:n],
            self.bus[:n],
            self.length[:n],
            self.offset[:n],
            self.data[:used],
        )


class BlockParser(Protocol):
    """A text format's parser with its state, made anew for each pass through the file."""

    tally: Tally

    def parse(self, block: ByteArray, ended: bool) -> CanFrames:
        """The frames of a block of lines. ended: the last line has its line feed."""
        ...

    def notes(self) -> list[str]:
        """What to tell the user after the last block."""
        ...


class TextSource:
    """A `FrameSource` over a text file."""

    def __init__(
        self,
        path: Path,
        log: ImportLog,
        progress: Callable[[int, int], None],
        parser: Callable[[], BlockParser],
        *,
        clock: str,
        absolute: bool,
    ) -> None:
        self._path = path
        self._log = log
        self._progress = progress
        self._parser = parser
        self.clock = clock
        self.absolute = absolute
        self.start_utc_ns: int | None = None

    def frames(self, *, counting: bool) -> Iterator[CanFrames]:
        """Batches of frames from the file's beginning; writes into the log book when `counting`."""
        parser = self._parser()
        size = max(self._path.stat().st_size, 1)
        ended, done = True, 0
        for block, ended in blocks_of_lines(self._path):
            frames = parser.parse(block, ended)
            done += block.size
            # the file is gone through twice, and the first look is half the way
            self._progress(min(done, size) + (size if counting else 0), 2 * size)
            if counting:
                self._log.messages += frames.time_ns.size
            if frames.time_ns.size:
                yield frames
        if counting:
            _write_down(parser, ended, self._log)


def blocks_of_lines(path: Path, size: int = BLOCK_BYTES) -> Iterator[tuple[ByteArray, bool]]:
    """A file as blocks of whole lines, and whether the block ends with a line feed (only the last may not).

    A line longer than `size` is cut there, and is malformed in both halves. Raises LogError.
    """
    rest = b""
    try:
        with path.open("rb") as file:
            while read := file.read(size):
                cut = read.rfind(b"\n") + 1
                if cut == 0 and len(rest) + len(read) <= 2 * size:
                    rest += read
                    continue
                cut = cut or len(read)
                yield np.frombuffer(rest + read[:cut], dtype=np.uint8), True
                rest = read[cut:]
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror})", path=path) from error
    if rest:
        yield np.frombuffer(rest, dtype=np.uint8), False


def first_lines(path: Path, size: int) -> list[str]:
    """The lines in a file's first `size` bytes. Raises LogError."""
    try:
        with path.open("rb") as file:
            return head_lines(file.read(size))
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror})", path=path) from error


def _write_down(parser: BlockParser, ended: bool, log: ImportLog) -> None:
    """Put a finished pass into the log book."""
    tally = parser.tally
    counts = tally.counts.copy()
    lines = int(tally.state[LINE])
    if not ended and lines and tally.state[LAST_BAD_LINE] == lines:
        counts[tally.state[LAST_BAD_CODE]] -= 1
        log.worsen(
            "truncated",
            f"the last line (line {lines}) breaks off: the log is truncated, all before it is whole",
        )
    for code, reason in enumerate(REASONS):
        log.reject(reason, int(counts[code]))
    damaged = int(counts[:MALFORMED_END].sum())
    if damaged:
        first = min(int(tally.first[code]) for code in range(MALFORMED_END) if counts[code])
        sentence = f"{damaged} of {lines} lines are malformed and were left out; the first is line {first}"
        if damaged * 1000 > lines:
            log.worsen("malformed", sentence)
        else:
            log.note(sentence)
    for sentence in parser.notes():
        log.note(sentence)


def looks_like_text(head: bytes) -> bool:
    """Whether a file's first bytes can be a text log: no NUL and hardly any control characters."""
    control = sum(byte < 9 or (13 < byte < 32 and byte != 27) for byte in head)
    return bool(head) and b"\0" not in head and control * 100 <= len(head)


def head_lines(head: bytes) -> list[str]:
    """The whole lines of a file's first bytes as text, without byte order mark."""
    return head.decode("latin-1").removeprefix("ï»¿").splitlines()
