"""A worker process and who looks after it: tasks one by one, limits kept, a new process when the old one is spent."""

from __future__ import annotations

import threading
import time

from parsers.errors import EngineError
from pipelines.engines.base import Done, Limits, Task
from pipelines.engines.endings import crash_reason, last_line
from pipelines.engines.messages import Message
from pipelines.engines.process import Nothing, WorkerProcess
from pipelines.engines.resident import resident_bytes

LOOK_EVERY_S = 0.1
"""How often the memory of a working process is looked at."""

READY_WITHIN_S = 120.0
"""Longest start of a process: imports on a busy machine, from a network's disk."""

RECYCLE_AFTER = 500
"""Tasks a process: whatever leaks in a library ends there. A start costs less than one task."""

KEPT_SHARE = 0.25
"""Of the memory limit: a process that keeps more than this beyond what it kept after its first task is replaced."""

KEPT_BYTES = 1 << 30
"""The same where there is no limit."""

STARTS = 3
"""How often a start is tried: memory or processes may be short for a moment."""

STOPPED = "the batch was stopped"


def seconds_reason(seconds: float) -> str:
    """A task that took too long, in words."""
    return f"took longer than {seconds:g} s (limit)"


def memory_reason(limit: int) -> str:
    """A task that took too much memory, in words. limit: bytes."""
    size = f"{limit / (1 << 30):.1f} GiB" if limit >= 1 << 30 else f"{limit / (1 << 20):.0f} MiB"
    return f"took more than {size} (limit)"


class _NotStartedError(EngineError):
    """A process did not come up, which may pass."""


class Stopped(Exception):  # noqa: N818 - not an error: somebody asked for it
    """The worker was ended by `Supervised.end` while it worked."""


class Supervised:
    """Runs one function over tasks in a process of its own, warm from task to task. One thread at a time calls `run`."""

    def __init__(self, function: str, name: str, start_within_s: float = READY_WITHIN_S) -> None:
        """function: "module:name". name: of this worker, in words. Nothing is started before the first task."""
        self._function = function
        self._name = name
        self._start_within = start_within_s
        self._lock = threading.Lock()
        self._process: WorkerProcess | None = None
        self._ended = False
        self._tasks = 0
        self._kept = 0

    def end(self) -> None:
        """End the process at once, whatever it does; any thread may. A `run` that is under way raises Stopped."""
        with self._lock:
            self._ended = True
            process, self._process = self._process, None
        if process is not None:
            process.end()

    @property
    def ended(self) -> bool:
        """Whether `end` was called."""
        return self._ended

    def run(self, task: Task, limits: Limits) -> Done:
        """Run one task. Raises EngineError where no process can be started; Stopped after `end`."""
        self._replace_if_spent(limits)
        process = self._given(task)
        began = time.perf_counter()
        ending = self._await(process, began, limits)
        seconds = time.perf_counter() - began
        if isinstance(ending, dict):
            self._after(process)
            return Done(task.key, ending["status"], ending["answer"], ending["reason"], seconds, self._name)
        done = self._judge(process, ending, task, seconds)
        self._drop()
        return done

    def _given(self, task: Task) -> WorkerProcess:
        """The process that has begun the task. One that dies before that is no fault of the task: another gets it."""
        for _ in range(2):
            process = self._warm()
            process.forget()
            process.send({"payload": task.payload})
            if isinstance(process.hear(self._start_within), dict):
                return process
            self._drop()
            if self._ended:
                raise Stopped
        raise EngineError("worker processes start, but do not take a task")

    def _await(self, process: WorkerProcess, began: float, limits: Limits) -> Message | Limits | None:
        """The answer; None where the process died; the limit that it broke, alone in its record."""
        deadline = None if limits.seconds is None else began + limits.seconds
        look = None if limits.memory_bytes is None else LOOK_EVERY_S
        while True:
            left = None if deadline is None else max(deadline - time.perf_counter(), 0.0)
            waits = [wait for wait in (left, look) if wait is not None]
            message = process.hear(min(waits, default=None))
            if not isinstance(message, Nothing):
                return message
            if deadline is not None and time.perf_counter() >= deadline:
                # after a pause of this process (Ctrl-Z) the answer may have waited longer than the task took
                message = process.hear(LOOK_EVERY_S)
                return Limits(seconds=limits.seconds) if isinstance(message, Nothing) else message
            if limits.memory_bytes is not None and resident_bytes(process.pid) > limits.memory_bytes:
                return Limits(memory_bytes=limits.memory_bytes)

    def _judge(self, process: WorkerProcess, ending: Limits | None, task: Task, seconds: float) -> Done:
        """What to say of a task without an answer: the limit that it broke, or how its process died."""
        if self._ended:
            raise Stopped
        if ending is None:
            reason = crash_reason(process.code(), process.stderr())
            return Done(task.key, "crashed", "", reason, seconds, self._name)
        if ending.seconds is not None:
            return Done(task.key, "timeout", "", seconds_reason(ending.seconds), seconds, self._name)
        return Done(task.key, "memory", "", memory_reason(ending.memory_bytes or 0), seconds, self._name)

    def _after(self, process: WorkerProcess) -> None:
        self._tasks += 1
        if self._tasks == 1:
            self._kept = resident_bytes(process.pid)

    def _replace_if_spent(self, limits: Limits) -> None:
        """End a process that did many tasks, or keeps what it should have given back."""
        process = self._process
        if process is None or self._tasks == 0:
            return
        most = KEPT_BYTES if limits.memory_bytes is None else int(KEPT_SHARE * limits.memory_bytes)
        if self._tasks >= RECYCLE_AFTER or resident_bytes(process.pid) - self._kept > most:
            self._drop()

    def _drop(self) -> None:
        with self._lock:
            process, self._process = self._process, None
        self._tasks = 0
        if process is not None:
            process.end()

    def _warm(self) -> WorkerProcess:
        """The process, ready for a task: the one that there is, or a new one."""
        if self._process is not None and self._process.alive:
            return self._process
        self._drop()
        for attempt in range(STARTS):
            try:
                return self._start()
            except _NotStartedError:
                if attempt == STARTS - 1:
                    raise
                time.sleep(0.2 * 4**attempt)
        raise AssertionError("the loop returns or raises")

    def _start(self) -> WorkerProcess:
        with self._lock:
            if self._ended:
                raise Stopped
            try:
                process = self._process = WorkerProcess()
            except EngineError as error:
                raise _NotStartedError(str(error)) from error
        process.send({"function": self._function})
        message = process.hear(self._start_within)
        if isinstance(message, dict) and message.get("ready"):
            return process
        said = process.stderr() if message is None else ""
        self._drop()
        if self._ended:
            raise Stopped
        if isinstance(message, dict):
            raise EngineError(str(message["reason"]))
        if message is None:
            raise _NotStartedError(
                f"a worker process ended while it started: {last_line(said) or crash_reason(process.code(), said)}"
            )
        raise _NotStartedError(f"a worker process was not ready within {self._start_within:g} s")
