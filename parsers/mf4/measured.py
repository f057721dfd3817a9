"""The measured channels of an MF4 file: which there are, under which names, and their values in columns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from parsers.channels import ChannelInfo, Chunk
from parsers.importer import ImportLog
from parsers.mf4 import conversions, values
from parsers.mf4.batch import Batch
from parsers.mf4.blocks import BlockFile
from parsers.mf4.clock import NO_TIME, find_master
from parsers.mf4.columns import ColumnReader, column_reader
from parsers.mf4.gaps import Gaps
from parsers.mf4.model import (
    CG_BUS,
    CG_REMOTE_MASTER,
    CG_VLSD,
    CN_BUS,
    MASTER,
    VIRTUAL_MASTER,
    Channel,
    DataGroup,
    Group,
    Measurement,
)
from parsers.mf4.records import batches
from parsers.mf4.remote import RemoteTime, remote_time
from parsers.mf4.stamps import StampReader, stamp_reader
from parsers.mf4.streams import open_stream
from parsers.mf4.zeros import find_zeros, left_out

_BUS_STRUCTURES = ("CAN_", "LIN_", "FLX_", "MOST_", "ETH_", "USB_", "K_", "PDU_")


@dataclass(frozen=True)
class Column:
    """A channel with its name in the log and the group that it is in."""

    info: ChannelInfo
    channel: Channel
    group: Group


def _of_bus(channel: Channel) -> bool:
    """Whether a channel is a piece of a bus event's structure ("CAN_DataFrame.ID"): by its flag or its name."""
    return bool(channel.flags & CN_BUS) or any(
        part.startswith(_BUS_STRUCTURES) and "Frame" in part for part in channel.name.split(".")
    )


def _unreadable(channel: Channel, group: Group) -> str | None:
    """Why a number channel cannot be read, None where it can."""
    if not channel.whole:
        return "an array or a structure"
    return values.fault(channel, group) or conversions.fault(channel.conversion)


def _is_text(channel: Channel) -> bool:
    return channel.whole and (6 <= channel.data_type <= 14 or conversions.gives_text(channel.conversion))


def group_label(group: Group) -> str:
    """A name for a group's time vector, unique in the file."""
    return f"group {group.number}" + (f" ({group.name})" if group.name else "")


def _candidates(group: Group, log: ImportLog) -> Iterator[Channel]:
    """The channels of a group that are listed; says what is left out."""
    left_out: Counter[str] = Counter()
    for channel in group.channels:
        if channel.kind in (MASTER, VIRTUAL_MASTER) or _of_bus(channel) or not channel.name:
            continue
        why = None if _is_text(channel) else _unreadable(channel, group)
        if why is None:
            yield channel
        elif channel.whole or not any(c.name.startswith(f"{channel.name}.") for c in group.channels):
            left_out[why] += 1
            if left_out[why] == 1:
                log.note(f"channel {channel.name!r} was left out: {why}")
    for why, count in left_out.items():
        if count > 1:
            log.note(f"{count - 1} more channels of {group_label(group)} were left out: {why}")


def _info(channel: Channel, name: str, group: Group, count: int | None) -> ChannelInfo:
    return ChannelInfo(
        name,
        group_label(group),
        channel.unit or None,
        "mdf",
        "text" if _is_text(channel) else "number",
        count,
        channel.comment,
        {"column": channel.name},
    )


def _listed(measurement: Measurement, log: ImportLog) -> Iterator[tuple[DataGroup, Group, list[Channel]]]:
    """The groups with measured channels and a time; says which others there are."""
    pairs = [(data_group, group) for data_group in measurement.data_groups for group in data_group.groups]
    masters = {group.at for _, group in pairs if find_master(group) is not None}
    events = 0
    for data_group, group in pairs:
        if group.flags & CG_VLSD:
            continue
        channels = list(_candidates(group, log))
        remote = group.flags & CG_REMOTE_MASTER and group.master_link in masters
        if not channels:
            named_can = any("CAN_" in channel.name for channel in group.channels)
            events += bool(group.flags & CG_BUS and group.cycles and not named_can)
        elif find_master(group) is not None or remote:
            yield data_group, group, channels
        else:
            log.note(f"{group_label(group)} has no time channel: its {len(channels)} channels were left out")
    if events:
        log.note(f"{events} channel groups hold bus events that are no CAN frames and were left out")


