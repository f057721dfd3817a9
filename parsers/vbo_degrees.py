"""VBO logs of other programs whose positions are degrees, where the format has minutes of arc: the way against the speed tells."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from parsers.channels import FloatArray
from parsers.table_cells import split_cells
from parsers.table_rows import RowRules
from parsers.table_text import Encoding, decode
from parsers.vbo_clock import of_day

PLACE = ("lat", "long")
SAID = (
    "the positions are degrees, where VBO has minutes of arc (as such the way would be a sixtieth of what the speed makes it): "
    "read as degrees; longitudes count west, as in all VBO files"
)
SAID_BY_SIZE = (
    "the positions are taken as degrees, where VBO has minutes of arc: as such they would be in the sea at 0° 0'; longitudes count "
    "west, as in all VBO files"
)
_PIECES = 4
_PIECE_BYTES = 64 * 1024
_MINUTE_M = 1852.0
_LEAST_WAY_M = 50.0
_BETWEEN = 60.0**0.5
"""The way is the speed's with minutes, and a sixtieth of it with degrees that are taken for them: the middle, as factors go."""


def told_degrees(
    places: Sequence[Sequence[str]], rules: RowRules, columns: Sequence[str], time_at: int, *, seconds: bool
) -> str | None:
    """What is said of positions in degrees; None where they are minutes. places: lines from `pieces_of`. columns: names. seconds:
    the times count them, and are no HHMMSS.

    No minutes of a vehicle are below 90 in latitude and 180 in longitude: there the sea is.
    """
    lower = [name.lower() for name in columns]
    if not all(name in lower for name in PLACE):
        return None
    position = [lower.index(name) for name in PLACE]
    speed_at = lower.index("velocity") if "velocity" in lower else None
    way = driven = 0.0
    seen = False
    for lines in places:
        rows = numbers_of(lines, rules, [time_at, *position, *([] if speed_at is None else [speed_at])])
        rows = rows[(rows[:, 1] != 0) | (rows[:, 2] != 0)]
        if not len(rows):
            continue
        seen = True
        if (np.abs(rows[:, 1]) > 90).any() or (np.abs(rows[:, 2]) > 180).any():
            return None
        if rows.shape[1] > 3:
            way += _way_m(rows[:, 1], rows[:, 2])
            driven += _driven_m(rows[:, 0] if seconds else of_day(rows[:, 0]), rows[:, 3])
    if not seen:
        return None
    if driven < _LEAST_WAY_M:
        return SAID_BY_SIZE
    return SAID if way < driven / _BETWEEN else None


def pieces_of(path: Path, body: int, size: int, encoding: Encoding) -> list[list[str]]:
    """Lines from a few places of the rows, whole ones. Raises OSError."""
    found = []
    with path.open("rb") as file:
        for k in range(_PIECES):
            start = body + (size - body) * k // _PIECES
            file.seek(start)
            data = file.read(_PIECE_BYTES)
            # a second drive's head, behind which the columns may be others
            head = data.find(b"\n[")
            lines = data[: head if head >= 0 else len(data)].split(b"\n")[(1 if k else 0) : -1]
            found.append([decode(line, encoding) for line in lines])
            if head >= 0:
                break
    return found


def numbers_of(lines: Sequence[str], rules: RowRules, places: Sequence[int]) -> FloatArray:
    """Columns of the rows that hold numbers there, (rows, n)."""
    point = chr(rules.decimal)
    rows = []
    for line in lines:
        cells = split_cells(line, rules)
        if len(cells) == rules.width:
            try:
                rows.append([float(cells[k].replace(point, ".")) for k in places])
            except ValueError:
                continue
    return np.array(rows, dtype=np.float64).reshape(-1, len(places))


def _way_m(lat: FloatArray, long: FloatArray) -> float:
    """The way along positions that are taken for minutes, in metres; east and west are shortened as degrees would be."""
    steps = np.hypot(np.diff(lat), np.diff(long) * np.cos(np.radians(lat[:-1])))
    return float(np.nansum(steps)) * _MINUTE_M


def _driven_m(seconds: FloatArray, kmh: FloatArray) -> float:
    """The way that the speed makes, in metres."""
    step = np.diff(seconds)
    usual = (step > 0) & (step < 2.0)
    return float(np.nansum(np.where(usual, step * np.abs(kmh[:-1]) / 3.6, 0.0)))
