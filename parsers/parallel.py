"""Work on the pieces of a log on all cores: results in order, and only a few pieces in memory at a time.

Threads, not processes: decompression and compiled kernels release the interpreter's lock, and columns need no copying.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")

CORES_VARIABLE = "COGEST_CORES"
"""Environment variable: use at most so many cores. Workers that stand beside others are given one each."""


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
) -> Iterator[R]:
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
    try:
        for item in items:
            waiting.append(pool.submit(function, item))
            if len(waiting) >= workers + ahead:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        # a caller that stops early, or an error, must not wait for what nobody will read
        pool.shutdown(wait=True, cancel_futures=True)
