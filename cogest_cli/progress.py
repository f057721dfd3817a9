"""Progress on stderr: only on a terminal, only when the work takes longer than two seconds."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import time
from types import TracebackType
from typing import TextIO

from cogest_cli.output import one_line

PATIENCE_S = 2.0
"""Work shorter than this shows nothing."""

REDRAW_S = 0.2
WIDTH = 24
COLUMNS = 80


class ProgressLine:
    """One line that is drawn over itself; a call with (what, share) updates it. Silent where stderr is no terminal.

    A thread redraws it, so that a long step that says nothing in between still shows what it is and how long it takes.
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        """stream: where to draw, stderr unless given."""
        self._stream = stream or sys.stderr
        self._live = self._stream.isatty()
        self._start = time.monotonic()
        self._doing = ("starting", 0.0)
        self._length = 0
        self._done = threading.Event()
        self._thread: threading.Thread | None = None
        encoding = (getattr(self._stream, "encoding", None) or "ascii").lower()
        self._marks = ("█", "·") if encoding.startswith("utf") else ("#", ".")

    def __call__(self, what: str, share: float) -> None:
        """Say what is being done and how much of it is done (0-1)."""
        self._doing = (what, share)

    def _columns(self) -> int:
        try:
            return os.get_terminal_size(self._stream.fileno()).columns or COLUMNS
        except (OSError, ValueError):
            return COLUMNS

    def _draw(self) -> None:
        what, share = self._doing
        filled = round(WIDTH * min(max(share, 0.0), 1.0))
        elapsed = time.monotonic() - self._start
        bar = self._marks[0] * filled + self._marks[1] * (WIDTH - filled)
        # a line that reaches the last column wraps, and would then pile up
        line = f"[{bar}] {elapsed:.0f} s  {one_line(what)}"[: self._columns() - 1]
        self._write("\r" + line.ljust(self._length))
        self._length = len(line)

    def _write(self, text: str) -> None:
        # a terminal that is gone must not end the work
        with contextlib.suppress(OSError, ValueError):
            self._stream.write(text)
            self._stream.flush()

    def _run(self) -> None:
        if self._done.wait(PATIENCE_S):
            return
        self._draw()
        while not self._done.wait(REDRAW_S):
            self._draw()

    def __enter__(self) -> ProgressLine:
        """Start."""
        if self._live:
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
        if self._length:
            self._write("\r" + " " * self._length + "\r")
