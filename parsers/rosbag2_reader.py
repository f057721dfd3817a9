"""The reader of ROS 2 bags: the SQLite and MCAP files of a bag as one log."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path

from parsers.channels import ChannelInfo, Chunk
from parsers.errors import LogError
from parsers.importer import ImportLog, LogReader, ReadOptions
from parsers.ros.bag2_database import (
    MAGIC,
    TopicRow,
    connect,
    first_time,
    missing_bytes,
    read_definitions,
    read_topics,
)
from parsers.ros.bag2_decode import Chosen, Collector
from parsers.ros.bag2_files import BagFile, Scratch, bag_file, bag_files, unpack
from parsers.ros.bag2_read import DatabaseRead, count_messages
from parsers.ros.clock import BagClock
from parsers.ros.contract import MessageDecoder
from parsers.ros.fields import short_name
from parsers.ros.stamps import StampChooser, is_wall_clock
from parsers.ros.topics import Topic, find_decoder, group_names

COUNT_BELOW = 1 << 26
"""Messages are counted at opening in files smaller than this; in larger ones that would take a while."""


@dataclass(frozen=True)
class Database:
    """One SQLite file of a bag. shown: the path that the user knows."""

    path: Path
    shown: Path
    topics: tuple[TopicRow, ...]
    counts: dict[int, int]
    first_ns: int | None
    cut: bool


@dataclass
class DatabaseReader(BagClock):
    """The SQLite files of one bag, read one after the other. topics: by (topic, type)."""

    databases: tuple[Database, ...]
    topics: dict[tuple[str, str], Topic]
    scratch: Scratch
    options: ReadOptions
    log: ImportLog
    wall_clock: bool
    chooser: StampChooser = field(default_factory=StampChooser)

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """All numbers and texts of all topics whose type is known."""
        return tuple(channel for topic in self.topics.values() for channel in topic.channels())

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Yield the wanted channels; messages of other topics are not fetched."""
        sizes = [database.path.stat().st_size for database in self.databases]
        collector = Collector(self.chooser, self.log)
        for number, database in enumerate(self.databases):
            chosen = self._chosen(database, wanted)
            if not chosen:
                continue
            with closing(connect(database.path, self.scratch)) as connection:
                part = DatabaseRead(connection, database.path, database.shown, chosen, self.log, database.cut)
                for outcome in part.outcomes():
                    self.options.progress(sum(sizes[:number]) + part.done_bytes, sum(sizes))
                    yield from collector.chunks(outcome)
        self.chooser.finish(self.log)

    def _chosen(self, database: Database, wanted: frozenset[str]) -> Chosen:
        """What is wanted of one file."""
        chosen: dict[int, tuple[Topic, tuple[str, ...]]] = {}
        for row in database.topics:
            topic = self.topics.get((row.name, row.type_name))
            paths = topic.wanted_paths(wanted) if topic is not None else ()
            if topic is not None and paths:
                chosen[row.id] = (topic, paths)
        return chosen


