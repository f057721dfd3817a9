"""The head of a Racelogic VBO file: sections, column names, units, date.

Sources: Racelogic, "VBO file structure" (developer pages) and "VBO File Format" (support pages). The names stand twice,
as a list in [header] and as one line in [column names]; units in [channel units] are one line for each channel
that is not a standard one.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from parsers.unit_words import plain_unit

# titles in [header] of the channels that Racelogic calls standard: token in [column names], unit ("" = none)
_STANDARD: dict[str, tuple[str, str]] = {
    "satellites": ("sats", ""),
    "sats": ("sats", ""),
    "time": ("time", ""),
    "latitude": ("lat", "min"),
    "longitude": ("long", "min"),
    "velocity": ("velocity", ""),
    "velocity kmh": ("velocity", "km/h"),
    "velocity km/h": ("velocity", "km/h"),
    "velocity knots": ("velocity", "knots"),
    "velocity mph": ("velocity", "mph"),
    "velocity m/s": ("velocity", "m/s"),
    "heading": ("heading", "deg"),
    "height": ("height", "m"),
    "vertical velocity": ("vert-vel", ""),
    "vertical velocity kmh": ("vert-vel", "km/h"),
    "vertical velocity km/h": ("vert-vel", "km/h"),
    "vertical velocity m/s": ("vert-vel", "m/s"),
    "vertical velocity knots": ("vert-vel", "knots"),
    "long accel g": ("longacc", "g"),
    "lat accel g": ("latacc", "g"),
    "event 1 time": ("event-1", "s"),
    "event 2 time": ("event-2", "s"),
    "trigger event time": ("event1", ""),
    "trigger event time in clock counts": ("event1", ""),
    "solution type": ("solution_type", ""),
    "avifileindex": ("avifileindex", ""),
    "avisynctime": ("avitime", "ms"),
    "avitime": ("avitime", "ms"),
    "brake trigger": ("brake_trigger", ""),
    "latitude_raw": ("_lat", "min"),
    "longitude_raw": ("_long", "min"),
    "speed_raw": ("_velocity", "km/h"),
    "heading_raw": ("_heading", "deg"),
    "height_raw": ("_height", "m"),
    "vertical_velocity_raw": ("_vert-vel", "km/h"),
}
_CREATED = re.compile(
    r"file created on\s+(\d{1,2})[/.\-](\d{1,2})[/.\-](\d{4})(?:\s*(?:@|at)?\s*(\d{1,2}):(\d{2})(?::(\d{2}))?)?",
    re.IGNORECASE,
)
_SECTION = re.compile(r"^\s*\[([^\]]+)\]")


@dataclass(frozen=True)
class VboColumn:
    """One column. name: as in [column names]. title: its line in [header], or "". unit: or None."""

    name: str
    title: str
    unit: str | None


@dataclass(frozen=True)
class VboHead:
    """The head's sections. names: tokens of [column names]. titles: lines of [header]. units: lines of [channel
    units], the last of which may be the blank line between sections."""

    created: datetime | None
    swapped_date: bool
    titles: tuple[str, ...]
    units: tuple[str, ...]
    names: tuple[str, ...]


def read_head(text: str) -> VboHead:
    """Read all that stands before [data]."""
    sections: dict[str, list[str]] = {"": []}
    current = sections[""]
    for line in text.splitlines():
        match = _SECTION.match(line)
        if match is not None:
            current = sections.setdefault(match[1].strip().lower(), [])
        else:
            current.append(line.strip())
    created, swapped = _created(text)
    return VboHead(
        created,
        swapped,
        tuple(line for line in sections.get("header", []) if line),
        tuple(sections.get("channel units", [])),
        tuple(" ".join(sections.get("column names", [])).split()),
    )


def _created(text: str) -> tuple[datetime | None, bool]:
    """Date and time of "File created on 11/04/2014 @ 09:42", and whether day and month had to be swapped."""
    match = _CREATED.search(text)
    if match is None:
        return None, False
    day, month, year, hour, minute, second = (int(part or 0) for part in match.groups())
    swapped = month > 12 and day <= 12
    if swapped:
        day, month = month, day
    try:
        return datetime(year, month, day, hour, minute, second, tzinfo=UTC), swapped
    except ValueError:
        return None, False


def name_columns(head: VboHead, width: int) -> tuple[tuple[VboColumn, ...], tuple[str, ...]]:
    """The columns of rows with `width` values; and what had to be decided, in sentences.

    Where [column names] has another count than the rows, [header] says which words belong together, or gives the
    names itself. Where neither fits, only the leading columns on which both agree are named: none is ever guessed.
    """
    notes: list[str] = []
    titles = head.titles if len(head.titles) == width else ()
    names: Sequence[str] = head.names
    if len(names) != width:
        found = f"[column names] has {len(names)} words, [header] {len(head.titles)} lines and the rows {width} values"
        joined = join_words(head.names, head.titles) if titles else None
        if joined is not None:
            names = joined
            notes.append(f"{found}: words of one name were joined as in [header]")
        elif titles:
            names = [_STANDARD.get(title.lower(), (title, ""))[0] for title in titles]
            notes.append(f"{found}: the names are taken from [header]")
        else:
            sure = _agreeing(head, width)
            names = [*head.names[:sure], *(f"column_{k + 1}" for k in range(sure, width))]
            notes.append(f"{found}: only the first {sure} columns can be named for certain")
    units, note = _align_units(head, titles)
    if note:
        notes.append(note)
    columns = []
    for k, name in enumerate(names):
        title = titles[k] if titles else ""
        standard = _STANDARD.get(title.lower()) or (_by_token(name, head.titles) if not titles else None)
        unit = standard[1] if standard is not None else units[k] if units else ""
        columns.append(VboColumn(name, title, plain_unit(unit)))
    return tuple(columns), tuple(notes)


def join_words(words: Sequence[str], titles: Sequence[str]) -> list[str] | None:
    """Join the words of [column names] to the names that [header] lists; None where they do not agree throughout."""
    names: list[str] = []
    at = 0
    for title in titles:
        pieces = title.split()
        taken = [word.lower() for word in words[at : at + len(pieces)]]
        if taken == [piece.lower() for piece in pieces]:
            names.append("_".join(words[at : at + len(pieces)]))
            at += len(pieces)
        elif title.lower() in _STANDARD and at < len(words):
            names.append(words[at])
            at += 1
        else:
            return None
    return names if at == len(words) else None


def _agreeing(head: VboHead, width: int) -> int:
    """How many leading names of [column names] are those of the standard titles in [header]."""
    count = 0
    for word, title in zip(head.names, head.titles, strict=False):
        if title.lower() not in _STANDARD or _STANDARD[title.lower()][0] != word.lower():
            break
        count += 1
    return min(count, width)


def _by_token(name: str, titles: Sequence[str]) -> tuple[str, str] | None:
    """The standard channel that a name of [column names] stands for, with the unit that [header] gives it."""
    found = [entry for title, entry in _STANDARD.items() if entry[0] == name.lower()]
    stated = [
        _STANDARD[t.lower()]
        for t in titles
        if t.lower() in _STANDARD and _STANDARD[t.lower()][0] == name.lower()
    ]
    units = {entry[1] for entry in found}
    return stated[0] if stated else found[0] if len(units) == 1 else None


def _align_units(head: VboHead, titles: Sequence[str]) -> tuple[list[str], str | None]:
    """The unit of each column ("" for standard ones); or nothing and the reason, where the counts do not agree."""
    if not any(head.units):
        return [], None
    others = [k for k, title in enumerate(titles) if title.lower() not in _STANDARD]
    lines = list(head.units)
    while len(lines) > len(others) and not lines[-1]:
        lines.pop()
    if not titles or len(lines) != len(others):
        return [], (
            f"[channel units] has {len(lines)} lines for {len(others)} channels that are not standard ones: "
            "they cannot be told apart and are left out"
        )
    units = [""] * len(titles)
    for k, unit in zip(others, lines, strict=True):
        units[k] = unit
    return units, None
