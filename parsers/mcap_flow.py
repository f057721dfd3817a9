"""ROS messages of an MCAP file's chunks straight to columns: one call of a kernel reads, unpacks, walks and decodes them.

A chunk's records are then decoded while they are still near the core, and nobody waits for the interpreter's lock in between.
Where a message does not fit its type the chunk is left to the slower way, which says why.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel
from parsers.mcap_chunks import ChunkSpan, McapFile, Scratch
from parsers.mcap_parts import MAX_CELLS, Part, Want
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
from parsers.ros.contract import Decoded
from parsers.ros.decoder import LayoutDecoder
from parsers.ros.kernels import CELL, COLUMNS, FILL, ROOM, STAMP_ROW, Program, Rows, Shapes
from parsers.ros.packed import UnpackingDecoder
from parsers.ros.program import make_program, make_rows, make_shapes
from parsers.ros.replay import decode_rows

SPARE_ROWS = 32
"""Beside the rows that are expected of each topic, should the chunks to come be like the one before."""


@kernel
def decode_chunks(
    chunks: Chunks,
    tools: Tools,
    room: ByteArray,
    slot_of: Slots,
    picked: IntArray,
    counts: IntArray,
    program: Program,
    shapes: Shapes,
    rows: Rows,
    offset: IntArray,
    length: IntArray,
    log_ns: IntArray,
    state: IntArray,
) -> None:
    """Decode the wanted messages of the chunks from state[NEXT] on, until one of them is not to be done here.

    room: for the records of one chunk. slot_of, picked: see `parsers.mcap_pick`; a slot is a topic of the program. counts:
    (topics,) messages of the last chunk. offset, length, log_ns: for each row of all topics, as `rows.stamp`. state: see
    `parsers.mcap_unpack`; SIZE is -1 but for a chunk that waits for rows.
    """
    place = rows.place
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
            counts[:] = 0
            for i in range(found):
                counts[picked[SLOT, i]] += 1
        for topic in range(counts.size):
            if place[topic, FILL] + counts[topic] > place[topic, ROOM]:
                state[WHY] = NO_ROW
                return
        for i in range(state[COUNT]):
            topic = picked[SLOT, i]
            row = place[topic, FILL]
            place[topic, FILL] = row + 1
            row += place[topic, STAMP_ROW]
            offset[row], length[row], log_ns[row] = picked[OFFSET, i], picked[LENGTH, i], picked[LOG, i]
        bad = 0
        for topic in range(counts.size):
            last = place[topic, FILL]
            if counts[topic]:
                bad += decode_rows(
                    room, offset, length, topic, last - counts[topic], last, program, shapes, rows
                )
        if bad:
            for topic in range(counts.size):
                place[topic, FILL] -= counts[topic]
            state[WHY] = ODD
            return
        state[NEXT] += 1
        state[SHORT] += state[SHORT_HERE]
        if state[USED] in (WALK_CUT, WALK_INVALID):
            state[WHY] = BROKEN
            return
        state[SIZE] = -1
    state[WHY] = DONE


@dataclass(frozen=True)
class FlowPlan:
    """The topics that are wanted, as one program. depth: how deep the loops of any of them nest."""

    wants: Sequence[Want]
    program: Program
    depth: int
    slot_of: Slots


def plan_of(wants: Sequence[Want], slot_of: Slots) -> FlowPlan | None:
    """None where not all of them are ROS messages of one encoding."""
    # messages that were compressed one by one do not fit their type as they are: the slower way unpacks them
    decoders = [each.plain if isinstance(each := want.decoder, UnpackingDecoder) else each for want in wants]
    if not all(isinstance(each, LayoutDecoder) and not each.layout.has_wstring for each in decoders):
        return None
    known = cast("list[LayoutDecoder]", decoders)
    if len({each.encoding for each in known}) != 1:
        return None
    topics = [(each.layout, want.paths) for each, want in zip(known, wants, strict=True)]
    depth = max(each.layout.depth for each in known)
    return FlowPlan(wants, make_program(topics, known[0].encoding), depth, slot_of)


class Flow(Train):
    """Some chunks on their way to columns; of one thread."""

    def __init__(
        self,
        file: McapFile,
        spans: Sequence[ChunkSpan],
        plain: Sequence[bool],
        plan: FlowPlan,
        cells: Callable[[int], FloatArray],
    ) -> None:
        """plain: which chunks are whole, and read whole. cells: gives memory for numbers."""
        super().__init__(file, spans, plain)
        self._plan, self._cells = plan, cells
        self._shapes = make_shapes(plan.program, plan.depth)
        self._counts = np.zeros(len(plan.wants), np.int64)
        self._place(np.zeros(len(plan.wants), np.int64))

    @property
    def unfit(self) -> bool:
        """Whether the chunk that is for the slower way was unpacked already, and its messages are what is odd."""
        return int(self.state[SIZE]) >= 0

    def _place(self, room: IntArray) -> None:
        """Room for so many rows of each topic."""
        self._rows = make_rows(self._plan.program, room, self._cells)
        n = len(self._rows.stamp)
        self._offset, self._length, self._log = (np.empty(n, np.int64) for _ in range(3))

    def decode(self, scratch: Scratch, picker: Picker) -> tuple[int, list[Part]]:
        """Go on from the next chunk: why it stopped (DONE, ODD: the next chunk is, BROKEN: the one before was), and what it gave."""
        state, tools, parts = self.state, tools_of(scratch, self.chunks), list[Part]()
        state[SIZE] = -1
        while True:
            decode_chunks(
                self.chunks,
                tools,
                scratch.records,
                self._plan.slot_of,
                picker.picked,
                self._counts,
                self._plan.program,
                self._shapes,
                self._rows,
                self._offset,
                self._length,
                self._log,
                state,
            )
            why = int(state[WHY])
            if why == NO_ROOM:
                state[SIZE] = -1
                scratch.used = picker.count = 0
                scratch.room(int(state[NEEDED]))
                picker.make_room(int(state[NEEDED]))
                continue
            parts += self._decoded()
            if why != NO_ROW:
                return why, parts
            columns = self._plan.program.spec[:, COLUMNS]
            if int((self._counts * columns).sum()) > MAX_CELLS:
                return ODD, parts
            like_it = self._counts * (len(self.chunks.starts) - self.chunk) * 21 // 20 + SPARE_ROWS
            few = int((like_it * columns).sum()) <= MAX_CELLS
            self._place(like_it if few else self._counts)

    def _decoded(self) -> list[Part]:
        """The rows so far, topic by topic."""
        rows, parts = self._rows, []
        for number, want in enumerate(self._plan.wants):
            fill, room = int(rows.place[number, FILL]), int(rows.place[number, ROOM])
            if not fill:
                continue
            cell, first = int(rows.place[number, CELL]), int(rows.place[number, STAMP_ROW])
            times = slice(first, first + fill)
            columns = rows.cells[cell : cell + len(want.paths) * room].reshape(len(want.paths), room)[
                :, :fill
            ]
            stamp_ns = rows.stamp[times] if want.decoder.has_header else None
            decoded = Decoded(dict(zip(want.paths, columns, strict=True)), stamp_ns, 0)
            parts.append(Part(number, self._log[times], decoded))
        # nothing of them is written any more
        self._place(np.zeros(len(self._plan.wants), np.int64))
        return parts
