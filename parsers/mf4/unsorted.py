"""Unsorted data: records of several groups one after the other, each behind its record id, told apart by a kernel."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.importer import ImportLog
from parsers.mf4.batch import EMPTY, Batch, Window
from parsers.mf4.clock import NO_TIME, find_master, is_double, ns_per_count, times_ns
from parsers.mf4.gaps import say_zeros
from parsers.mf4.model import CG_VLSD, Group
from parsers.mf4.payload_order import ENOUGH, SAMPLE, Records, Sample, payload_order, sample_of
from parsers.mf4.streams import DataStream
from parsers.mf4.unsorted_kernels import BAD, COUNT, LAST, POS, find_records, gather, look, walk_records

LEAP_NS = 3_600_000_000_000
"""A step of time between records beyond which they are looked at twice."""
_SECOND_NS = 1_000_000_000
_DOUBLES = 1 << 53
"""The step from a float to four times as much, in its bits."""
KEEP = 1 << 16


class UnsortedWalk:
    """The walk over a stream with records of several groups. wanted, windowed: see `parsers.mf4.records.batches`.

    by_order: see `PayloadOrder`. lost: bytes left out behind damage; cut: records in which it begins. spans: (before, after)
    stamps around it, relative to the file's start. unsure: records were handed on whose payloads cannot be told. While
    `searching` for records behind damage: bad_at is where it begins in the stream, lost_before what was lost before it, and
    zeros whether nothing but zeros was met since. limit: place in the stream from which on bytes of zeros are no records, though
    there is a record id 0.
    """

    def __init__(
        self,
        groups: tuple[Group, ...],
        id_size: int,
        wanted: frozenset[int],
        windowed: frozenset[int],
        *,
        by_order: bool = False,
    ) -> None:
        by_id = {group.record_id: group for group in groups if group.record_id < 1 << 62}
        self.groups = [by_id[key] for key in sorted(by_id)]
        self.ids = _id_table(sorted(by_id))
        self.sizes = np.array([-1 if g.flags & CG_VLSD else g.size for g in self.groups], np.int64)
        self.stamps, self.leap, self.rise = _stamp_table(self.groups)
        self.id_size, self.wanted = id_size, wanted
        self.firsts = [0] * len(self.groups)
        self.windows = {g.at: EMPTY for g in self.groups if g.at in windowed}
        self.sample: Sample | None = None
        self.orders = {key: payload_order(self.groups, key, by_order=by_order) for key in self.windows}
        self.step = id_size + min(((4 if size < 0 else int(size)) for size in self.sizes), default=0)
        self.state = np.array([0, 0, 0, -1], np.int64)
        self.tail = np.zeros(0, np.uint8)
        self.lost, self.damages, self.cut, self.searching = 0, 0, 0, False
        self.limit = 1 << 62
        self.unsure, self.zeros, self.bad_at, self.lost_before = False, False, 0, 0
        self.spans: list[tuple[int, int]] = []
        self.before = NO_TIME

    def jump(self, at: int, size: int) -> None:
        """A block of the stream, `size` bytes from `at` on, could not be read: what straddles it is lost too."""
        begin = at - self.tail.size
        self.tail = np.zeros(0, np.uint8)
        self._damaged(begin)
        self.lost += at + size - begin
        self.zeros = False

    def _damaged(self, at: int) -> None:
        self.damages += 1
        self.searching = self.zeros = True
        self.bad_at, self.lost_before = at, self.lost
        self.state[LAST] = -1
        if self.sample is not None:
            for key, order in self.orders.items():
                order.learn(
                    self.sample.data, self.sample.records, self.sample.firsts, self.sample.begins[key]
                )
        # how many payloads were lost is unknown, so that no place among them is certain any more
        self.windows = {
            key: Window(old.end, EMPTY.data, old.first + old.starts.size, EMPTY.starts, lost=True)
            for key, old in self.windows.items()
        }

    def walk(self, at: int, data: ByteArray, file_at: int) -> Iterator[Batch]:
        """The batches of one chunk, which begins at a place of the stream: first those before damage, then those behind it."""
        joined = np.concatenate([self.tail, data]) if self.tail.size else data
        for records in self._find(joined, at - self.tail.size):
            yield from self._handed_on(joined, records, file_at)

    def _handed_on(self, joined: ByteArray, columns: Records, file_at: int) -> Iterator[Batch]:
        """The batches of a row of records without damage; payloads go into the windows before."""
        counts = np.bincount(columns.slot, minlength=len(self.groups)).tolist()
        seen = 0 if self.sample is None else self.sample.records.slot.size
        if self.windows and not self.damages and seen < min(SAMPLE // 8, columns.slot.size):
            begins = {key: self._least(key) for key in self.windows}
            self.sample = sample_of(joined, columns, self.firsts, begins)
        for index, group in enumerate(self.groups):
            if group.at in self.windows:
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

    def _find(self, data: ByteArray, begin: int) -> Iterator[Records]:
        """The records of a chunk in rows without damage. begin: the chunk's place in the stream.

        A row is good until the next is asked for. Goes on behind damage where the stamps tell records from rubbish.
        """
        room = data.size // self.step + 1
        columns = Records(*(np.empty(room, np.int64) for _ in range(3)))
        pos = 0
        while True:
            self.state[COUNT] = 0
            if self.searching:
                place = self._search(data, pos)
                if place < 0:
                    return
                self._note_gap(data, place)
                pos = place
            walk_records(
                data, pos, self.id_size, self.ids, self.sizes, self.stamps, self.leap,
                columns.slot, columns.place, columns.length, self.state,
            )  # fmt: skip
            pos = int(self.state[POS])
            while self.state[BAD] and self._leaps(data, pos):
                walk_records(
                    data, pos, self.id_size, self.ids, self.sizes, self.stamps, self.leap,
                    columns.slot, columns.place, columns.length, self.state,
                )  # fmt: skip
                pos = int(self.state[POS])
            records = columns.part(0, int(self.state[COUNT]))
            if begin + data.size > self.limit:
                begun = np.searchsorted(records.place, self.limit - begin + self.id_size)
                records = records.part(0, int(begun))
            if self.state[BAD] and self._doubtful(data, records):
                self.cut += 1
                if self.sizes[records.slot[-1]] < 0:
                    # its length is not to be believed: the next record may be anywhere behind its beginning
                    pos = int(records.place[-1])
                records = records.part(0, records.slot.size - 1)
            self.before = self._last_time(data, records)
            yield records
            if not self.state[BAD]:
                self.tail = data[pos:]
                return
            self._damaged(begin + pos)

    def _leaps(self, data: ByteArray, pos: int) -> bool:
        """Whether the records simply go on here after a pause: no damage."""
        if not self.leap:
            return False
        again = find_records(
            data[: pos + KEEP], pos, self.id_size, self.ids, self.sizes, self.stamps, self.rise
        )
        if again == pos:
            self.state[LAST] = -1
            return True
        return False

    def _search(self, data: ByteArray, pos: int) -> int:
        """Where records begin again, or -1: then the chunk's end is kept, for they may begin in it."""
        place, empty = -1, not data[pos:].any()
        self.zeros = self.zeros and empty
        if self.rise and not empty:
            place = find_records(data, pos, self.id_size, self.ids, self.sizes, self.stamps, self.rise)
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

    def _last_time(self, data: ByteArray, records: Records) -> int:
        """The stamp of the last record that has one; what it was before where there is none."""
        count = records.slot.size
        for index in range(count - 1, max(count - 9, -1), -1):
            time = self._time(data, int(records.slot[index]), int(records.place[index]))
            if time != NO_TIME:
                return time
        return self.before

    def _doubtful(self, data: ByteArray, records: Records) -> bool:
        """Whether damage begins within the last record: its length, stamp or payload's place is not as it must be."""
        count = records.slot.size
        if not count:
            return False
        if self.sizes[records.slot[-1]] < 0:
            some = records.part(max(count - SAMPLE, 0), count)
            others = some.length[:-1][some.slot[:-1] == some.slot[-1]]
            return others.size >= ENOUGH and bool(some.length[-1] > others.max())
        if any(order.falls_back(data, records) for order in self.orders.values()):
            return True
        if find_master(self.groups[int(records.slot[-1])]) is None:
            return False
        time = self._time(data, int(records.slot[-1]), int(records.place[-1]))
        before = self._last_time(data, records.part(0, count - 1))
        return before != NO_TIME and not before - _SECOND_NS <= time <= before + LEAP_NS

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

    def end(self, stream: DataStream, at: int) -> str:
        """A place of the stream at which the records end, in words."""
        when = f", {self.before / _SECOND_NS:.3f} s after the start of the recording"
        return f"byte {stream.place(at)}" + (when if self.before != NO_TIME else "")

    def _least(self, key: int) -> int:
        """What the next payload of a VLSD group begins with: see `PayloadOrder.learn`."""
        old = self.windows[key]
        return old.first + old.starts.size if self.orders[key].by_order else old.end

    def _extend(self, key: int, data: ByteArray, columns: Records, index: int) -> None:
        """Move a window on: the last chunk's records stay in it, since a record may refer back a little."""
        old, order = self.windows[key], self.orders[key]
        base, first = old.base, old.first
        if old.lost:
            begin = order.begin(data, columns, self.firsts)
            if begin is None:
                self.unsure = self.unsure or bool(columns.slot.size)
                return
            base, first = (base, begin) if order.by_order else (begin, first)
        elif self.state[BAD]:
            # damage comes next: the records before it are the best to learn from
            order.learn(data, columns, self.firsts, self._least(key))
        length = columns.length[columns.slot == index]
        added = np.empty(int(length.sum()), np.uint8)
        gather(data, index, columns.slot, columns.place, columns.length, added)
        starts = base + old.data.size + np.cumsum(length) - length
        keep = max(0, old.starts.size - max(length.size, 4096))
        cut = int(old.starts[keep]) - base if keep < old.starts.size else old.data.size
        window = Window(
            base + cut,
            np.concatenate([old.data[cut:], added]),
            first + keep,
            np.concatenate([old.starts[keep:], starts]),
        )
        # what seems to begin before the damage's place is rubbish that hid behind a record id
        self.windows[key] = window.behind(old.base) if old.lost and not order.by_order else window


