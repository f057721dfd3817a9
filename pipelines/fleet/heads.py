"""What a file is, by its first bytes: a log, a log that will not be read, something that belongs to logs, or no log."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from parsers.errors import LogError
from parsers.importer import HEAD_BYTES, Importer, ReadOptions
from parsers.parallel import in_order
from parsers.places import remote
from parsers.registry import FORMATS, importer_at
from pipelines.fleet.entries import Entry
from pipelines.fleet.logs import Log
from pipelines.fleet.names import stem_of
from pipelines.fleet.suffixes import (
    LOG_SUFFIXES,
    NO_LOG_SUFFIXES,
    TABLE_SUFFIXES,
    is_quiet,
    suffix_of,
    why_packed,
)
from pipelines.fleet.table_heads import TableHeads, TableLook, names_a_time

_CSV = "csv"
_FAR_WORKERS = 16
Verdict = Log | str | None
"""A log; why a file is none; or None: not worth a word."""


@dataclass(frozen=True)
class _Head:
    """A file's first bytes, or why there are none."""

    path: Path
    head: bytes = b""
    failed: str = ""


_Begun = _Head | str | None


def _begin(entry: Entry) -> _Begun:
    """A file's first bytes; why it is no log, or None, where its name says so already."""
    if is_quiet(entry.name):
        return None
    if why := why_packed(entry.name):
        return why
    if suffix_of(entry.name) in NO_LOG_SUFFIXES:
        return "no log, by its suffix"
    path = entry.path
    if entry.size == 0:
        return _Head(path, failed="the file is empty (0 bytes)")
    try:
        far = remote(path)
        if far is not None:
            # opened, it would fetch ahead
            return _Head(path, far.fetch(0, min(entry.size, HEAD_BYTES)))
        with path.open("rb") as file:
            return _Head(path, file.read(HEAD_BYTES))
    except OSError as error:
        return _Head(path, failed=f"cannot be opened ({error.strerror or error})")


@dataclass
class Heads:
    """Looks at files. options: what the mapping file for a log (its own, or its folder's) says of CSV time columns."""

    options: Callable[[Entry], ReadOptions]
    tables: TableHeads = field(default_factory=TableHeads)

    def look_at_all(self, entries: Iterable[Entry]) -> Iterator[tuple[Entry, Verdict]]:
        """What each file is, in order. Files behind a URL are asked for several at a time: each costs a way there and back."""
        entries = list(entries)
        workers = _FAR_WORKERS if entries and "://" in entries[0].place else 1
        for entry, begun in zip(entries, in_order(_begin, entries, workers=workers), strict=True):
            yield entry, self._look(entry, begun)

    def look(self, entry: Entry) -> Verdict:
        """What a file is. Reads its first bytes alone, of tables at most a quarter of a MiB."""
        return self._look(entry, _begin(entry))

    def _look(self, entry: Entry, begun: _Begun) -> Verdict:
        if begun is None or isinstance(begun, str):
            return begun
        if begun.failed:
            sure = suffix_of(entry.name) in LOG_SUFFIXES
            return _log(entry, None, b"", begun.failed) if sure else begun.failed
        return self._claimed(entry, begun.path, begun.head, suffix_of(entry.name))

    def _claimed(self, entry: Entry, path: Path, head: bytes, suffix: str) -> Verdict:
        known = self.tables.known_look(head, self.options(entry)) if suffix in TABLE_SUFFIXES else None
        if known is not None:
            # no other format claimed the first log with this header
            return _log(entry, importer_at(FORMATS[-1]), head, look=known)
        importer = _binary_or_framed(path, head, suffix)
        if importer is not None:
            if importer.name == "parquet" and (why := _no_time_in_parquet(path)):
                return why
            return _log(entry, importer, head)
        table = self._table(entry, path, head)
        if isinstance(table, TableLook) and suffix not in LOG_SUFFIXES and not table.mostly_numbers:
            return "a text with times, but hardly a number beside them"
        if isinstance(table, TableLook):
            return _log(entry, importer_at(FORMATS[-1]), head, look=table)
        if suffix in TABLE_SUFFIXES and names_a_time(head, path):
            return _log(entry, importer_at(FORMATS[-1]), head, f"{table}: only its header is there")
        if suffix in LOG_SUFFIXES and suffix not in TABLE_SUFFIXES:
            return _log(entry, None, head, "not a format that cogest knows, or cut off in its header")
        if suffix in TABLE_SUFFIXES and b"\0" in head[:512]:
            return _log(entry, None, head, "not text: damaged, or not what its suffix says")
        return table

    def _table(self, entry: Entry, path: Path, head: bytes) -> TableLook | str:
        """The table of text that a file is, or why it is no log."""
        if head.lstrip()[:1] in (b"{", b"<") or b"\0\0" in head[:64]:
            return "no format that cogest knows"
        try:
            return self.tables.look(path, head, self.options(entry))
        except LogError as error:
            return (
                "no format that cogest knows"
                if error.problem == "not text"
                else f"a text, but {error.problem}"
            )


def _binary_or_framed(path: Path, head: bytes, suffix: str) -> Importer | None:
    """The importer that claims a file by its content, tables of text left aside."""
    for line in FORMATS:
        importer = importer_at(line)
        if importer.name == _CSV:
            continue
        if importer.claims(path, head):
            return importer
    return None


_DAYS = ("date", "datum")
"""Names of columns of texts that mostly are days, as those of receipts."""


def _no_time_in_parquet(path: Path) -> str:
    """Why a Parquet file is a table of something else; "" where it is a log, or cannot be read, which its drive will say."""
    import polars as pl

    from parsers.parquet_columns import is_text
    from parsers.parquet_parts import PartlyFilled
    from parsers.table_cells import NumberStyle
    from parsers.table_names import split_header
    from parsers.table_time import find_time, is_called_time

    try:
        far = remote(path)
        # of a file behind a URL only the table of contents is fetched
        filled = PartlyFilled(far) if far is not None else None
        schema: Mapping[str, pl.DataType] = pl.read_parquet_schema(path if filled is None else filled.path)
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException, LogError, OSError, ValueError):
        return ""
    if any(isinstance(kind, (pl.Datetime, pl.Duration)) for kind in schema.values()):
        return ""
    texts = [split_header(name) for name, kind in schema.items() if is_text(kind)]
    if any(is_called_time(each) and each.name.lower() not in _DAYS for each in texts):
        # times as texts, which are read
        return ""
    numbers = [name for name, kind in schema.items() if kind.is_numeric()]
    names = [split_header(name) for name in numbers]
    try:
        find_time(names, [("0", "1")] * len(names), NumberStyle("."), ReadOptions(), path)
    except LogError:
        return "a Parquet table without a time column"
    return ""


def _log(
    entry: Entry, importer: Importer | None, head: bytes, trouble: str = "", look: TableLook | None = None
) -> Log:
    return Log(
        place=entry.place,
        below=entry.below,
        size=entry.size,
        stem=stem_of(entry.name),
        format=importer.name if importer else "",
        title=importer.title if importer else "unknown",
        trouble=trouble,
        look=look,
        digest=hashlib.blake2b(head, digest_size=16).digest() if head else b"",
        changed=entry.changed,
    )
