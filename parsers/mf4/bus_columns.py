"""The columns of a batch of CAN frames: by a compiled kernel where all fields are plain, else column by column."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parsers.can.frames import EXTENDED
from parsers.channels import IntArray
from parsers.mf4 import frame_kernel as k
from parsers.mf4.batch import Batch
from parsers.mf4.bus_layout import BusLayout
from parsers.mf4.clock import NO_TIME
from parsers.mf4.conversions import LINEAR, convert, gives_text, only_names
from parsers.mf4.frame_room import FrameRoom
from parsers.mf4.model import Channel
from parsers.mf4.stamps import StampReader, stamp_reader
from parsers.mf4.values import UINT_LE, Raw, is_virtual, raw_values
from parsers.mf4.words import word_of

MOST_BYTES = 64
CODES = np.array([0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64], np.int64)
"""Payload bytes of the length codes of FD frames."""
IDE, BUS, FD = ("IDE", 0), "BusChannel", ("EDL", 0)
"""Fields, and what they are where a group does not have them (the bus: as the layout says)."""
BITS = 32
"""The widest identifier that the kernel takes."""


@dataclass(frozen=True)
class FrameColumns:
    """As in `CanFrames`, but time_ns is NO_TIME for the `timeless` frames, and payloads by reference have no offset."""

    time_ns: IntArray
    can_id: NDArray[np.uint32]
    bus: NDArray[np.int16]
    length: NDArray[np.uint8]
    offset: IntArray
    timeless: int

    def rows(self, choice: slice | NDArray[np.bool_]) -> FrameColumns:
        """Some of the frames."""
        time_ns = self.time_ns[choice]
        columns = (self.can_id[choice], self.bus[choice], self.length[choice], self.offset[choice])
        return FrameColumns(time_ns, *columns, int(np.count_nonzero(time_ns == NO_TIME)))


@dataclass(frozen=True)
class _Plan:
    """What the kernel needs to know: see `parsers.mf4.frame_kernel`."""

    fields: IntArray
    tables: IntArray


@dataclass(frozen=True)
class FrameColumnsReader:
    """Reads the columns of one group's frames. plan: None where the kernel cannot."""

    layout: BusLayout
    stamps: StampReader
    plan: _Plan | None

    def read(self, batch: Batch, room: FrameRoom | None = None) -> FrameColumns:
        """The columns of all records of a batch. room: memory that they may be put into."""
        time_ns, timeless = self.stamps.read(batch, None if room is None else room.time_ns)
        if self.plan is None:
            return FrameColumns(time_ns, *_by_column(self.layout, batch), timeless)
        n, payload = batch.count, self.layout.fields["DataBytes"].byte_offset
        if room is None:
            room = FrameRoom.of(0, n)
        columns = (room.can_id[:n], room.bus[:n], room.length[:n], room.offset[:n])
        fields, tables = self.plan.fields, self.plan.tables
        k.read_fields(batch.data, batch.stride, batch.skip, payload, fields, tables, *columns)
        return FrameColumns(time_ns, *columns, timeless)


def columns_reader(
    layout: BusLayout, start_ns: int, dates: dict[int, bool] | None = None, *, compiled: bool = True
) -> FrameColumnsReader:
    """The reader of a group's frames. start_ns, dates: of the measurement. compiled: False to take the slower way anyway."""
    stamps = stamp_reader(layout.master, layout.group, start_ns, dates, compiled=compiled)
    return FrameColumnsReader(layout, stamps, _plan(layout) if compiled else None)


