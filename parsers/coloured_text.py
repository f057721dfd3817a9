"""Text logs that were saved with a terminal's colours (`candump -c`), read as if these were blanks.

The readers of text logs take a file in pieces by byte places, so that nothing may move.
"""

from __future__ import annotations

import io
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from parsers.importer import HEAD_BYTES, ImportLog
from parsers.placed_stream import PlacedStream
from parsers.text_path import TextPath

_ESCAPE = re.compile(rb"\x1b\[[0-9;]{0,12}[A-Za-z]")
_LONGEST = 16


def without_colours(data: bytes) -> bytes:
    """The bytes with blanks for a terminal's escape sequences."""
    # few different ones stand in a log, each of them in every line
    for found in set(_ESCAPE.findall(data)):
        data = data.replace(found, b" " * len(found))
    return data


def plain_text(path: Path, log: ImportLog | None = None) -> Path:
    """The path, or what reads like the path of a file without colours where its first lines have some, which is noted. Raises OSError."""
    with path.open("rb") as file:
        if not _ESCAPE.search(file.read(HEAD_BYTES)):
            return path
    if log is not None:
        log.note("the file holds a terminal's colours (as candump -c writes them): they were passed over")
    return cast("Path", ColouredText(path))


@dataclass(frozen=True)
class ColouredText(TextPath):
    """What the readers of text ask of a path, for a file with colours."""

    def raw(self) -> io.RawIOBase:
        """The file as it reads."""
        return _PlainFile(self.path)


class _PlainFile(PlacedStream):
    """A file without colours."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._file = path.open("rb")

    def length(self) -> int:
        """As the file has them."""
        return self._file.seek(0, os.SEEK_END)

    def readinto(self, buffer: Any) -> int:
        view = memoryview(buffer).cast("B")
        # a sequence may begin before what is asked for, and end behind it
        before = min(self._at, _LONGEST)
        self._file.seek(self._at - before)
        data = self._file.read(before + len(view) + _LONGEST)
        text = without_colours(data)[before : before + len(view)]
        view[: len(text)] = text
        self._at += len(text)
        return len(text)

    def close(self) -> None:
        if not self.closed:
            self._file.close()
        super().close()
