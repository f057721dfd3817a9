"""When a recording begins and ends, on the clock that its stamps have when it is read: from headers, indexes and last rows.

Asked only of recordings whose names say that they may belong together.
"""

from __future__ import annotations

import re
import sqlite3
import struct
from collections.abc import Callable, Iterable
from contextlib import closing
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory

from parsers.errors import CogestError
from parsers.importer import ImportLog, LogReader, ReadOptions
from parsers.registry import find_importer
from pipelines.fleet.logs import Log
from pipelines.fleet.table_heads import first_and_last

NS = 1_000_000_000
MOST_BYTES = 64 << 20
"""A recording that must be read to know when it ends is read up to this size."""

_HEAD_BYTES = 64 << 10
_ABSOLUTE_NS = 631_152_000 * NS
_STAMPS = {
    "asc": (re.compile(rb"^\s*(\d+\.\d+)\s", re.MULTILINE), NS),
    "trc": (re.compile(rb"^\s*(?:\d+\)?)\s+(\d+(?:\.\d+)?)\s", re.MULTILINE), 1_000_000),
    "candump": (re.compile(rb"^\s*\((\d+\.\d+)\)", re.MULTILINE), NS),
}
"""A line's stamp in the text formats of CAN, and its unit in ns."""


@dataclass(frozen=True)
class Clock:
    """First and last stamp in ns. absolute: they count from 1970, else from a zero that only this recording knows."""

    first_ns: int
    last_ns: int
    absolute: bool

    @property
    def duration_ns(self) -> int:
        """How long it runs."""
        return self.last_ns - self.first_ns


def clock_of(log: Log, options: ReadOptions) -> Clock | None:
    """When a recording begins and ends; None where that cannot be told without reading much, or it is damaged."""
    if log.trouble:
        return None
    reader = _READERS.get(log.format)
    try:
        if log.look is not None and (ends := first_and_last(log.look, log.path)) is not None:
            return Clock(*ends, absolute=log.look.plan.absolute)
        return reader(log, options) if reader is not None else None
    except (CogestError, OSError, ValueError, struct.error, sqlite3.Error, MemoryError):
        return None


def _between(stamps: Iterable[tuple[int, int]], absolute: bool) -> Clock | None:
    """The clock over pieces with a first and a last stamp each."""
    known = list(stamps)
    if not known:
        return None
    return Clock(min(first for first, _ in known), max(last for _, last in known), absolute)


def _can_text(log: Log, _: ReadOptions) -> Clock | None:
    pattern, unit = _STAMPS[log.format]
    with log.path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
        size = file.seek(0, 2)
        file.seek(max(0, size - _HEAD_BYTES))
        tail = file.read(_HEAD_BYTES)
    if log.format == "asc" and re.search(rb"timestamps\s+relative", head[:4096], re.IGNORECASE):
        return None
    first = pattern.search(head)
    ends = pattern.findall(tail[: tail.rfind(b"\n") + 1])
    if first is None or not ends:
        return None
    a, b = round(float(first[1]) * unit), round(float(ends[-1]) * unit)
    return Clock(a, b, log.format == "candump" and a > 100_000_000 * NS) if b >= a else None


def _blf(log: Log, _: ReadOptions) -> Clock | None:
    """From the first frame to the header's end of measurement; of a file without that, to its last frame.

    None for a file shorter than its header says: it was cut, and did not go on to that end.
    """
    from parsers.blf_containers import read_header
    from parsers.blf_frames import BlfFrames
    from parsers.importer import no_progress

    header = read_header(log.path)
    if log.size < header.file_size:
        return None
    with log.path.open("rb") as file:
        fields = struct.unpack("<8H", file.read(72)[56:72])
    frames = BlfFrames(log.path, header, ImportLog(), no_progress)
    first: int | None = None
    for batch in frames.frames(counting=False):
        if batch.time_ns.size:
            first = int(batch.time_ns[0])
            break
    if first is None:
        return None
    last = _system_time(fields)
    if last is not None and last >= first and header.start_ns is not None:
        return Clock(first, last, frames.absolute)
    if log.size > MOST_BYTES:
        return None
    ends = [
        (int(b.time_ns.min()), int(b.time_ns.max())) for b in frames.frames(counting=False) if b.time_ns.size
    ]
    return _between(ends, frames.absolute)


def _system_time(fields: tuple[int, ...]) -> int | None:
    """A Windows SYSTEMTIME read as UTC, as the importer reads the start; None where none is set."""
    year, month, _, day, hour, minute, second, milli = fields
    try:
        moment = datetime(year, month, day, hour, minute, second, tzinfo=UTC)
    except ValueError:
        return None
    return int(moment.timestamp()) * NS + milli * 1_000_000


