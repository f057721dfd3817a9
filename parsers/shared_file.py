"""An open file that several threads read, each at places of its own."""

from __future__ import annotations

import os
from collections.abc import Callable
from io import RawIOBase
from threading import Lock

from parsers.channels import ByteArray


def _number_of(file: RawIOBase) -> int:
    try:
        return file.fileno() if hasattr(os, "preadv") else -1
    except OSError:
        return -1


def _filled(out: ByteArray, read: Callable[[memoryview, int], int | None]) -> int:
    """Read until `out` is full or nothing comes any more; how many bytes came. read: into a rest, behind so many bytes."""
    view, done = out.data, 0
    while done < out.size and (got := read(view[done:], done)):
        done += got
    return done


class SharedFile:
    """Reads at given places. number: by which the system knows the file; -1 for one that is not on this machine's disks."""

    def __init__(self, file: RawIOBase) -> None:
        self._file, self._lock = file, Lock()
        self.number = _number_of(file)

    def fill(self, at: int, out: ByteArray) -> int:
        """Read from `at` until `out` (contiguous) is full; how many bytes there were. Raises OSError."""
        number = self.number
        if number >= 0:
            # with a place of its own for each read, threads need not wait for each other
            return _filled(out, lambda rest, done: os.preadv(number, [rest], at + done))
        with self._lock:
            self._file.seek(at)
            return _filled(out, lambda rest, _: self._file.readinto(rest))

    def bytes(self, at: int, size: int) -> bytes:
        """Up to `size` bytes from `at`; a read may stop early without being at the end. Raises OSError."""
        if self.number >= 0:
            return os.pread(self.number, size, at)
        with self._lock:
            self._file.seek(at)
            return self._file.read(size) or b""
