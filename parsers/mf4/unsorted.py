"""Unsorted data: records of several groups one after the other, each behind its record id, told apart by a kernel."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.importer import ImportLog
from parsers.mf4.batch import EMPTY, Batch, Window
from parsers.mf4.clock import NO_TIME, find_master, ns_per_count, times_ns
from parsers.mf4.model import CG_VLSD, Group
from parsers.mf4.streams import DataStream
from parsers.mf4.unsorted_kernels import BAD, COUNT, LAST, POS, find_records, gather, look, walk_records

LEAP_NS = 3_600_000_000_000
"""A step of time between records beyond which they are looked at twice."""
KEEP = 1 << 16


@dataclass(frozen=True)
class _Columns:
    """Slot, first byte and bytes of each record found in a chunk."""

    slot: IntArray
    place: IntArray
    length: IntArray


class UnsortedWalk:
    """The walk over a stream with records of several groups. wanted, windowed: see `parsers.mf4.records.batches`.

    lost: bytes left out behind damage. spans: (before, after) stamps around it, relative to the file's start.
    """

    def __init__(
        self, groups: tuple[Group, ...], id_size: int, wanted: frozenset[int], windowed: frozenset[int]
    ) -> None:
        by_id = {group.record_id: group for group in groups if group.record_id < 1 << 62}
        self.groups = [by_id[key] for key in sorted(by_id)]
        self.ids = _id_table(sorted(by_id))
        self.sizes = np.array([-1 if g.flags & CG_VLSD else g.size for g in self.groups], np.int64)
        self.stamps, self.leap = _stamp_table(self.groups)
        self.id_size, self.wanted = id_size, wanted
        self.firsts = [0] * len(self.groups)
        self.windows = {g.at: EMPTY for g in self.groups if g.at in windowed}
        self.step = id_size + min(((4 if size < 0 else int(size)) for size in self.sizes), default=0)
        self.state = np.array([0, 0, 0, -1], np.int64)
        self.tail = np.zeros(0, np.uint8)
        self.lost, self.damages, self.searching = 0, 0, False
        self.spans: list[tuple[int, int]] = []
        self.before = NO_TIME

    def jump(self, size: int) -> None:
        """A block of the stream could not be read: what straddles it is lost too."""
        self.lost += size + self.tail.size
        self.tail = np.zeros(0, np.uint8)
        self._damaged()

    def _damaged(self) -> None:
        self.damages += 1
        self.searching = True
        self.state[LAST] = -1
        # how many payloads were lost is unknown, so that no place among them is certain any more
        self.windows = {key: Window(0, EMPTY.data, 0, EMPTY.starts, lost=True) for key in self.windows}

    def walk(self, data: ByteArray, file_at: int) -> Iterator[Batch]:
        """The batches of one chunk, those of variable length first."""
        joined = np.concatenate([self.tail, data]) if self.tail.size else data
        columns = self._find(joined)
        counts = np.bincount(columns.slot, minlength=len(self.groups)).tolist()
        for index, group in enumerate(self.groups):
            if group.at in self.windows and not self.windows[group.at].lost:
                self._extend(group.at, joined, columns, index)
        for index, group in enumerate(self.groups):
            count = counts[index]
            if group.number not in self.wanted or not count:
                continue
            rows = np.empty(count * group.size, np.uint8)
            gather(joined, index, columns.slot, columns.place, columns.length, rows)
            first = self.firsts[index]
            yield Batch(group, first, rows, count, group.size, 0, dict(self.windows), file_at)
            self.firsts[index] += count

    def _find(self, data: ByteArray) -> _Columns:
        """All records of a chunk; goes on behind damage where the stamps tell records from rubbish."""
        room = data.size // self.step + 1
        columns = _Columns(*(np.empty(room, np.int64) for _ in range(3)))
        pos = 0
        self.state[COUNT] = 0
        while True:
            if self.searching:
                place = self._search(data, pos)
                if place < 0:
                    break
                self._note_gap(data, place)
                pos = place
            walk_records(
                data, pos, self.id_size, self.ids, self.sizes, self.stamps, self.leap,
                columns.slot, columns.place, columns.length, self.state,
            )  # fmt: skip
            pos = int(self.state[POS])
            self._note_last(data, columns)
            if not self.state[BAD]:
                self.tail = data[pos:]
                break
            if self._leaps(data, pos):
                continue
            self._damaged()
        count = int(self.state[COUNT])
        return _Columns(columns.slot[:count], columns.place[:count], columns.length[:count])

    def _leaps(self, data: ByteArray, pos: int) -> bool:
        """Whether the records simply go on here after a pause: no damage."""
        if not self.leap:
            return False
        again = find_records(
            data[: pos + KEEP], pos, self.id_size, self.ids, self.sizes, self.stamps, self.leap
        )
        if again == pos:
            self.state[LAST] = -1
            return True
        return False

    def _search(self, data: ByteArray, pos: int) -> int:
        """Where records begin again, or -1: then the chunk's end is kept, for they may begin in it."""
        place = -1
        if self.leap:
            place = find_records(data, pos, self.id_size, self.ids, self.sizes, self.stamps, self.leap)
        stop = place if place >= 0 else max(pos, data.size - KEEP)
        self.lost += stop - pos
        if place < 0:
            self.tail = data[stop:].copy()
        else:
            self.searching = False
        return place

    def _time(self, data: ByteArray, slot: int, place: int) -> int:
        """The stamp of one record in ns, NO_TIME where it has none."""
        group = self.groups[slot]
        master = find_master(group)
        if master is None or self.sizes[slot] < 0:
            return NO_TIME
        return int(times_ns(data[place : place + group.size].reshape(1, -1), master, 0)[0])

    def _note_last(self, data: ByteArray, columns: _Columns) -> None:
        for index in range(int(self.state[COUNT]) - 1, max(int(self.state[COUNT]) - 8, -1), -1):
            time = self._time(data, int(columns.slot[index]), int(columns.place[index]))
            if time != NO_TIME:
                self.before = time
                return

    def _note_gap(self, data: ByteArray, pos: int) -> None:
        found = np.zeros(3, np.int64)
        for _ in range(8):
            if look(data, pos, self.id_size, self.ids, self.sizes, found) <= 0:
                return
            time = self._time(data, int(found[0]), int(found[1]))
            if time != NO_TIME:
                if self.before != NO_TIME and time > self.before:
                    self.spans.append((self.before, time))
                return
            pos = int(found[1] + found[2])

    def _extend(self, key: int, data: ByteArray, columns: _Columns, index: int) -> None:
        """Move a window on: the last chunk's records stay in it, since a record may refer back a little."""
        old = self.windows[key]
        length = columns.length[columns.slot == index]
        added = np.empty(int(length.sum()), np.uint8)
        gather(data, index, columns.slot, columns.place, columns.length, added)
        starts = old.end + np.cumsum(length) - length
        keep = max(0, old.starts.size - max(length.size, 4096))
        cut = int(old.starts[keep]) - old.base if keep < old.starts.size else old.data.size
        self.windows[key] = Window(
            old.base + cut,
            np.concatenate([old.data[cut:], added]),
            old.first + keep,
            np.concatenate([old.starts[keep:], starts]),
        )