def _id_table(ids: list[int]) -> IntArray:
    """How the kernels look up the slot of a record id: a table of slots for small ids, else 0 and the sorted ids."""
    if not ids or ids[-1] >= 1 << 16:
        return np.array([0, *ids], np.int64)
    table = np.full(ids[-1] + 2, -1, np.int64)
    table[0] = ids[-1] + 1
    table[np.array(ids) + 1] = np.arange(len(ids))
    return table


def _stamp_table(groups: list[Group]) -> tuple[IntArray, int, int]:
    """For each group place and bytes of its raw stamp, the leap in raw stamps, and the rise.

    The rise is what a stamp may be more than the one before it where records are searched for. Both are 0 where the stamps
    cannot be compared; bits of floats rise, but differences between them mean nothing: no leap can be told.
    """
    table = np.zeros((len(groups), 2), np.int64)
    units = set()
    for slot, group in enumerate(groups):
        master = find_master(group)
        if group.flags & CG_VLSD or master is None:
            continue
        unit = 0 if is_double(master) else ns_per_count(master)
        if unit is None:
            continue
        units.add(unit)
        table[slot] = master.byte_offset, min(master.bit_count // 8, 7 if unit else 8)
    if len(units) != 1:
        table[:] = 0
        return table, 0, 0
    unit = units.pop()
    return (table, LEAP_NS // unit, LEAP_NS // unit) if unit else (table, 0, _DOUBLES)


def walked(stream: DataStream, walk: UnsortedWalk, log: ImportLog, start_ns: int) -> Iterator[Batch]:
    """The batches of an unsorted stream, and in the log book what damage cost."""
    if any(group.record_id == 0 for group in walk.groups):
        walk.limit = stream.filled()
    after = 0
    for at, data, file_at in stream.chunks():
        if at != after:
            walk.jump(after, at - after)
        after = at + data.size
        yield from walk.walk(at, data, file_at)
    if after < stream.size:
        walk.jump(after, stream.size - after)
    if walk.searching:
        walk.lost += walk.tail.size
    _say_what_was_lost(stream, walk, log)
    log.lost_spans_ns.extend((start_ns + before, start_ns + end) for before, end in walk.spans)


def _say_what_was_lost(stream: DataStream, walk: UnsortedWalk, log: ImportLog) -> None:
    log.reject("record in which damage begins", walk.cut)
    damages, lost, behind = walk.damages, walk.lost, ""
    if walk.searching:
        end = walk.end(stream, walk.bad_at)
        rest = stream.size - walk.bad_at
        if walk.zeros:
            damages, lost = damages - 1, walk.lost_before
            say_zeros(log, end, rest)
        else:
            behind = f"; no records were found any more behind {end}"
    elif walk.limit < stream.size:
        say_zeros(log, walk.end(stream, walk.limit), stream.size - walk.limit)
    elif walk.tail.size and not damages:
        log.worsen("truncated", "the last record is not whole and was left out")
    if damages:
        log.reject("damaged place in the MF4 file's records", damages)
        log.worsen(
            "malformed",
            f"the records of the MF4 file are damaged in {damages} places: {lost} of {stream.size} bytes "
            f"of a data group were left out{behind}",
        )
    if walk.unsure:
        log.worsen(
            "malformed",
            "behind damage it is not certain which payloads belong to which CAN frames: those frames were left out",
        )
