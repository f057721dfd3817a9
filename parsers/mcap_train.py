"""Chunks of an MCAP file read, unpacked, checked and walked by one call of a kernel, for messages of any encoding.

A chunk by itself takes a quarter of a millisecond, between some ten calls that each come back for the interpreter's lock: two
cores then wait for each other. What is not as recorders write it (other compressions, damage, a chunk's record that is odd)
is left to the slower way, chunk by chunk.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel
from parsers.mcap_chunks import ChunkSpan, McapFile, Scratch
from parsers.mcap_pick import LEAST, Picker, Slots, pick
from parsers.mcap_records import WALK_CUT, WALK_INVALID
from parsers.mcap_unpack import (
    AT,
    BROKEN,
    COUNT,
    DONE,
    ENOUGH,
    NEEDED,
    NEXT,
    NO_ROOM,
    SHORT,
    SIZE,
    STATE,
    USED,
    WHY,
    Chunks,
    Tools,
    chunks_of,
    tools_of,
    unpack_chunk,
)


@kernel
def take_chunks(
    chunks: Chunks,
    tools: Tools,
    room: ByteArray,
    slot_of: Slots,
    picked: IntArray,
    enough: int,
    state: IntArray,
) -> None:
    """Collect the wanted messages of the chunks from state[NEXT] on, until one of them is not to be done here.

    room: for records, of which there are state[USED] bytes already. slot_of, picked: see `parsers.mcap_pick`. enough: bytes of
    records at which to stop. state: (STATE,), see `parsers.mcap_unpack`.
    """
    while state[NEXT] < chunks.starts.size:
        used = state[USED]
        size = unpack_chunk(chunks, tools, state[NEXT], room, used, state)
        if size < 0:
            return
        if picked.shape[1] - state[COUNT] < size // LEAST:
            state[WHY], state[NEEDED] = NO_ROOM, size
            return
        count, at, why, short = pick(room, used, used + size, slot_of, picked, state[COUNT])
        state[NEXT] += 1
        state[USED], state[COUNT], state[SHORT] = used + size, count, state[SHORT] + short
        if why in (WALK_CUT, WALK_INVALID):
            state[AT], state[SIZE], state[WHY] = at - used, size, BROKEN
            return
        if state[USED] >= enough:
            state[WHY] = ENOUGH
            return
    state[WHY] = DONE


class Train:
    """Some chunks on their way through a kernel; of one thread."""

    def __init__(self, file: McapFile, spans: Sequence[ChunkSpan], plain: Sequence[bool]) -> None:
        """plain: which chunks are whole, and read whole."""
        self.chunks = chunks_of(file, spans, plain)
        self.state = np.zeros(STATE, np.int64)

    @property
    def chunk(self) -> int:
        """The chunk to go on with."""
        return int(self.state[NEXT])

    def skip(self) -> None:
        """Leave the next chunk out."""
        self.state[NEXT] += 1

    @property
    def short(self) -> int:
        """Message records too short for their own head, so far."""
        return int(self.state[SHORT])

    @property
    def at(self) -> int:
        """Where in a broken chunk the walk stopped."""
        return int(self.state[AT])

    @property
    def size(self) -> int:
        """Bytes of a broken chunk."""
        return int(self.state[SIZE])

    def run(self, scratch: Scratch, picker: Picker, slot_of: Slots, enough: int) -> int:
        """Go on from the next chunk; why it stopped: DONE, ENOUGH, ODD (the next chunk is), BROKEN (the one before was)."""
        state, tools = self.state, tools_of(scratch, self.chunks)
        state[USED], state[COUNT] = scratch.used, picker.count
        while True:
            take_chunks(self.chunks, tools, scratch.records, slot_of, picker.picked, enough, state)
            scratch.used, picker.count = int(state[USED]), int(state[COUNT])
            if state[WHY] != NO_ROOM:
                return int(state[WHY])
            # once for all: what is made larger little by little is copied and cleared each time
            scratch.room(enough + int(state[NEEDED]))
            picker.make_room(enough + int(state[NEEDED]))