def _mcap(log: Log, _: ReadOptions) -> Clock | None:
    """From the summary at the file's end; None for a file that was cut off."""
    from parsers.mcap_chunks import McapFile
    from parsers.mcap_summary import read_summary

    with log.path.open("rb", buffering=0) as file:
        found = read_summary(McapFile(log.path, file), ImportLog())
    known = found.statistics
    if known is None or known.end_ns <= 0:
        return None
    return Clock(known.start_ns, known.end_ns, known.start_ns > _ABSOLUTE_NS)


def _bag1(log: Log, _: ReadOptions) -> Clock | None:
    """From the index of chunks."""
    from parsers.ros.bag1_index import read_index

    with log.path.open("rb") as file:
        index = read_index(file, log.size)
    if index is None:
        return None
    ends = [(c.first_ns, c.last_ns) for c in index.chunks if c.first_ns is not None and c.last_ns is not None]
    clock = _between(ends, absolute=True)
    return clock if clock is None else Clock(clock.first_ns, clock.last_ns, clock.first_ns > _ABSOLUTE_NS)


def _bag2(log: Log, options: ReadOptions) -> Clock | None:
    """From the database's index of stamps; of a folder, from all its files."""
    from parsers.ros.bag2_database import connect
    from parsers.ros.bag2_files import Scratch, bag_files

    path = log.path
    files = [file.path for file in bag_files(path, ImportLog())] if path.is_dir() else [path]
    clocks = []
    for file in files:
        if file.suffix.lower() == ".mcap":
            clocks.append(_mcap(Log(str(file), file.name, file.stat().st_size, "", "mcap", ""), options))
        elif file.suffix.lower() == ".db3":
            with closing(connect(file, Scratch())) as connection:
                a, b = connection.execute("SELECT min(timestamp), max(timestamp) FROM messages").fetchone()
            clocks.append(
                Clock(a, b, a > _ABSOLUTE_NS) if isinstance(a, int) and isinstance(b, int) else None
            )
        else:
            clocks.append(None)
    if not clocks or any(clock is None for clock in clocks):
        return None
    return _between([(c.first_ns, c.last_ns) for c in clocks if c], all(c.absolute for c in clocks if c))


def _mf4(log: Log, options: ReadOptions) -> Clock | None:
    """From the first and last records; of frames of several buses in one stream, by reading them."""
    from pipelines.fleet.clocks_mf4 import mf4_ends

    ends = mf4_ends(log.path)
    return Clock(*ends) if ends is not None else _read(log, options)


def _read(log: Log, options: ReadOptions) -> Clock | None:
    """By reading one channel of each group."""
    return _by_reading(log.path, options) if log.size <= MOST_BYTES else None


def _text(log: Log, options: ReadOptions) -> Clock | None:
    """By reading the first and the last rows of a table of text, through its own importer."""
    for head_bytes in (_HEAD_BYTES // 8, _HEAD_BYTES):
        if log.size <= 2 * head_bytes:
            return _by_reading(log.path, options)
        try:
            return _by_ends(log, options, head_bytes)
        except CogestError:
            # a head so long that no row followed in what was read of it
            continue
    return None


def _by_ends(log: Log, options: ReadOptions, head_bytes: int) -> Clock | None:
    path = log.path
    with path.open("rb") as file:
        head = file.read(head_bytes)
        file.seek(log.size - head_bytes // 2)
        tail = file.read()
    head, tail = head[: head.rfind(b"\n") + 1], tail[tail.find(b"\n") + 1 :]
    with TemporaryDirectory(prefix="cogest-") as folder:
        short = Path(folder) / f"ends{path.suffix}"
        short.write_bytes(head)
        begin = _by_reading(short, options)
        short.write_bytes(head + tail)
        whole = _by_reading(short, options)
    if begin is None or whole is None:
        return None
    return Clock(begin.first_ns, whole.last_ns, whole.absolute) if whole.first_ns == begin.first_ns else None


def _by_reading(path: Path, options: ReadOptions) -> Clock | None:
    from parsers.mf4.reader import Mf4Reader

    reader: LogReader = find_importer(path).open(path, options, ImportLog())
    if isinstance(reader, Mf4Reader) and reader.frames is not None:
        batches = reader.frames.frames(counting=False)
        ends = [(int(b.time_ns.min()), int(b.time_ns.max())) for b in batches if b.time_ns.size]
        if ends:
            return _between(ends, reader.absolute)
    groups: dict[str, str] = {}
    for channel in reader.channels:
        if channel.kind == "number":
            groups.setdefault(channel.group, channel.name)
    chunks = reader.read(frozenset(groups.values()))
    ends = [(int(c.time_ns.min()), int(c.time_ns.max())) for c in chunks if c.time_ns.size]
    return _between(ends, reader.absolute)


_READERS: dict[str, Callable[[Log, ReadOptions], Clock | None]] = {
    "asc": _can_text,
    "trc": _can_text,
    "candump": _can_text,
    "blf": _blf,
    "mcap": _mcap,
    "rosbag1": _bag1,
    "rosbag2": _bag2,
    "mf4": _mf4,
    "parquet": _read,
    "vbo": _text,
    "csv": _text,
}
