"""CAN frames in MF4: the CAN_DataFrame structures of bus logging, in columns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from parsers.can.frames import CanFrames
from parsers.channels import ByteArray
from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.mf4.batch import Batch
from parsers.mf4.blocks import BlockFile
from parsers.mf4.bus_columns import FrameColumns, FrameColumnsReader, columns_reader
from parsers.mf4.bus_layout import BusLayout
from parsers.mf4.clock import NO_TIME
from parsers.mf4.frame_room import FrameRoom
from parsers.mf4.gaps import Gaps
from parsers.mf4.model import UNFINISHED_OFFSETS, DataGroup, Measurement
from parsers.mf4.payload import Payload, stream_payload, window_payload
from parsers.mf4.records import batches
from parsers.mf4.runs import Runs, runs_of
from parsers.mf4.streams import DataStream, open_stream
from parsers.mf4.zeros import find_zeros, left_out
from parsers.parallel import in_order

MAX_WAITING = 1 << 20
"""Frames that may wait for payloads further on in the file."""
NO_PAYLOAD = "CAN frame without its payload"
NO_STAMP = "frame with an impossible time stamp"


@dataclass(frozen=True)
class _Work:
    """A batch, what reads its columns, and the runs that its bytes are still to be read of, if they are."""

    batch: Batch
    reader: FrameColumnsReader | None
    runs: Runs | None = None


@dataclass(frozen=True)
class _Read:
    """A batch that was read, its columns, or why it could not be. room: what they are in, to be given back to the runs."""

    batch: Batch
    columns: FrameColumns | LogError | None
    runs: Runs | None = None
    room: FrameRoom | None = None

    def done(self) -> None:
        """Nobody needs the columns any more."""
        if self.runs is not None and self.room is not None:
            self.runs.rooms.give(self.room)


@dataclass
class _GroupState:
    """What waits for payloads that come later in the file: rows, and the number of the first of them."""

    rows: ByteArray
    first: int


@dataclass
class _DataGroupReader:
    """Frames of one data group."""

    file: BlockFile
    data_group: DataGroup
    layouts: dict[int, BusLayout]
    measurement: Measurement
    log: ImportLog
    counts: Counter[str]
    gaps: Gaps
    waiting: dict[int, _GroupState] = field(default_factory=dict)
    streams: dict[int, DataStream] = field(default_factory=dict)
    readers: dict[int, FrameColumnsReader] = field(default_factory=dict)

    def stream(self) -> DataStream:
        """The records of all groups, as bytes."""
        return open_stream(self.file, self.data_group.data_link, self.measurement.unfinished, self.log)

    def batches(self, stream: DataStream) -> Iterator[Batch]:
        """The records of all groups with frames."""
        places = {group.at for group in self.data_group.groups}
        linked = {lay.fields["DataBytes"].data_link for lay in self.layouts.values() if not lay.rejected}
        wanted, windowed = frozenset(self.layouts), frozenset(linked & places)
        return batches(self.data_group, stream, wanted, windowed, self.measurement, self.log)

    def _reader(self, batch: Batch) -> FrameColumnsReader:
        number = batch.group.number
        if number not in self.readers:
            self.readers[number] = columns_reader(
                self.layouts[number], self.measurement.start_ns, self.measurement.dates
            )
        return self.readers[number]

    def work(self, stream: DataStream) -> Iterator[_Work]:
        """The batches, each with what reads its columns; None where they are read in turn, or not at all."""
        if not any(layout.rejected or layout.by_reference for layout in self.layouts.values()):
            runs = runs_of(self.data_group, stream, self.measurement, self.log)
            if runs is not None:
                for batch in runs.batches:
                    yield _Work(batch, self._reader(batch), runs)
                return
        for batch in self.batches(stream):
            layout = self.layouts[batch.group.number]
            yield _Work(batch, None if layout.rejected or layout.by_reference else self._reader(batch))

    def frames(self, batch: Batch, columns: FrameColumns | None) -> Iterator[CanFrames]:
        """The frames of a batch whose payloads are there. columns: as its reader gave them."""
        layout = self.layouts[batch.group.number]
        if layout.rejected:
            self.counts[layout.rejected] += batch.count
        elif columns is None:
            yield from self._referring(layout, batch)
        else:
            blank = self._zeros(batch, columns)
            if blank is not None:
                left_out(self.log, int(np.count_nonzero(blank)))
                columns = columns.rows(~blank)
            if columns.timeless:
                self.counts[NO_STAMP] += columns.timeless
                columns = columns.rows(columns.time_ns != NO_TIME)
            yield CanFrames(
                columns.time_ns, columns.can_id, columns.bus, columns.length, columns.offset, batch.data
            )

    def _zeros(self, batch: Batch, columns: FrameColumns) -> NDArray[np.bool_] | None:
        """Which records are what is left of a lost block of the file; the gaps are told of all of them."""
        blank = find_zeros(batch, columns.time_ns, self._reader(batch).stamps.zero_ns)
        time_ns = columns.time_ns if blank is None else np.where(blank, NO_TIME, columns.time_ns)
        holes = blank is not None or columns.timeless > 0
        self.gaps.see(batch.group.number, batch.first, time_ns, holes=holes)
        return blank

    def _referring(self, layout: BusLayout, batch: Batch) -> Iterator[CanFrames]:
        """Frames whose records hold the places of their payloads."""
        kept = self.waiting.pop(batch.group.number, None)
        if kept is not None:
            rows = np.concatenate([kept.rows, batch.rows])
            count, stride = rows.shape
            batch = replace(
                batch, first=kept.first, data=rows.reshape(-1), count=count, stride=stride, skip=0
            )
        columns = self._reader(batch).read(batch)
        blank = self._zeros(batch, columns)
        payload = self._payload(layout, batch, columns)
        if kept is not None and kept.rows.shape[0] > MAX_WAITING:
            payload = replace(payload, good=payload.good & ~payload.late, late=np.zeros_like(payload.late))
        if payload.late.any():
            # payloads come a little before or a little after the records that refer to them
            begin = int(np.argmax(payload.late))
            self.waiting[batch.group.number] = _GroupState(batch.rows[begin:].copy(), batch.first + begin)
            columns, payload = columns.rows(slice(0, begin)), payload.rows(slice(0, begin))
            blank = None if blank is None else blank[:begin]
        window = batch.windows.get(layout.fields["DataBytes"].data_link)
        if window is not None and window.lost:
            self.gaps.without_payload(columns.time_ns[~payload.good])
        if blank is not None and blank.any():
            left_out(self.log, int(np.count_nonzero(blank)))
            columns, payload = columns.rows(~blank), payload.rows(~blank)
        if columns.time_ns.size:
            yield self._made(columns, payload)

    def _payload(self, layout: BusLayout, batch: Batch, columns: FrameColumns) -> Payload:
        channel, length = layout.fields["DataBytes"], columns.length.astype(np.int64)
        window = batch.windows.get(channel.data_link)
        if window is not None:
            by_order = bool(self.measurement.unfinished & UNFINISHED_OFFSETS)
            return window_payload(batch, channel, length, window, by_order=by_order)
        link = channel.data_link
        if link not in self.streams:
            self.streams[link] = open_stream(self.file, link, self.measurement.unfinished, self.log)
        return stream_payload(batch, channel, length, self.streams[link])

    def _made(self, columns: FrameColumns, payload: Payload) -> CanFrames:
        good = payload.good & (columns.time_ns != NO_TIME)
        there = int(np.count_nonzero(payload.good))
        self.counts[NO_PAYLOAD] += good.size - there
        self.counts[NO_STAMP] += there - int(np.count_nonzero(good))
        length, offset = payload.length.astype(np.uint8), payload.offset
        if not good.all():
            columns, length, offset = columns.rows(good), length[good], offset[good]
        return CanFrames(columns.time_ns, columns.can_id, columns.bus, length, offset, payload.data)

    def left_over(self) -> None:
        """Count what still waits at the end."""
        for state in self.waiting.values():
            self.counts[NO_PAYLOAD] += state.rows.shape[0]
        if self.waiting:
            self.log.worsen("truncated", "the payloads of the last CAN frames are missing")


def _read(work: _Work) -> list[_Read]:
    """A batch with its bytes and columns; where it cannot be read, block by block."""
    if work.runs is None or work.reader is None:
        return [_Read(work.batch, None if work.reader is None else work.reader.read(work.batch))]
    room = work.runs.rooms.take()
    try:
        batch = work.runs.read(work.batch, room)
    except LogError:
        work.runs.rooms.give(room)
        return [_block(part, work.runs, work.reader) for part in work.runs.apart(work.batch)]
    return [_Read(batch, work.reader.read(batch, room), work.runs, room)]


def _block(batch: Batch, runs: Runs, reader: FrameColumnsReader) -> _Read:
    try:
        batch = runs.read(batch, None)
    except LogError as error:
        return _Read(batch, error)
    return _Read(batch, reader.read(batch))


@dataclass(frozen=True)
class Mf4Frames:
    """The CAN frames of an MF4 file. See `parsers.can.frames.FrameSource`."""

    path: Path
    measurement: Measurement
    layouts: dict[int, BusLayout]
    log: ImportLog
    progress: Callable[[int, int], None]

    @property
    def clock(self) -> str:
        """The recorder's own."""
        return "MF4 time channel"

    @property
    def absolute(self) -> bool:
        """Whether the file says when it began."""
        return self.measurement.start_ns > 0

    @property
    def start_utc_ns(self) -> int | None:
        """None: absolute stamps say it themselves, and of others the file does not know it."""
        return None

    def frames(self, *, counting: bool) -> Iterator[CanFrames]:
        """All data frames: data group by data group, within them in batches of one channel group."""
        log = self.log if counting else ImportLog()
        counts: Counter[str] = Counter()
        with BlockFile(self.path) as file:
            file.seen = list(self.measurement.places)
            for data_group in self.measurement.data_groups:
                mine = {
                    g.number: self.layouts[g.number] for g in data_group.groups if g.number in self.layouts
                }
                if not mine:
                    continue
                reader = _DataGroupReader(file, data_group, mine, self.measurement, log, counts, Gaps(log))
                yield from self._of_group(reader, reader.stream(), counting)
            if counting:
                self.progress(file.size, file.size)
        for reason, count in counts.items():
            log.reject(reason, count)

    def _of_group(
        self, reader: _DataGroupReader, stream: DataStream, counting: bool
    ) -> Generator[CanFrames, None, None]:
        """The frames of one data group."""
        size = reader.file.size
        for some in in_order(_read, reader.work(stream)):
            for read in some:
                if isinstance(read.columns, LogError):
                    stream.left_out(read.batch.file_at, read.columns)
                    continue
                for frames in reader.frames(read.batch, read.columns):
                    reader.log.messages += frames.time_ns.size
                    yield frames
                read.done()
                if counting:
                    self.progress(min(read.batch.file_at, size), size)
        reader.left_over()
