"""Extended multiplexing of a DBC that is read line by line: which multiplexer a signal hangs on, and at which values."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from parsers.can.definitions import BitField, Gate, SignalDef

MOST_VALUES = 1 << 20
"""Multiplexer values of a whole file; `WIDEST` those of one signal. What asks for more is left out."""

WIDEST = 4096

Multiplexers = Mapping[str, tuple[str, BitField]]
"""The multiplexers of a message: name -> mark ("M", or "m3M" of one below another) and place."""

Above = Mapping[tuple[int, str], tuple[str, tuple[int, ...] | None]]
"""(message, signal) -> the multiplexer that it hangs on and the values, or None where they cannot be used."""

_ENTRY = re.compile(
    r"^[ \t]{0,99}SG_MUL_VAL_[ \t]{1,99}(\d{1,10})[ \t]{1,99}(\S{1,999})[ \t]{1,99}([^\s;]{1,999})[ \t\n]{1,99}"
    r"([^;]{0,65536});",
    re.MULTILINE,
)
_RANGE = re.compile(r"\s*(\d{1,12})\s*-\s*(\d{1,12})\s*")


def read_above(text: str) -> Above:
    """What a file's SG_MUL_VAL_ lines say."""
    found: dict[tuple[int, str], tuple[str, tuple[int, ...] | None]] = {}
    left = MOST_VALUES
    for entry in _ENTRY.finditer(text):
        values = _values(entry[4], min(left, WIDEST))
        left -= len(values or ())
        found[int(entry[1]), entry[2]] = entry[3], values
    return found


def _values(text: str, most: int) -> tuple[int, ...] | None:
    """The values of "5-7, 9-9", or None where it is no list of ranges or holds more than `most` values."""
    values: set[int] = set()
    for part in text.split(","):
        found = _RANGE.fullmatch(part)
        if found is None or not 0 <= (width := int(found[2]) - int(found[1])) < most - len(values):
            return None
        values.update(range(int(found[1]), int(found[1]) + width + 1))
    return tuple(sorted(values))


def multiplexers_of(marked: Iterable[tuple[str | None, SignalDef]]) -> Multiplexers:
    """The multiplexers among a message's signals with their marks ("M", "m3", "m3M", None); of one name the first."""
    found: dict[str, tuple[str, BitField]] = {}
    for mark, signal in marked:
        if mark is not None and mark.endswith("M"):
            found.setdefault(signal.name, (mark, signal.field))
    return found


def gates_of(
    mark: str | None, name: str, dbc_id: int, multiplexers: Multiplexers, above: Above
) -> tuple[Gate, ...] | None:
    """The multiplexers above a signal, nearest first; None where the file does not say them all, or in a circle.

    A message with one multiplexer needs no SG_MUL_VAL_: the mark says the value. With several of them only that line
    says on which one a signal hangs.
    """
    gates: list[Gate] = []
    while mark is not None and mark != "M":
        said = above.get((dbc_id, name))
        if said is None and len(multiplexers) == 1 and not mark.endswith("M"):
            said = next(iter(multiplexers)), (int(mark[1:]),)
        if said is None or said[0] not in multiplexers or len(gates) > len(multiplexers):
            return None
        name, values = said
        if values is None:
            return None
        mark, field = multiplexers[name]
        mask = (1 << field.length) - 1
        gates.append(Gate(name, field, tuple(sorted({value & mask for value in values}))))
    return tuple(gates)
