"""Blobs that go on over overflow pages, gathered into one buffer; only the chains that are asked for are read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel
from parsers.sqlite_kernels import HERE, LENGTH, NEXT, PLACE, BoolArray, u32
from parsers.sqlite_pages import PagedFile, PageReader


@kernel
def lay_out(data: ByteArray, place: IntArray, here: IntArray, offset: IntArray, side: ByteArray) -> None:
    """Copy the parts of blobs that are on their leaf pages into `side`, each at its offset."""
    for i in range(place.shape[0]):
        for k in range(here[i]):
            side[offset[i] + k] = data[place[i] + k]


@kernel
def follow(
    window: ByteArray,
    first: IntArray,
    count: IntArray,
    start: IntArray,
    page_size: int,
    usable: int,
    following: IntArray,
    at: IntArray,
    left: IntArray,
    side: ByteArray,
) -> None:
    """Follow overflow chains as far as their pages are in the window, copying what is on them into `side`.

    The window holds runs of pages: `count` pages from number `first` on (sorted), at `start`. For each chain:
    `following` is the page that comes next, `at` where its bytes belong in `side`, `left` how many are missing.
    """
    for i in range(following.shape[0]):
        run = 0
        while left[i] > 0:
            page = following[i]
            if not (first[run] <= page < first[run] + count[run]):
                run = max(np.searchsorted(first, page, side="right") - 1, 0)
                if not (first[run] <= page < first[run] + count[run]):
                    break
            base = start[run] + (page - first[run]) * page_size
            size = min(left[i], usable - 4)
            for k in range(size):
                side[at[i] + k] = window[base + 4 + k]
            following[i] = u32(window, base)
            at[i] += size
            left[i] -= size


@dataclass(frozen=True)
class Gathered:
    """Blobs one after the other in data: at offset[i], length[i] bytes; whole[i] is False where its chain is broken.
    pages: how many overflow pages were followed."""

    data: ByteArray
    offset: IntArray
    length: IntArray
    whole: BoolArray
    pages: int


def pages_needed(paged: PagedFile, rows: IntArray) -> IntArray:
    """How many overflow pages each row of `leaf_rows`' table needs; shape (n,)."""
    needed: IntArray = -((rows[HERE] - rows[LENGTH]) // (paged.usable - 4))
    return needed


def gather(leaf_data: ByteArray, rows: IntArray, reader: PageReader) -> Gathered:
    """Copy the blobs of rows, as `leaf_rows` found them in `leaf_data`, and follow their chains with `reader`.

    Pages of a chain mostly follow each other in the file. So as many as a blob needs are read ahead, and where the
    chain turns out to go elsewhere, less is read ahead the next time. No chain is followed further than its blob's
    length asks for, so that one which goes round in circles ends as well.
    """
    length = rows[LENGTH].copy()
    offset = np.cumsum(length) - length
    side = np.empty(int(length.sum()), dtype=np.uint8)
    lay_out(leaf_data, rows[PLACE].copy(), rows[HERE].copy(), offset, side)
    following, at, left = rows[NEXT].copy(), offset + rows[HERE], length - rows[HERE]
    room = len(reader.buffer) // reader.paged.page_size
    ahead = np.minimum(pages_needed(reader.paged, rows), room)
    pages = int(pages_needed(reader.paged, rows).sum())
    while True:
        exists = (following >= 2) & (following <= reader.paged.pages)
        members = np.flatnonzero((left > 0) & exists)
        if not len(members):
            break
        members = members[: max(1, int(np.searchsorted(np.cumsum(ahead[members]), room, side="right")))]
        state = following[members], at[members], left[members]
        _round(reader, *state, ahead[members], side)
        moved = left[members] - state[2]
        following[members], at[members], left[members] = state
        following[members[moved == 0]] = -1  # the file ends before this page
        needed = -(-left[members] // (reader.paged.usable - 4))
        ahead[members] = np.minimum(needed, np.clip(2 * moved // (reader.paged.usable - 4), 1, room))
    return Gathered(side, offset, length, left == 0, pages)


def _round(
    reader: PageReader, following: IntArray, at: IntArray, left: IntArray, ahead: IntArray, side: ByteArray
) -> None:
    """Read `ahead` pages from each chain's next one on, and follow the chains as far as these pages go."""
    order = np.argsort(following, kind="stable")
    begin = following[order]
    end = np.minimum(begin + ahead[order], reader.paged.pages + 1)
    furthest = np.maximum.accumulate(end)
    starts = np.append(0, np.flatnonzero(begin[1:] > furthest[:-1]) + 1)
    first = begin[starts]
    start, read = reader.load_runs(first, furthest[np.append(starts[1:], len(begin)) - 1] - first)
    count = read // reader.paged.page_size
    follow(
        reader.buffer,
        first,
        count,
        start,
        reader.paged.page_size,
        reader.paged.usable,
        following,
        at,
        left,
        side,
    )
