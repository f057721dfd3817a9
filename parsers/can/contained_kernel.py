"""Kernels of J1939-22's frames of several parameter groups (Multi-PG, PGN 9472, on CAN FD): every group as a frame of its own.

A group has four bytes before it: type of service and trailer format (three bits each) with the 18 bits of its number, and its length. Type 2
without a trailer is J1939's own; behind a header of type 0 there is padding. What carries assurance data ends the frame for us: nothing here says
where the next group begins.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from parsers.can.j1939_kernel import GROUP
from parsers.can.slots import BusArray, IdArray
from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel

HEAD, FD_BYTES, CLASSIC_BYTES = 4, 64, 8
MOST_GROUPS = FD_BYTES // HEAD
"""Of one frame: groups may be empty."""
PADDING, PLAIN = 0, 2
CONTAINER = 0x80250000
"""GROUP bits of an identifier whose frame may hold several groups."""
# places in the state vector: groups written, those with assurance data or another service, frames that are not laid out so
FOUND, OTHER, ODD, STATE_SIZE = range(4)


class Groups(NamedTuple):
    """Room for the groups of a batch's frames, as `CanFrames` has it: payloads stay where they are. state: (STATE_SIZE,)."""

    time_ns: IntArray
    can_id: IdArray
    bus: BusArray
    length: ByteArray
    offset: IntArray
    state: IntArray


@kernel
def split_containers(
    time_ns: IntArray,
    can_id: IdArray,
    bus: BusArray,
    length: ByteArray,
    offset: IntArray,
    data: ByteArray,
    out: Groups,
) -> None:
    """Write the groups of all such frames; `out` has room for MOST_GROUPS a frame."""
    state = out.state
    for i in range(can_id.size):
        if np.int64(can_id[i]) & GROUP != CONTAINER:
            continue
        begin, size = int(offset[i]), min(int(length[i]), FD_BYTES)
        if begin < 0 or begin > data.size - size:
            continue
        first, at, other = int(state[FOUND]), 0, 0
        while at + HEAD <= size:
            head = int(data[begin + at])
            service, trailer = head >> 5, (head >> 2) & 7
            if service == PADDING:
                break
            if service != PLAIN or trailer:
                other = 1
                break
            count = int(data[begin + at + 3])
            pgn = (head & 3) << 16 | int(data[begin + at + 1]) << 8 | int(data[begin + at + 2])
            addressed = (pgn >> 8) & 0xFF < 240
            if at + HEAD + count > size or (addressed and pgn & 0xFF):
                other = -1
                break
            n = int(state[FOUND])
            target = int(can_id[i]) & 0xFF00 if addressed else 0
            out.time_ns[n], out.bus[n] = time_ns[i], bus[i]
            out.can_id[n] = int(can_id[i]) & 0x9C0000FF | (pgn << 8) | target
            out.length[n], out.offset[n] = count, begin + at + HEAD
            state[FOUND] = n + 1
            at += HEAD + count
        if other < 0:
            # some other protocol's frame, or a damaged one: none of its groups is believed
            state[FOUND] = first
            state[ODD] += 1
        elif other > 0 and size > CLASSIC_BYTES:
            # shorter ones may be another protocol's on classic CAN
            state[OTHER] += 1
