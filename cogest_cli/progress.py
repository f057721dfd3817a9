"""Progress on stderr: only on a terminal, only when the work takes longer than two seconds."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import time
import unicodedata
from collections.abc import Callable
from types import TracebackType
from typing import TextIO

from cogest_cli.output import one_line

PATIENCE_S = 2.0
"""Work shorter than this shows nothing."""

REDRAW_S = 0.2
WIDTH = 24
COLUMNS = 80


def _width(letter: str) -> int:
    """Columns that a letter takes on a terminal: those of East Asia take two."""
    return 2 if unicodedata.east_asian_width(letter) in "WF" else 1


def fitted(text: str, columns: int) -> str:
    """The beginning of a text that takes at most so many columns."""
    taken = 0
    for place, letter in enumerate(text):
        taken += _width(letter)
        if taken > columns:
            return text[:place]
    return text


class LiveLine:
    """One line that is drawn over itself while the work goes on. Silent where the stream is no terminal.

    A thread redraws it, so that a long step that says nothing in between still shows what it is and how long it takes.
    """

    def __init__(self, line: Callable[[int], str], stream: TextIO | None = None) -> None:
        """line: what to draw, given how many columns there are. stream: where, stderr unless given."""
        self._line = line
        self._stream = stream or sys.stderr
        self.live = self._stream.isatty()
        self._length = 0
        self._lock = threading.Lock()
        self._done = threading.Event()
        self._thread: threading.Thread | None = None
        encoding = (getattr(self._stream, "encoding", None) or "ascii").lower()
        self._marks = ("█", "·") if encoding.startswith("utf") else ("#", ".")

    def bar(self, share: float, width: int = WIDTH) -> str:
        """How much is done (0-1), as a bar in brackets."""
        filled = round(width * min(max(share, 0.0), 1.0))
        return f"[{self._marks[0] * filled}{self._marks[1] * (width - filled)}]"

    def above(self, text: str) -> None:
        """Print one line that stays, above the live one; plainly where there is no terminal."""
        with self._lock:
            self._wipe()
            self._write(one_line(text) + "\n")

    def _columns(self) -> int:
        try:
            return os.get_terminal_size(self._stream.fileno()).columns or COLUMNS
        except (OSError, ValueError):
            return COLUMNS

    def _draw(self) -> None:
        # a line that reaches the last column wraps, and would then pile up
        columns = self._columns() - 1
        line = fitted(self._line(columns), columns)
        with self._lock:
            length = sum(map(_width, line))
            self._write("\r" + line + " " * (self._length - length))
            self._length = length

    def _wipe(self) -> None:
        if self._length:
            self._write("\r" + " " * self._length + "\r")
            self._length = 0

    def _write(self, text: str) -> None:
        # a terminal that is gone must not end the work; nor may a letter that it lacks
        with contextlib.suppress(OSError, ValueError):
            self._stream.write(text)
            self._stream.flush()

    def _run(self) -> None:
        if self._done.wait(PATIENCE_S):
            return
        self._draw()
        while not self._done.wait(REDRAW_S):
            self._draw()

    def __enter__(self) -> LiveLine:
        """Start."""
        if self.live:
            self._thread = threading.Thread(target=self._run, daemon=True)
            self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wipe the line, so that what follows starts on a clean one."""
        self._done.set()
        if self._thread is not None:
            self._thread.join()
        with self._lock:
            self._wipe()


class ProgressLine:
    """The progress of one piece of work: a call with (what, share) updates it."""

    def __init__(self, stream: TextIO | None = None) -> None:
        """stream: where to draw, stderr unless given."""
        self._start = time.monotonic()
        self._doing = ("starting", 0.0)
        self._live = LiveLine(self._text, stream)

    def __call__(self, what: str, share: float) -> None:
        """Say what is being done and how much of it is done (0-1)."""
        self._doing = (what, share)

    def _text(self, columns: int) -> str:
        what, share = self._doing
        elapsed = time.monotonic() - self._start
        return f"{self._live.bar(share)} {elapsed:.0f} s  {one_line(what)}"

    def __enter__(self) -> ProgressLine:
        """Start."""
        self._live.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wipe the line, so that what follows starts on a clean one."""
        self._live.__exit__(kind, error, trace)