def _plan(layout: BusLayout) -> _Plan | None:
    """How the kernel reads the group; None where a field is not plain, or has more values than a table."""
    fields, tables = np.zeros((k.FIELDS, 3), np.int64), np.zeros((k.TABLES, k.TABLE), np.int64)
    word = word_of(layout.fields["ID"], layout.group, UINT_LE)
    if word is None or word.bits > BITS:
        return None
    fields[k.ID] = word.at, word.shift, word.mask
    raw = np.arange(k.TABLE, dtype=np.int64)
    size = _size_field(layout)
    for which, (name, default) in ((k.IDE, IDE), (k.BUS, (BUS, layout.bus)), (k.FD, FD), (k.LENGTH, size)):
        channel = layout.fields.get(name)
        if not layout.readable(name):
            tables[which] = default
        elif channel is not None and is_virtual(channel):
            rule = channel.conversion
            if rule is None or rule.kind != LINEAR or rule.values[1] != 0:
                return None
            tables[which] = _converted(channel, raw)
        elif channel is not None:
            word = word_of(channel, layout.group, UINT_LE)
            if word is None or word.bits > 8:
                return None
            fields[which] = word.at, word.shift, word.mask
            tables[which] = _converted(channel, raw)
    tables[k.FD_LENGTH] = _sizes(layout, tables[k.LENGTH], np.ones(k.TABLE, np.bool_))
    tables[k.LENGTH] = _sizes(layout, tables[k.LENGTH], np.zeros(k.TABLE, np.bool_))
    tables[k.BUS] = np.clip(tables[k.BUS], 0, 32767)
    return _Plan(fields, tables)


def _size_field(layout: BusLayout) -> tuple[str, int]:
    """The field with the payload's length, and what it is where there is none."""
    by_code = "DataLength" not in layout.fields and "DLC" in layout.fields
    return ("DLC", 8) if by_code else ("DataLength", MOST_BYTES)


def _sizes(layout: BusLayout, raw: IntArray, fd: NDArray[np.bool_]) -> IntArray:
    """Payload bytes of lengths or length codes; at most as wide as the field is."""
    if _size_field(layout)[0] == "DLC":
        code = np.clip(raw, 0, 15)
        raw = np.where(fd, CODES[code], np.minimum(code, 8))
    widest = MOST_BYTES if layout.by_reference else min(layout.fields["DataBytes"].byte_count, MOST_BYTES)
    return np.clip(raw, 0, widest)


def _converted(channel: Channel, raw: Raw) -> IntArray:
    """A field's values as whole numbers."""
    rule = channel.conversion
    if rule is None or only_names(rule) or gives_text(rule):
        return raw.astype(np.int64)
    value = convert(rule, raw.astype(np.float64), whole_numbers=True)
    return np.clip(np.nan_to_num(value), -(1 << 53), 1 << 53).astype(np.int64)


def _number(layout: BusLayout, field: tuple[str, int], batch: Batch) -> IntArray:
    """A field (name, default) of a batch as whole numbers, the default where the group does not have it."""
    channel = layout.fields.get(field[0])
    if channel is None or not layout.readable(field[0]):
        return np.full(batch.count, field[1], np.int64)
    return _converted(channel, raw_values(batch.rows, channel, batch.first))


def _identifiers(layout: BusLayout, batch: Batch) -> NDArray[np.uint32]:
    raw = raw_values(batch.rows, layout.fields["ID"], batch.first).astype(np.int64)
    extended = (_number(layout, IDE, batch) != 0) | (raw & EXTENDED != 0) | (raw & 0x1FFFFFFF > 0x7FF)
    return ((raw & 0x1FFFFFFF) | np.where(extended, EXTENDED, 0)).astype(np.uint32)


def _by_column(
    layout: BusLayout, batch: Batch
) -> tuple[NDArray[np.uint32], NDArray[np.int16], NDArray[np.uint8], IntArray]:
    """The same as the kernel, for fields of any kind: id, bus, length and offset."""
    size = _number(layout, _size_field(layout), batch)
    begin = batch.skip + layout.fields["DataBytes"].byte_offset
    return (
        _identifiers(layout, batch),
        np.clip(_number(layout, (BUS, layout.bus), batch), 0, 32767).astype(np.int16),
        _sizes(layout, size, _number(layout, FD, batch) != 0).astype(np.uint8),
        np.arange(batch.count, dtype=np.int64) * batch.stride + begin,
    )