@dataclass
class JoinedReader:
    """Several readers as one log: channels of one name are one channel."""

    readers: tuple[LogReader, ...]
    scratch: Scratch

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """The channels of all parts; counts are added up where all parts know them."""
        found: dict[str, ChannelInfo] = {}
        for reader in self.readers:
            for info in reader.channels:
                known = found.get(info.name)
                if known is None:
                    found[info.name] = info
                else:
                    unknown = known.count is None or info.count is None
                    count = None if unknown else (known.count or 0) + (info.count or 0)
                    found[info.name] = replace(known, count=count)
        return tuple(found.values())

    @property
    def clock(self) -> str:
        """Which clocks the parts' stamps are from."""
        return "; ".join(dict.fromkeys(reader.clock for reader in self.readers))

    @property
    def absolute(self) -> bool:
        """Whether the stamps of all parts count from 1970."""
        return all(reader.absolute for reader in self.readers)

    @property
    def start_utc_ns(self) -> int | None:
        """The first part's."""
        return self.readers[0].start_utc_ns

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Yield the wanted channels, part by part. Each part takes what it has: letters of names are no channels of their own."""
        for reader in self.readers:
            yield from reader.read(wanted)


def open_bag(path: Path, options: ReadOptions, log: ImportLog) -> LogReader:
    """Open a bag. Raises LogError where nothing of it can be used; says in the log book what could not be."""
    files = bag_files(path, log) if path.is_dir() else [bag_file(path) or BagFile(path, "db3", False)]
    scratch = Scratch()
    databases: list[Database] = []
    definitions: dict[str, tuple[str, str]] = {}
    readers: list[LogReader] = []
    problems: list[LogError] = []
    for file in files:
        try:
            plain = unpack(file, scratch, log)
            if file.kind == "mcap":
                readers.append(_open_mcap(plain, options, log))
            else:
                databases.append(_open_database(plain, file.path, scratch, definitions, log))
        except LogError as error:
            problems.append(error)
    if not databases and not readers:
        raise problems[0]
    for problem in problems:
        log.worsen("malformed", f"left out: {problem}")
    if databases:
        readers.insert(0, _database_reader(databases, definitions, scratch, options, log))
    return readers[0] if len(readers) == 1 and not scratch.folder else JoinedReader(tuple(readers), scratch)


def _open_mcap(path: Path, options: ReadOptions, log: ImportLog) -> LogReader:
    from parsers.mcap_log import McapImporter

    return McapImporter().open(path, options, log)


def _open_database(
    path: Path, shown: Path, scratch: Scratch, definitions: dict[str, tuple[str, str]], log: ImportLog
) -> Database:
    """Look into one SQLite file. Raises LogError."""
    try:
        with path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise LogError("not an SQLite file, though its name says so", path=shown)
        missing = missing_bytes(path)
        if missing:
            size = path.stat().st_size
            log.worsen(
                "truncated", f"{shown.name} breaks off: {size} of its {size + missing} bytes are there"
            )
        with closing(connect(path, scratch)) as connection:
            topics = read_topics(connection, shown)
            for type_name, entry in read_definitions(connection).items():
                definitions.setdefault(type_name, entry)
            first_ns = first_time(connection)
            counts = count_messages(connection, path, topics) if path.stat().st_size < COUNT_BELOW else {}
    except sqlite3.Error as error:
        raise LogError(f"the SQLite file cannot be read ({error})", path=shown) from error
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror or error})", path=shown) from error
    return Database(path, shown, tuple(topics), counts, first_ns, missing > 0)


def _database_reader(
    databases: Sequence[Database],
    definitions: dict[str, tuple[str, str]],
    scratch: Scratch,
    options: ReadOptions,
    log: ImportLog,
) -> DatabaseReader:
    """The reader over a bag's SQLite files, with a decoder for each of their types."""
    rows = [(database, row) for database in databases for row in database.topics]
    if not rows:
        raise LogError("the bag holds no topics", path=databases[0].shown, hint="check what was recorded")
    other = sorted({row.name for _, row in rows if row.serialization not in ("cdr", "")})
    if other:
        log.note(f"left out, not serialised as CDR: {', '.join(other[:4])}")
    kinds = [(row.name, row.type_name) for _, row in rows if row.name not in other]
    names = group_names(kinds)
    decoders: dict[str, MessageDecoder | None] = {}
    topics: dict[tuple[str, str], Topic] = {}
    for kind in names:
        topic, type_name = kind
        if type_name not in decoders:
            encoding, text = definitions.get(type_name, ("ros2msg", ""))
            decoders[type_name] = find_decoder(type_name, text, "cdr", log, encoding)
        decoder = decoders[type_name]
        if decoder is not None:
            topics[kind] = Topic(names[kind], topic, short_name(type_name), decoder, _count(kind, databases))
    first_ns = min(
        (database.first_ns for database in databases if database.first_ns is not None), default=None
    )
    wall_clock = is_wall_clock(first_ns, log)
    reader = DatabaseReader(tuple(databases), topics, scratch, options, log, wall_clock)
    for known in topics.values():
        reader.chooser.add(known.group, has_header=known.decoder.has_header)
    return reader


def _count(kind: tuple[str, str], databases: Sequence[Database]) -> int | None:
    """Messages of a topic in all files, None where one of them was not counted."""
    if any(not database.counts for database in databases):
        return None
    return sum(
        database.counts.get(row.id, 0)
        for database in databases
        for row in database.topics
        if (row.name, row.type_name) == kind
    )
