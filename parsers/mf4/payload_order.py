"""Which payload belongs to which record behind damage: told by the order in which the recorder wrote the two."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.mf4.model import VLSD, Channel, Group
from parsers.mf4.payload import reference_fault, references

SAMPLE = 1 << 14
"""Records that are looked at; more would not make it more certain."""
MAX_SAMPLE_BYTES = 1 << 20
ENOUGH = 16
"""Records that must agree."""
SHARE = 0.9
_UNSTEADY = 1 << 40


@dataclass(frozen=True)
class Records:
    """Slot (number of the group), first byte and bytes of each record found in a row of bytes."""

    slot: IntArray
    place: IntArray
    length: IntArray

    def part(self, begin: int, end: int) -> Records:
        """Those from begin to end (views)."""
        return Records(self.slot[begin:end], self.place[begin:end], self.length[begin:end])


@dataclass(frozen=True)
class Sample:
    """Some sound records, to learn from once there is damage: their bytes, the number of each slot's first, and by the VLSD
    groups' places what their payloads begin with (see `PayloadOrder.learn`).
    """

    data: ByteArray
    records: Records
    firsts: list[int]
    begins: dict[int, int]


def sample_of(data: ByteArray, records: Records, firsts: list[int], begins: dict[int, int]) -> Sample:
    """A copy of the first of the records, which is all that a sound file pays."""
    count = min(int(np.searchsorted(records.place, MAX_SAMPLE_BYTES)), SAMPLE, records.slot.size)
    some = records.part(0, count)
    end = int(some.place[-1] + some.length[-1]) if count else 0
    # a record longer than that is no CAN frame
    if end > 2 * MAX_SAMPLE_BYTES:
        some, end = records.part(0, 0), 0
    copied = Records(some.slot.copy(), some.place.copy(), some.length.copy())
    return Sample(data[:end].copy(), copied, list(firsts), begins)


@dataclass
class PayloadOrder:
    """The records of variable length of one group, and what refers to them.

    slot: theirs. links: slots of the groups that refer to them, and the channels that do. by_order: the places were never
    written, so that the n-th record goes with the n-th payload.

    A record refers to a payload by its place among all of them, which damage makes uncertain: how many were lost nobody
    knows. But recorders write both in a steady order (each payload right before its record, as a rule), which is learnt
    before the damage. Behind it this order says which record goes with which payload, and their places where those are.
    """

    slot: int
    links: tuple[tuple[int, Channel], ...]
    by_order: bool
    _lead: dict[int, int] = field(default_factory=dict)

    def _own(self, data: ByteArray, some: Records, link: tuple[int, Channel], first: int) -> IntArray:
        """What the records of a link refer to: a place, or by_order a number."""
        slot, channel = link
        place = some.place[some.slot == slot]
        if self.by_order:
            return np.arange(first, first + place.size, dtype=np.int64)
        field_at = place[:, None] + (channel.byte_offset + np.arange(channel.byte_count))
        return references(data[field_at], replace(channel, byte_offset=0))

    def _starts(self, some: Records) -> IntArray:
        """Of the payloads in `some`: where each begins, or by_order its number; from 0 on."""
        length = some.length[some.slot == self.slot]
        return np.arange(length.size, dtype=np.int64) if self.by_order else np.cumsum(length) - length

    def _before(self, some: Records, slot: int) -> IntArray:
        """How many payloads stand before each record of a slot."""
        before = np.cumsum(some.slot == self.slot, dtype=np.int64)
        return np.asarray(before[some.slot == slot], np.int64)

    def learn(self, data: ByteArray, records: Records, firsts: list[int], begin: int) -> None:
        """Learn the order from sound records. firsts: number of each slot's first. begin: of the first payload, see `_own`."""
        if len(self._lead) == len(self.links):
            return
        some = records.part(0, SAMPLE)
        starts = self._starts(some)
        for link in self.links:
            slot = link[0]
            if slot in self._lead or not starts.size:
                continue
            own = self._own(data, some, link, firsts[slot]) - begin
            number = np.minimum(np.searchsorted(starts, own), starts.size - 1)
            met = starts[number] == own
            lead = (number - self._before(some, slot))[met]
            if lead.size >= ENOUGH:
                self._lead[slot] = int(lead[0]) if (lead == lead[0]).all() else _UNSTEADY

    def begin(self, data: ByteArray, records: Records, firsts: list[int]) -> int | None:
        """Place (by_order: number) of the first payload behind damage, None where that is not certain."""
        some = records.part(0, SAMPLE)
        starts = self._starts(some)
        told = [np.zeros(0, np.int64)]
        for link in self.links:
            lead = self._lead.get(link[0], _UNSTEADY)
            if lead != _UNSTEADY:
                own = self._own(data, some, link, firsts[link[0]])
                number = self._before(some, link[0]) + lead
                there = (number >= 0) & (number < starts.size)
                told.append(own[there] - starts[number[there]])
        begins = np.concatenate(told)
        if begins.size < ENOUGH:
            return None
        middle = int(np.sort(begins)[begins.size // 2])
        return middle if np.mean(begins == middle) >= SHARE else None

    def falls_back(self, data: ByteArray, records: Records) -> bool:
        """Whether the last record refers to an earlier payload than the one of its group before."""
        some = records.part(max(records.slot.size - 64, 0), records.slot.size)
        for link in self.links:
            if not self.by_order and link[0] == some.slot[-1]:
                own = self._own(data, some, link, 0)
                return own.size > 1 and bool(own[-1] <= own[-2])
        return False


def payload_order(groups: list[Group], key: int, *, by_order: bool) -> PayloadOrder:
    """What is known of the VLSD group at a place of the file. groups: by their slots."""
    slot = next(number for number, group in enumerate(groups) if group.at == key)
    links = tuple(
        (number, channel)
        for number, group in enumerate(groups)
        for channel in group.channels
        if channel.kind == VLSD and channel.data_link == key and reference_fault(channel, group) is None
    )
    return PayloadOrder(slot, links, by_order)
