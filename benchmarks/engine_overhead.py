"""What an engine costs beside the work: start-up, and a task that does nothing.

python benchmarks/engine_overhead.py [tasks] [workers]

The last column holds it against a one-minute drive, taken as 3 s of work; the aim is at most 5 %.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Iterator

from parsers.errors import EngineError
from pipelines.engines.base import Limits, Task
from pipelines.engines.registry import ENGINES, engine_named

DRIVE_S = 3.0
"""Work of a one-minute drive on one core, seconds."""

LIMITS = Limits(seconds=300.0, memory_bytes=2 << 30)


def empty(payload: str) -> str:
    """A task that does nothing."""
    return ""


def started(name: str, workers: int) -> float:
    """Seconds until the first result is there."""
    began = time.perf_counter()
    ended = engine_named(name, workers).map("engine_overhead:empty", [Task("first", "")], LIMITS)
    next(ended)
    seconds = time.perf_counter() - began
    assert next(ended, None) is None
    return seconds


def a_task(name: str, workers: int, count: int) -> float:
    """Seconds a task, after the first of each worker."""

    def tasks() -> Iterator[Task]:
        for k in range(count + 2 * workers):
            yield Task(str(k), "{}")

    ended = engine_named(name, workers).map("engine_overhead:empty", tasks(), LIMITS)
    for _ in range(2 * workers):
        next(ended)
    began = time.perf_counter()
    done = sum(1 for _ in ended)
    assert done == count
    return (time.perf_counter() - began) / count


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("tasks", nargs="?", type=int, default=500, help="a round (default 500)")
    parser.add_argument("workers", nargs="?", type=int, default=1, help="but for serial (default 1)")
    chosen = parser.parse_args()
    count, most = chosen.tasks, chosen.workers
    print(f"{'engine':<8} {'workers':>7} {'start-up s':>11} {'a task ms':>10} {'of a drive %':>13}")
    for name in ENGINES:
        workers = 1 if name == "serial" else most
        try:
            start = statistics.median(started(name, workers) for _ in range(3))
            each = statistics.median(a_task(name, workers, count) for _ in range(3))
        except EngineError as error:
            print(f"{name:<8} {error}")
            continue
        # one worker does a task at a time: what it costs the worker is workers x the time between results
        print(
            f"{name:<8} {workers:>7} {start:>11.2f} {1e3 * each:>10.2f} {100 * each * workers / DRIVE_S:>13.3f}"
        )


if __name__ == "__main__":
    main()
