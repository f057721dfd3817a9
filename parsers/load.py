"""Log files to one Drive: read each, bring them together, check against physics, and record all of it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from parsers.apart import apart_notes
from parsers.checks import check_all
from parsers.checks.check import Checked
from parsers.checks.clock import clock_note
from parsers.drive import Decision, Drive, Gap, ImportRecord, MappedChannel, Signal
from parsers.errors import LogError, MappingError
from parsers.importer import ImportLog
from parsers.intake import Intake
from parsers.log_hash import BackgroundHash, hash_logs
from parsers.mapping import MapFile, missing_channels
from parsers.merge import merge_parts
from parsers.opened_log import LoadOptions, OpenedLog, Progress, lenient, open_log, quiet, read_chunks
from parsers.other_units import better, choice, swapped_entries, to_swap, with_other
from parsers.read_log import BEYOND_JUMP, Part, PartFacts, make_part, take_in
from parsers.registry import find_importer
from parsers.timebase import MAX_GAPS, NS, GapList, list_gaps

__all__ = [
    "LoadOptions",
    "OpenedLog",
    "Progress",
    "hash_logs",
    "load_drive",
    "open_log",
    "quiet",
    "read_chunks",
]


def _require_mapped(parts: Sequence[PartFacts], mapping: MapFile | None) -> None:
    """Raise MappingError where a mapping file that the user gave names a channel that no log has."""
    if mapping is None or not mapping.strict or len(parts) < 2:
        return
    absent = [set(missing_channels(part.opened.reader.channels, mapping)) for part in parts]
    for sentence in sorted(set.intersection(*absent)):
        raise MappingError(sentence.replace("this log", "any of the logs"), path=mapping.path)


def _no_signal(parts: Sequence[PartFacts]) -> LogError:
    """The error for logs in which nothing maps to a signal: what is there, and how to say what it is."""
    path = parts[0].opened.path
    every = [note for part in parts for note in part.opened.log.notes]
    notes = every[:3]
    rejected = [f"{count} x {reason}" for part in parts for reason, count in part.opened.log.rejected.items()]
    short = list(dict.fromkeys(name for part in parts for name in part.short))
    if short:
        problem = f"no signal has two valid samples: {', '.join(short[:6])}{', …' if len(short) > 6 else ''}"
        why = [f"rejected: {', '.join(rejected[:3])}"] if rejected else []
        return LogError(problem, path=path, hint="; ".join([*why, *notes]) or "is this the whole recording?")
    channels = [info for part in parts for info in part.opened.reader.channels]
    numbers = [info.name for info in channels if info.kind == "number"]
    found = f"{len(numbers)} numeric channels ({', '.join(numbers[:6])}{', …' if len(numbers) > 6 else ''})"
    hint = "run `cogest inspect LOG --write-map map.toml`, name the channels there and give it with --map"
    if not numbers:
        return LogError(no_numbers(every), path=path, hint="; ".join(every[:-1][-2:]) or None)
    return LogError(f"no channel maps to a signal: found {found}", path=path, hint="; ".join([*notes, hint]))


def no_numbers(notes: Sequence[str]) -> str:
    """Why a log gives no channel with numbers: its last note is of what is missing or damaged, those before it are of its clock."""
    return f"no numbers could be read: {notes[-1] if notes else 'it holds none'}"


def nothing_left(path: Path, decisions: Sequence[Decision]) -> LogError:
    """The error for logs whose every signal the checks left out."""
    found = "; ".join(f"{d.signal}: {d.found}" for d in decisions[:3])
    return LogError(
        f"no signal is left after the checks against physics ({found})",
        path=path,
        hint="say the right channels and units in a mapping file (--map), or look at the data as they are with --no-fix",
    )


def _start_utc(parts: Sequence[PartFacts], start_ns: int, shift_ns: int) -> str | None:
    """The wall clock at the drive's start, without an offset where nobody says of which time zone it is.

    shift_ns: what was added to the first log's stamps.
    """
    reader, log = parts[0].opened.reader, parts[0].opened.log
    origin = 0 if reader.absolute else reader.start_utc_ns
    zone = UTC if log.zone_known else None
    if origin is None:
        origin = log.local_start_ns
    if origin is None:
        return None
    try:
        moment = datetime.fromtimestamp((origin - shift_ns + start_ns) / NS, tz=UTC)
        return moment.replace(tzinfo=zone).isoformat(timespec="milliseconds")
    except (OverflowError, ValueError, OSError):
        return None


def _mapping(
    parts: Sequence[PartFacts], left_out: Set[tuple[int, str]], signals: Collection[str]
) -> Iterator[MappedChannel]:
    """What each log's channels became; a channel that is not used in the end says so."""
    for number, part in enumerate(parts):
        for entry in part.mapped:
            if (number, entry.signal) in left_out:
                yield replace(entry, used=False, rule=f"left out, another log has it; {entry.rule}")
            elif entry.signal not in signals:
                yield replace(entry, used=False, rule=f"left out by the checks; {entry.rule}")
            else:
                yield entry


