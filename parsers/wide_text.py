"""Text files of two bytes a letter (UTF-16, as PowerShell's ">" and Windows editors write) read as if they had one.

Logs of frames and VBO files are ASCII but for remarks: their readers take a file in pieces by byte places, which one byte a
letter keeps.
"""

from __future__ import annotations

import io
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from parsers.importer import HEAD_BYTES, ImportLog
from parsers.placed_stream import PlacedStream
from parsers.table_text import Encoding, find_encoding
from parsers.text_path import TextPath

_UNKNOWN = ord("?")
_NOTE = "the file is UTF-16, two bytes a letter: letters beyond Latin-1 were read as ?"


def wide_encoding(head: bytes) -> Encoding | None:
    """The encoding of a file by its first bytes, where it has two bytes a letter; else None."""
    if head[:2] not in (b"\xff\xfe", b"\xfe\xff") and b"\0" not in head[:2]:
        return None
    found = find_encoding(head)
    return found if found is not None and found.wide else None


def narrow(data: bytes, encoding: Encoding) -> bytes:
    """Latin-1 of text of two bytes a letter, without its byte order mark; half a letter at the end is left out."""
    return _narrow(data[encoding.mark :], big=encoding.codec.endswith("be")).tobytes()


def narrow_text(path: Path, log: ImportLog | None = None) -> Path:
    """The path, or what reads like the path of a file with one byte a letter where it has two, which is noted. Raises OSError."""
    with path.open("rb") as file:
        encoding = wide_encoding(file.read(HEAD_BYTES))
    if encoding is None:
        return path
    if log is not None:
        log.note(_NOTE)
    return cast("Path", WideText(path, encoding))


def _narrow(data: bytes | bytearray, *, big: bool) -> np.ndarray[tuple[int], np.dtype[np.uint8]]:
    pairs = np.frombuffer(data, np.uint8, len(data) // 2 * 2).reshape(-1, 2)
    high, low = (pairs[:, 0], pairs[:, 1]) if big else (pairs[:, 1], pairs[:, 0])
    return np.where(high == 0, low, np.uint8(_UNKNOWN))


@dataclass(frozen=True)
class _Facts:
    """What `Path.stat` is asked for."""

    st_size: int


@dataclass(frozen=True)
class WideText(TextPath):
    """What the readers of text ask of a path, for a file of two bytes a letter."""

    encoding: Encoding

    def stat(self) -> _Facts:
        """The size in letters."""
        return _Facts(max(self.path.stat().st_size - self.encoding.mark, 0) // 2)

    def raw(self) -> io.RawIOBase:
        """The file as it reads."""
        return _WideFile(self.path, self.encoding)


class _WideFile(PlacedStream):
    """A file whose places count letters."""

    def __init__(self, path: Path, encoding: Encoding) -> None:
        super().__init__()
        self._file = path.open("rb", buffering=0)
        self._mark, self._big = encoding.mark, encoding.codec.endswith("be")

    def length(self) -> int:
        """In letters."""
        return max(self._file.seek(0, os.SEEK_END) - self._mark, 0) // 2

    def readinto(self, buffer: Any) -> int:
        view = memoryview(buffer).cast("B")
        self._file.seek(self._mark + 2 * self._at)
        data = bytearray()
        # a raw file may give less than it is asked for, and half a letter
        while len(data) < 2 * len(view) and (more := self._file.read(2 * len(view) - len(data))):
            data += more
        text = _narrow(data, big=self._big)
        view[: text.size] = text.data
        self._at += text.size
        return int(text.size)

    def close(self) -> None:
        if not self.closed:
            self._file.close()
        super().close()
