"""Messages of several topics from where they are in a buffer to columns, inside of a kernel that finds them bit by bit.

A kernel that reads a log calls `has_rows` and `decode_found` for what it found in each bit of it, and comes back where rows run
out; `RowRoom` gives it new ones, and makes columns of those that are filled.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, cast

import numpy as np

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.jit import kernel
from parsers.ros.contract import Decoded, MessageDecoder
from parsers.ros.decoder import LayoutDecoder
from parsers.ros.kernels import CELL, COLUMNS, FILL, ROOM, STAMP_ROW, Program, Rows, Shapes
from parsers.ros.packed import UnpackingDecoder
from parsers.ros.program import make_program, make_rows, make_shapes
from parsers.ros.replay import decode_rows
from parsers.ros.topics import MAX_CELLS

SPARE_ROWS = 32
"""Beside the rows that are expected of each topic, should the bits to come be like the one before."""


class Into(NamedTuple):
    """Where messages are decoded to. counts: (topics,) of the bit that is looked at. offset, length, times: for each row of all
    topics, as `rows.stamp`."""

    counts: IntArray
    program: Program
    shapes: Shapes
    rows: Rows
    offset: IntArray
    length: IntArray
    times: IntArray


@kernel
def has_rows(topic: IntArray, found: int, into: Into) -> bool:
    """Whether there are rows for the messages that were found; sets `into.counts`. topic: (found,) at least."""
    counts, place, fits = into.counts, into.rows.place, True
    counts[:] = 0
    for i in range(found):
        counts[topic[i]] += 1
    for k in range(counts.size):
        fits = fits and place[k, FILL] + counts[k] <= place[k, ROOM]
    return fits


@kernel
def decode_found(
    data: ByteArray, topic: IntArray, at: IntArray, size: IntArray, time_ns: IntArray, found: int, into: Into
) -> bool:
    """Decode messages for which there are rows, as `has_rows` said; False where one does not fit its type: then none is taken.

    topic, at, size, time_ns: (found,) at least, of each message.
    """
    counts, rows, offset, length, times = into.counts, into.rows, into.offset, into.length, into.times
    place = rows.place
    for i in range(found):
        row = place[topic[i], FILL]
        place[topic[i], FILL] = row + 1
        row += place[topic[i], STAMP_ROW]
        offset[row], length[row], times[row] = at[i], size[i], time_ns[i]
    bad = 0
    for k in range(counts.size):
        last = place[k, FILL]
        if counts[k]:
            bad += decode_rows(
                data, offset, length, k, last - counts[k], last, into.program, into.shapes, rows
            )
    if bad:
        for k in range(counts.size):
            place[k, FILL] -= counts[k]
    return bad == 0


@dataclass(frozen=True)
class Plan:
    """The wanted topics as one program. depth: how deep the loops of any of them nest. paths, has_header: of each topic."""

    program: Program
    depth: int
    paths: tuple[tuple[str, ...], ...]
    has_header: tuple[bool, ...]


def plan_of(wanted: Sequence[tuple[MessageDecoder, tuple[str, ...]]]) -> Plan | None:
    """wanted: decoder and field paths of each topic. None where not all of them are ROS messages of one encoding."""
    # messages that were compressed one by one do not fit their type as they are: the slower way unpacks them
    decoders = [each.plain if isinstance(each, UnpackingDecoder) else each for each, _ in wanted]
    if not all(isinstance(each, LayoutDecoder) and not each.layout.has_wstring for each in decoders):
        return None
    known = cast("list[LayoutDecoder]", decoders)
    if len({each.encoding for each in known}) != 1:
        return None
    paths = tuple(tuple(each) for _, each in wanted)
    topics = [(each.layout, some) for each, some in zip(known, paths, strict=True)]
    return Plan(
        make_program(topics, known[0].encoding),
        max(each.layout.depth for each in known),
        paths,
        tuple(each.has_header for each in known),
    )


@dataclass(frozen=True)
class Filled:
    """Decoded messages of one topic, in their order. number: of the topic. time_ns: (n,), as the kernel was given them."""

    number: int
    time_ns: IntArray
    decoded: Decoded


class RowRoom:
    """Rows for one kernel to fill; of one thread. There are none at first. into: for the kernel."""

    def __init__(self, plan: Plan, cells: Callable[[int], FloatArray]) -> None:
        """cells: gives memory for numbers."""
        self._plan, self._cells = plan, cells
        self._shapes = make_shapes(plan.program, plan.depth)
        counts = np.zeros(len(plan.paths), np.int64)
        self.into = self._place(counts, counts.copy())

    def _place(self, counts: IntArray, room: IntArray) -> Into:
        """Room for so many rows of each topic."""
        program = self._plan.program
        rows = make_rows(program, room, self._cells)
        n = len(rows.stamp)
        offset, length, times = (np.empty(n, np.int64) for _ in range(3))
        return Into(counts, program, self._shapes, rows, offset, length, times)

    def renew(self, like_it: int) -> bool:
        """New rows for the messages that found none (`into.counts`), and for so many bits like that one. False: those alone are
        too many."""
        columns, counts = self._plan.program.spec[:, COLUMNS], self.into.counts
        if int((counts * columns).sum()) > MAX_CELLS:
            return False
        room = counts * like_it * 21 // 20 + SPARE_ROWS
        few = int((room * columns).sum()) <= MAX_CELLS
        self.into = self._place(counts, room if few else counts)
        return True

    def take(self) -> list[Filled]:
        """What is in the rows, topic by topic; there are none then."""
        rows, taken = self.into.rows, []
        for number, paths in enumerate(self._plan.paths):
            fill, room = int(rows.place[number, FILL]), int(rows.place[number, ROOM])
            if not fill:
                continue
            cell, first = int(rows.place[number, CELL]), int(rows.place[number, STAMP_ROW])
            times = slice(first, first + fill)
            columns = rows.cells[cell : cell + len(paths) * room].reshape(len(paths), room)[:, :fill]
            stamp_ns = rows.stamp[times] if self._plan.has_header[number] else None
            decoded = Decoded(dict(zip(paths, columns, strict=True)), stamp_ns, 0)
            taken.append(Filled(number, self.into.times[times], decoded))
        # nothing of them is written any more
        self.into = self._place(self.into.counts, np.zeros_like(self.into.counts))
        return taken
