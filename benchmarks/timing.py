"""The time of a piece of work in this process."""

from __future__ import annotations

import time
from collections.abc import Callable

ROUNDS = 5


def best(run: Callable[[], object]) -> float:
    """The shortest of ROUNDS runs in s, after one that compiles."""
    run()
    times = []
    for _ in range(ROUNDS):
        began = time.perf_counter()
        run()
        times.append(time.perf_counter() - began)
    return min(times)
