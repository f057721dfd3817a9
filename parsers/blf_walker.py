"""The frames of a BLF file's blocks, one block after the other; most of a block can be walked before its turn has come.

What is at a block's beginning only the block before can tell: the rest of an object, most of the time. A guess starts at
the first thing that looks like an object, on any core; when its turn comes, it is held against where the objects really
go on, and taken or thrown away. Either way the frames are the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from parsers.allocator import Slab
from parsers.blf_objects import (
    BAD,
    BAD_TIME,
    ERRORS,
    FRAMES,
    GAP_OPEN,
    LAST_TIME,
    LOST,
    MORE,
    OTHERS,
    POS,
    REMOTE,
    SEARCHING,
    first_object,
)
from parsers.blf_walk import BEHIND, FRONT, Block, Columns, block_of, fresh_state, no_gaps
from parsers.can.frames import CanFrames
from parsers.channels import ByteArray, IntArray

_PADDING = 7
_TROUBLE = (BAD, LOST, SEARCHING, GAP_OPEN)
_TALLIES = (REMOTE, ERRORS, OTHERS, BAD_TIME)


@dataclass(frozen=True)
class Guess:
    """A block that was walked from byte `first` of its buffer on. state: as the kernel left it, begun afresh."""

    first: int
    state: IntArray
    columns: Columns


def guess(block: Block, start_ns: int, columns: Columns) -> Guess | None:
    """Walk a block ahead of its turn; None where there is no object in it, or something is wrong with it."""
    state = fresh_state()
    first = first_object(block.buffer, block.begin, block.end)
    if first < 0:
        return None
    state[POS] = first
    columns.walk(block.buffer, block.end, start_ns, state, no_gaps())
    return None if state[list(_TROUBLE)].any() else Guess(first, state, columns)


@dataclass
class ObjectWalker:
    """Blocks in, frames out; keeps the piece of an object that straddles two blocks, and the tallies.

    start_ns: added to every stamp. state: the kernel's tallies, read after the last block.
    """

    start_ns: int
    state: IntArray = field(default_factory=fresh_state)
    gaps: IntArray = field(default_factory=no_gaps)
    tail: bytes = b""
    _columns: Columns = field(default_factory=lambda: Columns.of(Slab(0)))
    _joint: ByteArray = field(default_factory=lambda: np.zeros(2 * FRONT + BEHIND, np.uint8))

    def lose(self, size: int) -> None:
        """A block of `size` bytes could not be read: what straddles it is lost too, and the next object is searched."""
        self.state[LOST] += size + len(self.tail)
        self.tail = b""
        self.state[SEARCHING] = self.state[GAP_OPEN] = 1

    def walk(self, block: Block, ahead: Guess | None = None) -> Iterator[CanFrames]:
        """The frames that end in this block, in batches that are good until the next is asked for."""
        buffer, begin, end = block.buffer, block.begin, block.end
        if begin == end:
            return
        state = self.state
        straddling = self._up_to(block, ahead.first) if ahead is not None else -1
        if ahead is not None and straddling >= 0:
            if straddling:
                yield self._columns.frames(straddling, self._joint)
            self._take(ahead)
            yield ahead.columns.frames(int(ahead.state[FRAMES]), buffer)
        else:
            kept = len(self.tail)
            if kept > begin:
                joined = block_of("joined", 0, 0, self.tail, buffer[begin:end].tobytes())
                buffer, begin, end = joined.buffer, joined.begin, joined.end
            elif kept:
                begin -= kept
                buffer[begin : begin + kept] = np.frombuffer(self.tail, np.uint8)
            state[POS], state[MORE] = begin, 1
        while state[MORE]:
            self._columns.walk(buffer, end, self.start_ns, state, self.gaps)
            yield self._columns.frames(int(state[FRAMES]), buffer)
        self.tail = buffer[int(state[POS]) : end].tobytes()

    def _up_to(self, block: Block, first: int) -> int:
        """Walk what comes before byte `first` of a block's buffer: the number of frames there, which are in the columns.

        -1, and nothing has changed, where the objects do not go on at that byte.
        """
        state, size = self.state, len(self.tail) + first - block.begin
        if state[SEARCHING] or state[GAP_OPEN] or size > FRONT:
            return -1
        if not self.tail:
            return 0 if size <= _PADDING else -1
        before = state.copy()
        joint, end = self._joint, FRONT + size
        joint[FRONT : FRONT + len(self.tail)] = np.frombuffer(self.tail, np.uint8)
        joint[FRONT + len(self.tail) : end] = block.buffer[block.begin : first]
        state[POS] = FRONT
        self._columns.walk(joint, end, self.start_ns, state, self.gaps)
        trouble = any(state[place] != before[place] for place in _TROUBLE)
        if trouble or state[MORE] or end - state[POS] > _PADDING:
            state[:] = before
            return -1
        return int(state[FRAMES])

    def _take(self, ahead: Guess) -> None:
        """Go on from where a guess ended."""
        for place in _TALLIES:
            self.state[place] += ahead.state[place]
        self.state[POS], self.state[MORE] = ahead.state[POS], ahead.state[MORE]
        if ahead.state[FRAMES]:
            self.state[LAST_TIME] = ahead.state[LAST_TIME]
