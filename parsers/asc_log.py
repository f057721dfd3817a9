"""Vector ASC logs (CANalyzer, CANoe and what writes like them)."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from parsers.can.asc_kernel import parse_asc, walk_asc
from parsers.can.reader import CanReader
from parsers.can.tally import AS_WRITTEN, SUMMED
from parsers.can.textlines import TextSource, Work, first_lines, head_lines, looks_like_text
from parsers.channels import ByteArray, IntArray
from parsers.errors import LogError
from parsers.importer import HEAD_BYTES, TAKEN_AS_UTC, ImportLog, ReadOptions
from parsers.wide_text import narrow_text

_DATE = re.compile(r"^\s*date\s+(\S.*)", re.IGNORECASE)
_TRIGGER = re.compile(r"^\s*begin\s+triggerblock\s+(\S.*)", re.IGNORECASE)
_BASE = re.compile(r"^\s*base\s+(hex|dec)\b(?:\s+timestamps\s+(absolute|relative)\b)?", re.IGNORECASE)
_FRAME = re.compile(
    r"^\s*\d+[.,]\d+\s+(?:\d+\s+[0-9A-F]+x?\s+(?:Rx|Tx|TxRq)\s+[dr]\b|CANFD\s+\d+\s+(?:Rx|Tx)\s)",
    re.IGNORECASE,
)
_ANY_FRAME = re.compile(r"^\s*\d+[.,]\d+\s+\d+\s+(\w+)\s+(?:Rx|Tx|TxRq)\s+[dr]\b", re.IGNORECASE)
_SAMPLE_BYTES = 1 << 16
_DAY = re.compile(
    r"\b(?:(?P<year>\d{4})([-/.])(?P<m>\d{1,2})\2(?P<d>\d{1,2})|(?P<a>\d{1,2})([-/.])(?P<b>\d{1,2})\6(?P<last>\d{4}))\b"
)
_MONTHS = {
    "jan": 1, "feb": 2, "mar": 3, "mär": 3, "mrz": 3, "apr": 4, "may": 5, "mai": 5, "jun": 6,
    "jul": 7, "aug": 8, "sep": 9, "oct": 10, "okt": 10, "nov": 11, "dec": 12, "dez": 12,
}  # fmt: skip


class AscImporter:
    """Vector ASC."""

    name = "asc"
    title = "Vector ASC"
    suffixes = (".asc",)

    def claims(self, path: Path, head: bytes) -> bool:
        """Whether the file begins with an ASC header, or a frame in ASC's layout."""
        if not looks_like_text(head):
            return False
        lines = head_lines(head)[:60]
        header = any(_BASE.match(line) for line in lines)
        dated = any(_DATE.match(line) and read_date(line) is not None for line in lines)
        return header or dated or any(_FRAME.match(line) for line in lines)

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> CanReader:
        """Raises LogError where the file cannot be read."""
        text = narrow_text(path, log)
        header = read_header(first_lines(text, HEAD_BYTES))
        for note in header.notes:
            log.note(note)
        _refuse_symbols(first_lines(text, _SAMPLE_BYTES), header.base, path, log)
        if header.start is not None:
            log.began(header.start)

        clock = "log time since the start of measurement"
        source = TextSource(text, log, options.progress, _Parser(header), clock=clock, absolute=False)
        return CanReader(source, options, log, path)


def _refuse_symbols(lines: list[str], base: int, path: Path, log: ImportLog) -> None:
    """Raise LogError for frames that have messages' names in place of identifiers; of a log with both, the names are noted."""
    words = Counter(found[1] for line in lines if (found := _ANY_FRAME.match(line)))
    number = re.compile(r"(?:[0-9a-f]+|[0-9]+)x?" if base == 16 else r"[0-9]+x?", re.IGNORECASE)
    # one that stands once may be a number that damage spoilt
    names = [word for word, count in words.items() if count > 1 and not number.fullmatch(word)]
    if not names:
        return
    shown = ", ".join(names[:3]) + (" …" if len(names) > 3 else "")
    if not any(number.fullmatch(word) for word in words):
        raise LogError(
            f"the frames have symbolic names ({shown}) in place of identifiers, which cogest does not read",
            path=path,
            hint="export the log again with numeric identifiers (in CANoe and CANalyzer: without symbolic display), or as BLF",
        )
    log.note(f"frames that have symbolic names in place of identifiers ({shown}) are left out")


