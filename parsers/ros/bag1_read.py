"""The wanted messages of a ROS 1 bag's chunks in columns: some chunks at a time, on any thread."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import BinaryIO, cast

import numpy as np

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit_foreign import descriptor_of, pread_address
from parsers.ros import topics as ros_topics
from parsers.ros.bag1_chunks import ChunkData, ChunkError, ChunkRef, chunk_data, unpack
from parsers.ros.bag1_kernels import (
    BAD,
    BROKEN,
    CUT,
    FULL,
    LAST_NS,
    SEEN,
    TALLY,
    decode_records,
)
from parsers.ros.bag1_train import (
    AT,
    BEFORE,
    CHUNK,
    DAMAGED,
    DONE,
    NO_ROOM,
    NO_ROW,
    ODD,
    STATE,
    STOP,
    WHY,
    decode_chunks,
)
from parsers.ros.kernels import COLUMNS, FILL, Program, Rows, Shapes
from parsers.ros.memory import Memory, Scratch
from parsers.ros.program import make_rows, make_shapes

FIRST_WINDOW = 1 << 14
MAX_WINDOW = 1 << 24
"""How much of an uncompressed chunk is read at once: little at first where there may be much to step over."""
JOB_BYTES = 1 << 24
JOB_ROWS = 1 << 16
"""Chunks that are read by one thread, one after the other: until they hold so many bytes or wanted messages."""
_SPARE_ROWS = 256


@dataclass(frozen=True)
class Wanted:
    """What is wanted of a bag. topic_of: connection -> the place of its topic in `program`.

    ids, topics: the same as arrays, sorted by connection. depth: how deep the loops of any of the programs nest.
    """

    topic_of: Mapping[int, int]
    program: Program
    depth: int
    ids: IntArray = field(init=False)
    topics: IntArray = field(init=False)

    def __post_init__(self) -> None:
        """Make the arrays."""
        ids = sorted(self.topic_of)
        object.__setattr__(self, "ids", np.array(ids, dtype=np.int64))
        object.__setattr__(
            self, "topics", np.array([self.topic_of[number] for number in ids], dtype=np.int64)
        )

    def rows_of(self, refs: Sequence[ChunkRef]) -> IntArray:
        """How many messages of each topic to expect in some chunks, from what the index says; it may lie."""
        total = np.zeros(len(self.program.spec), dtype=np.int64)
        for ref in refs:
            for number, count in (ref.counts or {}).items():
                if number in self.topic_of:
                    total[self.topic_of[number]] += count
        if total.sum() > 4 * JOB_ROWS:
            total = np.minimum(total, 4 * JOB_ROWS // len(total) + _SPARE_ROWS)
        return total


@dataclass(frozen=True)
class Block:
    """Messages of one topic. topic: its place in the program. stamp_ns, receive_ns: (n,). columns: (wanted, n)."""

    topic: int
    stamp_ns: IntArray
    receive_ns: IntArray
    columns: FloatArray


@dataclass(frozen=True)
class Lost:
    """A part of a chunk that cannot be used. since: the last time before it, where known."""

    ref: ChunkRef
    since: int | None
    what: str


@dataclass(frozen=True)
class Result:
    """What some chunks gave. bad: messages that do not fit their type, which are rows of NaN."""

    last: ChunkRef
    blocks: tuple[Block, ...]
    lost: tuple[Lost, ...]
    bad: int


@dataclass
class _Job:
    """Some chunks on their way. left: how many more messages of each topic are expected."""

    wanted: Wanted
    shapes: Shapes
    left: IntArray
    memory: Memory
    scratch: Scratch
    rows: Rows
    receive: IntArray
    blocks: list[Block] = field(default_factory=list)
    tally: IntArray = field(default_factory=lambda: np.zeros(TALLY, dtype=np.int64))

    def window(self, file: BinaryIO, at: int, size: int) -> memoryview:
        """The file's bytes [at, at + size), or fewer at its end; valid until the next call."""
        if len(self.scratch.raw) < size:
            self.scratch.raw = bytearray(max(size, FIRST_WINDOW) * 5 // 4)
        file.seek(at)
        target, done = memoryview(self.scratch.raw)[:size], 0
        while done < size:
            got = cast("int", file.readinto(target[done:]))  # type: ignore[attr-defined]
            if not got:
                break
            done += got
        # not to be written, as bytes are not, so that the kernels need to be compiled only once
        return target[:done].toreadonly()

    def train(self, file: int, starts: Sequence[int], state: IntArray) -> None:
        """Decode chunks that lie one behind the other, from state[CHUNK] on; why it stopped is in the state.

        file: its descriptor. starts: where each begins in the file, and the end of the last.
        """
        places = np.array(starts, np.int64)
        longest = int(np.diff(places).max())
        if len(self.scratch.raw) < longest:
            self.scratch.raw = bytearray(longest * 5 // 4)
        # not to be written, as bytes are not, so that the kernels need to be compiled only once
        data = np.frombuffer(memoryview(self.scratch.raw).toreadonly(), np.uint8)
        unpacker, wanted = self.scratch.frames.addresses, self.wanted
        while True:
            room = self.scratch.unpacked.view()
            room.flags.writeable = False
            decode_chunks(
                pread_address(),
                file,
                places,
                data,
                room,
                unpacker.reset,
                unpacker.decompress,
                unpacker.context,
                wanted.ids,
                wanted.topics,
                wanted.program,
                self.shapes,
                self.rows,
                self.scratch.places[0],
                self.scratch.places[1],
                self.receive,
                self.tally,
                state,
            )
            if state[WHY] == NO_ROW:
                self.flush()
                self.prepare()
            elif state[WHY] == NO_ROOM:
                self.scratch.room(int(state[STOP]))
            else:
                return

    def decode(self, data: ByteArray) -> int:
        """Decode the records of `data`; where the walk stopped."""
        stop = 0
        while True:
            wanted = self.wanted
            stop = decode_records(
                data,
                stop,
                len(data),
                wanted.ids,
                wanted.topics,
                wanted.program,
                self.shapes,
                self.rows,
                self.scratch.places[0],
                self.scratch.places[1],
                self.receive,
                self.tally,
            )
            if not self.tally[FULL]:
                return stop
            self.flush()
            self.prepare()

    def prepare(self) -> None:
        """Make room for the messages that are expected, but for no more numbers than a batch may have."""
        program = self.wanted.program
        most = np.maximum(ros_topics.MAX_CELLS // np.maximum(program.spec[:, COLUMNS], 1), 1)
        room = np.minimum(self.left, most)
        self.rows = make_rows(program, room, self.memory.cells)
        n = len(self.rows.stamp)
        self.receive = np.empty(n, dtype=np.int64)
        if self.scratch.places.shape[1] < n:
            self.scratch.places = np.empty((2, n), dtype=np.int64)

    def flush(self) -> None:
        """Make blocks of the rows so far."""
        rows, program = self.rows, self.wanted.program
        for topic, (cell, room, first, fill) in enumerate(rows.place.tolist()):
            if not fill:
                continue
            k = int(program.spec[topic, COLUMNS])
            columns = rows.cells[cell : cell + k * room].reshape(k, room)[:, :fill]
            times = slice(first, first + fill)
            self.blocks.append(Block(topic, rows.stamp[times], self.receive[times], columns))
        self.left = np.maximum(self.left - rows.place[:, FILL], _SPARE_ROWS)


@dataclass(frozen=True)
class ChunkReader:
    """Reads chunks of a bag; may be called from several threads at once. after: where the next chunk begins, by each one's start."""

    path: Path
    size: int
    wanted: Wanted
    after: Mapping[int, int] = field(default_factory=dict)
    memory: Memory = field(default_factory=Memory)

    def __call__(self, refs: Sequence[ChunkRef]) -> Result:
        """Decode the wanted messages of some chunks."""
        program = self.wanted.program
        left = self.wanted.rows_of(refs)
        shapes = make_shapes(program, self.wanted.depth)
        scratch = self.memory.scratch()
        nothing = make_rows(program, np.zeros_like(left))
        job = _Job(self.wanted, shapes, left, self.memory, scratch, nothing, nothing.stamp)
        job.prepare()
        lost: list[Lost] = []
        with self.path.open("rb", buffering=0) as opened:
            file = cast("BinaryIO", opened)
            for train in self._trains(refs, descriptor_of(file) if pread_address() else -1):
                lost += self._train(file, train, job) if len(train) > 1 else self._alone(file, train[0], job)
        job.flush()
        self.memory.free.append(scratch)
        return Result(refs[-1], tuple(job.blocks), tuple(lost), int(job.tally[BAD]))

    def _trains(self, refs: Sequence[ChunkRef], file: int) -> Iterator[list[ChunkRef]]:
        """The chunks, those together that lie one behind the other and are read whole in any case."""
        train: list[ChunkRef] = []
        open_end = False
        for ref in refs:
            size = self.after.get(ref.start, self.size) - ref.start
            plain = (
                file >= 0 and ref.whole and not ref.bare and ref.start in self.after and size <= MAX_WINDOW
            )
            plain = plain and not self._has_large(ref, size)
            if train and not (open_end and plain and self.after[train[-1].start] == ref.start):
                yield train
                train = []
            train.append(ref)
            open_end = plain
        if train:
            yield train

    def _train(self, file: BinaryIO, refs: Sequence[ChunkRef], job: _Job) -> Iterator[Lost]:
        """Decode chunks that lie one behind the other; what of them cannot be used."""
        state = np.zeros(STATE, np.int64)
        starts = [ref.start for ref in refs]
        starts.append(self.after[starts[-1]])
        while state[CHUNK] < len(refs):
            state[AT] = -1
            job.train(descriptor_of(file), starts, state)
            ref = refs[min(int(state[CHUNK]), len(refs) - 1)]
            if state[WHY] == DAMAGED:
                yield from _damaged(ref, int(state[BEFORE]), job)
            elif state[WHY] == ODD:
                yield from self._alone(file, ref, job)
            if state[WHY] != DONE:
                state[CHUNK] += 1

    def _alone(self, file: BinaryIO, ref: ChunkRef, job: _Job) -> Iterator[Lost]:
        """Decode one chunk; what of it cannot be used."""
        before = int(job.tally[SEEN])
        try:
            whole = self._chunk(file, ref, job)
        except ChunkError as error:
            yield Lost(ref, ref.first_ns, f"a chunk was left out: {error}")
            return
        if not whole and ref.whole:
            yield from _damaged(ref, before, job)

    def _has_large(self, ref: ChunkRef, size: int) -> bool:
        """Whether a chunk of so many bytes may hold large messages that nobody wants."""
        if ref.counts is None:
            return True
        other = sum(count for number, count in ref.counts.items() if number not in self.wanted.topic_of)
        return bool(other) and size // other > FIRST_WINDOW

    def _chunk(self, file: BinaryIO, ref: ChunkRef, job: _Job) -> bool:
        """Decode one chunk; whether all of it could be used. Raises ChunkError."""
        where = chunk_data(file, ref, self.size)
        if where.compression != "none":
            data = unpack(job.window(file, where.at, where.available), where, ref.whole, job.scratch)
            return job.decode(data) == where.declared
        # all of it at first, but where there may be large messages that nobody wants
        return _windows(
            file, where, job, FIRST_WINDOW if self._has_large(ref, where.available) else MAX_WINDOW
        )


def _damaged(ref: ChunkRef, before: int, job: _Job) -> Iterator[Lost]:
    """A chunk that is damaged inside. before: how many messages were seen before it."""
    seen = int(job.tally[SEEN]) - before
    what = f"a chunk is damaged after {seen} messages; the rest of it was left out"
    yield Lost(ref, int(job.tally[LAST_NS]) if seen else ref.first_ns, what)


def _windows(file: BinaryIO, where: ChunkData, job: _Job, window: int) -> bool:
    """Decode an uncompressed chunk window by window, past large messages that nobody wants without reading them."""
    at, end = where.at, where.at + where.available
    tally = job.tally
    while at < end:
        base = at
        data = np.frombuffer(job.window(file, at, min(window, end - at)), dtype=np.uint8)
        at += job.decode(data)
        _, _, following, its_ns, needed, _, _ = tally.tolist()
        read, after = base + len(data), base + following
        if following == BROKEN or after > end or base == read:
            break
        if following != CUT and not needed:
            if its_ns >= 0:
                tally[SEEN] += 1
                tally[LAST_NS] = its_ns
            window = FIRST_WINDOW if after - read > FIRST_WINDOW else min(2 * window, MAX_WINDOW)
            at = after
        elif read >= end or (at == base and following == CUT and window >= MAX_WINDOW):
            break
        else:
            window = max(min(2 * window, MAX_WINDOW), after - at)
    return at == where.at + where.declared


def following(refs: Iterable[ChunkRef]) -> dict[int, int]:
    """Where the next chunk begins, by each one's start; nothing of the last."""
    starts = sorted(ref.start for ref in refs)
    return dict(pairwise(starts))


def jobs(refs: Sequence[ChunkRef], wanted: Wanted, size: int) -> Iterator[list[ChunkRef]]:
    """The chunks with wanted messages in portions for one call of a `ChunkReader` each."""
    portion: list[ChunkRef] = []
    held = rows = 0
    for i, ref in enumerate(refs):
        here = sum(count for number, count in (ref.counts or {}).items() if number in wanted.topic_of)
        if ref.counts is not None and not here:
            continue
        portion.append(ref)
        held += (refs[i + 1].start if i + 1 < len(refs) else size) - ref.start
        rows += here
        if held >= JOB_BYTES or rows >= JOB_ROWS:
            yield portion
            portion, held, rows = [], 0, 0
    if portion:
        yield portion
