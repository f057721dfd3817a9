"""Which bus the frames of a channel group are from where no member of the frames says it: by their acquisition source."""

from __future__ import annotations

import re
from dataclasses import replace

from parsers.importer import ImportLog
from parsers.mf4.bus_layout import BusLayout
from parsers.mf4.model import Group

MOST_BUSES = 255
_NUMBER = re.compile(r"(\d{1,3})\D*$")


def _source(group: Group) -> tuple[str, str]:
    """What tells a group's source from others: its name and path, or else the group's own name."""
    return group.source if any(group.source) else (group.name, "")


def _by_number(names: list[str]) -> list[int] | None:
    """The last number in each of the names, None where they do not tell all of them apart."""
    found = [_NUMBER.search(name) for name in names]
    numbers = [int(match.group(1)) for match in found if match is not None]
    distinct = len(set(numbers)) == len(names) and max(numbers) <= MOST_BUSES
    return numbers if distinct else None


def _numbered(sources: list[tuple[str, str]]) -> list[int]:
    """A bus for each source: the number in its name or in its path, else by their order."""
    for which in range(2):
        numbers = _by_number([source[which] for source in sources])
        if numbers is not None:
            return numbers
    return list(range(1, len(sources) + 1))


def tell_buses_apart(layouts: dict[int, BusLayout], log: ImportLog) -> dict[int, BusLayout]:
    """The layouts, and those of frames that name no bus with the bus of their source; groups of one source stay one bus."""
    frames = [layout for layout in layouts.values() if not layout.rejected]
    silent = [layout for layout in frames if not layout.names_bus]
    sources = list(dict.fromkeys(_source(layout.group) for layout in silent))
    if not silent or (len(sources) < 2 and len(silent) == len(frames)):
        return layouts
    if not any(any(layout.group.source) for layout in silent) and _by_number([s[0] for s in sources]) is None:
        # names of groups alone say little
        return layouts
    bus_of = dict(zip(sources, _numbered(sources), strict=True))
    told = ", ".join(f"{' / '.join(filter(None, source)) or 'none'}: {bus_of[source]}" for source in sources)
    log.note(f"CAN frames that name no bus have the one of their acquisition source ({told})")
    return {
        number: layout
        if layout.rejected or layout.names_bus
        else replace(layout, bus=bus_of[_source(layout.group)])
        for number, layout in layouts.items()
    }
