"""Workers of a Dask cluster: one that runs already, on any number of machines, or one that is started here."""

from __future__ import annotations

import contextlib
import importlib
import logging
import pkgutil
import sys
import time
from collections.abc import Generator, Iterable, Iterator
from queue import Empty, SimpleQueue
from typing import Any

from parsers.errors import EngineError
from pipelines.engines.base import Done, Limits, Task
from pipelines.engines.machine import default_workers
from pipelines.engines.version import VERSION
from pipelines.engines.window import keep_full

REACH_WITHIN_S = 10.0
"""How long a scheduler, and then its first worker, is waited for."""

_LOOK_EVERY_S = 1.0
"""How often the number of workers is asked for: they may join and leave."""

_TOLD_WITHIN_S = 5.0
"""How long a cluster may take to hear that the batch is over."""

_VERSION_PLACE = "pipelines.engines.version:VERSION"

_SAME_EVERYWHERE = "install the same version of cogest[dask] on every machine, the scheduler's too"


def _library() -> Any:
    """distributed, half of whose functions say nothing of their types. Loaded when it is needed: it takes a second."""
    return importlib.import_module("distributed")


@contextlib.contextmanager
def _kept_open(*opened: Any) -> Iterator[None]:
    """Close them in turn at the end, unless the interpreter ends: their threads do not run then, and they would wait."""
    try:
        yield
    finally:
        if not sys.is_finalizing():
            for one in opened:
                one.close()


@contextlib.contextmanager
def _connected(scheduler: str) -> Iterator[Any]:
    """A client of a running cluster. Raises EngineError where there is none."""
    distributed = _library()
    try:
        client = distributed.Client(scheduler, timeout=REACH_WITHIN_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise EngineError(
            f"no Dask scheduler answers at {scheduler} ({type(error).__name__})",
            hint="start one with: dask scheduler",
        ) from error
    with _kept_open(client):
        yield client


def _check(client: Any, scheduler: str) -> None:
    """Whether there is a worker, and the scheduler and all workers have this cogest. Raises EngineError."""
    try:
        client.wait_for_workers(1, timeout=REACH_WITHIN_S)
    except (TimeoutError, OSError) as error:
        raise EngineError(
            f"the Dask scheduler at {scheduler} has no workers",
            hint=f"start some with: dask worker {scheduler}",
        ) from error
    # a function of the standard library, by name: it reaches machines without cogest too, and they answer with an error
    ask: Any = pkgutil.resolve_name
    answers: dict[str, Any] = dict(client.run(ask, _VERSION_PLACE, on_error="return"))
    try:
        answers[f"the scheduler, {scheduler}"] = client.run_on_scheduler(ask, _VERSION_PLACE)
    except (ImportError, AttributeError) as error:
        answers[f"the scheduler, {scheduler}"] = error
    for place, found in sorted(answers.items(), key=lambda item: str(item[0])):
        if isinstance(found, BaseException):
            raise EngineError(f"no cogest of this kind at {place}: {found}", hint=_SAME_EVERYWHERE)
        if found != VERSION:
            raise EngineError(f"cogest {found} at {place}, {VERSION} here", hint=_SAME_EVERYWHERE)


@contextlib.contextmanager
def _own_cluster(workers: int) -> Iterator[Any]:
    """A cluster on this machine that nobody else can reach."""
    distributed = _library()
    try:
        cluster = distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            # tasks run in processes of ours with limits of their own; a Dask worker itself needs next to nothing
            memory_limit=None,
            silence_logs=logging.CRITICAL,
        )
    except (OSError, RuntimeError, TimeoutError) as error:
        raise EngineError(f"a Dask cluster cannot be started here: {error}") from error
    client = distributed.Client(cluster, set_as_default=False)
    with _kept_open(client, cluster):
        yield client


