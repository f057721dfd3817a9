"""Work on the pieces of a log on all cores: results in order, and only a few pieces in memory at a time.

Threads, not processes: decompression and compiled kernels release the interpreter's lock, and columns need no copying.
"""

from __future__ import annotations

import os
import sys
from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

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


def in_order(
    function: Callable[[T], R], items: Iterable[T], *, workers: int | None = None, ahead: int = 1
) -> Generator[R, None, None]:
    """`map` with threads: yields function(item) in the order of the items.

    At most workers + `ahead` items are taken from `items` before the first of their results is yielded, so that memory
    stays bounded however many there are. `items` is only ever advanced by the caller's thread. An exception of `function`
    is raised where its result would have come. With one worker (the default where there is one core) it is a plain map.
    """
    workers = workers or cores()
    if workers < 2:
        for item in items:
            yield function(item)
        return
    pool = ThreadPoolExecutor(workers)
    waiting: deque[Future[R]] = deque()
    usual = sys.getswitchinterval()
    sys.setswitchinterval(min(usual, _TURN_S))
    try:
        for item in items:
            waiting.append(pool.submit(function, item))
            if len(waiting) >= workers + ahead:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        # of several that run at once each puts back what it found, or less
        sys.setswitchinterval(usual)
        # a caller that stops early, or an error, must not wait for what nobody will read
        pool.shutdown(wait=True, cancel_futures=True)