def list_columns(
    measurement: Measurement, log: ImportLog, decoded: frozenset[str] = frozenset()
) -> tuple[Column, ...]:
    """All measured channels. A name met again becomes "name@group<number>"; the first keeps it plain.

    decoded: names that decoded frames have taken already.
    """
    taken: set[str] = set(decoded)
    repeated: list[str] = []
    columns: list[Column] = []
    for data_group, group, channels in _listed(measurement, log):
        count = group.cycles if len(data_group.groups) == 1 and group.cycles else None
        for channel in channels:
            name = channel.name
            if name in taken:
                name = f"{channel.name}@group{group.number}"
                repeated.append(name)
            while name in taken:
                name += "'"
            taken.add(name)
            columns.append(Column(_info(channel, name, group, count), channel, group))
    if repeated:
        log.note(
            f"{len(repeated)} channel names occur in several groups: the first keeps its name, "
            f"the others are listed as {repeated[0]!r} and so on"
        )
    return tuple(columns)


@dataclass(frozen=True)
class _GroupReader:
    """What reads a group's values and stamps; the stamps may be in another group."""

    columns: ColumnReader
    stamps: StampReader | None
    remote: RemoteTime | None


@dataclass(frozen=True)
class MeasuredReader:
    """Reads the values of measured channels, one group of one batch at a time.

    told: data groups (their data links) whose damage is in the log book already, since frames were read from them.
    _counted: channels of which is counted what was left out, so that a second reading does not count it again.
    """

    path: Path
    measurement: Measurement
    columns: tuple[Column, ...]
    log: ImportLog
    progress: Callable[[int, int], None]
    told: frozenset[int] = frozenset()
    _counted: set[str] = field(default_factory=set)

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Chunks with the wanted columns; data groups without one are not read."""
        by_group: dict[int, list[Column]] = {}
        for column in self.columns:
            if column.info.name in wanted and column.info.kind == "number":
                by_group.setdefault(column.group.number, []).append(column)
        with BlockFile(self.path) as file:
            file.seen = list(self.measurement.places)
            for data_group in self.measurement.data_groups:
                yield from self._read_group(file, data_group, by_group)
            self.progress(file.size, file.size)
        self._counted.update(column.info.name for columns in by_group.values() for column in columns)

    def _read_group(
        self, file: BlockFile, data_group: DataGroup, by_group: dict[int, list[Column]]
    ) -> Iterator[Chunk]:
        mine = frozenset(g.number for g in data_group.groups if g.number in by_group)
        if not mine:
            return
        log = ImportLog() if data_group.data_link in self.told else self.log
        stream = open_stream(file, data_group.data_link, self.measurement.unfinished, log)
        readers = {
            group.number: self._group_reader(file, group, by_group[group.number])
            for group in data_group.groups
            if group.number in mine
        }
        gaps = Gaps(log)
        for batch in batches(data_group, stream, mine, frozenset(), self.measurement, log):
            chunk = self._chunk(batch, readers[batch.group.number], gaps)
            if chunk is not None:
                self.log.messages += chunk.time_ns.size
                yield chunk
            self.progress(min(batch.file_at, file.size), file.size)

    def _group_reader(self, file: BlockFile, group: Group, columns: list[Column]) -> _GroupReader:
        master, remote = find_master(group), None
        if group.flags & CG_REMOTE_MASTER:
            remote = remote_time(file, self.measurement, group, self.log)
        stamps = None
        if remote is None and master is not None:
            stamps = stamp_reader(master, group, self.measurement.start_ns, self.measurement.dates)
        channels = {column.info.name: column.channel for column in columns}
        return _GroupReader(column_reader(channels, group), stamps, remote)

    def _chunk(self, batch: Batch, reader: _GroupReader, gaps: Gaps) -> Chunk | None:
        blank = None
        if reader.remote is not None:
            batch, time_ns, timeless = reader.remote.times(batch)
        elif reader.stamps is not None:
            time_ns, timeless = reader.stamps.read(batch)
            blank = find_zeros(batch, time_ns, reader.stamps.zero_ns)
        else:
            return None
        if blank is not None:
            left_out(gaps.log, int(np.count_nonzero(blank)))
            timeless = int(np.count_nonzero(~blank & (time_ns == NO_TIME)))
            time_ns = np.where(blank, NO_TIME, time_ns)
        gaps.see(batch.group.number, batch.first, time_ns, holes=timeless > 0 or blank is not None)
        read = reader.columns.read(batch)
        decoded = read.values
        for name, reason, where in read.left_out:
            if name not in self._counted:
                # records without a time are counted as such
                lost = where & (time_ns != NO_TIME) if timeless or blank is not None else where
                self.log.reject(f"{name}: {reason}", int(np.count_nonzero(lost)))
        if timeless:
            self.log.reject("record with an impossible time stamp", timeless)
        if timeless or blank is not None:
            good = time_ns != NO_TIME
            time_ns = time_ns[good]
            decoded = {name: column[good] for name, column in decoded.items()}
        return Chunk(group_label(batch.group), time_ns, decoded) if time_ns.size else None
