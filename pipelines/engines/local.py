"""Workers on this machine: processes of cogest's own, each with a core, looked after by a thread each."""

from __future__ import annotations

import sys
import threading
from collections.abc import Generator, Iterable
from queue import Empty, SimpleQueue

from parsers.errors import EngineError
from pipelines.engines.base import Done, Limits, Task
from pipelines.engines.machine import default_workers
from pipelines.engines.supervised import Stopped, Supervised
from pipelines.engines.window import keep_full

_WAKE_S = 1.0
"""A wait without an end cannot be interrupted on some systems, so it begins anew so often."""

_GONE_WITHIN_S = 30.0
"""How long the threads of ended workers are waited for; they have nothing left to do."""


class _Pool:
    """Threads that take tasks from one queue, each with a process of its own, started when there is work for it."""

    def __init__(self, function: str, limits: Limits, workers: int) -> None:
        self._function = function
        self._limits = limits
        self._most = workers
        self._tasks: SimpleQueue[Task | None] = SimpleQueue()
        self._results: SimpleQueue[Done | BaseException] = SimpleQueue()
        self._workers: list[Supervised] = []
        self._threads: list[threading.Thread] = []

    def give(self, task: Task) -> None:
        """Have a worker do it; a new one while there are fewer than there may be."""
        self._tasks.put(task)
        if len(self._threads) < self._most:
            worker = Supervised(self._function, f"worker {len(self._workers) + 1}")
            thread = threading.Thread(target=self._work, args=(worker,), daemon=True)
            self._workers.append(worker)
            self._threads.append(thread)
            thread.start()

    def take(self, wait: bool) -> Done | None:
        """The next result; None where there is none yet. Raises what kept a worker from starting."""
        while True:
            try:
                result = self._results.get(timeout=_WAKE_S) if wait else self._results.get_nowait()
            except Empty:
                if wait:
                    continue
                return None
            if isinstance(result, BaseException):
                raise result
            return result

    def end(self) -> None:
        """End all processes at once, and the threads with them."""
        for _ in self._threads:
            self._tasks.put(None)
        for worker in self._workers:
            worker.end()
        for thread in self._threads:
            if not sys.is_finalizing():
                thread.join(_GONE_WITHIN_S)

    def _work(self, worker: Supervised) -> None:
        try:
            while (task := self._tasks.get()) is not None:
                self._results.put(worker.run(task, self._limits))
        except Stopped:
            pass
        except BaseException as error:
            # the batch must hear of it: without this worker a result would be waited for in vain
            self._results.put(error)


class LocalEngine:
    """Runs tasks in worker processes on this machine. A limit or a crash costs a process, not the batch."""

    name = "local"
    title = "worker processes on this machine, one a core"

    def __init__(self, workers: int | None = None, scheduler: str | None = None) -> None:
        """workers: None = one a core, as far as memory allows. Raises EngineError for less than one, or a scheduler."""
        if workers is not None and workers < 1:
            raise EngineError(f"at least one worker is needed, not {workers}", wrong_usage=True)
        if scheduler is not None:
            raise EngineError(
                "the engine local has no scheduler", hint="--engine dask uses one", wrong_usage=True
            )
        self._workers = workers

    def map(self, function: str, tasks: Iterable[Task], limits: Limits) -> Generator[Done, None, None]:
        """Run them all. Raises EngineError where a worker cannot be started or cannot import the function."""
        workers = self._workers or default_workers(limits.memory_bytes)
        pool = _Pool(function, limits, workers)
        # one waits for each that works, so that no worker stands idle while the caller deals with a result
        try:
            yield from keep_full(tasks, lambda: 2 * workers, pool.give, pool.take)
        finally:
            pool.end()
