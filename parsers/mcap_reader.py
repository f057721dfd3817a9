"""The reader of MCAP recordings with ROS 1, ROS 2 (CDR), JSON and protobuf messages.

Source: the MCAP specification, https://mcap.dev/spec, with its registry of message encodings.
"""

from __future__ import annotations

from collections.abc import Iterator
from io import FileIO
from pathlib import Path

from parsers.allocator import Slabs, keep_freed_memory
from parsers.channels import ChannelInfo, Chunk
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions
from parsers.json_decode import NewKeys
from parsers.mcap_batches import Reader, groups_of
from parsers.mcap_chunks import McapFile
from parsers.mcap_join import Joiner
from parsers.mcap_parts import Part, Want
from parsers.mcap_survey import Surveyor
from parsers.mcap_topics import Source, sources_of
from parsers.parallel import in_order
from parsers.ros.stamps import StampChooser

_YEAR_1990_NS = 631_152_000_000_000_000


def _open(path: Path) -> FileIO:
    try:
        return path.open("rb", buffering=0)
    except OSError as error:
        raise LogError(f"cannot be opened ({error.strerror})", path=path) from error


class McapReader:
    """An opened MCAP file; see `parsers.importer.LogReader`."""

    def __init__(self, path: Path, options: ReadOptions, log: ImportLog) -> None:
        self._path, self._options, self._log = path, options, log
        with _open(path) as file:
            opened = McapFile(path, file)
            self._survey = Surveyor(opened, log).survey()
            self._sources = sources_of(opened, self._survey, log)
        self._chooser = StampChooser()
        for source in self._sources:
            self._chooser.add(source.topic.group, has_header=source.topic.decoder.has_header)
        self._channels = tuple(channel for source in self._sources for channel in source.channels())

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """All fields of all topics whose encoding is known."""
        return self._channels

    @property
    def clock(self) -> str:
        """Header stamps before the time of receipt (log time); which topics have which."""
        return self._chooser.clock

    @property
    def absolute(self) -> bool:
        """Whether the recorder's stamps count from 1970."""
        return self._survey.start_ns > _YEAR_1990_NS

    @property
    def start_utc_ns(self) -> int | None:
        """None: absolute stamps say it themselves, and of relative ones MCAP does not know it."""
        return None

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Yield the wanted channels, batch by batch; chunks of the file without them are not read."""
        picked = [(source, source.topic.wanted_paths(wanted)) for source in self._sources]
        picked = [(source, paths) for source, paths in picked if paths]
        if not picked:
            return
        sources = [source for source, _ in picked]
        wants = [Want(source.ids, source.topic.decoder, paths) for source, paths in picked]
        keep_freed_memory()
        slabs = Slabs()
        joiner = Joiner(len(wants), slabs)
        new_keys = [NewKeys() for _ in wants]
        with _open(self._path) as file:
            for part in self._parts(McapFile(self._path, file), wants, slabs):
                new_keys[part.number].add(part.decoded)
                for joined in joiner.add(part):
                    yield self._chunk(sources[joined.number], joined)
        for joined in joiner.rest():
            yield self._chunk(sources[joined.number], joined)
        for source, found in zip(sources, new_keys, strict=True):
            for note in (*source.notes(), *found.notes):
                self._log.note(f"{source.topic.group}: {note}")
        self._chooser.finish(self._log)

    def _parts(self, file: McapFile, wants: list[Want], slabs: Slabs) -> Iterator[Part]:
        """Decode the file on all cores; what went wrong is written down in the order of the file."""
        keep = frozenset(channel for want in wants for channel in want.ids)
        reader = Reader(file, wants, slabs)
        for result in in_order(reader, groups_of(file, self._survey.spans, keep, self._log)):
            result.write(self._log)
            yield from reader.parts(result)
            self._options.progress(result.place, file.size)
        self._options.progress(file.size, file.size)

    def _chunk(self, source: Source, part: Part) -> Chunk:
        """The columns of a topic's messages under their names, with the time chosen."""
        group, decoded = source.topic.group, part.decoded
        self._log.messages += part.log_ns.size
        self._log.reject(decoded.why_bad, decoded.bad)
        time_ns = self._chooser.choose(group, decoded.stamp_ns, part.log_ns, unread=decoded.bad)
        return Chunk(group, time_ns, {f"{group}.{path}": x for path, x in decoded.columns.items()})
