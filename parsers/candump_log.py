"""candump logs: `candump -l` files and what candump prints on a console."""

from __future__ import annotations

import contextlib
import re
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np

from parsers.can.candump_kernel import DATED, DELTA, PLAIN, parse_candump, walk_candump
from parsers.can.reader import CanReader
from parsers.can.tally import AS_WRITTEN, SINCE_FIRST, SUMMED
from parsers.can.textlines import TextSource, Work, first_lines, head_lines, looks_like_text
from parsers.channels import ByteArray, IntArray
from parsers.coloured_text import plain_text, without_colours
from parsers.errors import LogError
from parsers.importer import TAKEN_AS_UTC, ImportLog, ReadOptions
from parsers.wide_text import narrow_text

_STAMP = r"\(\s*(?P<stamp>\d+\.\d+|\d{4}-\d\d-\d\d \d\d:\d\d:\d\d\.\d+)\s*\)"
_NAME = r"[A-Za-z_][\w.:-]{0,15}"
_FILE = re.compile(rf"^\s*{_STAMP}\s+{_NAME}\s+[0-9A-Fa-f]{{3,8}}#")
_CONSOLE = re.compile(
    rf"^\s*(?:{_STAMP}\s+)?{_NAME}\s+(?:[TR]X(?:\s+[-BE]){{0,2}}\s+)?[0-9A-Fa-f]{{3,8}}\s+\[\d{{1,2}}\]"
)
_MEANINGS = {PLAIN: AS_WRITTEN, DELTA: SUMMED, DATED: SINCE_FIRST}
_SAMPLE_BYTES = 1 << 16
_WALL_CLOCK_FROM_S = 100_000_000
"""Stamps below (1973) count from the log's own zero."""


class CandumpImporter:
    """candump of can-utils, in both dialects."""

    name = "candump"
    title = "candump"
    suffixes = (".log", ".candump", ".txt")

    def claims(self, path: Path, head: bytes) -> bool:
        """Whether one of the first lines is a frame in candump's layout."""
        head = without_colours(head)
        if not looks_like_text(head):
            return False
        return any(_FILE.match(line) or _CONSOLE.match(line) for line in head_lines(head)[:20])

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> CanReader:
        """Raises LogError where the frames carry no time stamps."""
        text = plain_text(narrow_text(path, log), log)
        lines = first_lines(text, _SAMPLE_BYTES)
        how, absolute, clock = _time_of(lines, path, log)
        source = TextSource(text, log, options.progress, _Parser(how), clock=clock, absolute=absolute)
        return CanReader(source, options, log, path)


@dataclass(frozen=True)
class _Parser:
    """The kernel for stamps written as `how` says, one of `parsers.can.candump_kernel`."""

    how: int

    @property
    def meaning(self) -> int:
        """What stamps mean."""
        return _MEANINGS[self.how]

    def parse(self, text: ByteArray, begin: int, stop: int, ended: bool, work: Work) -> int:
        """Read the lines in [begin, stop) as long as there is room; where it stopped."""
        return parse_candump(
            text, begin, stop, self.how, work.names, work.sizes, work.book, work.rows, work.layouts
        )

    def walk(self, text: ByteArray, walk: IntArray, work: Work) -> bool:
        """Parse all that a walk has left; whether it stopped for want of room."""
        return walk_candump(text, walk, self.how, work.names, work.sizes, work.book, work.rows, work.layouts)


def _time_of(lines: list[str], path: Path, log: ImportLog) -> tuple[int, bool, str]:
    """How the stamps are written, whether they count from 1970, and the clock in words."""
    stamps: list[str] = []
    bare: list[int] = []
    console = False
    for number, line in enumerate(lines, start=1):
        in_file = _FILE.match(line)
        found = in_file or _CONSOLE.match(line)
        if found is None:
            continue
        console = console or in_file is None
        if found["stamp"] is None:
            bare.append(number)
        else:
            stamps.append(found["stamp"])
    # a line that lost its stamp by damage is not a log without stamps
    if len(bare) > len(stamps):
        raise LogError(
            "a candump console log without time stamps, from which no signal over time can be made",
            path=path,
            place=f"line {bare[0]}",
            hint="record with `candump -l` or `candump -t a`",
        )
    if stamps and "-" in stamps[0]:
        with contextlib.suppress(ValueError):
            # a date that there is not has lost a bit or two
            log.began(datetime.fromisoformat(stamps[0]))
        log.note(
            f"recorded from {stamps[0]} (local time of the recorder, time zone unknown: {TAKEN_AS_UTC}); time counts from there"
        )
        return DATED, False, "local time of the recorder since its first frame"
    seconds = np.array([float(stamp) for stamp in stamps if "-" not in stamp])
    if seconds.size == 0 or seconds[0] >= _WALL_CLOCK_FROM_S:
        return PLAIN, True, "receive time of the recorder, UTC"
    if console and _are_differences(seconds):
        log.note("the stamps are differences from frame to frame (candump -t d): they were summed up")
        return DELTA, False, "sum of the differences between frames"
    return PLAIN, False, "receive time since the log's own zero"


def _are_differences(seconds: np.ndarray[tuple[int], np.dtype[np.float64]]) -> bool:
    """Whether stamps are steps and not time: they go up and down, or are all one step after the first."""
    if seconds.size < 3:
        return False
    steps = np.diff(seconds)
    return bool((steps < 0).any() or (seconds[0] == 0 and seconds[1] > 0 and (steps[1:] == 0).all()))
