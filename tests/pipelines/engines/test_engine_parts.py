"""The pieces under the engines: messages, the window, words for endings, what a machine allows."""

from __future__ import annotations

import io
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from parsers.parallel import CORES_VARIABLE, cores
from pipelines.engines.base import Done, Task
from pipelines.engines.call import called, one_line
from pipelines.engines.endings import crash_reason, last_line
from pipelines.engines.machine import cpu_quota, default_workers, memory_left
from pipelines.engines.messages import read_message, write_message
from pipelines.engines.one_core import one_core
from pipelines.engines.resident import _from_psutil, resident_bytes
from pipelines.engines.window import keep_full


def test_messages_come_back_whole_or_not_at_all() -> None:
    stream = io.BytesIO()
    sent = [{"a": "重 \udc80"}, {"b": 1.5, "c": None}]
    for message in sent:
        write_message(stream, message)
    whole = stream.getvalue()
    stream.seek(0)
    assert [read_message(stream), read_message(stream), read_message(stream)] == [*sent, None]
    for cut in (3, 8, 12):
        assert read_message(io.BytesIO(whole[:cut])) is None
    assert read_message(io.BytesIO(b"rubbish from a library")) is None


@pytest.mark.parametrize("size", [1, 3, 50])
def test_the_window_is_kept_full_and_never_exceeded(size: int) -> None:
    given: list[Task] = []
    most = 0

    def give(task: Task) -> None:
        nonlocal most
        given.append(task)
        most = max(most, len(given))

    def take(wait: bool) -> Done | None:
        # nothing is ever there before it is waited for
        return Done(given.pop(0).key, "done") if wait else None

    done = [one.key for one in keep_full((Task(str(k), "") for k in range(20)), lambda: size, give, take)]
    assert done == [str(k) for k in range(20)]
    assert most == min(size, 20)


def test_a_result_that_is_there_goes_out_before_the_next_task_is_made() -> None:
    order: list[str] = []

    def tasks() -> Iterator[Task]:
        for k in range(4):
            order.append(f"made {k}")
            yield Task(str(k), "")

    given: list[Task] = []
    for done in keep_full(tasks(), lambda: 10, given.append, lambda _: Done(given.pop(0).key, "done")):
        order.append(f"out {done.key}")
    assert order == [f"{what} {k}" for k in range(4) for what in ("made", "out")]


def test_a_window_that_shrinks_waits_for_results() -> None:
    sizes = iter([3, 3, 3, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1])
    given: list[Task] = []
    ended = keep_full(
        (Task(str(k), "") for k in range(5)),
        lambda: next(sizes),
        given.append,
        lambda wait: Done(given.pop(0).key, "done") if wait else None,
    )
    assert [one.key for one in ended] == ["0", "1", "2", "3", "4"]


TRACE = """
Fatal Python error: Segmentation fault

Thread 0x01 (most recent call first):
  File "/a/other.py", line 1 in other

Current thread 0x02 (most recent call first):
  File "/usr/lib/site-packages/somebody/fast.py", line 9 in fast
  File "/home/me/estimate.py", line 12 in estimate
"""


@pytest.mark.parametrize(
    ("code", "stderr", "reason"),
    [
        (3, "", "its process ended itself (exit code 3)"),
        (None, "", "its process closed the connection to cogest"),
        (-9, "", "killed by the system (signal 9), most likely out of memory"),
        (-11, "", "its process died of a segmentation fault (signal 11, SIGSEGV)"),
        (
            -11,
            TRACE,
            "its process died of a segmentation fault (signal 11, SIGSEGV) (estimate.py, line 12, in estimate)",
        ),
        (-6, "Fatal Python error: Aborted", "its process died of an abort (signal 6, SIGABRT)"),
        (-15, "", "its process was ended by signal 15 (SIGTERM)"),
        (-99, "", "its process was ended by signal 99"),
        (0xC0000005, "", "its process died of an access violation"),
    ],
)
def test_endings_in_words(code: int | None, stderr: str, reason: str) -> None:
    assert crash_reason(code, stderr) == reason


