"""A log that is open: how it is to be loaded, its reader and its log book."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from parsers.channels import Chunk
from parsers.errors import LogError
from parsers.importer import Importer, ImportLog, LogReader, ReadOptions, no_progress
from parsers.mapping import MapFile
from parsers.mapping.wheel_radius import WheelRadius
from parsers.places import remote
from parsers.registry import find_importer
from parsers.ros.frame_topics import with_frame_topics
from parsers.ros.joint_topics import with_joint_names
from parsers.ros.labelled_topics import with_labels

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

        def reopen(book: ImportLog) -> LogReader:
            return importer.open(path, read_options, book)

        reader = with_labels(with_joint_names(reader, reopen, log), reopen, log)
        reader = with_frame_topics(reader, reopen, read_options, log, path)
    except OSError as error:
        raise _unreadable(path, error) from error
    return OpenedLog(path, importer, reader, log)


def read_chunks(opened: OpenedLog, wanted: frozenset[str]) -> Iterator[Chunk]:
    """The chunks of an open log. Raises LogError where the disk fails in the middle."""
    try:
        yield from opened.reader.read(wanted)
    except OSError as error:
        raise _unreadable(opened.path, error) from error


def lenient(options: LoadOptions) -> LoadOptions:
    """The options for one of several logs: a mapped channel need not be in each of them."""
    return options if options.map is None else replace(options, map=replace(options.map, strict=False))
