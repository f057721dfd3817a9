"""Blocks of whole lines of a file, read from within a kernel: a piece of a log then needs the interpreter once, not for each block.

On two cores, threads that come back for the interpreter's lock every half millisecond wait for each other longer than they work.
"""

from __future__ import annotations

import numpy as np

from parsers.can.words import FRONT
from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel
from parsers.jit_foreign import address_of_byte, call_4

PREAD, FILE, BLOCK, AT, LEFT, BEGIN, STOP, FILL, CUT, PASSING, LAST, WALK = range(12)
"""Places in a walk: the address of `pread`, the file's number, the bytes of a block; where in the file to go on and how much is left
of the piece; the lines in the buffer that are to be parsed, the end of what is in it, whether their last one is cut off, whether the
rest of that is being passed over; the last byte that was read, 0 where the file
ended before the piece, -1 where reading failed."""


def walk_of(pread: int, file: int, block: int, begin: int, end: int) -> IntArray:
    """A walk through the bytes [begin, end) of an open file."""
    walk = np.zeros(WALK, np.int64)
    walk[[PREAD, FILE, BLOCK, AT, LEFT]] = pread, file, block, begin, end - begin
    walk[[BEGIN, STOP, FILL]] = FRONT
    return walk


@kernel
def next_block(text: ByteArray, walk: IntArray) -> bool:
    """Whether there are lines to parse, [BEGIN, STOP): the rest of the last ones, or after those the next of the piece.

    text: a buffer for two blocks between margins. A line without a feed for more than a block is cut: what follows up to its
    feed is passed over.
    """
    if walk[BEGIN] < walk[STOP]:
        return True
    while walk[LEFT] > 0:
        kept = FRONT + walk[FILL] - walk[STOP]
        for i in range(kept - FRONT):
            text[FRONT + i] = text[walk[STOP] + i]
        got = call_4(
            walk[PREAD], walk[FILE], address_of_byte(text, kept), min(walk[BLOCK], walk[LEFT]), walk[AT]
        )
        if got < 0:
            walk[LAST], walk[LEFT] = -1, 0
            return False
        # a file may have become shorter since it was measured
        walk[LEFT] = walk[LEFT] - got if got > 0 else 0
        walk[AT] += got
        fill = kept + got
        begin = FRONT
        walk[FILL] = walk[STOP] = fill
        if walk[PASSING] == 1:
            while begin < fill and text[begin] != 10:
                begin += 1
            if begin == fill:
                continue
            begin, walk[PASSING] = begin + 1, 0
        stop = fill
        if walk[LEFT] > 0:
            while stop > begin and text[stop - 1] != 10:
                stop -= 1
        walk[CUT] = 0
        if stop == begin and fill - begin > walk[BLOCK]:
            stop, walk[CUT], walk[PASSING] = fill, 1, 1
        walk[BEGIN], walk[STOP] = begin, stop
        walk[LAST] = text[fill - 1] if got > 0 else 0
        if stop > begin:
            return True
    return False