def _without_samples(parts: Sequence[PartFacts]) -> list[str]:
    """A note on signals that have a channel in a log, and no two valid samples in any."""
    found = {entry.signal for part in parts for entry in part.mapped}
    absent = list(dict.fromkeys(name for part in parts for name in part.short if name not in found))
    if not absent:
        return []
    return [f"left out, since the channel has fewer than two valid samples: {', '.join(absent)}"]


def _rejected(logs: Sequence[ImportLog]) -> dict[str, int]:
    rejected: dict[str, int] = {}
    for log in logs:
        for reason, count in log.rejected.items():
            rejected[reason] = rejected.get(reason, 0) + count
    return rejected


def _gaps(outcome: Outcome, logs: Sequence[ImportLog], notes: list[str]) -> tuple[Gap, ...]:
    """Gaps in the signals and what damage took, at most MAX_GAPS of each sort; a note says how many there are."""
    found, start_ns = outcome.gaps, outcome.start_ns
    shifts = zip(logs, outcome.shifts_ns, strict=True)
    lost = [(a + ns, b + ns) for log, ns in shifts for a, b in log.lost_spans_ns]
    for total, what in ((found.total, "gaps"), (len(lost), "damaged spans")):
        if total > MAX_GAPS:
            notes.append(f"there are {total} {what}: only the {MAX_GAPS} longest are listed")
    if len(lost) > MAX_GAPS:
        lost = sorted(sorted(lost, key=lambda span: span[0] - span[1])[:MAX_GAPS])
    return found.gaps + tuple(Gap((a - start_ns) / NS, (b - start_ns) / NS, "lost") for a, b in lost)


@dataclass(frozen=True)
class Outcome:
    """What came out of the logs of a drive, for its record. gaps: of the signals; signals: names, as they are used;
    shifts_ns: what was added to each log's stamps; turned: signals whose sign the checks changed."""

    parts: Sequence[PartFacts]
    left_out: Set[tuple[int, str]]
    signals: Collection[str]
    decisions: tuple[Decision, ...]
    unchecked: tuple[str, ...]
    notes: tuple[str, ...]
    start_ns: int
    end_ns: int
    gaps: GapList
    shifts_ns: Sequence[int]
    turned: tuple[str, ...]


def make_record(paths: Sequence[Path], outcome: Outcome, sha256: str) -> ImportRecord:
    """Write down what happened."""
    parts, start_ns = outcome.parts, outcome.start_ns
    logs = [part.opened.log for part in parts]
    notes = [note for log in logs for note in log.notes] + list(outcome.notes)
    notes += _without_samples(parts)
    if outcome.unchecked:
        notes.append("not checked against physics: " + "; ".join(outcome.unchecked))
    paused = sum(gap.end_s - gap.start_s for gap in outcome.gaps.gaps if gap.signal is None)
    notes += _odd_time(parts, (outcome.end_ns - start_ns) / NS, paused)
    return ImportRecord(
        format=", ".join(dict.fromkeys(part.opened.importer.title for part in parts)),
        paths=tuple(paths),
        sha256=sha256,
        status=max((log.status for log in logs), key=["complete", "truncated", "malformed"].index),
        messages=sum(log.messages for log in logs),
        rejected=_rejected(logs),
        gaps=_gaps(outcome, logs, notes),
        clock=", ".join(dict.fromkeys(part.opened.reader.clock for part in parts)),
        start_utc=_start_utc(parts, start_ns, outcome.shifts_ns[0]),
        duration_s=(outcome.end_ns - start_ns) / NS,
        mapped=tuple(_mapping(parts, outcome.left_out, outcome.signals)),
        decisions=outcome.decisions,
        notes=tuple(dict.fromkeys(notes)),
        out_of_order=sum(part.out_of_order for part in parts),
        duplicates=sum(part.duplicates for part in parts),
        clock_jumps=sum(part.jumps for part in parts),
        turned=outcome.turned,
        databases=tuple(sorted({name for log in logs for name in log.databases})),
    )


