"""The engine that all others must equal: one task after the other in this process."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Generator, Iterable

from parsers.errors import EngineError
from pipelines.engines.base import Done, Limits, Task
from pipelines.engines.call import called, function_at
from pipelines.engines.one_core import one_core


class SerialEngine:
    """Runs tasks in this process, on one core, in their order.

    It keeps no limits: a process cannot end a part of itself, so that a task that hangs hangs the batch, and one that
    crashes ends it. What a task prints goes to stderr, because stdout belongs to the command.
    """

    name = "serial"
    title = "one drive after the other in this process; no limits"

    def __init__(self, workers: int | None = None, scheduler: str | None = None) -> None:
        """Raises EngineError for more than one worker, or a scheduler."""
        if workers is not None and workers != 1:
            raise EngineError(
                f"the engine serial is one worker, and {workers} were asked for",
                hint="--engine local has more",
                wrong_usage=True,
            )
        if scheduler is not None:
            raise EngineError(
                "the engine serial has no scheduler", hint="--engine dask uses one", wrong_usage=True
            )

    def map(self, function: str, tasks: Iterable[Task], limits: Limits) -> Generator[Done, None, None]:
        """Run them all. Raises EngineError where the function cannot be imported."""
        with one_core():
            call = function_at(function)
        for task in tasks:
            began = time.perf_counter()
            # around each task, not all: between them this process is the caller's
            with one_core(), contextlib.redirect_stdout(sys.stderr):
                outcome = called(call, task.payload)
            seconds = time.perf_counter() - began
            yield Done(task.key, outcome.status, outcome.answer, outcome.reason, seconds, "this process")
