"""One worker process as its supervisor sees it: start it, send to it, hear from it, end it."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import BinaryIO, cast

from parsers.errors import EngineError
from pipelines.engines.messages import Message, read_message, write_message
from pipelines.engines.one_core import DRAWING, ONE_CORE

_STDERR_KEPT = 16 << 10
"""Bytes of what a worker wrote last: enough for the trace of a crash."""

_LAST_WORDS_S = 2.0
"""How long a process whose pipe ended may take to be gone."""

_GONE_WITHIN_S = 10.0
"""How long a killed process is waited for."""

# -m would put the current folder before all that is installed, and what lies there into the worker. So it starts with
# the search path of this process instead
_START = "import sys, json; sys.path[:] = json.loads(sys.argv[2]); from pipelines.engines.worker import main; main()"


class Nothing:
    """What `WorkerProcess.hear` gives when nothing came in time."""


NOTHING = Nothing()


def _command() -> list[str]:
    paths = json.dumps([str(Path(place).absolute()) for place in sys.path])
    # -P: nor is the current folder looked at before that
    return [sys.executable, "-P", "-c", _START, str(os.getpid()), paths]


def _popen() -> subprocess.Popen[bytes]:
    """A worker in a session of its own: the terminal's Ctrl-C does not reach it, and all that it starts can be ended."""
    new_group = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)
    environment = {**os.environ, **ONE_CORE, **DRAWING}
    # Dask sets it for its workers, and the C library then no longer learns by itself what to keep (parsers.allocator)
    environment.pop("MALLOC_TRIM_THRESHOLD_", None)
    return subprocess.Popen(
        _command(),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
        start_new_session=True,
        creationflags=new_group,
    )


class WorkerProcess:
    """A process that runs `pipelines.engines.worker.main`. Raises EngineError where it cannot be started.

    A thread waits for what it says. The same thread starts it, because on Linux a process can only be tied to the life of
    a thread, and this one lives as long as the process; any other might end before.
    """

    def __init__(self) -> None:
        """Start it; `hear` says when it is ready."""
        self._heard: SimpleQueue[Message | None] = SimpleQueue()
        self._said = bytearray()
        self._code: int | None = None
        self._stderr_thread: threading.Thread | None = None
        self._process: subprocess.Popen[bytes]
        born: SimpleQueue[subprocess.Popen[bytes] | OSError] = SimpleQueue()
        self._thread = threading.Thread(target=self._live, args=(born,), daemon=True)
        self._thread.start()
        process = born.get()
        if isinstance(process, OSError):
            raise EngineError(f"a worker process cannot be started: {process}") from process

    def _live(self, born: SimpleQueue[subprocess.Popen[bytes] | OSError]) -> None:
        try:
            process = _popen()
        except OSError as error:
            born.put(error)
            return
        # here, not by who waits for it: a process may be gone before that one is let in
        self._process = process
        self._stderr_thread = threading.Thread(target=self._keep, args=(process.stderr,), daemon=True)
        self._stderr_thread.start()
        born.put(process)
        answers = cast("BinaryIO", process.stdout)
        with contextlib.suppress(OSError, ValueError):
            while (message := read_message(answers)) is not None:
                self._heard.put(message)
        # the end of the pipe: it is dead or dying, or has closed what it should not
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(_LAST_WORDS_S)
        self._code = process.poll()
        self._kill()
        process.wait()
        self._heard.put(None)

    def _keep(self, stderr: BinaryIO) -> None:
        """Read what it writes, so that it never waits for us, and keep the last of it."""
        with contextlib.suppress(OSError, ValueError), stderr:
            while piece := os.read(stderr.fileno(), _STDERR_KEPT):
                self._said += piece
                del self._said[:-_STDERR_KEPT]

    @property
    def pid(self) -> int:
        """The number of the process."""
        return self._process.pid

    @property
    def alive(self) -> bool:
        """Whether it still hears us."""
        return self._thread.is_alive()

    def send(self, message: Message) -> None:
        """Send; a process that is gone says so through `hear`."""
        with contextlib.suppress(OSError, ValueError):
            write_message(cast("BinaryIO", self._process.stdin), message)

    def hear(self, seconds: float | None) -> Message | Nothing | None:
        """Its next message; None where it is gone; NOTHING where it said nothing in so many seconds (None: wait)."""
        try:
            return self._heard.get(timeout=seconds)
        except Empty:
            return NOTHING

    def forget(self) -> None:
        """Drop what it wrote to stderr before: a new task begins."""
        self._said.clear()

    def code(self) -> int | None:
        """Exit code as of Popen.returncode, after `hear` gave None; None where it closed its pipe and lived on."""
        return self._code

    def stderr(self) -> str:
        """The last that it wrote to stderr, after `hear` gave None."""
        if self._stderr_thread is not None:
            self._stderr_thread.join(1.0)
        return self._said.decode("utf-8", "replace")

    def stderr_kept(self) -> int:
        """Bytes of it that are held."""
        return len(self._said)

    def _kill(self) -> None:
        """End it and all that it started, at once. No request first: a drive's results are written whole or not at all."""
        if sys.platform == "win32":
            self._process.kill()
            return
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)

    def end(self) -> None:
        """End it at once and wait until it is gone; not for ever: the kernel keeps what hangs in a dead network's disk."""
        if self._thread.is_alive():
            self._kill()
        if sys.is_finalizing():
            # threads do not run any more when the interpreter ends: nothing would come of waiting for them
            return
        self._thread.join(_GONE_WITHIN_S)
        if self._stderr_thread is not None:
            self._stderr_thread.join(1.0)
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                # what was not sent is of no interest to a process that is gone
                with contextlib.suppress(OSError):
                    pipe.close()