@dataclass(frozen=True)
class AscHeader:
    """base: 16 or 10, of identifiers and payload. relative: a stamp counts from the line before it."""

    base: int
    relative: bool
    start: datetime | None
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Parser:
    """The kernel for lines written as the header says."""

    header: AscHeader

    @property
    def meaning(self) -> int:
        """What stamps mean."""
        return SUMMED if self.header.relative else AS_WRITTEN

    def parse(self, text: ByteArray, begin: int, stop: int, ended: bool, work: Work) -> int:
        """Read the lines in [begin, stop) as long as there is room; where it stopped."""
        header = self.header
        return parse_asc(
            text, begin, stop, header.base, header.relative, ended, work.book, work.rows, work.layouts
        )

    def walk(self, text: ByteArray, walk: IntArray, work: Work) -> bool:
        """Parse all that a walk has left; whether it stopped for want of room."""
        return walk_asc(
            text, walk, self.header.base, self.header.relative, work.book, work.rows, work.layouts
        )


def read_header(lines: list[str]) -> AscHeader:
    """What the lines before the first event say. A file without them is hexadecimal and absolute."""
    base, relative, start = 16, False, None
    notes: list[str] = []
    found_base = False
    for line in lines:
        if match := _BASE.match(line):
            found_base = True
            base = 10 if match[1].lower() == "dec" else 16
            relative = (match[2] or "").lower() == "relative"
        elif start is None and (dated := _DATE.match(line)):
            start = read_date(line)
            if start is None:
                notes.append(f"the date in the ASC header is not understood ({dated[1].strip()!r})")
        elif start is not None and _TRIGGER.match(line):
            # some writers date a file when they write it, and its trigger block when it was recorded
            start = min(start, read_date(line) or start)
        elif _FRAME.match(line):
            break
    if not found_base:
        notes.append(
            "the ASC header does not say how numbers are written: taken as hexadecimal, stamps as absolute"
        )
    if start is not None:
        text = start.isoformat(sep=" ", timespec="milliseconds")
        notes.append(f"recorded from {text} (local time of the recorder, time zone unknown: {TAKEN_AS_UTC})")
    return AscHeader(base, relative, start, tuple(notes))


def _day_and_month(numbers: re.Match[str], *, american: bool) -> tuple[int, int]:
    """Of a date in numbers. american: with AM or PM, where slashes mean that the month comes first."""
    if numbers["year"]:
        return int(numbers["d"]), int(numbers["m"])
    first, second = int(numbers["a"]), int(numbers["b"])
    if second > 12 or (american and numbers[6] == "/" and first <= 12):
        first, second = second, first
    return first, second


def read_date(line: str) -> datetime | None:
    """The moment in a header's date line, None where it is not understood.

    English and German months or numbers (16.03.2024, 03/16/2024, 2024-03-16), 12 and 24 hours. What follows the seconds' point is a number of milliseconds, which
    some writers do not pad: ".7" is 7 ms.
    """
    # umlauts come in Latin-1 or UTF-8
    text = line.lower().replace("ã¤", "ä")
    clock = re.search(r"\b(\d{1,2}):(\d\d):(\d\d)(?:[.,](\d{1,6}))?\s*(am|pm)?", text)
    year = re.search(r"\b((?:19|20)\d\d)\b", text)
    words = re.findall(r"[a-zä]+", text)[1:]
    month = next((_MONTHS[word[:3]] for word in reversed(words) if word[:3] in _MONTHS), None)
    numbers = _DAY.search(text)
    if clock is None or year is None:
        return None
    if month is not None:
        found = re.search(r"\b(\d{1,2})\b", text[: clock.start()])
        day = int(found[1]) if found else 0
    elif numbers is not None:
        day, month = _day_and_month(numbers, american=bool(clock[5]))
    else:
        return None
    hour = int(clock[1])
    if clock[5]:
        hour = hour % 12 + (12 if clock[5] == "pm" else 0)
    fraction = clock[4] or "0"
    micro = int(fraction) * 1000 if len(fraction) <= 3 else int(fraction.ljust(6, "0"))
    try:
        return datetime(int(year[1]), month, day, hour, int(clock[2]), int(clock[3]), micro)
    except ValueError:
        return None
