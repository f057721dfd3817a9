"""Frames of several J1939 parameter groups on CAN FD (J1939-22's Multi-PG), taken apart to frames that a database knows."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from parsers.can.contained_kernel import (
    CONTAINER,
    FOUND,
    MOST_GROUPS,
    ODD,
    OTHER,
    STATE_SIZE,
    Groups,
    split_containers,
)
from parsers.can.frames import CanFrames
from parsers.can.j1939_kernel import count_groups
from parsers.can.matching import Stream
from parsers.importer import ImportLog

CARRIER = 0x2500
"""The parameter group of such frames."""


class Contained:
    """One pass through a log. frames, groups: how many were taken apart, and into how many. other, odd: frames with groups of another
    service or with assurance data, and frames that are not laid out so."""

    def __init__(self) -> None:
        self.frames = self.groups = self.other = self.odd = 0
        self.keys: set[int] = set()

    def take(self, frames: CanFrames) -> CanFrames | None:
        """The groups of these frames, in order; None where there are none."""
        if not (count := count_groups(np.ascontiguousarray(frames.can_id, np.uint32), CONTAINER, CONTAINER)):
            return None
        room = count * MOST_GROUPS
        out = Groups(
            np.empty(room, np.int64), np.empty(room, np.uint32), np.empty(room, np.int16), np.empty(room, np.uint8),
            np.empty(room, np.int64), np.zeros(STATE_SIZE, np.int64),
        )  # fmt: skip
        columns = frames.columns()
        split_containers(*columns, out)
        n, odd = int(out.state[FOUND]), int(out.state[ODD])
        self.groups += n
        self.other += int(out.state[OTHER])
        self.odd += odd
        self.frames += count - odd
        if not n:
            return None
        self.keys.update(np.unique(out.bus[:n].astype(np.int64) << 32 | out.can_id[:n]).tolist())
        return CanFrames(
            out.time_ns[:n], out.can_id[:n], out.bus[:n], out.length[:n], out.offset[:n], columns.data
        )

    def say(self, streams: Iterable[Stream], log: ImportLog) -> None:
        """Write into the log book that messages were found in such frames, and what was left of those."""
        if not self.keys.isdisjoint(key for stream in streams for key in stream.keys):
            log.note(
                f"J1939-22: {self.frames} CAN FD frames were taken apart to {self.groups} parameter groups"
            )
            log.reject("J1939-22 frame whose parameter groups do not fill it", self.odd)
        log.reject(
            "J1939-22 frame with assurance data or another service than J1939's, not read from there on",
            self.other,
        )
