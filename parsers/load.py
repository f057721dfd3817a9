"""Log files to one Drive: open, map, read, order in time, convert, check against physics, and record all of it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from parsers.channels import ChannelInfo, FloatArray, IntArray
from parsers.checks import check_all
from parsers.drive import Drive, Gap, ImportRecord, MappedChannel, Signal
from parsers.errors import LogError, MappingError
from parsers.importer import Importer, ImportLog, LogReader, ReadOptions, no_progress
from parsers.mapping import Binding, MapFile, bind, missing_channels, needed_channels, propose
from parsers.registry import find_importer
from parsers.signals import SIGNALS
from parsers.timebase import NS, drive_gaps, order, usual_period_s
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
class _Part:
    """One log, read: its signals, before the physics checks, and what the record needs."""

    opened: OpenedLog
    signals: dict[str, Signal]
    mapped: tuple[MappedChannel, ...]
    stated: dict[str, bool]
    out_of_order: int
    duplicates: int
    jumps: int


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
        raise LogError(f"cannot be read ({error.strerror or error})", path=path) from error
    return OpenedLog(path, importer, reader, log)


def _files(path: Path) -> list[Path]:
    return sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]


def hash_logs(paths: Sequence[Path]) -> str:
    """SHA-256 over the logs' bytes, in the order given (a folder: its files by name)."""
    digest = hashlib.sha256()
    for path in paths:
        for file in _files(path):
            with file.open("rb") as stream:
                while block := stream.read(1 << 20):
                    digest.update(block)
    return digest.hexdigest()


