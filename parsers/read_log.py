"""One log file to signals: recognise, open, map, read, and order in time. `parsers.load` makes a drive of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from parsers.axle_sums import HeldRows, with_axle_sums
from parsers.bound_signals import is_stated, make_signal, mapped_channel
from parsers.channels import ChannelInfo, Chunk, IntArray
from parsers.drive import MappedChannel, Signal
from parsers.errors import LogError, MappingError
from parsers.importer import ImportLog, LogReader
from parsers.intake import Intake, LogRows
from parsers.mapping import Binding, missing_channels, needed_channels, propose_all
from parsers.opened_log import LoadOptions, OpenedLog, open_log, read_chunks
from parsers.other_units import Spare, spare_of
from parsers.timebase import LATEST_NS, usual_period_s
from parsers.velocity_frames import with_frames

MOST_MISSING = 3
"""Channels of a mapping file that a log lacks which are named one by one."""


BEYOND_JUMP = "row beyond a jump of the clock"
MUCH = 0.05
"""Share of a log's rows beyond jumps of its clock from which on it is no whole log."""


@dataclass(frozen=True)
class _ReadOut:
    """What is still to be known of a reader when its log was read."""

    channels: tuple[ChannelInfo, ...]
    clock: str
    absolute: bool
    start_utc_ns: int | None

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Nothing: a log is read once."""
        return iter(())


def _read_out(reader: LogReader) -> _ReadOut:
    return _ReadOut(reader.channels, reader.clock, reader.absolute, reader.start_utc_ns)


@dataclass(frozen=True)
class Taken:
    """A log that was read: what its channels may become (signal -> bindings, best first), and its rows."""

    opened: OpenedLog
    proposals: Mapping[str, tuple[Binding, ...]]
    rows: LogRows

    @property
    def infos(self) -> dict[str, ChannelInfo]:
        """The log's channels by name."""
        return {info.name: info for info in self.opened.reader.channels}


@dataclass(frozen=True)
class PartFacts:
    """What the record needs to know of one log.

    stated: signal -> whether its unit is known, not assumed. taken: signal -> factor to SI of the unit that it was taken in.
    short: signals whose channel has too few valid samples. spares: of inertial signals the next candidates, of other rows.
    """

    opened: OpenedLog
    mapped: tuple[MappedChannel, ...]
    stated: Mapping[str, bool]
    taken: Mapping[str, float]
    short: tuple[str, ...]
    spares: Mapping[str, Spare[Any]]
    out_of_order: int
    duplicates: int
    jumps: int


@dataclass(frozen=True)
class Part(PartFacts):
    """One log, read: its signals, before the physics checks."""

    signals: Mapping[str, Signal]


def _possible(time_ns: IntArray) -> slice | IntArray:
    """The rows whose stamps a clock can show."""
    if len(time_ns) == 0 or (time_ns.min() >= -LATEST_NS and time_ns.max() <= LATEST_NS):
        return slice(None)
    return np.flatnonzero((time_ns >= -LATEST_NS) & (time_ns <= LATEST_NS))


def _take_rows(opened: OpenedLog, wanted: frozenset[str], rows: LogRows) -> None:
    """Read the wanted channels, chunk by chunk."""
    for chunk in read_chunks(opened, wanted):
        possible = _possible(chunk.time_ns)
        time_ns = chunk.time_ns[possible]
        opened.log.reject("row whose time stamp is impossible", len(chunk.time_ns) - len(time_ns))
        columns = {name: values[possible] for name, values in chunk.columns.items()}
        rows.add(chunk.group, time_ns, columns, own=chunk.own)


def _propose(opened: OpenedLog, options: LoadOptions) -> Mapping[str, tuple[Binding, ...]]:
    # a log of which nothing can be read lacks every channel, which is not the map's doing
    if options.map is not None and not options.map.strict and opened.reader.channels:
        sentences = missing_channels(opened.reader.channels, options.map)
        for sentence in sentences[:MOST_MISSING]:
            opened.log.note(sentence)
        if len(sentences) > MOST_MISSING:
            opened.log.note(
                f"{options.map.path.name} maps {len(sentences) - MOST_MISSING} more channels that are not in this log: is it for another one?"
            )
    try:
        found = propose_all(opened.reader.channels, options.map, options.radius)
    except MappingError as error:
        # a channel may be missing because the log is damaged: then the map is not what is to be looked at first
        if not opened.log.notes:
            raise
        hint = "; ".join(filter(None, [error.hint, "of the log is said: " + "; ".join(opened.log.notes[:3])]))
        raise MappingError(error.problem, path=error.path, place=error.place, hint=hint) from error
    for sentence in (*found.said, *found.unknown):
        opened.log.note(sentence)
    return found.bindings


