"""Whatever ends the batch's process, its workers end too, in the middle of a task that takes no notice."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest
from engine_help import environment, wait_until, workers_of

BATCH = """
import json, sys
from pipelines.engines.base import Limits, Task
from pipelines.engines.registry import engine_named

def tasks():
    yield Task("first", json.dumps(["echo", "first"]))
    for k in range(2):
        yield Task(f"sleep {k}", json.dumps(["deaf", 120]))
    yield Task("hold", json.dumps(["hold", 120]))

if __name__ == "__main__":
    try:
        for done in engine_named(sys.argv[1], None if sys.argv[2:] else 2, *sys.argv[2:]).map("engine_tasks:act", tasks(), Limits()):
            print(done.key, done.status, flush=True)
    except KeyboardInterrupt:
        print("interrupted", flush=True)
        sys.exit(130)
"""


def started(tmp_path: Path, *arguments: str) -> subprocess.Popen[str]:
    """A batch at work in a process group of its own, as a shell starts it, after its first result."""
    script = tmp_path / "batch.py"
    script.write_text(BATCH, encoding="utf-8")
    process = subprocess.Popen(
        [sys.executable, str(script), *arguments],
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "first done\n"
    return process


@pytest.fixture(params=["local", "dask"])
def batch(request: pytest.FixtureRequest, tmp_path: Path) -> subprocess.Popen[str]:
    """A batch with workers of its own."""
    if request.param == "dask":
        pytest.importorskip("distributed")
    return started(tmp_path, request.param)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_nothing_lives_on(batch: subprocess.Popen[str], number: signal.Signals) -> None:
    assert wait_until(lambda: len(workers_of(batch.pid)) == 2)
    below = [psutil.Process(batch.pid), *psutil.Process(batch.pid).children(recursive=True)]
    if number == signal.SIGINT:
        # as a terminal does: to the whole group in front
        os.killpg(batch.pid, number)
    else:
        batch.send_signal(number)
    out, err = batch.communicate(timeout=20)
    if number == signal.SIGINT:
        assert (batch.returncode, out) == (130, "interrupted\n")
        assert err == ""
    else:
        assert batch.returncode == -number
    assert wait_until(lambda: not [one for one in below if one.is_running()], 10.0)


def test_a_cluster_stops_the_work_of_a_batch_that_was_killed(
    cluster: tuple[str, int], tmp_path: Path
) -> None:
    address, pid = cluster
    batch = started(tmp_path, "dask", address)
    assert wait_until(lambda: len(workers_of(pid)) == 2)
    working = [psutil.Process(one) for one in workers_of(pid)]
    batch.kill()
    batch.communicate(timeout=20)
    assert wait_until(lambda: not [one for one in working if one.is_running()], 20.0)


UNCLOSED = """
import json, sys
from pipelines.engines.base import Limits, Task
from pipelines.engines.registry import engine_named

if __name__ == "__main__":
    tasks = [Task("a", json.dumps(["echo", 1])), Task("b", json.dumps(["deaf", 120])), Task("c", json.dumps(["deaf", 120]))]
    ended = engine_named(sys.argv[1], 2, None).map("engine_tasks:act", tasks, Limits())
    print(next(ended).key)
"""


@pytest.mark.parametrize("name", ["local", "dask"])
def test_a_program_that_forgets_to_close_ends_all_the_same(name: str, tmp_path: Path) -> None:
    if name == "dask":
        pytest.importorskip("distributed")
    script = tmp_path / "unclosed.py"
    script.write_text(UNCLOSED, encoding="utf-8")
    command = [sys.executable, str(script), name]
    done = subprocess.run(command, env=environment(), capture_output=True, text=True, timeout=30, check=False)
    assert (done.returncode, done.stdout) == (0, "a\n")
    assert wait_until(
        lambda: not [one for one in psutil.process_iter() if str(tmp_path) in _words_of(one)], 10.0
    )


def _words_of(process: psutil.Process) -> str:
    """Its command: a worker's holds the search path of the program that started it."""
    try:
        return " ".join(process.cmdline())
    except psutil.Error:
        return ""
