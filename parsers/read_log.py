"""One log file to signals: recognise, open, map, read, and order in time. `parsers.load` makes a drive of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from parsers.axle_sums import HeldRows, with_axle_sums
from parsers.channels import ChannelInfo, Chunk, FloatArray, IntArray
from parsers.drive import MappedChannel, Signal
from parsers.errors import LogError, MappingError
from parsers.importer import Importer, ImportLog, LogReader, ReadOptions, no_progress
from parsers.intake import Group, Intake, LogRows
from parsers.mapping import Binding, MapFile, bind, missing_channels, needed_channels, propose_all
from parsers.mapping.wheel_radius import WheelRadius
from parsers.places import remote
from parsers.registry import find_importer
from parsers.ros.frame_topics import with_frame_topics
from parsers.ros.joint_topics import with_joint_names
from parsers.signals import SIGNALS
from parsers.timebase import LATEST_NS, usual_period_s
from parsers.units import SI_TEXT

MOST_MISSING = 3
"""Channels of a mapping file that a log lacks which are named one by one."""

MIN_SAMPLES = 2
"""A channel with fewer valid samples than this is no signal."""

BEYOND_JUMP = "row beyond a jump of the clock"
MUCH = 0.05
"""Share of a log's rows beyond jumps of its clock from which on it is no whole log."""

_BLOCK = 1 << 14

Progress = Callable[[str, float], None]
"""Called with what is being done and how much of it is done (0-1)."""


def quiet(what: str, share: float) -> None:
    """Report nothing."""


@dataclass(frozen=True)
class LoadOptions:
    """How to load. map: a mapping file that was read. fix: apply what the physics checks are sure of.

    dbc, dbc_given: as in `ReadOptions`. radius: of the wheels, as the vehicle file has it.
    """

    map: MapFile | None = None
    dbc: tuple[Path, ...] = ()
    fix: bool = True
    progress: Progress = quiet
    dbc_given: bool = True
    radius: WheelRadius | None = None


@dataclass(frozen=True)
class OpenedLog:
    """A log that is open, and its log book."""

    path: Path
    importer: Importer
    reader: LogReader
    log: ImportLog


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
    short: signals whose channel has too few valid samples.
    """

    opened: OpenedLog
    mapped: tuple[MappedChannel, ...]
    stated: Mapping[str, bool]
    taken: Mapping[str, float]
    short: tuple[str, ...]
    out_of_order: int
    duplicates: int
    jumps: int


@dataclass(frozen=True)
class Part(PartFacts):
    """One log, read: its signals, before the physics checks."""

    signals: Mapping[str, Signal]


def _unreadable(path: Path, error: OSError) -> LogError:
    hint = "check the network, and try again" if remote(path) else "check the disk, or copy the log again"
    return LogError(f"cannot be read ({error.strerror or error})", path=path, hint=hint)


def open_log(
    path: Path, options: LoadOptions, progress: Callable[[int, int], None] = no_progress
) -> OpenedLog:
    """Recognise and open a log. Raises LogError where that cannot be done."""
    importer = find_importer(path)
    log = ImportLog()
    read_options = ReadOptions(
        dbc=options.dbc,
        dbc_given=options.dbc_given,
        buses=options.map.buses if options.map else {},
        time_channel=options.map.time_channel if options.map else None,
        time_unit=options.map.time_unit if options.map else None,
        progress=progress,
    )
    try:
        reader = importer.open(path, read_options, log)
        reader = with_joint_names(reader, lambda book: importer.open(path, read_options, book), log)
        reader = with_frame_topics(
            reader, lambda book: importer.open(path, read_options, book), read_options, log, path
        )
    except OSError as error:
        raise _unreadable(path, error) from error
    return OpenedLog(path, importer, reader, log)


def read_chunks(opened: OpenedLog, wanted: frozenset[str]) -> Iterator[Chunk]:
    """The chunks of an open log. Raises LogError where the disk fails in the middle."""
    try:
        yield from opened.reader.read(wanted)
    except OSError as error:
        raise _unreadable(opened.path, error) from error


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


def _bound(binding: Binding, columns: Mapping[str, FloatArray], *, in_place: bool) -> FloatArray:
    """`bind` block by block: what it makes in between then stays in the processor's cache.

    in_place: over the main channel, which nobody needs any more; fresh memory takes longer than the arithmetic.
    """
    columns = {name: columns[name] for name in binding.needed}
    main = columns[binding.channels[0]]
    n = len(main)
    values = main if in_place else np.empty(n)
    for start in range(0, n, _BLOCK):
        part = {name: column[start : start + _BLOCK] for name, column in columns.items()}
        values[start : start + _BLOCK] = bind(binding, part)
    return values


def given(binding: Binding, columns: Mapping[str, FloatArray]) -> int:
    """How many rows have a number for a binding that may refuse some; 0 where it takes what it gets, or picks rows."""
    if not (_by_covariance(binding) or _by_fix(binding)) and (
        binding.where is not None or (binding.valid_range is None and binding.kind in ("scale", "length"))
    ):
        return 0
    whole = np.logical_and.reduce([np.isfinite(columns[name]) for name in binding.channels])
    return int(np.count_nonzero(whole))


def _by_covariance(binding: Binding) -> bool:
    """Whether a message itself says, by a covariance below zero, that it has no such value."""
    return binding.where is not None and "covariance" in binding.where[0].rsplit("/", 1)[-1]


def _by_fix(binding: Binding) -> bool:
    """Whether a receiver itself says that it has no fix, by a status below zero or a place at 0° and 0°."""
    return binding.beside is not None or (
        binding.where is not None and binding.where[0].endswith("status.status")
    )


def refused(binding: Binding) -> str:
    """Why the record counts a value that a binding had and did not take."""
    if _by_covariance(binding):
        return f"{binding.signal}: message that says it has none (covariance below 0), or value outside of its valid range"
    if _by_fix(binding):
        return f"{binding.signal}: row without a position fix, or value outside of its valid range"
    if binding.kind in ("scale", "length"):
        return f"{binding.signal}: value outside of its valid range"
    return f"{binding.signal}: quaternion that is none, or value outside of its valid range"


def _signal(
    binding: Binding,
    groups: Mapping[str, Group],
    infos: Mapping[str, ChannelInfo],
    log: ImportLog,
    *,
    last: bool,
) -> Signal | None:
    """A binding's signal, or None where its channel has too few valid samples. last: nobody else needs the channel."""
    group = groups.get(group_of(binding, infos))
    if group is None or any(name not in group.columns for name in binding.channels):
        return None
    offered = given(binding, group.columns)
    values = _bound(binding, group.columns, in_place=last and binding.channels[0] in group.own)
    valid = np.isfinite(values)
    count = int(np.count_nonzero(valid))
    log.reject(refused(binding), max(offered - count, 0))
    if count < MIN_SAMPLES:
        return None
    whole = count == len(values)
    return Signal(
        binding.signal,
        group.time_ns if whole else group.time_ns[valid],
        values if whole else values[valid],
        source_text(binding),
        group=group_of(binding, infos),
    )