class _Submitted:
    """Tasks of one batch on a cluster."""

    def __init__(
        self, client: Any, where: str, function: str, limits: Limits, workers: int | None, ours: bool
    ) -> None:
        from pipelines.engines.dask_side import WarmWorkers

        self._client = client
        self._where = where
        self._limits = limits
        self._most = workers
        self._name = f"cogest-{client.id}"
        self._ended: SimpleQueue[Any] = SimpleQueue()
        self._running: dict[str, tuple[Task, Any]] = {}
        self._count = 0
        self._threads = 1
        self._looked = -_LOOK_EVERY_S
        client.register_plugin(WarmWorkers(self._name, function, VERSION, ours), name=self._name)

    def window(self) -> int:
        """How many tasks may be with the cluster: two a worker, or the number that the user allows at once."""
        if self._most is not None:
            return self._most
        if time.monotonic() - self._looked >= _LOOK_EVERY_S:
            with self._reaching():
                self._threads = sum(self._client.nthreads().values())
            self._looked = time.monotonic()
        return max(1, 2 * self._threads)

    def give(self, task: Task) -> None:
        """Send it to the cluster."""
        from pipelines.engines.dask_side import run_task

        self._count += 1
        key = f"{self._name}-{self._count}"
        limits = (self._limits.seconds, self._limits.memory_bytes)
        with self._reaching():
            future = self._client.submit(
                run_task, self._name, task.key, task.payload, *limits, key=key, pure=False
            )
        self._running[key] = task, future
        future.add_done_callback(self._ended.put)

    def take(self, wait: bool) -> Done | None:
        """The next result; None where there is none yet. Raises EngineError where the cluster is lost."""
        while True:
            try:
                future = self._ended.get(timeout=_LOOK_EVERY_S) if wait else self._ended.get_nowait()
            except Empty:
                if not wait:
                    return None
                if self._client.status not in ("running", "connecting"):
                    raise self._lost() from None
                continue
            task, _ = self._running.pop(future.key)
            return self._result(task, future)

    def _result(self, task: Task, future: Any) -> Done:
        from concurrent.futures import CancelledError

        try:
            key, status, answer, reason, seconds, worker = future.result(timeout=REACH_WITHIN_S)
        except _library().KilledWorker as error:
            # Dask has tried it elsewhere, as often as the cluster allows
            tries = int(error.allowed_failures) + 1
            who = f"all {tries} Dask workers that ran it" if tries > 1 else "the Dask worker that ran it"
            return Done(task.key, "crashed", "", f"{who} went away")
        except (CancelledError, TimeoutError, OSError) as error:
            raise self._lost() from error
        except EngineError:
            raise
        except Exception as error:
            raise EngineError(
                f"a Dask worker cannot run tasks of cogest: {type(error).__name__}: {error}",
                hint=_SAME_EVERYWHERE,
            ) from error
        return Done(key, status, answer, reason, seconds, worker)

    def end(self) -> None:
        """Drop what has not begun, and end what has."""
        futures = [future for _, future in self._running.values()]
        client = self._client
        # a cluster that is gone cannot be told, and the reason why we end matters more; it must not hold us up either
        with contextlib.suppress(Exception):
            client.sync(client._cancel, futures, force=True, callback_timeout=_TOLD_WITHIN_S)
        with contextlib.suppress(Exception):
            client.sync(client._unregister_worker_plugin, self._name, callback_timeout=_TOLD_WITHIN_S)
        self._running.clear()

    def _lost(self) -> EngineError:
        return EngineError(
            f"the connection to the Dask scheduler at {self._where} was lost",
            hint="run the same command to go on",
        )

    @contextlib.contextmanager
    def _reaching(self) -> Iterator[None]:
        try:
            yield
        except (OSError, TimeoutError, RuntimeError) as error:
            raise self._lost() from error


class DaskEngine:
    """Runs tasks on a Dask cluster: each Dask worker has supervised processes, as the engine local has."""

    name = "dask"
    title = "workers of a Dask cluster, on many machines or started here"

    def __init__(self, workers: int | None = None, scheduler: str | None = None) -> None:
        """scheduler: its address; None starts a cluster here. workers: to start, or tasks at once on a running cluster.

        Raises EngineError for less than one worker, and where Dask is not installed.
        """
        if workers is not None and workers < 1:
            raise EngineError(f"at least one worker is needed, not {workers}", wrong_usage=True)
        self._workers = workers
        self._scheduler = scheduler
        try:
            _library()
        except ImportError as error:
            raise EngineError(
                f"the engine dask needs a package that is not installed ({error.name})",
                hint="pip install 'cogest[dask]'",
            ) from error

    def map(self, function: str, tasks: Iterable[Task], limits: Limits) -> Generator[Done, None, None]:
        """Run them all. Raises EngineError where no scheduler or worker is reached, or where one has another cogest."""
        ours = self._scheduler is None
        if self._scheduler is None:
            opened: Any = _own_cluster(self._workers or default_workers(limits.memory_bytes))
            where, most = "this machine", None
        else:
            opened = _connected(self._scheduler)
            where, most = self._scheduler, self._workers
        with opened as client:
            if not ours:
                _check(client, where)
            submitted = _Submitted(client, where, function, limits, most, ours)
            try:
                yield from keep_full(tasks, submitted.window, submitted.give, submitted.take)
            finally:
                if not sys.is_finalizing():
                    submitted.end()
