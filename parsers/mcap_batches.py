"""Pieces of an MCAP file that are read, unpacked and decoded at once, each by one thread."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from parsers.allocator import Slabs
from parsers.channels import ByteArray
from parsers.importer import ImportLog
from parsers.mcap_chunks import ChunkSpan, DamagedError, LooseSpan, McapFile, Scratch, Span, load_chunk
from parsers.mcap_flow import Flow
from parsers.mcap_parts import ENOUGH_CELLS, Part, Want
from parsers.mcap_pick import Picker, Picks, slot_table
from parsers.mcap_records import RECORD_HEAD, WALK_CUT, WALK_INVALID, gather
from parsers.mcap_sparse import may_skip, pick_sparsely
from parsers.mcap_survey import damage
from parsers.mcap_toplevel import TopLevel, Window
from parsers.mcap_train import Train
from parsers.mcap_unpack import BROKEN, DONE, ODD
from parsers.ros.flow import plan_of
from parsers.ros.topics import MAX_CELLS

PACKED_BYTES = 2 << 20
"""Chunks that are handed to a thread together: many small ones, or a large one."""
UNPACKED_BYTES = 4 << 20
"""Records decoded together, where a chunk is not larger by itself."""
TOO_SHORT = "message record too short for its own head"

Group = tuple[ChunkSpan, ...] | Window


@dataclass(frozen=True)
class Undecoded:
    """Messages of one topic that give too many numbers to be decoded at once, in a buffer of their own."""

    picks: Picks
    data: ByteArray


@dataclass
class Result:
    """What a group gave, and what is to be written into the log book. place: how far in the file it reaches.

    damaged: chunks with the reason. cut: chunk, place inside it from which on it is damaged, and its size.
    """

    place: int = 0
    parts: list[Part | Undecoded] = field(default_factory=list)
    damaged: list[tuple[ChunkSpan, str]] = field(default_factory=list)
    cut: list[tuple[ChunkSpan, int, int]] = field(default_factory=list)
    short: int = 0

    def write(self, log: ImportLog) -> None:
        """Write into the log book what went wrong."""
        log.reject(TOO_SHORT, self.short)
        for span, why in self.damaged:
            damage(log, span, why)
        for span, at, size in self.cut:
            log.worsen(
                "malformed",
                f"the chunk at byte {span.offset} is damaged from its byte {at} on (of {size}): "
                "what stands behind was left out",
            )


def groups_of(file: McapFile, spans: Iterable[Span], keep: frozenset[int], log: ImportLog) -> Iterator[Group]:
    """The spans with these channels in portions for threads: some chunks, or a window of bare messages."""
    held: list[ChunkSpan] = []
    size = 0
    for span in spans:
        if isinstance(span, LooseSpan):
            if held:
                yield tuple(held)
            held, size = [], 0
            yield from _windows(file, span, keep, log)
        elif span.channels is None or not span.channels.isdisjoint(keep):
            if held and size + span.length > PACKED_BYTES:
                yield tuple(held)
                held, size = [], 0
            held.append(span)
            size += span.length
    if held:
        yield tuple(held)


def _windows(file: McapFile, span: LooseSpan, keep: frozenset[int], log: ImportLog) -> Iterator[Window]:
    top = TopLevel(file, span.offset, span.end)
    for window in top.windows(keep):
        if window.records.opcode.size:
            yield window
    if top.broken:
        log.worsen("malformed", f"at byte {top.at} {top.broken}")


class _Tools(threading.local):
    """What each thread has of its own."""

    scratch: Scratch | None = None
    picker: Picker | None = None


class Reader:
    """Reads and decodes groups; may be called by several threads at once."""

    def __init__(self, file: McapFile, wants: Sequence[Want], slabs: Slabs) -> None:
        """slabs: memory for columns that live on."""
        self._file, self._wants = file, wants
        self._keep = frozenset(channel for want in wants for channel in want.ids)
        self._slot_of = slot_table([want.ids for want in wants])
        self._tools, self._slabs = _Tools(), slabs
        self._plan = plan_of([(want.decoder, want.paths) for want in wants])

    def __call__(self, group: Group) -> Result:
        """The decoded messages of a group, topic by topic, each topic's in their order."""
        result = Result()
        tools = self._tools
        if tools.picker is None:
            tools.picker = Picker(self._slot_of, len(self._wants))
        if isinstance(group, Window):
            records = group.records
            start, end = int(records.offset[0]) - RECORD_HEAD, int(records.offset[-1] + records.length[-1])
            _, _, result.short = tools.picker.walk(group.data, start, end)
            self._decode(group.data, tools.picker, result)
            result.place = group.base
            return result
        if tools.scratch is None:
            tools.scratch = Scratch()
        self._chunks(group, tools.scratch, tools.picker, result)
        return result

    def _chunks(self, spans: Sequence[ChunkSpan], scratch: Scratch, picker: Picker, result: Result) -> None:
        scratch.used = 0
        plain = [span.whole and not may_skip(span, self._keep) for span in spans]
        if self._plan is None:
            self._by_train(Train(self._file, spans, plain), spans, scratch, picker, result)
        else:
            flow = Flow(self._file, spans, plain, self._plan, self._slot_of, self._slabs.cells)
            self._by_flow(flow, spans, scratch, picker, result)
        result.place = spans[-1].offset

    def _by_train(
        self, train: Train, spans: Sequence[ChunkSpan], scratch: Scratch, picker: Picker, result: Result
    ) -> None:
        """Collect the messages of some chunks, then decode them, topic by topic."""
        while (why := train.run(scratch, picker, self._slot_of, UNPACKED_BYTES)) != DONE:
            if why == BROKEN:
                result.cut.append((spans[train.chunk - 1], train.at, train.size))
            elif why == ODD:
                self._alone(spans[train.chunk], scratch, picker, result)
                train.skip()
            if scratch.used >= UNPACKED_BYTES:
                self._decode(scratch.records, picker, result)
                scratch.used = 0
        result.short += train.short
        self._decode(scratch.records, picker, result)

    def _by_flow(
        self, flow: Flow, spans: Sequence[ChunkSpan], scratch: Scratch, picker: Picker, result: Result
    ) -> None:
        """Decode the messages of some chunks, chunk by chunk."""
        while True:
            why, parts = flow.decode(scratch, picker)
            result.parts += parts
            if why == DONE:
                break
            if why == BROKEN:
                result.cut.append((spans[flow.chunk - 1], flow.at, flow.size))
            else:
                if flow.unfit:
                    # so may all those be that come: not to be unpacked twice
                    self._plan = None
                picker.rewind(0)
                self._alone(spans[flow.chunk], scratch, picker, result)
                flow.skip()
                self._decode(scratch.records, picker, result)
                scratch.used = 0
        result.short += flow.short

    def _alone(self, span: ChunkSpan, scratch: Scratch, picker: Picker, result: Result) -> None:
        """Collect the messages of one chunk."""
        try:
            at, state, short, size = self._pick(span, scratch, picker)
        except DamagedError as error:
            result.damaged.append((span, str(error)))
            return
        result.short += short
        if span.whole and state in (WALK_CUT, WALK_INVALID):
            result.cut.append((span, at, size))

    def _pick(self, span: ChunkSpan, scratch: Scratch, picker: Picker) -> tuple[int, int, int, int]:
        """Where and why the walk over a chunk stopped, how many records were too short, and the chunk's size."""
        if may_skip(span, self._keep):
            found = pick_sparsely(self._file, span, self._keep, scratch, picker)
            if found:
                return found
        start = scratch.used
        size = load_chunk(self._file, span, scratch)
        at, state, short = picker.walk(scratch.records, start, start + size)
        return at - start, state, short, size

    def _decode(self, data: ByteArray, picker: Picker, result: Result) -> None:
        """Decode what the picker has collected from a buffer."""
        for picks in picker.take():
            if picks.length.size * len(self._wants[picks.number].paths) > MAX_CELLS:
                result.parts.append(_packed(picks, data))
            else:
                result.parts.append(self.decode(picks, data, slice(None)))

    def decode(self, picks: Picks, data: ByteArray, rows: slice) -> Part:
        """Decode some of the picked messages."""
        want = self._wants[picks.number]
        offset, length = picks.offset[rows], picks.length[rows]
        # small parts are joined, and what they took used again
        cells = self._slabs.cells if length.size * len(want.paths) >= ENOUGH_CELLS else np.empty
        decoded = want.decoder.decode(data, offset, length, want.paths, cells)
        return Part(picks.number, picks.log_ns[rows].copy(), decoded)

    def parts(self, result: Result) -> Iterator[Part]:
        """The parts of a result; what is not decoded yet is, little by little."""
        for part in result.parts:
            if isinstance(part, Part):
                yield part
                continue
            step = max(1, MAX_CELLS // len(self._wants[part.picks.number].paths))
            for start in range(0, part.picks.length.size, step):
                yield self.decode(part.picks, part.data, slice(start, start + step))


def _packed(picks: Picks, data: ByteArray) -> Undecoded:
    """A copy of messages that outlives the scratch."""
    offset = np.cumsum(picks.length) - picks.length
    out = np.empty(int(picks.length.sum()), dtype=np.uint8)
    gather(data, picks.offset, picks.length, offset, out)
    return Undecoded(Picks(picks.number, picks.log_ns.copy(), offset, picks.length.copy()), out)
