"""Records out of data streams, a chunk at a time: sorted groups by arithmetic, unsorted ones by their record ids."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from parsers.importer import ImportLog
from parsers.mf4.batch import Batch
from parsers.mf4.clock import find_master
from parsers.mf4.gaps import say_zeros
from parsers.mf4.invalidation import BitSource
from parsers.mf4.model import (
    CG_VLSD,
    MASTER,
    UNFINISHED_CYCLES,
    UNFINISHED_OFFSETS,
    DataGroup,
    Group,
    Measurement,
)
from parsers.mf4.streams import DataStream
from parsers.mf4.unsorted import UnsortedWalk, walked


def record_size(group: Group, stream: DataStream) -> int:
    """Bytes of a record in a sorted stream."""
    return group.invalid_at if stream.values_only else group.size


def records_there(group: Group, stream: DataStream, size: int, unfinished: int, log: ImportLog) -> int:
    """How many records a sorted stream holds. size: of a record with its id."""
    there = stream.size // size
    total = there if unfinished & UNFINISHED_CYCLES or not group.cycles else min(group.cycles, there)
    if group.cycles > there:
        log.worsen(
            "truncated",
            f"channel group {group.number} has {there} of the {group.cycles} records that it should have",
        )
    if unfinished:
        total = min(total, _written(group, stream, size, total, log))
    return total


def _sorted(
    group: Group, stream: DataStream, id_size: int, unfinished: int, log: ImportLog
) -> Iterator[Batch]:
    """Batches of a stream that holds one group only (a record id before each record is allowed)."""
    size = record_size(group, stream) + id_size
    if size == id_size:
        yield from _empty_records(group)
        return
    total = records_there(group, stream, size, unfinished, log)
    apart = stream.values_only and group.size > group.invalid_at
    bits = BitSource(group, stream.bits, log) if apart else None
    tail = np.zeros(0, np.uint8)
    tail_at = 0
    for at, data, file_at in stream.chunks(size):
        if tail_at + tail.size != at:
            # something is missing before: go on with the first whole record
            tail = np.zeros(0, np.uint8)
            data = data[-at % size :]
            tail_at = at + (-at % size)
        joined = np.concatenate([tail, data]) if tail.size else data
        first, whole = tail_at // size, joined.size // size
        count = min(whole, max(0, total - first))
        if count:
            yield Batch(group, first, joined, count, size, id_size, {}, file_at, bits)
        tail = joined[whole * size :]
        tail_at += whole * size


def _written(group: Group, stream: DataStream, size: int, total: int, log: ImportLog) -> int:
    """How many records the recorder filled of the space that it had reserved: a record of zeros has no time of its own."""
    master = find_master(group)
    if master is None or master.kind != MASTER:
        return total
    count = -(-stream.filled() // size)
    if count < total:
        end = count * size
        say_zeros(log, f"byte {stream.place(end)} (record {count})", stream.size - end)
    return count


def _empty_records(group: Group) -> Iterator[Batch]:
    """Records without bytes: all channels are virtual; counted, not stored."""
    step = 1 << 18
    for first in range(0, min(group.cycles, 1 << 32), step):
        yield Batch(group, first, np.zeros(0, np.uint8), min(step, group.cycles - first), 0)


def batches(
    data_group: DataGroup,
    stream: DataStream,
    wanted: frozenset[int],
    windowed: frozenset[int],
    measurement: Measurement,
    log: ImportLog,
) -> Iterator[Batch]:
    """Records of the wanted groups (by number), a chunk at a time.

    windowed: places of the VLSD groups whose payloads the wanted groups refer to.
    """
    groups = data_group.groups
    if not groups or wanted.isdisjoint(group.number for group in groups):
        return
    if len(groups) == 1 and not groups[0].flags & CG_VLSD:
        yield from _sorted(groups[0], stream, data_group.id_size, measurement.unfinished, log)
    elif data_group.id_size:
        if stream.size:
            by_order = bool(measurement.unfinished & UNFINISHED_OFFSETS)
            walk = UnsortedWalk(groups, data_group.id_size, wanted, windowed, by_order=by_order)
            yield from walked(stream, walk, log, measurement.start_ns)
    else:
        log.worsen("malformed", "a data group with several channel groups has no record ids and was left out")
