"""One worker and its supervisor: warm from task to task, replaced when spent, ended from outside."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from engine_help import FUNCTION, NO_LIMITS, task, wait_until

import pipelines.engines.process
import pipelines.engines.supervised
from parsers.errors import EngineError
from pipelines.engines.base import Limits
from pipelines.engines.supervised import Stopped, Supervised, memory_reason, seconds_reason


@pytest.fixture
def worker() -> Iterator[Supervised]:
    one = Supervised(FUNCTION, "the worker", 20.0)
    yield one
    one.end()


def pid_of(worker: Supervised) -> int:
    return int(worker.run(task("pid"), NO_LIMITS).answer)


def test_the_process_stays_warm(worker: Supervised) -> None:
    assert pid_of(worker) == pid_of(worker) != os.getpid()


def test_it_is_replaced_after_many_tasks(worker: Supervised, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipelines.engines.supervised, "RECYCLE_AFTER", 3)
    pids = [pid_of(worker) for _ in range(6)]
    assert pids[0] == pids[2] != pids[3] == pids[5]


def test_it_is_replaced_when_it_keeps_memory(worker: Supervised) -> None:
    first = pid_of(worker)
    limits = Limits(memory_bytes=800 << 20)
    assert worker.run(task("keep", 100), limits).answer == str(first)
    assert worker.run(task("pid"), limits).answer == str(first)
    assert worker.run(task("keep", 150), limits).answer == str(first)
    assert worker.run(task("pid"), limits).answer != str(first)


def test_dying_between_tasks_is_no_fault_of_the_next(worker: Supervised) -> None:
    first = pid_of(worker)
    os.kill(first, signal.SIGKILL)
    done = worker.run(task("echo", "alive"), NO_LIMITS)
    assert (done.status, done.answer) == ("done", "alive")


def test_dying_before_the_task_began_is_no_fault_of_it(worker: Supervised) -> None:
    # stopped, it is alive for all that we see, and dies with the task in its pipe
    first = pid_of(worker)
    os.kill(first, signal.SIGSTOP)
    threading.Timer(0.2, os.kill, (first, signal.SIGKILL)).start()
    done = worker.run(task("echo", "alive"), NO_LIMITS)
    assert (done.status, done.answer) == ("done", "alive")


def test_end_from_another_thread_stops_a_task(worker: Supervised) -> None:
    process = psutil.Process(pid_of(worker))
    threading.Timer(0.2, worker.end).start()
    began = time.monotonic()
    with pytest.raises(Stopped):
        worker.run(task("deaf", 60), NO_LIMITS)
    assert time.monotonic() - began < 30
    assert not process.is_running()
    with pytest.raises(Stopped):
        worker.run(task("echo", "no more"), NO_LIMITS)


def test_what_a_task_started_ends_with_it(worker: Supervised, tmp_path: Path) -> None:
    file = tmp_path / "pid"
    done = worker.run(task("leave_a_child", str(file)), Limits(seconds=1.0))
    assert done.status == "timeout"
    assert wait_until(lambda: not psutil.pid_exists(int(file.read_text())), 5.0)


def test_a_task_that_closes_all_files_has_crashed(
    worker: Supervised, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pipelines.engines.process, "_LAST_WORDS_S", 0.1)
    done = worker.run(task("close"), NO_LIMITS)
    assert (done.status, done.reason) == ("crashed", "its process closed the connection to cogest")


def test_a_flood_on_stderr_neither_blocks_nor_stays(worker: Supervised) -> None:
    assert worker.run(task("flood", 3_000_000), Limits(seconds=20)).answer == "flooded"
    process = worker._process
    assert process is not None
    assert wait_until(lambda: process.stderr_kept() > 0)
    assert process.stderr_kept() <= 16 << 10


def test_a_start_that_fails_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipelines.engines.supervised, "STARTS", 1)
    monkeypatch.setattr(pipelines.engines.process, "_START", "raise SystemExit('no licence')")
    with pytest.raises(EngineError, match="ended while it started: no licence"):
        Supervised(FUNCTION, "w").run(task("echo", 1), NO_LIMITS)


def test_a_start_without_end_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipelines.engines.supervised, "STARTS", 1)
    monkeypatch.setattr(pipelines.engines.process, "_START", "import time; time.sleep(60)")
    with pytest.raises(EngineError, match=r"not ready within 0\.3 s"):
        Supervised(FUNCTION, "w", 0.3).run(task("echo", 1), NO_LIMITS)


def test_a_start_is_tried_again(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    good = pipelines.engines.process._START
    flag = tmp_path / "tried"
    once = f"import os; p = {str(flag)!r}; os.path.exists(p) or (open(p, 'w').close(), os._exit(1)); {good}"
    monkeypatch.setattr(pipelines.engines.process, "_START", once)
    one = Supervised(FUNCTION, "w")
    try:
        assert one.run(task("echo", "up"), NO_LIMITS).answer == "up"
    finally:
        one.end()


def test_no_program_to_start(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pipelines.engines.supervised, "STARTS", 1)
    monkeypatch.setattr("sys.executable", "/nowhere/python")
    with pytest.raises(EngineError, match="a worker process cannot be started"):
        Supervised(FUNCTION, "w").run(task("echo", 1), NO_LIMITS)


def test_limits_in_words() -> None:
    assert seconds_reason(300.0) == "took longer than 300 s (limit)"
    assert memory_reason(2 << 30) == "took more than 2.0 GiB (limit)"
    assert memory_reason(200 << 20) == "took more than 200 MiB (limit)"