def test_short_texts() -> None:
    assert last_line("one\n\n two \n\n") == "two"
    assert last_line("") == ""
    assert one_line("a\n  b\tc") == "a b c"
    assert len(one_line("x" * 10_000)) == 600


def test_ctrl_c_in_a_call_is_the_users() -> None:
    def interrupted(_: str) -> str:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        called(interrupted, "")


def test_memory_is_counted_with_children() -> None:
    code = "x = b'x' * (64 << 20); print('held', flush=True); input()"
    before = resident_bytes(os.getpid())
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as child:
        assert child.stdout is not None
        child.stdout.readline()
        alone, both = resident_bytes(child.pid), resident_bytes(os.getpid())
        slow = _from_psutil(child.pid)
        child.communicate(b"\n")
    assert 64 << 20 < alone < 128 << 20
    assert both - before > 60 << 20
    assert slow == pytest.approx(alone, rel=0.05)
    assert resident_bytes(child.pid) == 0


def test_one_core_is_given_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv(CORES_VARIABLE, raising=False)
    all_of_them = cores()
    with one_core():
        assert (cores(), os.environ["OMP_NUM_THREADS"]) == (1, "1")
    assert (cores(), os.environ["OMP_NUM_THREADS"]) == (all_of_them, "7")
    monkeypatch.setenv(CORES_VARIABLE, "many")
    assert cores() == all_of_them


def groups(tmp_path: Path, files: dict[str, str], membership: str) -> tuple[Path, Path]:
    """A tree of control groups, and a process's place in it."""
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="ascii")
    (tmp_path / "membership").write_text(membership, encoding="ascii")
    return tmp_path, tmp_path / "membership"


def test_the_tightest_control_group_counts(tmp_path: Path) -> None:
    files = {
        "cpu.max": "max 100000\n",
        "pod/cpu.max": "250000 100000\n",
        "pod/box/cpu.max": "max 100000\n",
        "pod/memory.max": "5000000\n",
        "pod/memory.current": "1000000\n",
        "pod/box/memory.max": "max\n",
    }
    place = groups(tmp_path, files, "0::/pod/box\n")
    assert cpu_quota(*place) == 2.5
    assert memory_left(*place) == 4_000_000


def test_control_groups_of_the_first_kind(tmp_path: Path) -> None:
    files = {
        "cpu,cpuacct/box/cpu.cfs_quota_us": "-1",
        "cpu/box/cpu.cfs_quota_us": "50000",
        "cpu/box/cpu.cfs_period_us": "100000",
        "memory/box/memory.limit_in_bytes": "3000000",
        "memory/box/memory.usage_in_bytes": "4000000",
    }
    place = groups(tmp_path, files, "4:memory:/box\n3:cpu,cpuacct:/box\n")
    assert cpu_quota(*place) == 0.5
    assert memory_left(*place) == 0


def test_no_control_groups(tmp_path: Path) -> None:
    assert cpu_quota(tmp_path, tmp_path / "none") == math.inf
    assert memory_left(tmp_path, tmp_path / "none") > 0


def test_at_least_one_worker_and_at_most_one_a_core(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pipelines.engines.machine.cores", lambda: 8)
    monkeypatch.setattr("pipelines.engines.machine.cpu_quota", lambda: 6.5)
    monkeypatch.setattr("pipelines.engines.machine.memory_left", lambda: 100 << 30)
    assert default_workers(None) == 6
    monkeypatch.setattr("pipelines.engines.machine.memory_left", lambda: 3 << 30)
    assert default_workers(None) == 3
    assert default_workers(8 << 30) == 3
    assert default_workers(256 << 20) == 6
    monkeypatch.setattr("pipelines.engines.machine.memory_left", lambda: 0)
    assert default_workers(None) == 1
