"""PEAK TRC logs (PCAN-View, PCAN-Explorer, PCAN-Trace), versions 1.0 to 2.1."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from parsers.can.reader import CanReader
from parsers.can.tally import AS_WRITTEN
from parsers.can.textlines import TextSource, Work, first_lines, head_lines, looks_like_text
from parsers.can.trc_kernel import parse_trc, walk_trc
from parsers.channels import ByteArray, IntArray
from parsers.errors import LogError
from parsers.importer import TAKEN_AS_UTC, ImportLog, ReadOptions
from parsers.wide_text import narrow_text

COLUMNS_OF_VERSION = {
    "1.0": "NOILD",
    "1.1": "NOdILD",
    "1.2": "NOBdILD",
    "1.3": "NOBdIRLD",
    "2.0": "NOTIdlD",
    "2.1": "NOTBIdRLD",
}
"""Columns by the letters of $COLUMNS; versions 1.x write their direction or kind of event in d."""

_VERSION = re.compile(r"^\s*;\s*\$FILEVERSION\s*=\s*(\d+\.\d+)", re.IGNORECASE)
_START = re.compile(r"^\s*;\s*\$STARTTIME\s*=\s*(\d+(?:[.,]\d+)?)", re.IGNORECASE)
_STATED = re.compile(r"^\s*;\s*Start time:\s*(\S.*?)\s*$", re.IGNORECASE)
"""As version 1.0 has it, which lacks the other, in words of the recorder's country."""
_DAY_FIRST = re.compile(
    r"(\d{1,2})([./])(\d{1,2})\2(\d{4})[ ,]+(\d{1,2}):(\d{2}):(\d{2})(?:[.,](\d{1,6}))?(?:\.\d+)?\s*([AP]M)?",
    re.IGNORECASE,
)
_COLUMNS = re.compile(r"^\s*;\s*\$COLUMNS\s*=\s*([A-Za-z](?:\s*,\s*[A-Za-z])*)", re.IGNORECASE)
_OLD_LINE = re.compile(
    r"^\s*\d+\)\s+\d+(\.\d+)?\s+(?:(?:\d+\s+)?(?:Rx|Tx|Error|Warng)\s+)?[0-9A-F]{3,8}\s", re.I
)
_DAY_ZERO = datetime(1899, 12, 30)
_HEADER_BYTES = 1 << 16


class TrcImporter:
    """PEAK TRC."""

    name = "trc"
    title = "PEAK TRC"
    suffixes = (".trc",)

    def claims(self, path: Path, head: bytes) -> bool:
        """Whether the file names its TRC version, or begins with comments and a line of version 1.0's layout."""
        if not looks_like_text(head):
            return False
        lines = head_lines(head)
        if any(_VERSION.match(line) for line in lines[:20]):
            return True
        data = [line for line in lines if line.strip() and not line.lstrip().startswith(";")]
        return bool(data) and _OLD_LINE.match(data[0]) is not None

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> CanReader:
        """Raises LogError where the file's version is not known."""
        text = narrow_text(path, log)
        header = read_header(first_lines(text, _HEADER_BYTES), path)
        if header.start is not None:
            started = header.start.isoformat(sep=" ", timespec="milliseconds")
            log.began(header.start)
            log.note(f"recorded from {started} (clock of the recorder, time zone unknown: {TAKEN_AS_UTC})")

        clock = "receive time since the start of the trace"
        parser = _Parser(header.columns)
        source = TextSource(text, log, options.progress, parser, clock=clock, absolute=False)
        return CanReader(source, options, log, path)


@dataclass(frozen=True)
class TrcHeader:
    """columns: letters in order, D last. start: on the recorder's clock."""

    version: str
    columns: str
    start: datetime | None


class _Parser:
    """The kernel for a trace's columns."""

    meaning = AS_WRITTEN

    def __init__(self, columns: str) -> None:
        self._columns = np.frombuffer(columns.encode("ascii"), dtype=np.uint8)

    def parse(self, text: ByteArray, begin: int, stop: int, ended: bool, work: Work) -> int:
        """Read the lines in [begin, stop) as long as there is room; where it stopped."""
        return parse_trc(text, begin, stop, self._columns, work.book, work.rows, work.layouts)

    def walk(self, text: ByteArray, walk: IntArray, work: Work) -> bool:
        """Parse all that a walk has left; whether it stopped for want of room."""
        return walk_trc(text, walk, self._columns, work.book, work.rows, work.layouts)


def read_header(lines: list[str], path: Path) -> TrcHeader:
    """Version, columns and start of a trace. Raises LogError for a version or columns that are not known."""
    version, columns, start, stated = "1.0", "", None, ""
    for line in lines:
        if line.strip() and not line.lstrip().startswith(";"):
            break
        if match := _VERSION.match(line):
            version = match[1]
        elif match := _START.match(line):
            start = _from_days(float(match[1].replace(",", ".")))
        elif match := _STATED.match(line):
            stated = match[1]
        elif match := _COLUMNS.match(line):
            columns = re.sub(r"[\s,]", "", match[1])
    if version.startswith("1."):
        # versions 1.x have no such line; what stands there is some writer's remark
        columns = ""
    if version not in COLUMNS_OF_VERSION and not columns:
        known = ", ".join(COLUMNS_OF_VERSION)
        raise LogError(
            f"TRC version {version} is not known (known: {known})",
            path=path,
            place="header",
            hint="save the trace in one of these versions with PEAK's converter",
        )
    columns = columns or COLUMNS_OF_VERSION[version]
    missing = [letter for letter in "OID" if letter not in columns]
    if missing or not ("l" in columns or "L" in columns) or not columns.endswith("D"):
        raise LogError(
            f"$COLUMNS={','.join(columns)} lacks what a frame needs (O, I, l or L, D last)", path=path
        )
    return TrcHeader(version, columns, start or _from_words(stated))


def _from_days(days: float) -> datetime | None:
    """The moment that a number of days since 1899-12-30 means; None beyond what the calendar holds."""
    if not math.isfinite(days) or not 0 < days < 2_900_000:
        return None
    # the text carries about ten microseconds
    return _DAY_ZERO + timedelta(milliseconds=round(days * 86_400_000))


def _from_words(text: str) -> datetime | None:
    """The moment that "18.12.2021 14:28:07.062", "12/18/2021 2:28:07 PM" or an ISO date means; None where day and month may be either."""
    try:
        return datetime.fromisoformat(text).replace(tzinfo=None)
    except ValueError:
        match = _DAY_FIRST.fullmatch(text)
    if match is None:
        return None
    first, second = int(match[1]), int(match[3])
    if match[2] == "/" and first <= 12 and second <= 12 and first != second:
        return None
    day, month = (second, first) if match[2] == "/" and first <= 12 else (first, second)
    hour = int(match[5])
    if match[9]:
        hour = hour % 12 + 12 * (match[9].upper() == "PM")
    try:
        return datetime(
            int(match[4]),
            month,
            day,
            hour,
            int(match[6]),
            int(match[7]),
            int((match[8] or "0").ljust(6, "0")),
        )
    except ValueError:
        return None
