"""Runs of records that any thread may read by itself: of sorted streams whose blocks hold whole records."""

from __future__ import annotations

import bisect
import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from parsers.channels import ByteArray
from parsers.importer import ImportLog
from parsers.mf4.batch import Batch
from parsers.mf4.compression import TRANSPOSED, inflate_into
from parsers.mf4.frame_room import FrameRoom, FrameRooms
from parsers.mf4.model import CG_VLSD, DataGroup, Measurement
from parsers.mf4.pieces import CHUNK
from parsers.mf4.records import record_size, records_there
from parsers.mf4.streams import DataStream

PLAIN_BYTES = 1 << 20
"""Of a run that is not compressed: with its columns it stays in a core's own cache."""
MOST_BYTES = 2 * CHUNK
"""Of a block: several runs are in memory at a time."""


@dataclass(frozen=True)
class Runs:
    """The runs of a stream: their records without bytes, to be read in any order, and the memory that they are read into."""

    stream: DataStream
    batches: list[Batch]
    rooms: FrameRooms

    def read(self, batch: Batch, room: FrameRoom | None) -> Batch:
        """With the records' bytes, in `room` where there is one. Raises LogError where they cannot be read."""
        begin = batch.first * batch.stride
        end = begin + batch.count * batch.stride
        if self.stream.plain:
            data = np.empty(end - begin, np.uint8) if room is None else room.data[: end - begin]
            self.stream.read_into(begin, data)
            return batch.with_data(data)
        return batch.with_data(self._inflated(begin, end, room or self._new_room(begin, end)))

    def _new_room(self, begin: int, end: int) -> FrameRoom:
        blocks = [self.stream.fragments[i] for i in self._blocks(begin, end)]
        largest = max(block.size for block in blocks)
        return FrameRoom.of(sum(block.size for block in blocks), 0, max(b.stored for b in blocks), largest)

    def _blocks(self, begin: int, end: int) -> range:
        starts = self.stream.starts
        return range(bisect.bisect_right(starts, begin) - 1, bisect.bisect_left(starts, end))

    def _inflated(self, begin: int, end: int, room: FrameRoom) -> ByteArray:
        """The bytes from begin, where a block begins, to end."""
        at = 0
        for index in self._blocks(begin, end):
            block = self.stream.fragments[index]
            into = room.data[at : at + block.size]
            if block.method < 0:
                self.stream.file.read_into(block.at, into)
            else:
                packed = room.packed[: block.stored]
                self.stream.file.read_into(block.at, packed)
                inflate_into(packed, block.method, block.columns, into, room.turned)
            at += block.size
        return room.data[: end - begin]

    def apart(self, batch: Batch) -> list[Batch]:
        """The records of each block by themselves, lest a damaged one costs the others."""
        begin = batch.first * batch.stride
        end = begin + batch.count * batch.stride
        starts = [self.stream.starts[i] for i in self._blocks(begin, end)]
        edges = [begin, *starts[1:], end] if not self.stream.plain else [begin, end]
        return [
            _batch(batch, self.stream, a // batch.stride, b // batch.stride)
            for a, b in itertools.pairwise(edges)
        ]


def _batch(like: Batch, stream: DataStream, first: int, end: int) -> Batch:
    """Records from number `first` to `end`, without their bytes."""
    at = stream.place(first * like.stride)
    return Batch(like.group, first, like.data, end - first, like.stride, like.skip, {}, at)


def runs_of(
    data_group: DataGroup, stream: DataStream, measurement: Measurement, log: ImportLog
) -> Runs | None:
    """The runs of a data group's stream.

    None where the place of a record in the stream, or of the stream's bytes in the file, is not known beforehand.
    """
    groups, id_size = data_group.groups, data_group.id_size
    if len(groups) != 1 or groups[0].flags & CG_VLSD or stream.values_only:
        return None
    size = record_size(groups[0], stream) + id_size
    if size <= id_size or not (stream.plain or _whole_records(stream, size)):
        return None
    total = records_there(groups[0], stream, size, measurement.unfinished, log)
    like = Batch(groups[0], 0, np.zeros(0, np.uint8), 0, size, id_size)
    edges = [min(edge // size, total) for edge in _edges(stream, size)]
    batches = [_batch(like, stream, a, b) for a, b in itertools.pairwise(edges) if b > a]
    return Runs(stream, batches, _rooms(stream, batches, size))


def _whole_records(stream: DataStream, size: int) -> bool:
    """Whether every block begins with a record, and none is too large, or cut, to be read by itself."""
    return all(start % size == 0 for start in stream.starts) and all(
        fragment.size <= MOST_BYTES and fragment.stored <= MOST_BYTES and not fragment.cut
        for fragment in stream.fragments
    )


def _edges(stream: DataStream, size: int) -> Iterator[int]:
    """Places in the stream: where runs begin, and its end."""
    if stream.plain:
        yield from range(0, stream.size, max(PLAIN_BYTES // size, 1) * size)
    else:
        begin = 0
        for start, fragment in zip(stream.starts, stream.fragments, strict=True):
            if start == begin or start + fragment.size - begin > CHUNK:
                yield start
                begin = start
    yield stream.size


def _rooms(stream: DataStream, batches: list[Batch], size: int) -> FrameRooms:
    rows = max((batch.count for batch in batches), default=0)
    if stream.plain:
        return FrameRooms(rows * size, rows)
    packed = [fragment for fragment in stream.fragments if fragment.method >= 0]
    turned = [fragment.size for fragment in packed if fragment.method in TRANSPOSED]
    # the last block may hold more than whole records
    largest = max(CHUNK, max(fragment.size for fragment in stream.fragments))
    return FrameRooms(largest, rows, max(fragment.stored for fragment in packed), max(turned, default=0))
