"""A table's file in ranges that are read each on its own, on all cores: which lines are whose, and how they are read.

A line belongs to the range in which it begins. A range is read in pieces that stay in the processor's cache.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from parsers.errors import LogError
from parsers.parallel import in_order
from parsers.table_rows import RowBlock, RowCollector, RowCounts, RowPlan
from parsers.table_swar import PADDING
from parsers.table_text import BLOCK_BYTES, MOST_LINE_BYTES, Encoding, TextBlock, text_blocks

PIECE_BYTES = 256 * 1024
_LEAST_READ = 4096


@dataclass(frozen=True)
class ByteRange:
    """Bytes of a file. first: a line begins at `start`; else perhaps in the midst of one."""

    start: int
    stop: int
    first: bool


@dataclass(frozen=True)
class RangeRows:
    """What a range held. done: bytes of the file up to its end. left_out: what was behind its last row, as the collector says.
    ends_open: it ends with the file's last line, which has no line feed; last_short, last_kept: this one had too few
    columns; it is the last row. place: its bytes of the file, where it was read from there."""

    blocks: list[RowBlock]
    counts: RowCounts
    done: int
    left_out: int
    ends_open: bool
    last_short: bool
    last_kept: bool
    place: ByteRange | None = None

    @property
    def rows(self) -> int:
        """Rows in all blocks."""
        return sum(len(block.time_ns) for block in self.blocks)

    def without_last_row(self) -> list[RowBlock]:
        """The blocks less their last row; there must be one."""
        *whole, last = self.blocks
        rows = len(last.time_ns) - 1
        if rows == 0:
            return whole
        gaps, torn = last.gaps[last.gaps < rows], last.torn[last.torn < rows]
        return [*whole, RowBlock(last.time_ns[:rows], last.numbers[:, :rows], gaps, torn)]


def read_table(
    path: Path,
    encoding: Encoding,
    body: int,
    size: int,
    plan: RowPlan,
    *,
    block_bytes: int = BLOCK_BYTES,
    workers: int | None = None,
) -> Iterator[RangeRows]:
    """The rows of a file from byte `body` of its plain text on, range by range.

    size: of the file, or where in it a line begins before which the rows end (not in files of wide letters or old lines). Memory is bounded by a few ranges of `block_bytes`. Raises LogError where the file cannot be read.
    """
    if size - body <= block_bytes:
        workers = 1
    if encoding.wide or encoding.old_lines:
        blocks = text_blocks(path, encoding, body, block_bytes)
        yield from in_order(partial(_read_block, plan), blocks, workers=workers)
        return
    begin = encoding.mark + body
    ranges = [
        ByteRange(a, min(a + block_bytes, size), a == begin)
        for a in range(begin, max(size, begin + 1), block_bytes)
    ]
    yield from in_order(partial(_read_range, path, plan, []), ranges, workers=workers)


def _read_block(plan: RowPlan, block: TextBlock) -> RangeRows:
    """The rows of a text that is held already."""
    collector = RowCollector(plan)
    for _ in range(block.lost_lines):
        collector.lose_line()
    if block.data:
        size = len(block.data)
        collector.take(bytearray(block.data + b"\n" + bytes(PADDING)), 0, size, size, 0)
    return _finished(collector, block.done, block.ends_open)


def _finished(collector: RowCollector, done: int, ends_open: bool) -> RangeRows:
    blocks = collector.finish()
    return RangeRows(
        blocks,
        collector.counts,
        done,
        collector.left_out,
        ends_open,
        collector.last_short,
        collector.last_kept,
    )


def _read_range(path: Path, plan: RowPlan, buffers: list[bytearray], place: ByteRange) -> RangeRows:
    """The rows of the lines that begin in a range of a file. buffers: used ones, for the next range."""
    collector = RowCollector(plan)
    reader = _RangeReader(path, place, collector, buffers.pop() if buffers else None)
    try:
        ends_open = reader.run()
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror})", path=path) from error
    buffers.append(reader.buffer)
    return replace(_finished(collector, min(reader.base, place.stop), ends_open), place=place)


def read_again(path: Path, plan: RowPlan, place: ByteRange, stop: int) -> RangeRows:
    """A range's rows up to byte `stop`, where a line begins. Raises LogError where the file cannot be read."""
    return _read_range(path, plan, [], replace(place, stop=stop))


class _RangeReader:
    """Reads one range. buffer: the text held, `held` bytes of it; base: the place of its first byte in the file."""

    def __init__(
        self, path: Path, place: ByteRange, collector: RowCollector, buffer: bytearray | None
    ) -> None:
        self._path = path
        self._place = place
        self._collector = collector
        self.buffer = buffer or bytearray(PIECE_BYTES + PADDING)
        # a line that begins just here is told by the line feed before it
        self.base = place.start if place.first else place.start - 1
        self._held = 0
        self._dropping = not place.first

    def run(self) -> bool:
        """Read to the end of the last line that begins in the range; whether that line has no line feed."""
        with self._path.open("rb", buffering=0) as file:
            file.seek(self.base)
            while self.base < self._place.stop:
                self._make_room()
                ahead = self._place.stop - self.base - self._held
                room = len(self.buffer) - PADDING - self._held
                with memoryview(self.buffer) as view:
                    got = file.readinto(view[self._held : self._held + min(room, max(ahead, _LEAST_READ))])
                if not got:
                    return self._end_of_file()
                self._held += got
                self._take_lines()
        return False

    def _make_room(self) -> None:
        if len(self.buffer) - PADDING - self._held < _LEAST_READ:
            self.buffer = self.buffer[: self._held] + bytearray(self._held + _LEAST_READ + PADDING)

    def _end_of_file(self) -> bool:
        if self._dropping or not self._held:
            return False
        self.buffer[self._held] = 10
        self._collector.take(self.buffer, 0, self._held, self._held, 0)
        self.base += self._held
        return True

    def _take_lines(self) -> None:
        """Read the whole lines that are held, and keep the rest; drop a line that does not end."""
        begin = 0
        if self._dropping:
            begin = self.buffer.find(b"\n", 0, self._held) + 1
            self._dropping = begin == 0
            if self._dropping:
                self._forget(self._held)
                return
        cut = self.buffer.rfind(b"\n", begin, self._held) + 1
        limit = self._place.stop - self.base
        if begin < cut and begin < limit:
            to_come = max(0, limit - cut)
            self._collector.take(self.buffer, begin, cut, limit, to_come)
        self._forget(max(begin, cut))
        if self._held > MOST_LINE_BYTES and self.base < self._place.stop:
            self._collector.lose_line()
            self._forget(self._held)
            self._dropping = True

    def _forget(self, count: int) -> None:
        """Let go of the first bytes held."""
        self.buffer[: self._held - count] = self.buffer[count : self._held]
        self._held -= count
        self.base += count
