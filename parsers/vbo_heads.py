"""Further heads among a VBO file's rows: a logger that appends to its file, or two files in one. What follows may have other columns.

They are looked for only where lines were met that are no rows, so that they cost good logs nothing.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import timedelta
from pathlib import Path
from typing import BinaryIO

from parsers.table_text import Encoding, decode
from parsers.vbo_header import VboHead, read_head

HEAD_LIMIT = 4 * 1024 * 1024
"""No head is longer."""

_PIECE = 1024 * 1024
_BEFORE = 512
"""Bytes before a section in which the line with the date is looked for."""

_SECTION = re.compile(rb"\[(?:header|column names|data)\]", re.IGNORECASE)
_CREATED = re.compile(rb"[\r\n][ \t]*(file created on[^\r\n]*\s*)\Z", re.IGNORECASE)
_SAME_DRIVE = timedelta(hours=12)
"""Heads whose dates are further apart are of two drives: times of day would be laid on the wrong day."""


@dataclass(frozen=True)
class FurtherHead:
    """A head among the rows. at: the byte at which it begins. body: of the first row behind it."""

    at: int
    body: int
    head: VboHead


def further_heads(path: Path, start: int, encoding: Encoding) -> Iterator[FurtherHead]:
    """The heads from byte `start` of a file's rows on. Raises OSError where the file cannot be read."""
    with path.open("rb") as file:
        at = start
        while (found := _next_section(file, at)) is not None:
            begin = max(start, found - _BEFORE)
            before = _bytes(file, begin, found - begin)
            created = _CREATED.search(b"\n" + before)
            head_at = found - len(created[1]) if created is not None else found
            text, body = _head_text(file, head_at)
            yield FurtherHead(head_at, body, read_head(decode(text, encoding)))
            at = start = body


def _bytes(file: BinaryIO, at: int, count: int) -> bytes:
    file.seek(at)
    return file.read(count)


def _next_section(file: BinaryIO, at: int) -> int | None:
    """Where the next section begins that only heads have, at the beginning of a line; None where there is none."""
    # a line that begins just here is told by the line end before it
    base = max(at - 1, 0)
    while data := _bytes(file, base, _PIECE + 64):
        place = data.find(b"[")
        while 0 <= place < _PIECE:
            line = max(data.rfind(b"\n", 0, place), data.rfind(b"\r", 0, place))
            if line >= 0 and not data[line:place].strip() and _SECTION.match(data, place):
                return base + place
            place = data.find(b"[", place + 1)
        # what begins with the last line of this piece is seen with the next one
        base += _PIECE - 1
    return None


def _head_text(file: BinaryIO, at: int) -> tuple[bytes, int]:
    """A head's text, and where the rows behind it begin: the end of what was read where it has no [data]."""
    data = _bytes(file, at, HEAD_LIMIT)
    end = data.lower().find(b"[data]")
    if end < 0:
        return data, at + len(data)
    line = data.find(b"\n", end)
    return data[:end], at + (line + 1 if line >= 0 else len(data))


def goes_on(first: VboHead, other: VboHead) -> bool:
    """Whether the rows behind another head are the first one's drive: the same columns and units, and no other day."""
    alike = all(
        not theirs or _plain(theirs) == _plain(own)
        for own, theirs in (
            (first.names, other.names),
            (first.titles, other.titles),
            (first.units, other.units),
        )
    )
    if first.created is None or other.created is None:
        return alike
    return alike and abs(other.created - first.created) <= _SAME_DRIVE


def _plain(lines: Sequence[str]) -> list[str]:
    kept = [line.strip().casefold() for line in lines]
    while kept and not kept[-1]:
        kept.pop()
    return kept


def ended_by(path: Path, found: FurtherHead, first: VboHead, size: int) -> str:
    """The sentence about a second drive in the file. Raises OSError where the file cannot be read."""
    line = _line_ends(path, 0, found.at) + 1
    rows = _line_ends(path, found.body, size)
    if found.head.created is not None and goes_on(replace(first, created=None), found.head):
        what = f"a second drive, of {found.head.created:%Y-%m-%d %H:%M},"
    else:
        shown = " ".join(found.head.names[:5]) + (" …" if len(found.head.names) > 5 else "")
        what = f"a second drive with other columns or units ({shown!r})"
    return (
        f"{what} begins at line {line} of the file: the log ends there, and the {rows} lines of rows behind its head are left "
        "out; split the file there"
    )


def _line_ends(path: Path, start: int, stop: int) -> int:
    count = 0
    with path.open("rb") as file:
        file.seek(start)
        while start < stop and (data := file.read(min(_PIECE, stop - start))):
            count += data.count(b"\n")
            start += len(data)
    return count