def _collect(opened: OpenedLog, wanted: frozenset[str]) -> tuple[dict[str, _Group], int, int, int]:
    """Read the wanted channels whole and order each group in time; counts of late, equal and jumping stamps."""
    times: dict[str, list[IntArray]] = {}
    columns: dict[str, dict[str, list[FloatArray]]] = {}
    for chunk in opened.reader.read(wanted):
        times.setdefault(chunk.group, []).append(chunk.time_ns)
        group = columns.setdefault(chunk.group, {})
        for name, values in chunk.columns.items():
            group.setdefault(name, []).append(values)
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
    source = " + ".join(binding.channels)
    whole = bool(valid.all())
    return Signal(
        binding.signal,
        group.time_ns if whole else group.time_ns[valid],
        values if whole else values[valid],
        source,
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


def _for_parts(paths: Sequence[Path], options: LoadOptions) -> LoadOptions:
    """With several logs, a mapped channel need not be in each of them."""
    if len(paths) > 1 and options.map is not None:
        return replace(options, map=replace(options.map, strict=False))
    return options


def _require_mapped(parts: Sequence[_Part], mapping: MapFile | None) -> None:
    """Raise MappingError where a mapping file that the user gave names a channel that no log has."""
    if mapping is None or not mapping.strict or len(parts) < 2:
        return
    absent = [set(missing_channels(part.opened.reader.channels, mapping)) for part in parts]
    for sentence in sorted(set.intersection(*absent)):
        raise MappingError(sentence.replace("this log", "any of the logs"), path=mapping.path)


def _read_part(path: Path, options: LoadOptions) -> _Part:
    def progress(done: int, total: int) -> None:
        options.progress(f"reading {path.name}", done / total if total else 0.0)

    opened = open_log(path, options, progress)
    infos = {info.name: info for info in opened.reader.channels}
    if options.map is not None and not options.map.strict:
        for sentence in missing_channels(opened.reader.channels, options.map):
            opened.log.note(sentence)
    proposals = propose(opened.reader.channels, options.map)
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
    return _Part(opened, signals, tuple(mapped), stated, late, equal, jumps)


def _no_signal(parts: Sequence[_Part]) -> LogError:
    """The error for logs in which nothing maps to a signal: what is there, and how to say what it is."""
    first = parts[0]
    channels = [info for part in parts for info in part.opened.reader.channels]
    numbers = [info.name for info in channels if info.kind == "number"]
    found = f"{len(numbers)} numeric channels ({', '.join(numbers[:6])}{', …' if len(numbers) > 6 else ''})"
    notes = [note for part in parts for note in part.opened.log.notes]
    hint = "run `cogest inspect LOG --write-map map.toml`, name the channels there and give it with --map"
    return LogError(
        "no channel maps to a signal: found " + (found if numbers else "no numeric channel"),
        path=first.opened.path,
        hint="; ".join([*notes[:3], hint]) if numbers else "; ".join(notes[:3]) or None,
    )


def _joined(name: str, parts: Sequence[Signal], notes: list[str]) -> Signal:
    """One signal that several logs hold: parts in a row are joined, a second recorder of the same span is left out."""
    chosen = [max(parts, key=lambda s: len(s.values))]
    for part in sorted(parts, key=lambda s: int(s.time_ns[0])):
        if part is chosen[0] or any(
            part.time_ns[0] <= other.time_ns[-1] and other.time_ns[0] <= part.time_ns[-1] for other in chosen
        ):
            if part is not chosen[0]:
                notes.append(f"{name} is in several logs over the same time: {part.source!r} left out")
            continue
        chosen.append(part)
    chosen.sort(key=lambda s: int(s.time_ns[0]))
    return replace(
        chosen[0],
        time_ns=np.concatenate([s.time_ns for s in chosen]),
        values=np.concatenate([s.values for s in chosen]),
    )


def _merge(parts: Sequence[_Part], notes: list[str]) -> dict[str, Signal]:
    """The signals of all logs on one clock. Raises LogError where the logs' clocks cannot be brought together."""
    if len(parts) == 1:
        return parts[0].signals
    kinds = {part.opened.reader.absolute for part in parts}
    if len(kinds) > 1:
        relative = next(part.opened.path for part in parts if not part.opened.reader.absolute)
        raise LogError(
            "its stamps count from its own start, the other log's from 1970: they cannot be laid side by side",
            path=relative,
            hint="analyse the logs one by one, or record with one clock",
        )
    if kinds == {False}:
        notes.append("the logs' stamps are relative: their zeros are taken as one moment")
    spans = [(int(s.time_ns[0]), int(s.time_ns[-1])) for part in parts for s in part.signals.values()]
    if spans and max(b for _, b in spans) - min(a for a, _ in spans) > 48 * 3600 * NS:
        raise LogError(
            "the logs lie more than two days apart: nothing overlaps",
            path=parts[0].opened.path,
            hint="give only logs of one drive",
        )
    names = dict.fromkeys(name for part in parts for name in part.signals)
    return {
        name: _joined(name, [part.signals[name] for part in parts if name in part.signals], notes)
        for name in names
    }


def _start_utc(parts: Sequence[_Part], start_ns: int) -> str | None:
    reader = parts[0].opened.reader
    origin = 0 if reader.absolute else reader.start_utc_ns
    if origin is None:
        return None
    try:
        return datetime.fromtimestamp((origin + start_ns) / NS, tz=UTC).isoformat(timespec="milliseconds")
    except (OverflowError, ValueError, OSError):
        return None


def load_drive(paths: Sequence[Path], options: LoadOptions | None = None) -> Drive:
    """Read one drive from its logs (recorded in parts, or by several recorders).

    Raises LogError (a log cannot be read, or nothing in it maps to a signal), MappingError, DatabaseError.
    """
    options = options or LoadOptions()
    with ThreadPoolExecutor(1) as pool:
        # hashing releases the GIL: it runs beside the decoding
        digest = pool.submit(hash_logs, paths)
        parts = [_read_part(path, _for_parts(paths, options)) for path in paths]
        _require_mapped(parts, options.map)
        if not any(part.signals for part in parts):
            raise _no_signal(parts)
        sha256 = digest.result()
    notes: list[str] = []
    merged = _merge(parts, notes)
    stated = {name: value for part in parts for name, value in part.stated.items()}
    options.progress("checking signs and units", 0.0)
    checked = check_all(merged, fix=options.fix, units_stated=stated)
    signals, decisions = checked.signals, checked.decisions
    if checked.unchecked:
        notes.append("not checked against physics: " + "; ".join(checked.unchecked))
    if not signals:
        found = "; ".join(f"{d.signal}: {d.found}" for d in decisions)
        raise LogError(
            f"no signal is left after the checks against physics ({found})",
            path=paths[0],
            hint="say the right channels and units in a mapping file (--map)",
        )
    start_ns = min(int(s.time_ns[0]) for s in signals.values())
    end_ns = max(int(s.time_ns[-1]) for s in signals.values())
    logs = [part.opened.log for part in parts]
    status = max((log.status for log in logs), key=["complete", "truncated", "malformed"].index)
    rejected: dict[str, int] = {}
    for log in logs:
        for reason, count in log.rejected.items():
            rejected[reason] = rejected.get(reason, 0) + count
    lost = tuple(
        Gap((a - start_ns) / NS, (b - start_ns) / NS, "lost") for log in logs for a, b in log.lost_spans_ns
    )
    record = ImportRecord(
        format=", ".join(dict.fromkeys(part.opened.importer.title for part in parts)),
        paths=tuple(paths),
        sha256=sha256,
        status=status,
        messages=sum(log.messages for log in logs),
        rejected=rejected,
        gaps=drive_gaps({name: s.time_ns for name, s in signals.items()}, start_ns) + lost,
        clock=", ".join(dict.fromkeys(part.opened.reader.clock for part in parts)),
        start_utc=_start_utc(parts, start_ns),
        duration_s=(end_ns - start_ns) / NS,
        mapped=tuple(entry for part in parts for entry in part.mapped),
        decisions=decisions,
        notes=tuple(note for log in logs for note in log.notes) + tuple(notes),
        out_of_order=sum(part.out_of_order for part in parts),
        duplicates=sum(part.duplicates for part in parts),
        clock_jumps=sum(part.jumps for part in parts),
    )
    return Drive(signals, record, start_ns)
