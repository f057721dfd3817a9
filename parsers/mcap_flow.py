"""ROS messages of an MCAP file's chunks straight to columns: one call of a kernel reads, unpacks, walks and decodes them.

A chunk's records are then decoded while they are still near the core, and nobody waits for the interpreter's lock in between.
Where a message does not fit its type the chunk is left to the slower way, which says why.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel
from parsers.mcap_chunks import ChunkSpan, McapFile, Scratch
from parsers.mcap_parts import Part
from parsers.mcap_pick import LEAST, LENGTH, LOG, OFFSET, SLOT, Picker, Slots, pick
from parsers.mcap_records import WALK_CUT, WALK_INVALID
from parsers.mcap_train import Train
from parsers.mcap_unpack import (
    AT,
    BROKEN,
    COUNT,
    DONE,
    NEEDED,
    NEXT,
    NO_ROOM,
    NO_ROW,
    ODD,
    SHORT,
    SHORT_HERE,
    SIZE,
    USED,
    WHY,
    Chunks,
    Tools,
    tools_of,
    unpack_chunk,
)
from parsers.ros.flow import Into, Plan, RowRoom, decode_found, has_rows


@kernel
def decode_chunks(
    chunks: Chunks,
    tools: Tools,
    room: ByteArray,
    slot_of: Slots,
    picked: IntArray,
    into: Into,
    state: IntArray,
) -> None:
    """Decode the wanted messages of the chunks from state[NEXT] on, until one of them is not to be done here.

    room: for the records of one chunk. slot_of, picked: see `parsers.mcap_pick`; a slot is a topic of the program. into:
    see `parsers.ros.flow`. state: see `parsers.mcap_unpack`; SIZE is -1 but for a chunk that waits for rows.
    """
    while state[NEXT] < chunks.starts.size:
        if state[SIZE] < 0:
            size = unpack_chunk(chunks, tools, state[NEXT], room, 0, state)
            if size < 0:
                return
            if picked.shape[1] < size // LEAST:
                state[WHY], state[NEEDED] = NO_ROOM, size
                return
            found, at, why, short = pick(room, 0, size, slot_of, picked, 0)
            state[SIZE], state[COUNT], state[AT], state[USED] = size, found, at, why
            state[SHORT_HERE] = short
        if not has_rows(picked[SLOT], state[COUNT], into):
            state[WHY] = NO_ROW
            return
        if not decode_found(
            room, picked[SLOT], picked[OFFSET], picked[LENGTH], picked[LOG], state[COUNT], into
        ):
            state[WHY] = ODD
            return
        state[NEXT] += 1
        state[SHORT] += state[SHORT_HERE]
        if state[USED] in (WALK_CUT, WALK_INVALID):
            state[WHY] = BROKEN
            return
        state[SIZE] = -1
    state[WHY] = DONE


class Flow(Train):
    """Some chunks on their way to columns; of one thread."""

    def __init__(
        self,
        file: McapFile,
        spans: Sequence[ChunkSpan],
        plain: Sequence[bool],
        plan: Plan,
        slot_of: Slots,
        cells: Callable[[int], FloatArray],
    ) -> None:
        """plain: which chunks are whole, and read whole. slot_of: see `parsers.mcap_pick`. cells: gives memory for numbers."""
        super().__init__(file, spans, plain)
        self._slot_of = slot_of
        self._room = RowRoom(plan, cells)

    @property
    def unfit(self) -> bool:
        """Whether the chunk that is for the slower way was unpacked already, and its messages are what is odd."""
        return int(self.state[SIZE]) >= 0

    def decode(self, scratch: Scratch, picker: Picker) -> tuple[int, list[Part]]:
        """Go on from the next chunk: why it stopped (DONE, ODD: the next chunk is, BROKEN: the one before was), and what it gave."""
        state, tools, rows = self.state, tools_of(scratch, self.chunks), self._room
        parts: list[Part] = []
        state[SIZE] = -1
        while True:
            decode_chunks(
                self.chunks,
                tools,
                scratch.records,
                self._slot_of,
                picker.picked,
                rows.into,
                state,
            )
            why = int(state[WHY])
            if why == NO_ROOM:
                state[SIZE] = -1
                scratch.used = picker.count = 0
                scratch.room(int(state[NEEDED]))
                picker.make_room(int(state[NEEDED]))
                continue
            parts += [Part(each.number, each.time_ns, each.decoded) for each in rows.take()]
            if why != NO_ROW:
                return why, parts
            if not rows.renew(len(self.chunks.starts) - self.chunk):
                return ODD, parts
