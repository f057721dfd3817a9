"""MCAP recordings with ROS 1, ROS 2 (CDR), JSON and protobuf messages.

Source: the MCAP specification, https://mcap.dev/spec, with its registry of message encodings.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from parsers.channels import ChannelInfo, Chunk
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions
from parsers.mcap_chunks import McapFile
from parsers.mcap_messages import Batcher, holds, messages_in
from parsers.mcap_records import MAGIC, Messages
from parsers.mcap_survey import Surveyor
from parsers.mcap_topics import Source, sources_of
from parsers.ros.stamps import StampChooser
from parsers.ros.topics import decode_chunk

_YEAR_1990_NS = 631_152_000_000_000_000
MAX_CELLS = 1 << 22
"""Numbers decoded at once: a batch of a type with many fields has fewer rows."""


def _open(path: Path) -> BinaryIO:
    try:
        return path.open("rb")
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
        keep = frozenset(channel for source, _ in picked for channel in source.ids)
        with _open(self._path) as file:
            opened = McapFile(self._path, file)
            for number, messages in self._batches(opened, [source for source, _ in picked], keep):
                yield from self._decode(*picked[number], messages)
        for source, _ in picked:
            for note in source.notes():
                self._log.note(f"{source.topic.group}: {note}")
        self._chooser.finish(self._log)

    def _batches(
        self, file: McapFile, sources: list[Source], keep: frozenset[int]
    ) -> Iterator[tuple[int, Messages]]:
        batcher = Batcher([source.ids for source in sources])
        for span in self._survey.spans:
            if not holds(span, keep):
                continue
            for messages in messages_in(file, span, keep, self._log):
                yield from batcher.add(messages)
                self._options.progress(span.offset, file.size)
        yield from batcher.rest()
        self._options.progress(file.size, file.size)

    def _decode(self, source: Source, paths: tuple[str, ...], messages: Messages) -> Iterator[Chunk]:
        """Decode a batch, in parts where it would become too many numbers."""
        rows = max(256, MAX_CELLS // len(paths))
        for start in range(0, messages.length.size, rows):
            part = slice(start, start + rows)
            place = (messages.offset[part], messages.length[part], messages.log_ns[part])
            yield decode_chunk(source.topic, paths, messages.data, place, self._chooser, self._log)


class McapImporter:
    """MCAP files, whole or broken off, with or without an index."""

    name = "mcap"
    title = "MCAP"
    suffixes = (".mcap",)

    def claims(self, path: Path, head: bytes) -> bool:
        """By the magic bytes."""
        return head.startswith(MAGIC)

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> McapReader:
        """Raises LogError where there is no topic that could be read."""
        return McapReader(path, options, log)
