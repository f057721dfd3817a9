"""Drives of one vehicle whose recording another of its drives is already: the same bytes, or a part of the other."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from pipelines.fleet.rows import DriveRows
from pipelines.fleet.stored import StoredDrive
from pipelines.starts import is_local

SAME_START_S = 1.0
"""Recordings of one vehicle that begin within this are of one drive: it cannot be driven twice at once."""

OTHER_MPS, FEWEST = 3.0, 4
"""Root mean square of the difference of two speeds, over so many steps or more, from which on they are of two drives: the recorder's
clock began at the same moment for both, as one without a battery does."""


@dataclass(frozen=True)
class Finished:
    """A drive that goes into joining. start_utc: as the log says it, else as a drive.toml does."""

    stored: StoredDrive
    rows: DriveRows
    start_utc: str | None

    @property
    def drive_id(self) -> str:
        """The drive's name in the store."""
        return self.stored.drive.drive_id


@dataclass(frozen=True)
class Copy:
    """of: the drive_id of the drive that counts. part: it is not the same bytes, but lies within that drive."""

    of: str
    part: bool

    def sentence(self, drive_id: str) -> str:
        """What is said of the copy."""
        what = (
            f"{drive_id} begins as {self.of} does, lies within it and has no signal that this lacks"
            if self.part
            else f"{drive_id} is the same recording as {self.of}"
        )
        return f"{what}: it counts once"


def copies_of(drives: Sequence[Finished]) -> dict[str, Copy]:
    """Drives whose recording another one is already, by drive_id. What such a drive told must not count twice.

    Of the same bytes the first drive counts, of parts (a copy that was cut off, or saved in another format) the longest.
    """
    first: dict[str, str] = {}
    copies: dict[str, Copy] = {}
    for drive in drives:
        same = first.setdefault(drive.rows.log_sha256 or drive.drive_id, drive.drive_id)
        if same != drive.drive_id:
            copies[drive.drive_id] = Copy(same, part=False)
    return {**copies, **_parts([drive for drive in drives if drive.drive_id not in copies])}


@dataclass(frozen=True)
class _Span:
    """start_s: since 1970; local: of an unknown time zone, so that only others of that kind can be held against it."""

    drive: Finished
    start_s: float
    duration_s: float
    local: bool


def _parts(drives: Sequence[Finished]) -> dict[str, Copy]:
    """Drives that are a part of another one."""
    parts: dict[str, Copy] = {}
    longer: dict[tuple[bool, int], list[_Span]] = defaultdict(list)
    for span in sorted(_spans(drives), key=_longest_and_whole_first):
        second = int(span.start_s // SAME_START_S)
        near = [other for at in (second - 1, second, second + 1) for other in longer[span.local, at]]
        of = next((other for other in near if _within(span, other)), None)
        if of is None:
            longer[span.local, second].append(span)
        else:
            parts[span.drive.drive_id] = Copy(of.drive.drive_id, part=True)
    return parts


def _longest_and_whole_first(span: _Span) -> tuple[float, bool]:
    """Of a recording and its damaged copy of one length the one that is whole counts."""
    return -span.duration_s, span.drive.rows.import_status != "complete"


def _spans(drives: Sequence[Finished]) -> Iterator[_Span]:
    for drive in drives:
        try:
            start = datetime.fromisoformat(drive.start_utc or "")
        except ValueError:
            continue
        if drive.rows.duration_s is not None and drive.rows.signals:
            zoned = start if start.tzinfo is not None else start.replace(tzinfo=UTC)
            yield _Span(drive, zoned.timestamp(), drive.rows.duration_s, is_local(drive.start_utc))


def _within(span: _Span, other: _Span) -> bool:
    """Whether a recording tells nothing that the other one does not, which is as long or longer: beginning together, it ends
    within that. A second recorder has signals of its own."""
    one, two = span.drive.rows, other.drive.rows
    together = abs(span.start_s - other.start_s) <= SAME_START_S
    return together and set(one.signals) <= set(two.signals) and not _driven_otherwise(one.pace, two.pace)


def _driven_otherwise(one: Sequence[float], two: Sequence[float]) -> bool:
    """Whether two speeds from the start on are not of one drive; False where too little of them is known."""
    off = [a - b for a, b in zip(one, two, strict=False)]
    return len(off) >= FEWEST and sum(x * x for x in off) > OTHER_MPS**2 * len(off)
