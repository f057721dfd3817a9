"""The reader over a whole MF4 file: frames through the CAN decoder, measured channels directly."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from parsers.can.reader import CanReader
from parsers.channels import ChannelInfo, Chunk
from parsers.errors import LogError
from parsers.importer import TAKEN_AS_UTC, ImportLog, LogReader, ReadOptions
from parsers.mf4.blocks import BlockFile
from parsers.mf4.bus import Mf4Frames
from parsers.mf4.bus_layout import BusLayout, find_layout
from parsers.mf4.bus_sources import tell_buses_apart
from parsers.mf4.measured import MeasuredReader, list_columns
from parsers.mf4.model import Measurement
from parsers.mf4.tree import read_measurement


class Mf4Reader:
    """A `LogReader` over an MF4 file; `frames` is None where it holds no bus logging."""

    def __init__(
        self, measured: MeasuredReader, frames: Mf4Frames | None, can: LogReader | None, log: ImportLog
    ) -> None:
        self._measured, self._can, self._log = measured, can, log
        self.frames = frames
        known = can.channels if can is not None else ()
        self._channels = known + tuple(column.info for column in measured.columns)

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """Decoded signals first, then measured channels."""
        return self._channels

    @property
    def clock(self) -> str:
        """The recorder's own."""
        return "MF4 time channel"

    @property
    def absolute(self) -> bool:
        """Whether the file says when it began, or its stamps do: those are known once they were read."""
        measurement = self._measured.measurement
        return measurement.start_ns > 0 or any(measurement.dates.values())

    @property
    def start_utc_ns(self) -> int | None:
        """None: absolute stamps say it themselves, and of others the file does not know it."""
        return None

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Chunks of decoded frames, then of measured channels; what has no wanted channel is not read."""
        decoded = frozenset(c.name for c in self._can.channels) if self._can is not None else frozenset()
        if self._can is not None and not wanted.isdisjoint(decoded):
            yield from self._can.read(wanted & decoded)
        rest = wanted - decoded
        if rest:
            yield from self._measured.read(rest)
        _say_clock(self._measured.measurement, self._log)


def _layouts(measurement: Measurement, log: ImportLog) -> dict[int, BusLayout]:
    found = {}
    for data_group in measurement.data_groups:
        for group in data_group.groups:
            layout = find_layout(group, log)
            if layout is not None:
                found[group.number] = layout
    return tell_buses_apart(found, log)


def _say_what_it_is(measurement: Measurement, log: ImportLog) -> None:
    """Notes on an unfinished recording and on databases inside the file."""
    if measurement.unfinished:
        log.note("the recorder did not finish this MF4 file; its data were read to their end")
    databases = [
        name for name in measurement.attachments if name.lower().endswith((".dbc", ".arxml", ".xml"))
    ]
    if databases:
        log.note(f"the MF4 file carries {', '.join(databases)}; give the database with --dbc to use it")


def _say_clock(measurement: Measurement, log: ImportLog) -> None:
    """Notes on what the stamps count from, once they were read: a group's own dates need no start of the file."""
    dated = sum(measurement.dates.values())
    if dated:
        some = (
            ""
            if dated == len(measurement.dates)
            else f" of {dated} of {len(measurement.dates)} channel groups"
        )
        log.note(
            f"the MF4 file's time channels{some} count from 1970: taken as dates in UTC, and the file's start not added to them"
        )
    if dated and dated == len(measurement.dates):
        return
    if not measurement.start_ns:
        log.note("the MF4 file has no start time: its clock counts from the start of the recording")
    elif measurement.local:
        log.without_zone(f"the MF4 file's start time is local time without a zone: it is {TAKEN_AS_UTC}")


def open_mf4(path: Path, options: ReadOptions, log: ImportLog) -> Mf4Reader:
    """Open an MF4 file. Raises LogError where its descriptions cannot be read."""
    with BlockFile(path) as file:
        measurement = read_measurement(file, log)
    damage = log.notes[-1] if log.notes and log.status != "complete" else "the MF4 file holds no data groups"
    _say_what_it_is(measurement, log)
    layouts = _layouts(measurement, log)
    if not measurement.data_groups:
        raise LogError(
            damage,
            path=path,
            place="byte 64",
            hint="check that the recording was copied whole",
        )
    frames = can = None
    if any(not layout.rejected for layout in layouts.values()):
        frames = Mf4Frames(path, measurement, layouts, log, options.progress)
        can = CanReader(frames, options, log, path)
    decoded = frozenset(channel.name for channel in can.channels) if can is not None else frozenset[str]()
    columns = list_columns(measurement, log, decoded)
    told = frozenset(
        data_group.data_link
        for data_group in measurement.data_groups
        if can is not None and any(group.number in layouts for group in data_group.groups)
    )
    measured = MeasuredReader(path, measurement, columns, log, options.progress, told)
    return Mf4Reader(measured, frames, can, log)
