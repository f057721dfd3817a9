"""Progress on stderr: only on a terminal, only when the work takes longer than two seconds."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import TextIO

PATIENCE_S = 2.0
"""Work shorter than this shows nothing."""

REDRAW_S = 0.1
WIDTH = 24


class ProgressLine:
    """One line that is drawn over itself; a call with (what, share) updates it. Silent where stderr is no terminal."""

    def __init__(self, stream: TextIO | None = None) -> None:
        """stream: where to draw, stderr unless given."""
        self._stream = stream or sys.stderr
        self._live = self._stream.isatty()
        self._start = time.monotonic()
        self._drawn = 0.0
        self._length = 0

    def __call__(self, what: str, share: float) -> None:
        """Say what is being done and how much of it is done (0-1)."""
        if not self._live:
            return
        now = time.monotonic()
        if now - self._start < PATIENCE_S or now - self._drawn < REDRAW_S:
            return
        self._drawn = now
        filled = round(WIDTH * min(max(share, 0.0), 1.0))
        safe = "".join(c if c.isprintable() else "?" for c in what)[:50]
        line = f"[{'█' * filled}{'·' * (WIDTH - filled)}] {safe}  {now - self._start:.0f} s"
        self._stream.write("\r" + line.ljust(self._length))
        self._stream.flush()
        self._length = len(line)

    def __enter__(self) -> ProgressLine:
        """Start."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Wipe the line, so that what follows starts on a clean one."""
        if self._length:
            self._stream.write("\r" + " " * self._length + "\r")
            self._stream.flush()