def _id_table(ids: list[int]) -> IntArray:
    """How the kernels look up the slot of a record id: a table of slots for small ids, else 0 and the sorted ids."""
    if not ids or ids[-1] >= 1 << 16:
        return np.array([0, *ids], np.int64)
    table = np.full(ids[-1] + 2, -1, np.int64)
    table[0] = ids[-1] + 1
    table[np.array(ids) + 1] = np.arange(len(ids))
    return table


def _stamp_table(groups: list[Group]) -> tuple[IntArray, int]:
    """For each group place and bytes of its raw stamp, and the leap in raw stamps; 0 where they cannot be compared."""
    table = np.zeros((len(groups), 2), np.int64)
    units = set()
    for slot, group in enumerate(groups):
        master = find_master(group)
        if group.flags & CG_VLSD or master is None:
            continue
        unit = ns_per_count(master)
        if unit is None:
            continue
        units.add(unit)
        table[slot] = master.byte_offset, min(master.bit_count // 8, 7)
    if len(units) != 1:
        table[:] = 0
        return table, 0
    return table, LEAP_NS // units.pop()


def walked(stream: DataStream, walk: UnsortedWalk, log: ImportLog, start_ns: int) -> Iterator[Batch]:
    """The batches of an unsorted stream, and in the log book what damage cost."""
    after = 0
    for at, data, file_at in stream.chunks():
        if at != after:
            walk.jump(at - after)
        after = at + data.size
        yield from walk.walk(data, file_at)
    if after < stream.size:
        walk.jump(stream.size - after)
    if walk.searching:
        walk.lost += walk.tail.size
    if walk.damages:
        log.reject("damaged place in the MF4 file's records", walk.damages)
        log.worsen(
            "malformed",
            f"the records of the MF4 file are damaged in {walk.damages} places: {walk.lost} of {stream.size} bytes "
            "of a data group were left out",
        )
        log.lost_spans_ns.extend((start_ns + before, start_ns + end) for before, end in walk.spans)
    elif walk.tail.size:
        log.worsen("truncated", "the last record is not whole and was left out")
