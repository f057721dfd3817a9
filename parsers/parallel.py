"""Work on the pieces of a log on all cores: results in order, and only a few pieces in memory at a time.

Threads, not processes: decompression and compiled kernels release the interpreter's lock, and columns need no copying.
"""

from __future__ import annotations

import os
import sys
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable
from queue import Empty, SimpleQueue
from typing import Generic, TypeVar, cast

T = TypeVar("T")
R = TypeVar("R")

CORES_VARIABLE = "COGEST_CORES"
"""Environment variable: use at most so many cores. Workers that stand beside others are given one each."""


_TURN_S = 0.0005
"""How long a thread that has the interpreter's lock may let another wait for it.

By default it is 5 ms, in which a core unpacks some fifty pieces: with one thread that works in Python and others that come
back from compiled code for a moment only, both cores then stand still in turns.
"""


def cores() -> int:
    """How many cores this process may use (a container, `taskset` or COGEST_CORES may give fewer than there are)."""
    try:
        allowed = len(os.sched_getaffinity(0))
    except AttributeError:  # not on macOS and Windows
        allowed = os.cpu_count() or 1
    told = os.environ.get(CORES_VARIABLE, "")
    return min(allowed, int(told)) if told.isdecimal() and int(told) > 0 else allowed


class _Task(Generic[T, R]):
    """One item's work: whoever takes it first does it."""

    __slots__ = ("_done", "_error", "_function", "_item", "_result")

    def __init__(self, function: Callable[[T], R], item: T) -> None:
        self._function, self._item = function, item
        self._done = threading.Lock()
        self._done.acquire()
        self._result: R | None = None
        self._error: BaseException | None = None

    def run(self) -> None:
        """Do it, on any thread."""
        try:
            self._result = self._function(self._item)
        except BaseException as error:  # raised where the result is asked for
            self._error = error
        self._done.release()

    def is_done(self) -> bool:
        return not self._done.locked()

    def result(self) -> R:
        """Wait for it; what the function gave or raised."""
        self._done.acquire()
        if self._error is not None:
            raise self._error
        # the thread that did it holds on to the task until it gets another: not to what came of it
        found, self._result = self._result, None
        return cast("R", found)


def _help(tasks: SimpleQueue[_Task[T, R] | None]) -> None:
    """What a thread beside the caller's does, until it is told that nothing comes any more."""
    while (task := tasks.get()) is not None:
        task.run()


def in_order(
    function: Callable[[T], R], items: Iterable[T], *, workers: int | None = None, ahead: int = 2
) -> Generator[R, None, None]:
    """`map` with threads: yields function(item) in the order of the items.

    At most workers + `ahead` items are taken from `items` before the first of their results is yielded, so that memory
    stays bounded however many there are. `items` is only ever advanced by the caller's thread. An exception of `function`
    is raised where its result would have come. With one worker (the default where there is one core) it is a plain map.

    The caller's thread is one of the workers: it does what nobody has begun before it waits for what somebody has. So there
    are as many threads as cores, and they seldom stop and wake each other, which can take as long as the work itself.
    """
    workers = workers or cores()
    if workers < 2:
        for item in items:
            yield function(item)
        return
    tasks: SimpleQueue[_Task[T, R] | None] = SimpleQueue()
    helpers = [threading.Thread(target=_help, args=(tasks,), daemon=True) for _ in range(workers - 1)]
    waiting: deque[_Task[T, R]] = deque()
    usual = sys.getswitchinterval()
    sys.setswitchinterval(min(usual, _TURN_S))
    try:
        for helper in helpers:
            helper.start()
        for item in items:
            task = _Task(function, item)
            waiting.append(task)
            tasks.put(task)
            if len(waiting) >= workers + ahead:
                yield _first(waiting, tasks)
        while waiting:
            yield _first(waiting, tasks)
    finally:
        # of several that run at once each puts back what it found, or less
        sys.setswitchinterval(usual)
        # a caller that stops early, or an error, must not wait for what nobody will read
        while _taken(tasks) is not None:
            pass
        for _ in helpers:
            tasks.put(None)
        for helper in helpers:
            helper.join()


def _taken(tasks: SimpleQueue[_Task[T, R] | None]) -> _Task[T, R] | None:
    """A task that nobody has begun, if there is one."""
    try:
        return tasks.get_nowait()
    except Empty:
        return None


def _first(waiting: deque[_Task[T, R]], tasks: SimpleQueue[_Task[T, R] | None]) -> R:
    """The first task's result; until it is there, do others."""
    first = waiting.popleft()
    while not first.is_done() and (task := _taken(tasks)) is not None:
        task.run()
    return first.result()