def take_in(path: Path, options: LoadOptions, intake: Intake) -> Taken:
    """Read one log's rows. Raises LogError, MappingError, DatabaseError."""

    def progress(done: int, total: int) -> None:
        options.progress(f"reading {path.name}", done / total if total else 0.0)

    opened = open_log(path, options, progress)
    proposals = _propose(opened, options)
    wanted = frozenset(name for bindings in proposals.values() for name in needed_channels(bindings))
    rows = intake.begin(opened.reader.channels, wanted)
    if wanted:
        said = len(opened.log.notes)
        _take_rows(opened, wanted, rows)
        if opened.log.messages == 0:
            # what the reading found is the reason; what was said of the channels before comes behind it
            notes = (*opened.log.notes[said:], *opened.log.notes[:said])
            raise LogError(
                f"holds no readable data ({opened.importer.title})",
                path=path,
                hint="; ".join(notes) or "check that the recording was copied whole",
            )
    # what a reader keeps of its log (frames, an index) must not stay in memory for the rest of the work
    return Taken(replace(opened, reader=_read_out(opened.reader)), proposals, rows)


def leave_out_beyond_jumps(log: ImportLog, lost: int) -> None:
    """Write down the rows that are not used since the clock was set, or started again with another drive."""
    log.reject(BEYOND_JUMP, lost)
    rows = max(log.messages, lost)
    if lost > MUCH * rows:
        log.worsen(
            "malformed",
            f"the clock is set or starts again within the log: its longest stretch is read, and {lost} of {rows} rows "
            f"({lost / rows:.0%}) beyond it are left out; split the log there for what they hold",
        )


def unheard(signal: Signal) -> None:
    """Nobody waits for the signals one by one."""


def make_part(taken: Taken, made: Callable[[Signal], None] = unheard) -> Part:
    """The signals of a log whose rows were kept in memory; the rows are given up. made: called with each as it is made."""
    groups, infos = taken.rows.groups(), taken.infos
    ordered = [group.ordered for group in groups.values()]
    held = HeldRows(groups)
    framed = with_frames(taken.proposals, infos, held, taken.opened.log)
    summed = with_axle_sums(framed, infos, held, taken.opened.log)
    taken = replace(taken, proposals=summed)
    leave_out_beyond_jumps(taken.opened.log, sum(each.lost for each in ordered))
    # signals of one table share their stamps: how often they come is worked out once
    periods = {id(group.time_ns): usual_period_s(group.time_ns) for group in groups.values()}
    uses = Counter(name for each in taken.proposals.values() for binding in each for name in binding.needed)
    signals: dict[str, Signal] = {}
    mapped: list[MappedChannel] = []
    stated: dict[str, bool] = {}
    units: dict[str, float] = {}
    spares: dict[str, Spare[Signal]] = {}
    group = {name: info.group for name, info in infos.items()}
    for name, bindings in taken.proposals.items():
        for binding in bindings:
            once = uses[binding.channels[0]] == 1
            signal = make_signal(binding, groups, infos, taken.opened.log, last=once)
            if signal is not None:
                time_ns = signal.time_ns
                period = periods[id(time_ns)] if id(time_ns) in periods else usual_period_s(time_ns)
                signals[name] = signal
                made(signal)
                mapped.append(mapped_channel(binding, len(time_ns), period, bindings))
                stated[name] = is_stated(binding)
                units[name] = binding.unit.scale
                other = spare_of(name, binding, bindings, group)
                spare = other and make_signal(other, groups, infos, ImportLog(), last=False)
                if other and spare:
                    entry = mapped_channel(other, len(spare.values), usual_period_s(spare.time_ns), bindings)
                    spares[name] = Spare(spare, entry, is_stated(other), other.unit.scale)
                break
    return Part(
        opened=taken.opened,
        mapped=tuple(mapped),
        stated=stated,
        taken=units,
        short=tuple(name for name in taken.proposals if name not in signals),
        spares=spares,
        out_of_order=sum(each.out_of_order for each in ordered),
        duplicates=sum(each.duplicates for each in ordered),
        jumps=sum(each.jumps for each in ordered),
        signals=signals,
    )
