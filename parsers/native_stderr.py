"""Keeps what a native library writes to stderr while it breaks down: the error that is raised says it in one line.

polars reads damaged Parquet files until an assertion fails; the threads that do so write their stacks to file descriptor 2.
"""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
import threading
from collections.abc import Iterator
from typing import IO

import polars as pl

_STDERR = 2


class _Redirected:
    """Descriptor 2 is the process's, and so is who holds it: the first in redirects it, the last out gives it back."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._holders = 0
        self._kept: IO[bytes] | None = None
        self._original = -1

    def enter(self) -> None:
        """One more holder."""
        with self._lock:
            self._holders += 1
            if self._holders > 1:
                return
            with contextlib.suppress(OSError, ValueError):
                sys.stderr.flush()
                kept = tempfile.TemporaryFile()  # noqa: SIM115 - closed in `leave`
                self._original = os.dup(_STDERR)
                os.dup2(kept.fileno(), _STDERR)
                self._kept = kept

    def leave(self, *, broke: bool) -> None:
        """One holder less. broke: what was written is not worth telling."""
        with self._lock:
            self._holders -= 1
            if self._holders or self._kept is None:
                return
            kept, self._kept = self._kept, None
            os.dup2(self._original, _STDERR)
            os.close(self._original)
            with kept, contextlib.suppress(OSError):
                if not broke:
                    kept.seek(0)
                    os.write(_STDERR, kept.read())


_redirected = _Redirected()


@contextlib.contextmanager
def quiet_panics() -> Iterator[None]:
    """While in it, what is written to stderr waits; it is dropped where a panic comes out, and written else."""
    _redirected.enter()
    broke = False
    try:
        yield
    except pl.exceptions.PanicException:
        broke = True
        raise
    finally:
        _redirected.leave(broke=broke)