_ONE_CLOCK = ("csv", "parquet", "vbo")
SHORT_S, MANY = 1.0, 500
"""A log of so many rows within less than SHORT_S has a clock of another unit: nobody records a vehicle at that rate."""

FAST_HZ = 2000.0
"""Rows of a table that come faster than this rather have a clock of another unit: no recorder of a vehicle's motion is as quick."""

SLOW_S = 4.0
"""Rows that come less often than this, in the mean, show no bend: hours in steps of 20 are rather two minutes in milliseconds."""

ODD_UNIT = "is the unit of the time right?"
"""Of a note that doubts it: words for a terminal to know it by."""

DISORDER = 0.2
"""Share of rows whose stamps go back or repeat from which on the clock is rather another channel."""


def _odd_time(parts: Sequence[PartFacts], seconds: float, paused: float = 0.0) -> list[str]:
    """What is said of a time that is hardly the log's. paused: seconds of pauses of the whole drive, which are no steps of a clock."""
    tables = [part for part in parts if not part.opened.log.can_frames]
    # rows beyond a jump of the clock are of another drive, or another time, and told of
    books = {id(part): part.opened.log for part in tables}
    used = {key: max(0, log.messages - log.rejected[BEYOND_JUMP]) for key, log in books.items()}
    rows = sum(used.values())
    said = []
    if rows >= MANY and seconds < SHORT_S:
        said.append(f"all {rows} rows lie within {seconds:.3g} s: {ODD_UNIT}")
    elif seconds > 0:
        # messages of several topics are no rows of one clock
        most = max((used[id(p)] for p in tables if p.opened.importer.name in _ONE_CLOCK), default=0)
        if most >= MANY and most / seconds > FAST_HZ:
            said.append(
                f"{most} rows within {seconds:.3g} s are {most / seconds:.0f} Hz: {ODD_UNIT} "
                "A mapping file's [time] unit states it"
            )
        elif rows >= MANY and rows == most and (seconds - paused) / most > SLOW_S:
            said.append(
                f"a row every {(seconds - paused) / most:.3g} s: too seldom for a vehicle's motion; {ODD_UNIT} "
                "A mapping file's [time] unit states it"
            )
    astray = sum(part.out_of_order + part.duplicates for part in tables)
    if astray > DISORDER * max(rows, 1) and rows >= MANY:
        said.append(
            f"the stamps of {astray / rows:.0%} of the rows go back or repeat: is that channel the time?"
        )
    return said


def find_all(paths: Sequence[Path]) -> None:
    """Raise LogError where one of the paths is no log: said before its hash is begun, which would go through all of it."""
    for path in paths:
        find_importer(path)


def options_of_each(paths: Sequence[Path], options: LoadOptions) -> LoadOptions:
    """The options for each of the logs."""
    return lenient(options) if len(paths) > 1 else options


UNUSED_DATABASE = "--dbc "
"""How a note begins that is about databases which were named and decoded nothing."""


def note_unused_databases(parts: Sequence[PartFacts], options: LoadOptions) -> None:
    """Say in the first log's book which of the databases that were given decoded nothing: no frames, or none of their messages."""
    if not (options.dbc and options.dbc_given):
        return
    if any(part.opened.log.can_frames for part in parts):
        used = {name for part in parts for name in part.opened.log.databases}
        vain = [path.name for path in options.dbc if path.name not in used]
        # where none has any, that is said with the identifiers of both
        if vain and used:
            which = "log" if len(parts) == 1 else "logs"
            parts[0].opened.log.note(
                f"{UNUSED_DATABASE}{', '.join(vain)} decoded nothing: none of {'its' if len(vain) == 1 else 'their'} messages is in the {which}"
            )
        return
    names = ", ".join(path.name for path in options.dbc)
    none = "the log holds none" if len(parts) == 1 else "none of the logs holds any"
    parts[0].opened.log.note(
        f"{UNUSED_DATABASE}{names} was not used: it is for CAN frames, and {none} that cogest reads"
    )


