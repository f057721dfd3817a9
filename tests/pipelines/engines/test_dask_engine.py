"""What only a cluster can do: be absent, be of another version, gain and lose machines."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from engine_help import FUNCTION, NO_LIMITS, environment, task, wait_until, workers_of

from parsers.errors import EngineError
from pipelines.engines.base import Task
from pipelines.engines.registry import engine_named

pytest.importorskip("distributed")

from distributed import Client

import pipelines.engines.dask_cluster

WITHOUT_COGEST = "import sys; sys.modules['pipelines'] = None; "
WITH_ANOTHER = "import pipelines.engines.version as it; it.VERSION = '99.1'; "


def started(
    stack: ExitStack, part: str, *arguments: str, before: str = "", **more: str
) -> subprocess.Popen[bytes]:
    """A scheduler or a worker, as its command starts it; ended with the stack."""
    code = f"{before}from distributed.cli.dask_{part} import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", code, *arguments],
        env={**environment(), **more},
        cwd=Path(__file__).parent,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )

    def end() -> None:
        process.send_signal(signal.SIGCONT)
        process.kill()
        process.wait()

    stack.callback(end)
    return process


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def answers(port: int) -> bool:
    """Whether somebody listens there."""
    with socket.socket() as one:
        return one.connect_ex(("127.0.0.1", port)) == 0


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as one:
        yield one


def scheduler(stack: ExitStack, **more: str) -> tuple[str, subprocess.Popen[bytes]]:
    port = free_port()
    arguments = ("--host", "127.0.0.1", "--port", str(port), "--no-dashboard")
    process = started(stack, "scheduler", *arguments, **more)
    assert wait_until(lambda: answers(port))
    return f"tcp://127.0.0.1:{port}", process


def a_worker(stack: ExitStack, address: str, name: str, before: str = "") -> subprocess.Popen[bytes]:
    arguments = (
        address,
        "--no-nanny",
        "--nthreads",
        "1",
        "--no-dashboard",
        "--name",
        name,
        "--host",
        "127.0.0.1",
    )
    return started(stack, "worker", *arguments, before=before)


def test_no_scheduler_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipelines.engines.dask_cluster, "REACH_WITHIN_S", 0.5)
    address = f"tcp://127.0.0.1:{free_port()}"
    began = time.monotonic()
    with pytest.raises(EngineError, match=f"no Dask scheduler answers at {address} .*dask scheduler"):
        list(engine_named("dask", None, address).map(FUNCTION, [task("echo")], NO_LIMITS))
    assert time.monotonic() - began < 30


def test_an_address_that_is_none() -> None:
    with pytest.raises(EngineError, match="no Dask scheduler answers at carrier-pigeon://loft"):
        list(engine_named("dask", None, "carrier-pigeon://loft").map(FUNCTION, [task("echo")], NO_LIMITS))


def test_another_version_on_the_machines(cluster: tuple[str, int], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipelines.engines.dask_cluster, "VERSION", "99.1")
    with pytest.raises(EngineError, match=r"cogest \S+ at \S+, 99\.1 here; install the same version"):
        list(engine_named("dask", None, cluster[0]).map(FUNCTION, [task("echo")], NO_LIMITS))


def test_dask_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(EngineError, match=r"\(distributed\); pip install 'cogest\[dask\]'"):
        engine_named("dask")


def test_workers_none_then_one_without_cogest(stack: ExitStack, monkeypatch: pytest.MonkeyPatch) -> None:
    address, _ = scheduler(stack)
    engine = engine_named("dask", None, address)
    with monkeypatch.context() as patch:
        patch.setattr(pipelines.engines.dask_cluster, "REACH_WITHIN_S", 3.0)
        with pytest.raises(
            EngineError, match=f"{address} has no workers; start some with: dask worker {address}"
        ):
            list(engine.map(FUNCTION, [task("echo")], NO_LIMITS))
    a_worker(stack, address, "bare", WITHOUT_COGEST)
    with pytest.raises(EngineError, match=r"no cogest of this kind at tcp://\S+: .*pipelines"):
        list(engine.map(FUNCTION, [task("echo")], NO_LIMITS))


def test_machines_join_and_go_away(stack: ExitStack) -> None:
    address, _ = scheduler(stack)
    first = a_worker(stack, address, "first")
    engine = engine_named("dask", None, address)
    ended = engine.map(FUNCTION, (Task(str(k), '["sleep", 0.1]') for k in range(60)), NO_LIMITS)
    done = [next(ended)]
    assert "first" in done[0].worker
    a_worker(stack, address, "second")
    while "second" not in done[-1].worker:
        done.append(next(ended))
    # the machine is gone in the middle of its task: that drive is done elsewhere
    first.kill()
    done += ended
    assert sorted(int(one.key) for one in done) == list(range(60))
    assert {one.status for one in done} == {"done"}
    assert "second" in done[-1].worker


@pytest.mark.parametrize("before", [WITHOUT_COGEST, WITH_ANOTHER], ids=["none", "another"])
def test_who_joins_without_this_cogest_is_turned_away(stack: ExitStack, before: str) -> None:
    address, _ = scheduler(stack)
    a_worker(stack, address, "good")
    tasks = (Task(str(k), '["sleep", 0.05]') for k in range(1000))
    ended = engine_named("dask", None, address).map(FUNCTION, tasks, NO_LIMITS)
    done = [next(ended)]
    odd = a_worker(stack, address, "odd", before)
    while odd.poll() is None:
        done.append(next(ended))
    done += [next(ended) for _ in range(5)]
    ended.close()  # type: ignore[attr-defined]
    assert {one.status for one in done} == {"done"}
    assert not [one for one in done if "odd" in one.worker]


def test_a_machine_that_goes_away_each_time_is_reported(stack: ExitStack, tmp_path: Path) -> None:
    address, _ = scheduler(stack, DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES="0")
    first = a_worker(stack, address, "first")
    at_work = tmp_path / "at work"

    def tasks() -> Iterator[Task]:
        yield task("touch_and_sleep", [str(at_work), 20])
        assert wait_until(at_work.exists)
        a_worker(stack, address, "second")
        assert wait_until(lambda: len(client.nthreads()) == 2)
        first.kill()
        # a task that is given to a worker counts as killed with it, even if it has not begun
        assert wait_until(lambda: len(client.nthreads()) == 1)
        yield task("echo", 2)

    with Client(address, set_as_default=False) as client:
        ended = engine_named("dask", None, address).map(FUNCTION, tasks(), NO_LIMITS)
        good, bad = sorted(ended, key=lambda one: one.key)
    assert (bad.key, bad.status) == ("touch_and_sleep", "crashed")
    assert bad.reason == "the Dask worker that ran it went away"
    assert (good.key, good.status) == ("echo", "done")


def test_a_scheduler_that_dies_ends_the_batch_in_words(stack: ExitStack) -> None:
    address, process = scheduler(stack)
    a_worker(stack, address, "only")
    ended = engine_named("dask", None, address).map(FUNCTION, [task("echo"), task("deaf", 60)], NO_LIMITS)
    next(ended)
    process.kill()
    began = time.monotonic()
    with pytest.raises(EngineError, match=f"the connection to the Dask scheduler at {address} was lost"):
        next(ended)
    assert time.monotonic() - began < 50


def test_a_cluster_of_its_own(stack: ExitStack) -> None:
    ended = engine_named("dask", 2, None).map(
        "engine_tasks:heavy_sum", (Task(str(k), str(k)) for k in range(4)), NO_LIMITS
    )
    answers = {one.key: one.answer for one in ended}
    serial = engine_named("serial").map(
        "engine_tasks:heavy_sum", (Task(str(k), str(k)) for k in range(4)), NO_LIMITS
    )
    assert answers == {one.key: one.answer for one in serial}
    assert not workers_of(os.getpid())
