"""The tally of a whole text log, put together from the books of its pieces in their order."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from parsers.can.linebook import (
    BLOCK_LOST,
    CLOCK,
    DAMAGED,
    LAST_BAD_CODE,
    LAST_BAD_LINE,
    LEADING,
    LINE,
    LOST_FROM_NS,
    MALFORMED_END,
    NO_CLOCK,
    REASONS,
    SPANS,
    TORN,
    Book,
)
from parsers.channels import IntArray
from parsers.importer import ImportLog

AS_WRITTEN, SUMMED, SINCE_FIRST = 0, 1, 2
"""What stamps mean: a time, a step since the line before, a time that counts from the first stamp of the log."""


def _zeros() -> IntArray:
    return np.zeros(len(REASONS), dtype=np.int64)


@dataclass
class Tally:
    """What is known of the log up to the piece added last.

    meaning: AS_WRITTEN, SUMMED or SINCE_FIRST. lines: number of lines. clock: sum of the steps, or first stamp.
    last_bad_line, last_bad_code: the last malformed line. counts, first: as in `Book`. last_ns: stamp of the last
    frame, and damaged: whether malformed lines, or a damaged block, stand behind it, as in `Book`. spans: stamps around malformed lines.
    """

    meaning: int = AS_WRITTEN
    lines: int = 0
    clock: IntArray = field(default_factory=lambda: np.zeros(1, dtype=np.int64))
    last_bad_line: int = 0
    last_bad_code: int = 0
    counts: IntArray = field(default_factory=_zeros)
    first: IntArray = field(default_factory=_zeros)
    last_ns: int | None = None
    damaged: int = 0
    spans: list[tuple[int, int]] = field(default_factory=list)

    def __post_init__(self) -> None:
        if self.meaning == SINCE_FIRST:
            self.clock[0] = NO_CLOCK

    def add(self, book: Book, time_ns: IntArray) -> None:
        """Add a piece's book, and make times of the stamps of its frames, in place."""
        state = book.state
        fresh = (self.first == 0) & (book.first > 0)
        self.first[fresh] = book.first[fresh] + self.lines
        self.counts += book.counts
        if state[LAST_BAD_LINE]:
            self.last_bad_line = self.lines + int(state[LAST_BAD_LINE])
            self.last_bad_code = int(state[LAST_BAD_CODE])
        self.lines += int(state[LINE])
        spans = book.spans[: int(state[SPANS])]
        if self.meaning == SUMMED:
            # arrays, not numbers: a file that goes beyond the range of the clock must wrap and not warn
            time_ns += self.clock
            spans += self.clock
            self.clock += state[CLOCK : CLOCK + 1]
        elif self.meaning == SINCE_FIRST:
            if self.clock[0] == NO_CLOCK:
                self.clock[0] = state[CLOCK]
            if self.clock[0] != NO_CLOCK:
                time_ns -= self.clock
                spans -= self.clock
        self._add_spans(book, time_ns)

    def _add_spans(self, book: Book, time_ns: IntArray) -> None:
        """What was lost from the piece before into this one, and in this one."""
        state = book.state
        if time_ns.size:
            lost = max(self.damaged, int(state[LEADING]))
            least = 0 if lost == BLOCK_LOST else LOST_FROM_NS
            if lost and self.last_ns is not None and int(time_ns[0]) - self.last_ns > least:
                self.spans.append((self.last_ns, int(time_ns[0])))
            self.last_ns = int(time_ns[-1])
            self.damaged = 0
        self.spans += [(a, b) for a, b in book.spans[: int(state[SPANS])].tolist()]
        self.damaged = max(self.damaged, int(state[DAMAGED]))

    def write_down(self, log: ImportLog, *, ended: bool, cut: bool = False) -> None:
        """Put the finished tally into the log book. ended: the last line has its line feed. cut: it is a frame that was
        left out, since it seems to have been longer."""
        counts = self.counts.copy()
        if not ended and self.lines and self.last_bad_line == self.lines:
            counts[self.last_bad_code] -= 1
            log.worsen(
                "truncated",
                f"the last line (line {self.lines}) breaks off: the log is truncated, all before it is whole",
            )
        elif cut:
            log.worsen(
                "truncated",
                f"the last line (line {self.lines}) breaks off: it is shorter than all frames of its identifier before it; "
                "the log is truncated, all before it is whole",
            )
        elif not ended and self.lines:
            log.note("the last line has no line end; if the log was cut there, its last frame may be cut too")
        for code, reason in enumerate(REASONS):
            log.reject(reason, int(counts[code]))
        damaged = int(counts[:MALFORMED_END].sum())
        if damaged:
            first = min(int(self.first[code]) for code in range(MALFORMED_END) if counts[code])
            sentence = (
                f"{damaged} of {self.lines} lines are malformed and were left out; the first is line {first}"
            )
            # a single line that some tool wrote between the frames is no damage, however short the log
            if counts[TORN] or self.spans or (damaged > 1 and damaged * 1000 > self.lines):
                log.worsen("malformed", sentence)
            else:
                log.note(sentence)
        log.lost_spans_ns.extend(self.spans)
