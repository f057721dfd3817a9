"""What a recording's name tells: a number or a time of day in a row of parts, which recorder it is from, and a name for its drive."""

from __future__ import annotations

import hashlib
import re
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass

from pipelines.fleet.suffixes import DOUBLE

_MOMENT = re.compile(
    r"(?<!\d)(?:"
    r"(?:19|20)\d\d[-_.]?[01]\d[-_.]?[0-3]\d(?:[-_. T]{0,2}[0-2]\d[-_.:h]?[0-5]\d(?:[-_.:m]?[0-5]\d)?(?:[.,_-]\d{3,6})?)?"
    r"|[0-2]\d[-_:h][0-5]\d[-_:m][0-5]\d"
    r"|1\d{9}(?:\d{3})?(?:\d{3})?(?:\d{3})?"
    r")(?!\d)",
    re.IGNORECASE,
)
"""A date, perhaps with a time of day; a time of day; a number of seconds (to ns) since 1970."""
_NUMBER = re.compile(r"\d+")
_PART_WORD = re.compile(r"(?:part|split|seg|segment|chunk|file)$")
_LOOSE = " -_.,()[]#+"
_RECORDERS = re.compile(
    r"^(?:can(?:fd)?\d*|[hp]?can|canbus|bus\d*|lin\d*|flexray|j1939|obd2?|gps\d*|gnss\d*|dgps|rtk|vbox|imu\d*|ins\d*|ahrs|adma|"
    r"oxts|correvit|daq\d*|accel|accelerometers?|gyro|wheels?|wft|suspension|susp|strain|loads?|forces?|lidar|radar)$"
)
"""Words that name a recorder, not a drive."""
_COPY = re.compile(
    r"^(?:copy(?: \(?\d+\)?)? of |kopie(?: \(?\d+\)?)? von )(?P<a>.+)$"
    r"|^(?P<b>.+?)(?: ?\(\d+\)| ?- copy(?: ?\(\d+\))?| ?- kopie(?: ?\(\d+\))?| copy(?: \d+)?|_copy\d*|\.bak|\.orig)$",
    re.IGNORECASE,
)


def stem_of(name: str) -> str:
    """A file's name without the suffix of its format."""
    for ending in DOUBLE:
        if name.lower().endswith(ending):
            return name[: -len(ending)]
    stem, dot, _ = name.rpartition(".")
    return stem if dot and stem else name


@dataclass(frozen=True)
class NumberedName:
    """A stem taken apart. row: what parts of one recording have in common. number: which part; moment: a time in the name."""

    row: str
    number: int | None
    moment: str | None


def numbered(stem: str) -> NumberedName:
    """Take a stem apart: "tour_002" is number 2 of "tour"; "log_2024-05-01_10-30-00" is of "log", at that time."""
    text = stem.casefold()
    found = _MOMENT.search(text)
    moment = "".join(c for c in found[0] if c.isdigit()) if found else None
    if found:
        text = f"{text[: found.start()]}\0{text[found.end() :]}"
    numbers = list(_NUMBER.finditer(text))
    if found and numbers and numbers[-1].start() and text[numbers[-1].start() - 1].isalpha():
        # "car1_<time>": the car's number, not a part's
        numbers = []
    number = None
    if numbers and len(numbers[-1][0]) <= 9:
        last = numbers[-1]
        number = int(last[0])
        before = _PART_WORD.sub("", text[: last.start()].rstrip(_LOOSE)).rstrip(_LOOSE)
        text = before + text[last.end() :]
    return NumberedName(text.strip(_LOOSE), number, moment)


def follows(before: str, after: str) -> bool:
    """Whether a name can be the next part after another: of one row, the number one higher or the time later.

    A first part without a number may go before part 0, 1 or 2.
    """
    a, b = numbered(before), numbered(after)
    if a.row != b.row or (a.moment is None) != (b.moment is None):
        return False
    later = a.moment is not None and b.moment is not None and b.moment > a.moment
    same = a.moment == b.moment
    if a.number is None and b.number is None:
        return later
    if a.number is None:
        return same and b.number is not None and b.number <= 2
    if b.number is None:
        return False
    return b.number == a.number + 1 or (later and b.number == a.number)


@dataclass(frozen=True)
class RecorderName:
    """A stem's words: those of the drive, and those that name a recorder."""

    drive: tuple[str, ...]
    recorder: tuple[str, ...]


def recorder_name(stem: str) -> RecorderName:
    """Part a stem's words: "monday_can1" is the recorder can1 of the drive monday."""
    words = [word for word in re.split(r"[^0-9a-zà-ÿ]+", stem.casefold()) if word]
    return RecorderName(
        tuple(word for word in words if not _RECORDERS.match(word)),
        tuple(word for word in words if _RECORDERS.match(word)),
    )


def copied_from(stem: str) -> str | None:
    """The stem that a file manager's name for a copy was made from: "drive (1)", "drive - Copy"; None for other names."""
    match = _COPY.match(stem)
    return (match["a"] or match["b"]) if match else None


def natural(text: str) -> tuple[tuple[int, int, str], ...]:
    """A key that sorts part 10 behind part 9."""
    pieces = re.findall(r"\d+|\D+", text.casefold())
    return tuple((0, int(p), "") if p[0].isdecimal() and p.isascii() else (1, 0, p) for p in pieces)


def drive_id(name: str, logs: Iterable[str]) -> str:
    """A short name that every file system takes: what can be read of `name`, and a hash of the logs' names.

    logs: their names below the fleet's folder. At most 72 characters of a-z, 0-9 and "-", and never a reserved name.
    """
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode("ascii").lower()
    slug = re.sub(r"[^a-z0-9]+", "-", plain).strip("-")
    if len(slug) > 60:
        # the end of a long name is the drive's own, the beginning its folders
        slug = slug[-60:].partition("-")[2] or slug[-60:]
    digest = hashlib.sha256("\n".join(sorted(logs)).encode("utf-8", "surrogatepass")).hexdigest()[:10]
    return f"{slug.strip('-') or 'drive'}-{digest}"
