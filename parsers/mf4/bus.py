"""CAN frames in MF4: the CAN_DataFrame structures of bus logging, in columns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from parsers.can.frames import EXTENDED, CanFrames
from parsers.channels import ByteArray, IntArray
from parsers.importer import ImportLog
from parsers.mf4.batch import Batch
from parsers.mf4.blocks import BlockFile
from parsers.mf4.clock import NO_TIME, find_master, times_ns
from parsers.mf4.conversions import convert, gives_text
from parsers.mf4.conversions import fault as rule_fault
from parsers.mf4.model import CG_VLSD, UNFINISHED_OFFSETS, VLSC, VLSD, Channel, DataGroup, Group, Measurement
from parsers.mf4.payload import Payload, fixed_payload, reference_fault, stream_payload, window_payload
from parsers.mf4.records import batches
from parsers.mf4.streams import DataStream, open_stream
from parsers.mf4.values import fault, raw_values

FRAME = "CAN_DataFrame"
MAX_WAITING = 1 << 20
"""Frames that may wait for payloads further on in the file."""
_REJECTED = {
    "CAN_RemoteFrame": "CAN remote frame",
    "CAN_ErrorFrame": "CAN error frame",
    "CAN_OverloadFrame": "CAN error frame",
}
_FD_LENGTH = np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64], np.int64)


@dataclass(frozen=True)
class BusLayout:
    """Which channels of a group make up its frames. rejected: the reason where the group holds no data frames."""

    group: Group
    master: Channel
    fields: dict[str, Channel]
    rejected: str = ""

    @property
    def by_reference(self) -> bool:
        """Whether the record holds only the place of the payload."""
        return self.fields["DataBytes"].kind == VLSD


def _structure(group: Group) -> tuple[str, str]:
    """The frame structure in a group: its name and its kind ("CAN_DataFrame"), empty where there is none."""
    for channel in group.channels:
        last = channel.name.rsplit(".", 1)[-1]
        if last in (FRAME, *_REJECTED):
            return channel.name, last
    for channel in group.channels:
        # structures are optional: the members' names say enough
        head = channel.name.rsplit(".", 1)[0]
        if head.rsplit(".", 1)[-1] in (FRAME, *_REJECTED):
            return head, head.rsplit(".", 1)[-1]
    return "", ""


def find_layout(group: Group, log: ImportLog) -> BusLayout | None:
    """How a group holds CAN frames; None where it holds none, or (said in the log book) not in a known way."""
    name, kind = _structure(group)
    if not name or group.flags & CG_VLSD:
        return None
    master = find_master(group)
    fields = {c.name[len(name) + 1 :]: c for c in group.channels if c.name.startswith(f"{name}.")}
    if master is None:
        if group.cycles:
            log.note(f"CAN frames of channel group {group.number} have no time and were left out")
        return None
    if kind in _REJECTED:
        return BusLayout(group, master, fields, _REJECTED[kind])
    usable = "ID" in fields and "DataBytes" in fields and fault(fields["ID"], group) is None
    if usable:
        data = fields["DataBytes"]
        # VLSC (4.3) keeps the payloads in a way of its own
        usable = data.kind != VLSC and data.byte_offset + data.byte_count <= group.invalid_at
        usable = usable and (data.kind != VLSD or reference_fault(data, group) is None)
    if not usable:
        log.note(
            f"CAN frames of channel group {group.number} are described in an unknown way and were left out"
        )
        return None
    return BusLayout(group, master, fields)


def _number(layout: BusLayout, name: str, batch: Batch, default: int) -> IntArray:
    """A field as whole numbers, converted; the default where the group does not have it."""
    channel = layout.fields.get(name)
    count = batch.rows.shape[0]
    if (
        channel is None
        or fault(channel, layout.group) is not None
        or rule_fault(channel.conversion) is not None
    ):
        return np.full(count, default, np.int64)
    raw = raw_values(batch.rows, channel, batch.first)
    if channel.conversion is None or gives_text(channel.conversion):
        return raw.astype(np.int64)
    value = convert(channel.conversion, raw.astype(np.float64), whole_numbers=True)
    return np.clip(np.nan_to_num(value), -(1 << 53), 1 << 53).astype(np.int64)


def _lengths(layout: BusLayout, batch: Batch) -> IntArray:
    """Payload bytes by DataLength, else by DLC, else as wide as the field."""
    if "DataLength" in layout.fields:
        return np.clip(_number(layout, "DataLength", batch, 64), 0, 64)
    if "DLC" in layout.fields:
        dlc = np.clip(_number(layout, "DLC", batch, 8), 0, 15)
        fd = _number(layout, "EDL", batch, 0) != 0
        return np.where(fd, _FD_LENGTH[dlc], np.minimum(dlc, 8))
    return np.full(batch.rows.shape[0], 64, np.int64)


def _identifiers(layout: BusLayout, batch: Batch) -> NDArray[np.uint32]:
    raw = raw_values(batch.rows, layout.fields["ID"], batch.first).astype(np.int64)
    extended = (_number(layout, "IDE", batch, 0) != 0) | (raw & EXTENDED != 0) | (raw & 0x1FFFFFFF > 0x7FF)
    return ((raw & 0x1FFFFFFF) | np.where(extended, EXTENDED, 0)).astype(np.uint32)


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
    waiting: dict[int, _GroupState] = field(default_factory=dict)
    streams: dict[int, DataStream] = field(default_factory=dict)

    def batches(self) -> Iterator[Batch]:
        """The records of all groups with frames."""
        stream = open_stream(self.file, self.data_group.data_link, self.measurement.unfinished, self.log)
        places = {group.at for group in self.data_group.groups}
        linked = {lay.fields["DataBytes"].data_link for lay in self.layouts.values() if not lay.rejected}
        wanted, windowed = frozenset(self.layouts), frozenset(linked & places)
        return batches(self.data_group, stream, wanted, windowed, self.measurement, self.log)

    def frames(self, batch: Batch) -> Iterator[CanFrames]:
        """The frames of a batch whose payloads are there."""
        layout = self.layouts[batch.group.number]
        if layout.rejected:
            self.counts[layout.rejected] += batch.rows.shape[0]
            return
        kept = self.waiting.pop(batch.group.number, None)
        if kept is not None:
            batch = Batch(
                batch.group, kept.first, np.concatenate([kept.rows, batch.rows]), batch.windows, batch.file_at
            )
        payload = self._payload(layout, batch)
        late = payload.late
        if kept is not None and kept.rows.shape[0] > MAX_WAITING:
            payload = replace(payload, good=payload.good & ~late, late=np.zeros_like(late))
            late = payload.late
        if late.any():
            # payloads come a little before or a little after the records that refer to them
            begin = int(np.argmax(late))
            self.waiting[batch.group.number] = _GroupState(batch.rows[begin:].copy(), batch.first + begin)
            batch = Batch(batch.group, batch.first, batch.rows[:begin], batch.windows, batch.file_at)
            payload = Payload(
                payload.data,
                payload.offset[:begin],
                payload.length[:begin],
                payload.good[:begin],
                late[:begin],
            )
        if batch.rows.shape[0]:
            yield self._made(layout, batch, payload)

    def _payload(self, layout: BusLayout, batch: Batch) -> Payload:
        channel, length = layout.fields["DataBytes"], _lengths(layout, batch)
        if not layout.by_reference:
            return fixed_payload(batch.rows, channel, length)
        window = batch.windows.get(channel.data_link)
        if window is not None:
            by_order = bool(self.measurement.unfinished & UNFINISHED_OFFSETS)
            return window_payload(batch, channel, length, window, by_order=by_order)
        link = channel.data_link
        if link not in self.streams:
            self.streams[link] = open_stream(self.file, link, self.measurement.unfinished, self.log)
        return stream_payload(batch, channel, length, self.streams[link])

    def _made(self, layout: BusLayout, batch: Batch, payload: Payload) -> CanFrames:
        time_ns = times_ns(batch.rows, layout.master, batch.first)
        bus = np.clip(_number(layout, "BusChannel", batch, 1), 0, 32767).astype(np.int16)
        good = payload.good & (time_ns != NO_TIME)
        self.counts["CAN frame without its payload"] += int(np.count_nonzero(~payload.good))
        self.counts["frame with an impossible time stamp"] += int(np.count_nonzero(payload.good & ~good))
        time_ns = np.where(good, time_ns, 0) + self.measurement.start_ns
        columns = (time_ns, _identifiers(layout, batch), bus, payload.length.astype(np.uint8), payload.offset)
        if not good.all():
            time_ns, ident, bus, length, offset = (column[good] for column in columns)
            return CanFrames(time_ns, ident, bus, length, offset, payload.data)
        return CanFrames(*columns, payload.data)

    def left_over(self) -> None:
        """Count what still waits at the end."""
        for state in self.waiting.values():
            self.counts["CAN frame without its payload"] += state.rows.shape[0]
        if self.waiting:
            self.log.worsen("truncated", "the payloads of the last CAN frames are missing")


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
        return "MF4 time channel"

    @property
    def absolute(self) -> bool:
        return self.measurement.start_ns > 0

    @property
    def start_utc_ns(self) -> int | None:
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
                reader = _DataGroupReader(file, data_group, mine, self.measurement, log, counts)
                for batch in reader.batches():
                    for frames in reader.frames(batch):
                        log.messages += frames.time_ns.size
                        yield frames
                    if counting:
                        self.progress(min(batch.file_at, file.size), file.size)
                reader.left_over()
            if counting:
                self.progress(file.size, file.size)
        for reason, count in counts.items():
            log.reject(reason, count)
