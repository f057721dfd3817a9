"""What runs on a Dask worker: supervised processes, as on one's own machine, so that a drive cannot cost the Dask worker."""

from __future__ import annotations

import signal
import threading
from typing import Any

from dask.typing import Key
from distributed import Worker, get_worker
from distributed.diagnostics.plugin import WorkerPlugin

from parsers.errors import EngineError
from pipelines.engines.base import Done, Limits, Task
from pipelines.engines.supervised import STOPPED, Stopped, Supervised
from pipelines.engines.version import VERSION

IDLE_S = 300.0
"""Processes that nobody used for so long are ended: the batch that wanted them may have been killed."""

Answer = tuple[str, str, str, str, float, str]
"""A `Done` as it travels: key, status, answer, reason, seconds, worker."""


class WarmWorkers(WorkerPlugin):
    """Lives in each Dask worker, also in those that join later, and holds one process a thread of it, warm."""

    def __init__(self, name: str, function: str, version: str, ours: bool = False) -> None:
        """name: under which `run_task` finds it. function: "module:name". version: of the cogest that asks.

        ours: the Dask worker belongs to this batch, which ends it; Ctrl-C, which goes to all, is not for it.
        """
        self.name = name
        self._ours = ours
        self._function = function
        self._version = version

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Arrive on a machine. Raises EngineError for another cogest: a worker that joins later with it is turned away."""
        self.__dict__.update(state)
        if self._version != VERSION:
            raise EngineError(
                f"this machine has cogest {VERSION}, the batch {self._version}",
                hint="install the same version on every machine",
            )

    def setup(self, worker: Worker) -> None:
        """Called by Dask in the worker. What cannot travel is made here."""
        if self._ours and threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        self._label = f"Dask worker {worker.name} at {worker.address}"
        self._lock = threading.Lock()
        self._all: list[Supervised] = []
        self._free: list[Supervised] = []
        self._busy: dict[str, Supervised] = {}
        self._timer: threading.Timer | None = None
        self._over = False

    def transition(self, key: Key, start: str, finish: str, **_: Any) -> None:
        """Called by Dask when a task changes its state. One that nobody wants any more ends, with its process.

        So a batch that was killed leaves no machine at work; Dask itself lets such tasks run to their end.
        """
        unwanted = start == "executing" and finish == "released"
        if unwanted and (one := self._busy.get(str(key))) is not None:
            # the wait for its end is not for the thread that speaks with the scheduler
            threading.Thread(target=one.end, daemon=True).start()

    def teardown(self, worker: Worker) -> None:
        """Called by Dask when the batch or the worker ends: all processes end at once."""
        with self._lock:
            self._over = True
            if self._timer is not None:
                self._timer.cancel()
            ending, self._all, self._free = self._all, [], []
        for one in ending:
            one.end()

    def run(self, dask_key: str, task: Task, limits: Limits) -> Done:
        """Run it in a process that is free, or in a new one. dask_key: the task's name in the cluster."""
        one = self._busy[dask_key] = self._take()
        try:
            return one.run(task, limits)
        except Stopped:
            return Done(task.key, "crashed", "", STOPPED, 0.0, self._label)
        finally:
            del self._busy[dask_key]
            self._put_back(one)

    def _take(self) -> Supervised:
        with self._lock:
            if self._over:
                raise EngineError(STOPPED)
            if self._timer is not None:
                self._timer.cancel()
            if self._free:
                return self._free.pop()
            one = Supervised(self._function, self._label)
            self._all.append(one)
            return one

    def _put_back(self, one: Supervised) -> None:
        with self._lock:
            if self._over:
                return
            if one.ended:
                self._all.remove(one)
                return
            self._free.append(one)
            if self._timer is not None:
                self._timer.cancel()
            self._timer = threading.Timer(IDLE_S, self._end_idle)
            self._timer.daemon = True
            self._timer.start()

    def _end_idle(self) -> None:
        with self._lock:
            ending, self._free = self._free, []
            self._all = [one for one in self._all if one not in ending]
        for one in ending:
            one.end()


def run_task(name: str, key: str, payload: str, seconds: float | None, memory_bytes: int | None) -> Answer:
    """Called by Dask in the worker: hand the task to the plugin of that name."""
    worker = get_worker()
    warm = worker.plugins.get(name)
    if not isinstance(warm, WarmWorkers):
        raise EngineError(f"a Dask worker ({worker.address}) was not prepared for this batch")
    done = warm.run(str(worker.get_current_task()), Task(key, payload), Limits(seconds, memory_bytes))
    return (done.key, done.status, done.answer, done.reason, done.seconds, done.worker)
