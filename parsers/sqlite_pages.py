"""An SQLite file as numbered pages, and reading many of them at once."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from io import FileIO
from pathlib import Path

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.sqlite_kernels import SLACK

HEADER_BYTES = 100
GAP_PAGES = 3
"""Reading on over so few pages that nobody wants is cheaper than reading again behind them."""


@dataclass(frozen=True)
class PagedFile:
    """An SQLite file. page_size, usable: bytes of a page, and how many of them SQLite uses. pages: how many there are,
    the last one numbered so; a file that was cut has fewer than it says. size: of the file, in bytes."""

    path: Path
    page_size: int
    usable: int
    pages: int
    size: int


def paged_file(path: Path) -> PagedFile | None:
    """Look at the header of an SQLite file; None where it is one that SQLite would not open either. Raises OSError."""
    with path.open("rb") as file:
        head = file.read(HEADER_BYTES)
    size = path.stat().st_size
    if len(head) < HEADER_BYTES:
        return None
    told = int.from_bytes(head[16:18], "big")
    page_size = 1 << 16 if told == 1 else told
    usable = page_size - head[20]
    good = 512 <= page_size <= 1 << 16 and page_size & (page_size - 1) == 0 and usable >= 480
    if not good or head[21:24] != b"\x40\x20\x20" or not 1 <= head[19] <= 2:
        return None
    pages = size // page_size
    declared = int.from_bytes(head[28:32], "big")
    if declared and head[24:28] == head[92:96]:  # else an old writer did not keep the count up to date
        pages = min(pages, declared)
    return PagedFile(path, page_size, usable, pages, size)


@dataclass
class PageReader:
    """Reads pages of a file into a buffer of its own, which is used again and again: one reader for each thread."""

    paged: PagedFile
    room: int
    _file: FileIO = field(init=False, repr=False)
    buffer: ByteArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Open the file. room: how many pages `load` can be asked for at a time. Raises OSError."""
        self._file = FileIO(self.paged.path, "rb")
        self.buffer = np.empty(2 * self.room * self.paged.page_size + SLACK, dtype=np.uint8)

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> PageReader:
        """For `with`."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self.close()

    def load(self, pages: IntArray) -> IntArray:
        """Read pages, at most `room`, in any order; where each one is in `buffer`, -1 where it could not be read."""
        place = np.full(len(pages), -1, dtype=np.int64)
        order = np.flatnonzero(pages > 0)
        if not len(order):
            return place
        if (np.diff(pages[order]) < 0).any():
            order = order[np.argsort(pages[order], kind="stable")]
        ordered = pages[order]
        step = np.diff(ordered)
        near = GAP_PAGES + 1
        if int(np.minimum(step, near).sum()) >= 2 * self.room:
            near = 1
        breaks = np.flatnonzero(step > near) + 1
        starts = np.append(0, breaks)
        first = ordered[starts]
        members = np.diff(np.append(starts, len(order)))
        begin, read = self.load_runs(first, ordered[starts + members - 1] - first + 1)
        within = (ordered - np.repeat(first, members)) * self.paged.page_size
        there = within + self.paged.page_size <= np.repeat(read, members)
        place[order] = np.where(there, np.repeat(begin, members) + within, -1)
        return place

    def load_runs(self, first: IntArray, count: IntArray) -> tuple[IntArray, IntArray]:
        """Read runs of `count` pages from number `first` on, one after the other into the buffer.

        Gives where each begins in it, and how many of its bytes there were. Raises ValueError where they do not fit.
        """
        size = count * self.paged.page_size
        begin = np.cumsum(size) - size
        if len(size) and int(begin[-1] + size[-1]) > len(self.buffer) - SLACK:
            raise ValueError("more pages than the buffer holds")
        read = np.zeros(len(first), dtype=np.int64)
        view = self.buffer.data
        places = ((first - 1) * self.paged.page_size).tolist()
        for i, (at, start, length) in enumerate(zip(places, begin.tolist(), size.tolist(), strict=True)):
            if at >= 0:
                read[i] = self._read(at, view[start : start + length])
        return begin, read

    def _read(self, at: int, view: memoryview) -> int:
        done = 0
        while done < len(view):
            if hasattr(os, "preadv"):
                got = os.preadv(self._file.fileno(), [view[done:]], at + done)
            else:  # not on Windows
                self._file.seek(at + done)
                got = self._file.readinto(view[done:])
            if not got:
                break
            done += got
        return done
