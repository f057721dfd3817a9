"""Which channels of a group make up its CAN frames (the CAN_DataFrame structures of bus logging)."""

from __future__ import annotations

from dataclasses import dataclass

from parsers.importer import ImportLog
from parsers.mf4.clock import find_master
from parsers.mf4.conversions import fault as rule_fault
from parsers.mf4.model import CG_VLSD, VLSC, VLSD, Channel, Group
from parsers.mf4.payload import reference_fault
from parsers.mf4.values import fault

FRAME = "CAN_DataFrame"
_REJECTED = {
    "CAN_RemoteFrame": "CAN remote frame",
    "CAN_ErrorFrame": "CAN error frame",
    "CAN_OverloadFrame": "CAN error frame",
}


@dataclass(frozen=True)
class BusLayout:
    """Which channels of a group make up its frames. rejected: the reason where the group holds no data frames.

    bus: of frames that do not name theirs.
    """

    group: Group
    master: Channel
    fields: dict[str, Channel]
    rejected: str = ""
    bus: int = 1

    @property
    def by_reference(self) -> bool:
        """Whether the record holds only the place of the payload."""
        return self.fields["DataBytes"].kind == VLSD

    @property
    def names_bus(self) -> bool:
        """Whether each frame says which bus it was on."""
        return self.readable("BusChannel")

    def readable(self, name: str) -> bool:
        """Whether there is a field of this name whose numbers can be read."""
        channel = self.fields.get(name)
        if channel is None or fault(channel, self.group) is not None:
            return False
        return rule_fault(channel.conversion) is None


def _structure(group: Group) -> tuple[str, str]:
    """The frame structure in a group: its name and its kind ("CAN_DataFrame"), empty where there is none."""
    for channel in group.channels:
        last = channel.name.rsplit(".", 1)[-1]
        if last in (FRAME, *_REJECTED):
            return channel.name, last
    for channel in group.channels:
        # structures are optional: the members' names say enough
        head = channel.name.rsplit(".", 1)[0]
        if head.rsplit(".", 1)[-1] in (FRAME, *_REJECTED):
            return head, head.rsplit(".", 1)[-1]
    return "", ""


def find_layout(group: Group, log: ImportLog) -> BusLayout | None:
    """How a group holds CAN frames; None where it holds none, or (said in the log book) not in a known way."""
    name, kind = _structure(group)
    if not name or group.flags & CG_VLSD:
        return None
    master = find_master(group)
    fields = {c.name[len(name) + 1 :]: c for c in group.channels if c.name.startswith(f"{name}.")}
    if master is None:
        if group.cycles:
            log.note(f"CAN frames of channel group {group.number} have no time and were left out")
        return None
    if kind in _REJECTED:
        return BusLayout(group, master, fields, _REJECTED[kind])
    usable = "ID" in fields and "DataBytes" in fields and fault(fields["ID"], group) is None
    if usable:
        data = fields["DataBytes"]
        # VLSC (4.3) keeps the payloads in a way of its own
        usable = data.kind != VLSC and data.byte_offset + data.byte_count <= group.invalid_at
        usable = usable and (data.kind != VLSD or reference_fault(data, group) is None)
    if not usable:
        log.note(
            f"CAN frames of channel group {group.number} are described in an unknown way and were left out"
        )
        return None
    return BusLayout(group, master, fields)
