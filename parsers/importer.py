"""The contract of an importer, and the log book in which it writes down what it met.

An importer is one class in one file and one line in `parsers.registry`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path
from typing import Literal, Protocol

from parsers.channels import ChannelInfo, Chunk

HEAD_BYTES = 4096
"""How much of a file's beginning `claims` is given."""

Status = Literal["complete", "truncated", "malformed"]
_SEVERITY: dict[Status, int] = {"complete": 0, "truncated": 1, "malformed": 2}


def no_progress(done: int, total: int) -> None:
    """Report nothing."""


@dataclass(frozen=True)
class ReadOptions:
    """What the user said about how to read a log.

    dbc: CAN databases, in the order given. dbc_given: the user named them; else they were found beside the log, and one
    that cannot be used is left out with a note. buses: those that a database is of, by its file's name, where the mapping file
    says so. time_channel / time_unit: the mapping file's [time] table (CSV only).
    progress: called now and then with bytes done and bytes in all; prints nothing itself.
    """

    dbc: tuple[Path, ...] = ()
    dbc_given: bool = True
    buses: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    time_channel: str | None = None
    time_unit: str | None = None
    progress: Callable[[int, int], None] = no_progress


TAKEN_AS_UTC = "taken as UTC, up to 14 hours off"
"""What is assumed of a wall clock of no stated time zone: zones are up to 14 hours from UTC."""


@dataclass
class ImportLog:
    """The log book of one import: what was read, what was not and why. Importers write, `load` freezes it.

    messages: rows, frames or messages read. rejected: reason -> count (a reason is a short phrase in words,
        e.g. "row with too few columns"). notes: sentences for the user. status only ever gets worse.
    lost_spans_ns: (start, end) of time that a damaged block took with it, where it can be told.
    can_frames: whether the log holds CAN frames, for which databases are of use.
    databases: file names of those databases of which a message is in the log.
    zone_known: False where the wall clock is the recorder's own and nothing says of which time zone.
    local_start_ns: the moment of stamp 0 on the recorder's own clock, of which the zone is unknown, as nanoseconds since
        1970-01-01 on that clock: good for laying logs of one recorder beside each other, and for the order of drives.
    """

    messages: int = 0
    rejected: Counter[str] = field(default_factory=Counter)
    notes: list[str] = field(default_factory=list)
    status: Status = "complete"
    lost_spans_ns: list[tuple[int, int]] = field(default_factory=list)
    can_frames: bool = False
    databases: tuple[str, ...] = ()
    zone_known: bool = True
    local_start_ns: int | None = None

    def without_zone(self, sentence: str) -> None:
        """Write down that nothing says of which time zone the wall clock is. sentence: what was found."""
        self.zone_known = False
        self.note(sentence)

    def began(self, moment: datetime) -> None:
        """Write down the moment of stamp 0 on the recorder's clock. moment: without a zone."""
        since = moment.replace(tzinfo=None) - datetime(1970, 1, 1)
        self.local_start_ns = since // timedelta(microseconds=1) * 1000
        self.zone_known = False

    def note(self, sentence: str) -> None:
        """Write a sentence down, once."""
        if sentence not in self.notes:
            self.notes.append(sentence)

    def reject(self, reason: str, count: int = 1) -> None:
        """Count what was left out."""
        if count > 0:
            self.rejected[reason] += int(count)

    def worsen(self, status: Status, sentence: str) -> None:
        """Say that the log is truncated or malformed, and how much of it was whole."""
        if _SEVERITY[status] > _SEVERITY[self.status]:
            self.status = status
        self.note(sentence)

    def take_over(self, other: ImportLog) -> None:
        """Write down what another log book says, of the same log read in another pass."""
        self.messages += other.messages
        self.rejected.update(other.rejected)
        self.lost_spans_ns += other.lost_spans_ns
        if _SEVERITY[other.status] > _SEVERITY[self.status]:
            self.status = other.status
        for sentence in other.notes:
            self.note(sentence)


class LogReader(Protocol):
    """An opened log.

    channels: all that is in it, numbers and text, in the log's order. clock: which clock the stamps are from, in
    words ("header stamp", "log time", "UTC time of day", …). start_utc_ns: wall clock of stamp 0 where the stamps
    are relative and the log knows it; None where the stamps are absolute already or nothing is known.
    absolute: whether stamps count from 1970.
    """

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """Everything in the log, numbers and text, in the log's order."""
        ...

    @property
    def clock(self) -> str:
        """Which clock the stamps are from, in words."""
        ...

    @property
    def absolute(self) -> bool:
        """Whether stamps count from 1970."""
        ...

    @property
    def start_utc_ns(self) -> int | None:
        """Wall clock of stamp 0; None where the stamps say it themselves or nothing is known."""
        ...

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Yield chunks with the wanted channels only (names of `channels`); others cost nothing that can be saved.

        Each read starts from the beginning and counts into the log book given to `open`; may be called once
        per opened reader. Raises LogError where nothing can be read at all; a log that breaks off yields what is
        whole and says so in the log book.
        """
        ...


class Importer(Protocol):
    """A format. Stateless: `open` gives the state."""

    @property
    def name(self) -> str:
        """Short, lower case: "vbo"."""
        ...

    @property
    def title(self) -> str:
        """As an engineer says it: "Racelogic VBO"."""
        ...

    @property
    def suffixes(self) -> tuple[str, ...]:
        """Usual suffixes, lower case, with the dot; a tie-breaker and for searching folders, never proof."""
        ...

    def claims(self, path: Path, head: bytes) -> bool:
        """Whether the content is this format: `head` is the first HEAD_BYTES of a file, b"" for a folder."""
        ...

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> LogReader:
        """Open; raises LogError with place and next step where the log cannot be used."""
        ...