def group_of(binding: Binding, infos: Mapping[str, ChannelInfo]) -> str:
    """The group in whose rows a binding's channels are."""
    return binding.group or infos[binding.channels[0]].group


def source_text(binding: Binding) -> str:
    """The channels of a binding as a signal's source."""
    return " + ".join(binding.channels)


def mapped_channel(
    binding: Binding, samples: int, period_s: float, proposed: Iterable[Binding]
) -> MappedChannel:
    """What the record says of a binding that was chosen out of the proposed ones. period_s: 0 where there is none."""
    others = (source_text(other) for other in proposed if other is not binding)
    return MappedChannel(
        signal=binding.signal,
        channel=source_text(binding),
        unit=binding.unit.text or SI_TEXT[SIGNALS[binding.signal].quantity],
        unit_from=binding.unit_from,
        rule=binding.rule,
        samples=samples,
        rate_hz=1 / period_s if period_s > 0 else 0.0,
        scale=binding.scale,
        offset=binding.offset,
        inverted=binding.invert,
        alternatives=tuple(dict.fromkeys(others)),
    )


def is_stated(binding: Binding) -> bool:
    """Whether a binding's unit is known, not assumed."""
    return not binding.unit_from.startswith("assumed")


def _propose(opened: OpenedLog, options: LoadOptions) -> Mapping[str, tuple[Binding, ...]]:
    if options.map is not None and not options.map.strict:
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
        _take_rows(opened, wanted, rows)
        if opened.log.messages == 0:
            raise LogError(
                f"holds no readable data ({opened.importer.title})",
                path=path,
                hint="; ".join(opened.log.notes) or "check that the recording was copied whole",
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
    summed = with_axle_sums(taken.proposals, infos, HeldRows(groups), taken.opened.log)
    taken = replace(taken, proposals=summed)
    leave_out_beyond_jumps(taken.opened.log, sum(each.lost for each in ordered))
    # signals of one table share their stamps: how often they come is worked out once
    periods = {id(group.time_ns): usual_period_s(group.time_ns) for group in groups.values()}
    uses = Counter(name for each in taken.proposals.values() for binding in each for name in binding.needed)
    signals: dict[str, Signal] = {}
    mapped: list[MappedChannel] = []
    stated: dict[str, bool] = {}
    units: dict[str, float] = {}
    for name, bindings in taken.proposals.items():
        for binding in bindings:
            once = uses[binding.channels[0]] == 1
            signal = _signal(binding, groups, infos, taken.opened.log, last=once)
            if signal is not None:
                time_ns = signal.time_ns
                period = periods[id(time_ns)] if id(time_ns) in periods else usual_period_s(time_ns)
                signals[name] = signal
                made(signal)
                mapped.append(mapped_channel(binding, len(time_ns), period, bindings))
                stated[name] = is_stated(binding)
                units[name] = binding.unit.scale
                break
    return Part(
        opened=taken.opened,
        mapped=tuple(mapped),
        stated=stated,
        taken=units,
        short=tuple(name for name in taken.proposals if name not in signals),
        out_of_order=sum(each.out_of_order for each in ordered),
        duplicates=sum(each.duplicates for each in ordered),
        jumps=sum(each.jumps for each in ordered),
        signals=signals,
    )


def lenient(options: LoadOptions) -> LoadOptions:
    """The options for one of several logs: a mapped channel need not be in each of them."""
    return options if options.map is None else replace(options, map=replace(options.map, strict=False))
