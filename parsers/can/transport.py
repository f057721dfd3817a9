"""Messages of more bytes than a frame has that J1939's transport protocols send in packets, put together to frames that a database knows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

import numpy as np

from parsers.can.definitions import MessageDef, pgn_of
from parsers.can.frames import CanFrames
from parsers.can.j1939_kernel import count_groups
from parsers.can.matching import Stream
from parsers.can.transport_kernel import (
    ABORTED,
    CROWDED,
    CUT,
    GIVEN_UP,
    LONG,
    MESSAGES,
    MISSING,
    MOST_BYTES,
    MOST_SESSIONS,
    OPEN,
    PACKETS_21,
    PACKETS_22,
    PER_FD_PACKET,
    PER_PACKET,
    ROW,
    STATE_SIZE,
    UNANNOUNCED,
    USED,
    Messages,
    Sessions,
    give_up_all,
    take_packets,
)
from parsers.channels import IntArray
from parsers.importer import ImportLog

CARRIERS = (0xEB00, 0xEC00, 0x4D00, 0x4E00)
"""The parameter groups of packets and of what announces them, of J1939-21 and J1939-22."""

WHY = {
    MISSING: "packets missing",
    ABORTED: "broken off by sender or receiver",
    CUT: "cut by the log's end",
    LONG: f"longer than {MOST_BYTES} bytes",
    CROWDED: f"more than {MOST_SESSIONS} messages in packets at once",
}


class Transport:
    """One pass through a log: frames in, the messages that they complete out.

    found: messages by bus * 2**32 + id. given_up: messages by the same and why they are not whole. unannounced:
    messages that began without their announcement.
    """

    def __init__(self) -> None:
        self._held: Sessions | None = None
        self.found: Counter[int] = Counter()
        self.given_up: Counter[tuple[int, int]] = Counter()

    @property
    def unannounced(self) -> int:
        """Messages whose first packet came without an announcement: of which group they are is not known."""
        return int(self._held.state[UNANNOUNCED]) if self._held is not None else 0

    def take(self, frames: CanFrames) -> CanFrames | None:
        """The messages whose last packet is among these frames, in order; None where there are none."""
        can_id = np.ascontiguousarray(frames.can_id, np.uint32)
        packets, fd_packets = count_groups(can_id, *PACKETS_21), count_groups(can_id, *PACKETS_22)
        if not packets + fd_packets:
            return None
        if self._held is None:
            self._held = _no_sessions()
        out = _room(packets, fd_packets, int(self._held.state[OPEN]))
        columns = frames.columns()
        take_packets(*columns, self._held, out)
        self._count(out)
        n, used = int(self._held.state[MESSAGES]), int(self._held.state[USED])
        if not n:
            return None
        return CanFrames(
            out.time_ns[:n], out.can_id[:n], out.bus[:n], out.length[:n], out.offset[:n], out.data[:used]
        )

    def end(self) -> None:
        """The log is at its end: what is under way is cut."""
        if self._held is not None:
            out = _room(0, 0, int(self._held.state[OPEN]))
            give_up_all(self._held, out)
            self._count(out)

    def _count(self, out: Messages) -> None:
        """Add up what was found and what was given up."""
        if self._held is None:
            return
        state = self._held.state
        n, lost = int(state[MESSAGES]), int(state[GIVEN_UP])
        keys = out.bus[:n].astype(np.int64) << 32 | out.can_id[:n]
        self.found.update(_counted(keys))
        for why in WHY:
            gone = out.given_up[:lost][out.given_up[:lost, 2] == why]
            counts = _counted(gone[:, 0] << 32 | gone[:, 1])
            self.given_up.update({(key, why): count for key, count in counts.items()})

    def say(self, known: Iterable[MessageDef], streams: Iterable[Stream], log: ImportLog) -> None:
        """Write into the log book what was put together of the messages that databases know, and what was lost of them."""
        names = _names(known)
        used = {key for stream in streams for key in stream.keys} & self.found.keys()
        if used:
            groups = Counter[int]()
            for key in used:
                groups[_group_of(key)] += self.found[key]
            each = ", ".join(f"{names.get(group, 'PGN')} ({group})" for group in sorted(groups)[:6])
            more = f" and {len(groups) - 6} more" if len(groups) > 6 else ""
            total = groups.total()
            many = "1 message was" if total == 1 else f"{total} messages were"
            log.note(f"J1939 transport protocol: {many} put together from their packets: {each}{more}")
            log.reject("J1939 message in packets without its announcement", self.unannounced)
        for (key, why), count in self.given_up.items():
            name = names.get(_group_of(key))
            if name is not None:
                log.reject(f"{name}: J1939 message in packets, {WHY[why]}", count)


def without_carriers(seen: Mapping[int, int], transport: Transport) -> dict[int, int]:
    """The frames of each key but for packets, where these are put together and count as messages."""
    if not transport.found:
        return dict(seen)
    return {key: count for key, count in seen.items() if pgn_of(key & 0xFFFF_FFFF) not in CARRIERS}


def _names(known: Iterable[MessageDef]) -> dict[int, str]:
    """Names of messages by their parameter groups; the first database's come first."""
    names: dict[int, str] = {}
    for message in known:
        pgn = pgn_of(message.can_id)
        if pgn is not None:
            names.setdefault(pgn, message.name)
    return names


def _group_of(key: int) -> int:
    pgn = pgn_of(key & 0xFFFF_FFFF)
    return -1 if pgn is None else pgn


def _counted(keys: IntArray) -> dict[int, int]:
    """How often each number comes."""
    values, counts = np.unique(keys, return_counts=True)
    return dict(zip(values.tolist(), counts.tolist(), strict=True))


def _no_sessions() -> Sessions:
    return Sessions(
        np.zeros((MOST_SESSIONS, ROW), np.int64),
        np.zeros((MOST_SESSIONS, 256), np.uint8),
        np.zeros((MOST_SESSIONS, MOST_BYTES), np.uint8),
        np.zeros(STATE_SIZE, np.int64),
    )


def _room(packets: int, fd_packets: int, under_way: int) -> Messages:
    """Room for all that so many packets can complete, or end, with so many messages under way before them."""
    held = PER_PACKET * packets + PER_FD_PACKET * fd_packets + MOST_BYTES * under_way
    packets += fd_packets
    return Messages(
        np.empty(packets, np.int64),
        np.empty(packets, np.uint32),
        np.empty(packets, np.int16),
        np.empty(packets, np.uint16),
        np.empty(packets, np.int64),
        np.empty(held, np.uint8),
        # a frame that breaks off two messages, or begins one where there is no room
        np.empty((2 * packets + under_way, 3), np.int64),
    )
