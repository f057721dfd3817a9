"""One log file to signals: recognise, open, map, read, and order in time. `parsers.load` makes a drive of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from parsers.channels import ChannelInfo, Chunk, FloatArray, IntArray
from parsers.drive import MappedChannel, Signal
from parsers.errors import LogError
from parsers.importer import Importer, ImportLog, LogReader, ReadOptions, no_progress
from parsers.mapping import Binding, MapFile, bind, missing_channels, needed_channels, propose
from parsers.registry import find_importer
from parsers.signals import SIGNALS
from parsers.timebase import LATEST_NS, order, usual_period_s
from parsers.units import SI_TEXT

MIN_SAMPLES = 2
"""A channel with fewer valid samples than this is no signal."""

Progress = Callable[[str, float], None]
"""Called with what is being done and how much of it is done (0-1)."""


def quiet(what: str, share: float) -> None:
    """Report nothing."""


@dataclass(frozen=True)
class LoadOptions:
    """How to load. map: a mapping file that was read. fix: apply what the physics checks are sure of."""

    map: MapFile | None = None
    dbc: tuple[Path, ...] = ()
    fix: bool = True
    progress: Progress = quiet


@dataclass(frozen=True)
class OpenedLog:
    """A log that is open, and its log book."""

    path: Path
    importer: Importer
    reader: LogReader
    log: ImportLog


@dataclass(frozen=True)
class _Group:
    """All rows of one group, in order: time_ns (n,), columns name -> (n,)."""

    time_ns: IntArray
    columns: Mapping[str, FloatArray]


@dataclass(frozen=True)
class Part:
    """One log, read: its signals, before the physics checks, and what the record needs.

    stated: signal -> whether its unit is known, not assumed. short: signals whose channel has too few valid samples.
    """

    opened: OpenedLog
    signals: Mapping[str, Signal]
    mapped: tuple[MappedChannel, ...]
    stated: Mapping[str, bool]
    short: tuple[str, ...]
    out_of_order: int
    duplicates: int
    jumps: int


def _unreadable(path: Path, error: OSError) -> LogError:
    return LogError(
        f"cannot be read ({error.strerror or error})", path=path, hint="check the disk, or copy the log again"
    )


def open_log(
    path: Path, options: LoadOptions, progress: Callable[[int, int], None] = no_progress
) -> OpenedLog:
    """Recognise and open a log. Raises LogError where that cannot be done."""
    importer = find_importer(path)
    log = ImportLog()
    read_options = ReadOptions(
        dbc=options.dbc,
        time_channel=options.map.time_channel if options.map else None,
        time_unit=options.map.time_unit if options.map else None,
        progress=progress,
    )
    try:
        reader = importer.open(path, read_options, log)
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


def _collect(opened: OpenedLog, wanted: frozenset[str]) -> tuple[dict[str, _Group], int, int, int]:
    """Read the wanted channels whole and order each group in time; counts of late, equal and jumping stamps."""
    times: dict[str, list[IntArray]] = {}
    columns: dict[str, dict[str, list[FloatArray]]] = {}
    for chunk in read_chunks(opened, wanted):
        rows = _possible(chunk.time_ns)
        time_ns = chunk.time_ns[rows]
        opened.log.reject("row whose time stamp is impossible", len(chunk.time_ns) - len(time_ns))
        times.setdefault(chunk.group, []).append(time_ns)
        group = columns.setdefault(chunk.group, {})
        for name, values in chunk.columns.items():
            group.setdefault(name, []).append(values[rows])
    groups: dict[str, _Group] = {}
    late = equal = jumps = 0
    for name, parts in times.items():
        time_ns = np.concatenate(parts)
        ordered = order(time_ns)
        late, equal, jumps = late + ordered.out_of_order, equal + ordered.duplicates, jumps + ordered.jumps
        opened.log.reject("row beyond a jump of the clock", ordered.lost)
        groups[name] = _Group(
            ordered.time_ns, {c: np.concatenate(v)[ordered.rows] for c, v in columns[name].items()}
        )
    return groups, late, equal, jumps


def _signal(
    binding: Binding, groups: Mapping[str, _Group], infos: Mapping[str, ChannelInfo]
) -> Signal | None:
    """A binding's signal, or None where its channel has too few valid samples."""
    group = groups.get(infos[binding.channels[0]].group)
    if group is None or any(name not in group.columns for name in binding.channels):
        return None
    values = bind(binding, group.columns)
    valid = np.isfinite(values)
    if int(valid.sum()) < MIN_SAMPLES:
        return None
    whole = bool(valid.all())
    return Signal(
        binding.signal,
        group.time_ns if whole else group.time_ns[valid],
        values if whole else values[valid],
        " + ".join(binding.channels),
        group=infos[binding.channels[0]].group,
    )


def _mapped(binding: Binding, signal: Signal, others: Iterable[Binding]) -> MappedChannel:
    period = usual_period_s(signal.time_ns)
    return MappedChannel(
        signal=binding.signal,
        channel=signal.source,
        unit=binding.unit.text or SI_TEXT[SIGNALS[binding.signal].quantity],
        unit_from=binding.unit_from,
        rule=binding.rule,
        samples=len(signal.values),
        rate_hz=1 / period if period > 0 else 0.0,
        scale=binding.scale,
        offset=binding.offset,
        inverted=binding.invert,
        alternatives=tuple(dict.fromkeys(" + ".join(other.channels) for other in others)),
    )


def _propose(opened: OpenedLog, options: LoadOptions) -> Mapping[str, tuple[Binding, ...]]:
    if options.map is not None and not options.map.strict:
        for sentence in missing_channels(opened.reader.channels, options.map):
            opened.log.note(sentence)
    return propose(opened.reader.channels, options.map)


def read_part(path: Path, options: LoadOptions) -> Part:
    """Read one log's signals. Raises LogError, MappingError, DatabaseError."""

    def progress(done: int, total: int) -> None:
        options.progress(f"reading {path.name}", done / total if total else 0.0)

    opened = open_log(path, options, progress)
    infos = {info.name: info for info in opened.reader.channels}
    proposals = _propose(opened, options)
    wanted = frozenset(name for bindings in proposals.values() for name in needed_channels(bindings))
    groups, late, equal, jumps = _collect(opened, wanted) if wanted else ({}, 0, 0, 0)
    signals: dict[str, Signal] = {}
    mapped: list[MappedChannel] = []
    stated: dict[str, bool] = {}
    for name, bindings in proposals.items():
        for place, binding in enumerate(bindings):
            signal = _signal(binding, groups, infos)
            if signal is not None:
                signals[name] = signal
                mapped.append(_mapped(binding, signal, bindings[:place] + bindings[place + 1 :]))
                stated[name] = not binding.unit_from.startswith("assumed")
                break
    if opened.log.messages == 0 and wanted:
        raise LogError(
            f"holds no readable data ({opened.importer.title})",
            path=path,
            hint="; ".join(opened.log.notes) or "check that the recording was copied whole",
        )
    short = tuple(name for name in proposals if name not in signals)
    return Part(opened, signals, tuple(mapped), stated, short, late, equal, jumps)


def lenient(options: LoadOptions) -> LoadOptions:
    """The options for one of several logs: a mapped channel need not be in each of them."""
    return options if options.map is None else replace(options, map=replace(options.map, strict=False))
