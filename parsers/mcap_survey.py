"""What is in an MCAP file and where, from its summary where that is whole, else from the records themselves.

A whole summary costs a few reads. What the chunk index does not cover is walked over; a chunk is unpacked only
where it may define a channel that is not known yet.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.mcap_chunks import (
    ChunkSpan,
    DamagedError,
    LooseSpan,
    McapFile,
    Scratch,
    Span,
    find_chunk,
    load_chunk,
    read_chunk_head,
)
from parsers.mcap_records import (
    CHANNEL,
    CHUNK,
    MAGIC,
    MESSAGE,
    MESSAGE_INDEX,
    RECORD_HEAD,
    SCHEMA,
    BadRecordError,
    Walker,
    find_messages,
)
from parsers.mcap_summary import Definitions, Summary, read_summary
from parsers.mcap_toplevel import TopLevel, Window

_DAMAGED = "damaged chunk"
_DAMAGE_NOTES = 5
_INTERESTING = np.array([SCHEMA, CHANNEL, CHUNK, MESSAGE_INDEX], dtype=np.uint8)


@dataclass
class Survey:
    """The map of a file. spans: where the messages are, in file order. counts: channel id -> messages, None where
    that is not known without unpacking everything. start_ns: the earliest log time known, 0 where none is."""

    definitions: Definitions
    spans: list[Span] = field(default_factory=list)
    counts: dict[int, int] | None = None
    start_ns: int = 0


def damage(log: ImportLog, span: ChunkSpan, why: object) -> None:
    """Write a damaged chunk down, with the time that it took with it.

    Of a chunk that the end of the file cuts off it is said already that the file breaks off in it.
    """
    if not span.whole:
        return
    if log.rejected[_DAMAGED] < _DAMAGE_NOTES:
        log.worsen("malformed", f"the chunk at byte {span.offset} is damaged and was left out: {why}")
    else:
        log.worsen("malformed", "further damaged chunks were left out")
    log.reject(_DAMAGED)
    lose(log, span.start_ns, span.end_ns)


def lose(log: ImportLog, start_ns: int, end_ns: int) -> None:
    """Write down a span of time that is lost, where its ends can be times."""
    if 0 < start_ns <= end_ns < 1 << 63:
        log.lost_spans_ns.append((start_ns, end_ns))


class Surveyor:
    """Makes the map of one file; writes what is wrong with the file into the log book."""

    def __init__(self, file: McapFile, log: ImportLog) -> None:
        self._file, self._log = file, log
        self._summary = Summary(file.size)
        self._out = Survey(self._summary.definitions)
        self._loose_counts: Counter[int] = Counter()
        self._chunk_counts: dict[int, Counter[int] | None] = {}
        self._starts: list[int] = []
        self._whole_to = file.size

    def survey(self) -> Survey:
        """Raises LogError where the file holds nothing that could be read."""
        if self._file.size < len(MAGIC) + RECORD_HEAD:
            raise LogError(
                f"the MCAP file ends after {self._file.size} bytes, before its first record",
                path=self._file.path,
                hint="check that the recording was copied whole",
            )
        summary = self._summary = read_summary(self._file, self._log)
        out = self._out = Survey(summary.definitions)
        if summary.names_all:
            out.spans = [LooseSpan(len(MAGIC), summary.data_end)]
        else:
            self._map()
            if summary.broken_off:
                self._log.worsen(
                    "truncated",
                    f"the recording breaks off: the file ends at byte {self._file.size} without a footer "
                    f"and is whole up to byte {self._whole_to}",
                )
            self._define_channels()
        self._count()
        return out

    def _count(self) -> None:
        """Sum up what is known of counts and of the first time."""
        known = self._summary.statistics
        if known and known.counts:
            self._out.counts = dict(known.counts)
        elif all(count is not None for count in self._chunk_counts.values()):
            for count in self._chunk_counts.values():
                self._loose_counts.update(count or {})
            self._out.counts = dict(self._loose_counts)
        starts = [known.start_ns] if known and known.start_ns else self._starts
        self._out.start_ns = min((start for start in starts if start > 0), default=0)

    def _map(self) -> None:
        """Lay out the spans: the indexed chunks, and between them whatever a walk finds."""
        end = self._summary.data_end
        at = len(MAGIC)
        for index in sorted(self._summary.chunks, key=lambda chunk: chunk.offset):
            if index.offset < at or index.length < RECORD_HEAD or index.offset + index.length > end:
                self._log.worsen("malformed", "the index names chunks at places where none can be")
                continue
            self._walk(at, index.offset)
            span = ChunkSpan(index.offset, index.length, index.start_ns, index.end_ns, index.channels)
            self._add_chunk(span, None)
            at = min(index.offset + index.length + index.index_length, end)
        self._walk(at, end)

    def _add_chunk(self, span: ChunkSpan, counts: Counter[int] | None) -> None:
        self._out.spans.append(span)
        self._chunk_counts[span.offset] = counts
        self._starts.append(span.start_ns)

    def _walk(self, start: int, end: int) -> None:
        """Find the chunks and the loose messages between two places; goes on behind damage where it finds a chunk."""
        while start < end:
            top = TopLevel(self._file, start, end)
            first = len(self._out.spans)
            loose = -1
            for window in top.windows(frozenset()):
                loose = self._take_window(window, loose)
            if loose >= 0:
                self._out.spans.append(LooseSpan(loose, top.at))
            # the index of the last chunk may be cut off too: what it names may not be all
            last = self._out.spans[-1] if len(self._out.spans) > first else None
            if isinstance(last, ChunkSpan) and not top.ended:
                self._out.spans[-1] = replace(last, channels=None)
                self._chunk_counts[last.offset] = None
            start = self._behind_damage(top, last) if top.broken else end

    def _behind_damage(self, top: TopLevel, last: Span | None) -> int:
        """Say that a walk could not go on at top.at; returns where it can, or the end."""
        again = find_chunk(self._file, top.at + 1, top.end)
        if again is not None:
            self._log.worsen(
                "malformed", f"bytes {top.at} to {again} of the file are damaged and were left out"
            )
            if isinstance(last, ChunkSpan):
                lose(self._log, last.end_ns, read_chunk_head(self._file, again)[0].start_ns)
            return again
        self._whole_to = min(self._whole_to, top.at)
        if top.cut and self._summary.broken_off:
            if top.cut_chunk:
                # its beginning may still be unpacked
                self._add_chunk(self._cut_chunk(top.at), None)
        else:
            self._log.worsen(
                "malformed", f"at byte {top.at} {top.broken}; what stands up to byte {top.end} was left out"
            )
        return top.end

    def _cut_chunk(self, at: int) -> ChunkSpan:
        """The chunk that the end of the file cuts off, with the time of its first message where its head still says it."""
        span = ChunkSpan(at, self._file.size - at, whole=False)
        try:
            return replace(span, start_ns=read_chunk_head(self._file, at)[0].start_ns)
        except DamagedError:
            return span

    def _take_window(self, window: Window, loose: int) -> int:
        """Take one window in. loose: where the loose messages before it began, or -1; returns the same."""
        if window.chunk:
            return self._chunk_at(*window.chunk, loose)
        opcode, offset, length = window.records.opcode, window.records.offset, window.records.length
        messages, _ = find_messages(window.data, window.records)
        if messages.channel.size:
            ids, counts = np.unique(messages.channel, return_counts=True)
            self._loose_counts.update(dict(zip(ids.tolist(), counts.tolist(), strict=True)))
            self._starts.append(int(messages.log_ns.min()))
        message_at = np.flatnonzero(opcode == MESSAGE)
        for i in np.flatnonzero(np.isin(opcode, _INTERESTING)).tolist():
            begin, size = int(offset[i]), int(length[i])
            at = window.base + begin - RECORD_HEAD
            if opcode[i] == CHUNK:
                before = int(np.searchsorted(message_at, i))
                if loose < 0 and before:
                    loose = self._first_loose(window, message_at)
                loose = self._chunk_at(at, RECORD_HEAD + size, loose)
                message_at = message_at[before:]
            elif opcode[i] == MESSAGE_INDEX:
                self._message_index(window.data[begin : begin + min(size, 2)], size)
            else:
                self._define_safely(int(opcode[i]), window.data[begin : begin + size].tobytes(), at)
        if loose < 0 and message_at.size:
            loose = self._first_loose(window, message_at)
        return loose

    def _first_loose(self, window: Window, message_at: IntArray) -> int:
        return window.base + int(window.records.offset[message_at[0]]) - RECORD_HEAD

    def _define_safely(self, opcode: int, content: bytes, at: int) -> None:
        try:
            self._out.definitions.take(opcode, content)
        except BadRecordError as error:
            self._log.worsen("malformed", f"the record at byte {at} is damaged: {error}")

    def _chunk_at(self, at: int, length: int, loose: int) -> int:
        """Take a chunk in that the walk has met; a stretch of loose messages ends before it. Returns -1."""
        if loose >= 0:
            self._out.spans.append(LooseSpan(loose, at))
        span = ChunkSpan(at, length)
        try:
            head, _ = read_chunk_head(self._file, at)
            self._add_chunk(replace(span, start_ns=head.start_ns, end_ns=head.end_ns), Counter())
        except DamagedError as error:
            damage(self._log, span, error)
        return -1

    def _message_index(self, start: ByteArray, length: int) -> None:
        """A message index names a channel of the chunk before it, and how many messages it has there."""
        last = self._out.spans[-1] if self._out.spans else None
        if not isinstance(last, ChunkSpan) or length < 6:
            return
        channel = int(start[0]) | int(start[1]) << 8
        self._out.spans[-1] = replace(last, channels=(last.channels or frozenset()) | {channel})
        counts = self._chunk_counts.get(last.offset)
        if counts is not None:
            counts[channel] += (length - 6) // 16

    def _define_channels(self) -> None:
        """Unpack the chunks that may define a channel that is not known yet."""
        out = self._out
        for number, span in enumerate(out.spans):
            if not isinstance(span, ChunkSpan):
                continue
            if span.channels is not None and all(
                out.definitions.is_known(channel) for channel in span.channels
            ):
                continue
            out.spans[number] = self._unpack(span)

    def _unpack(self, span: ChunkSpan) -> ChunkSpan:
        """Read a chunk for its definitions; returns the span with the channels that are really in it."""
        scratch = Scratch()
        try:
            size = load_chunk(self._file, span, scratch)
        except DamagedError as error:
            damage(self._log, span, error)
            return replace(span, channels=frozenset())
        data = scratch.records[:size]
        found: Counter[int] = Counter()
        walker = Walker()
        for records in walker.walk(data):
            for i in np.flatnonzero((records.opcode == SCHEMA) | (records.opcode == CHANNEL)).tolist():
                content = data[records.offset[i] : records.offset[i] + records.length[i]].tobytes()
                self._define_safely(int(records.opcode[i]), content, span.offset)
            ids, counts = np.unique(find_messages(data, records)[0].channel, return_counts=True)
            found.update(dict(zip(ids.tolist(), counts.tolist(), strict=True)))
        self._chunk_counts[span.offset] = found
        return replace(span, channels=frozenset(found))