def require_signals(parts: Sequence[PartFacts], found: bool, mapping: MapFile | None) -> None:
    """Raise MappingError where no log has a channel that the user named, LogError where no signal was found."""
    _require_mapped(parts, mapping)
    if not found:
        raise _no_signal(parts)


def load_drive(paths: Sequence[Path], options: LoadOptions | None = None) -> Drive:
    """Read one drive from its logs (recorded in parts, or by several recorders).

    Raises LogError (a log cannot be read, or nothing in it maps to a signal), MappingError, DatabaseError.
    """
    options = options or LoadOptions()
    find_all(paths)
    with BackgroundHash(paths) as digest:
        each = options_of_each(paths, options)
        # log by log, so that no more than one of them is in memory as it was read
        parts = [make_part(take_in(path, each, Intake())) for path in paths]
        return make_drive(paths, parts, options, digest)


def make_drive(
    paths: Sequence[Path], parts: Sequence[Part], options: LoadOptions, digest: BackgroundHash
) -> Drive:
    """Bring the parts together, check them against physics, and record it. Raises as `load_drive`."""
    note_unused_databases(parts, options)
    require_signals(parts, any(part.signals for part in parts), options.map)
    merged = merge_parts(parts)
    options.progress("checking signs and units", 0.0)
    checked, parts = _checked(merged.signals, parts, fix=options.fix)
    signals = checked.signals
    if not signals:
        raise nothing_left(paths[0], checked.decisions)
    spans = {name: (int(s.time_ns[0]), int(s.time_ns[-1])) for name, s in signals.items()}
    start_ns = min(first for first, _ in spans.values())
    outcome = Outcome(
        parts=parts,
        left_out=merged.left_out,
        signals=signals,
        decisions=checked.decisions,
        unchecked=checked.unchecked,
        notes=(*merged.notes, *digest.notes(), *apart_notes(spans), *clock_note(signals, ODD_UNIT)),
        start_ns=start_ns,
        end_ns=max(last for _, last in spans.values()),
        gaps=list_gaps({name: s.time_ns for name, s in signals.items()}, start_ns),
        shifts_ns=merged.shifts_ns,
        turned=checked.turned,
    )
    return Drive(signals, make_record(paths, outcome, digest.result()), start_ns)


def _checked(
    held: Mapping[str, Signal], parts: Sequence[Part], *, fix: bool
) -> tuple[Checked, Sequence[Part]]:
    """The checked signals; where an inertial unit is left out and the log holds another one that is right, with that, which the parts then tell."""
    stated, taken = all_stated(parts), all_taken(parts)
    checked = check_all(held, fix=fix, units_stated=stated, units_taken=taken)
    left_out = held.keys() - checked.signals.keys()
    spares = parts[0].spares if len(parts) == 1 else {}
    names = to_swap(held, left_out, spares)
    if not names:
        return checked, parts
    other = {name: spares[name] for name in names}
    trial = {name: other[name].piece if name in names else signal for name, signal in held.items()}
    units = with_other(stated, taken, other)
    then = check_all(trial, fix=fix, units_stated=units[0], units_taken=units[1])
    if not better(left_out, trial.keys() - then.signals.keys(), names):
        return checked, parts
    part = parts[0]
    said = choice(checked.decisions, left_out, part.mapped, other)
    return replace(then, decisions=(said, *then.decisions)), [
        replace(part, mapped=swapped_entries(part.mapped, other))
    ]


def all_stated(parts: Sequence[PartFacts]) -> dict[str, bool]:
    """Signal -> whether its unit is known."""
    return {name: value for part in parts for name, value in part.stated.items()}


def all_taken(parts: Sequence[PartFacts]) -> dict[str, float]:
    """Signal -> factor to SI of the unit that it was taken in."""
    return {name: value for part in parts for name, value in part.taken.items()}
