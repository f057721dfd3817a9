"""Which database tells a bus's frames, where several define one identifier otherwise: gateways and recorders put buses of their own into a log.

What tells a bus's database is the identifiers that it alone defines: those that the bus carries speak for it, those that only other buses of
the log carry speak against it. A mapping file's [buses] says it outright.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from parsers.can.definitions import MessageDef, id_text
from parsers.importer import ImportLog

SAID = 4
"""Identifiers that a note names."""

UNDECIDED = (
    'left undecoded; say in a mapping file which database is of which bus: [buses], then "FILE.dbc" = 1'
)


@dataclass
class BusDatabases:
    """The databases' messages by identifier, and which of them a bus's frames are.

    messages: of all databases, in their order. seen: number of frames of each key
    (bus * 2**32 + id). bound: the buses of a database, by file name, where the user said so.
    """

    messages: Sequence[MessageDef]
    seen: Mapping[int, int]
    bound: Mapping[str, tuple[int, ...]]
    _by_id: dict[int, list[MessageDef]] = field(init=False)
    _buses: dict[int, set[int]] = field(init=False)
    _own: dict[str, set[int]] = field(init=False)
    _chosen: dict[tuple[str, tuple[str, ...], int], set[str]] = field(init=False)
    _undecided: dict[tuple[str, ...], set[tuple[int, int]]] = field(init=False)

    def __post_init__(self) -> None:
        """Sort by identifier and by database."""
        self._by_id, self._buses, self._own = defaultdict(list), defaultdict(set), defaultdict(set)
        self._chosen, self._undecided = defaultdict(set), defaultdict(set)
        for message in self.messages:
            self._by_id[message.can_id].append(message)
        for key in self.seen:
            self._buses[key & 0xFFFF_FFFF].add(key >> 32)
        for can_id, messages in self._by_id.items():
            # what several define, be it alike, speaks for none of them
            if len(messages) == 1 and can_id in self._buses:
                self._own[messages[0].origin].add(can_id)

    def of(self, message: MessageDef | None, bus: int) -> MessageDef | None:
        """The message where its database is one for this bus."""
        there = message is not None and bus in self.bound.get(message.origin, (bus,))
        return message if there else None

    def _fits(self, origin: str, bus: int) -> int:
        own = self._own[origin]
        there = sum(bus in self._buses[can_id] for can_id in own)
        return 2 * there - len(own)

    def pick(self, can_id: int, bus: int) -> tuple[MessageDef | None, bool]:
        """What a bus's frames of an identifier are, None where no database says; and whether that is for want of knowing which."""
        several = [message for message in self._by_id.get(can_id, []) if self.of(message, bus) is not None]
        said = [message for message in several if message.origin in self.bound]
        several = said or several
        if all(message.signals == several[0].signals for message in several[1:]):
            return (several[0] if several else None), False
        origins = tuple(dict.fromkeys(message.origin for message in several))
        fits = [self._fits(message.origin, bus) for message in several]
        best = max(fits)
        if fits.count(best) > 1 and len(self._buses[can_id]) > 1:
            self._undecided[origins].add((bus, can_id))
            return None, True
        found = several[fits.index(best)]
        self._chosen[found.origin, origins, bus].add(id_text(can_id))
        return found, False

    def say(self, log: ImportLog) -> None:
        """What was chosen among several, and what was not."""
        for (origin, origins, bus), names in sorted(self._chosen.items()):
            where = f"on bus {bus}, " if len({key >> 32 for key in self.seen}) > 1 else ""
            log.note(
                f"{_some(names)}: {where}taken as {origin} has it; {_those(origins)} define it differently"
            )
        for origins, places in sorted(self._undecided.items()):
            names = {id_text(can_id) for _, can_id in places}
            buses = " and ".join(str(bus) for bus in sorted({bus for bus, _ in places}))
            log.note(
                f"{_some(names)} on buses {buses}: {_those(origins)} define it differently, and nothing tells which is whose: {UNDECIDED}"
            )


def _those(origins: Sequence[str]) -> str:
    return " and ".join(origins)


def _some(names: Iterable[str]) -> str:
    ordered = sorted(names)
    return ", ".join(ordered[:SAID]) + (f" and {len(ordered) - SAID} more" if len(ordered) > SAID else "")
