"""What holds for every engine: the same answers, the same words for what went wrong, tasks taken lazily, nothing left behind."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Iterator

import pytest
from engine_help import FUNCTION, NO_LIMITS, task, wait_until, workers_of
from engine_tasks import heavy_sum

from parsers.errors import EngineError
from pipelines.engines.base import Done, Engine, Limits, Task
from pipelines.engines.one_core import one_core
from pipelines.engines.registry import ENGINES


def by_key(engine: Engine, tasks: list[Task], limits: Limits = NO_LIMITS) -> dict[str, Done]:
    """All results."""
    ended = list(engine.map(FUNCTION, iter(tasks), limits))
    assert sorted(done.key for done in ended) == sorted(one.key for one in tasks)
    return {done.key: done for done in ended}


def test_the_contract_is_tested_for_every_engine() -> None:
    assert set(ENGINES) == {"serial", "local", "dask"}


def test_answers_are_what_the_function_gives(engine: Engine) -> None:
    texts = {
        "plain": "ok",
        "empty": "",
        "unicode": "Höhe ≈ 0,5 m 重心 🚙",
        "not utf-8": "log\udce9.csv",
        "nul": "a\0b\n",
    }
    done = by_key(engine, [task("echo", text, key) for key, text in texts.items()])
    assert {key: one.answer for key, one in done.items()} == texts
    assert {one.status for one in done.values()} == {"done"}
    assert all(one.worker and one.seconds >= 0 and not one.reason for one in done.values())


def test_a_long_answer_comes_whole(engine: Engine) -> None:
    (done,) = engine.map(FUNCTION, [task("long", 5_000_000)], NO_LIMITS)
    assert done.answer == "x" * 5_000_000


def test_sums_are_the_same_to_the_last_bit(engine: Engine) -> None:
    with one_core():
        expected = [heavy_sum(str(seed)) for seed in range(3)]
    done = {
        d.key: d.answer
        for d in engine.map("engine_tasks:heavy_sum", (Task(str(k), str(k)) for k in range(3)), NO_LIMITS)
    }
    assert [done[str(k)] for k in range(3)] == expected


def test_each_worker_has_one_core(engine: Engine) -> None:
    names = ("COGEST_CORES", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "MPLBACKEND")
    done = by_key(engine, [task("environment", name, name) for name in names])
    assert [done[name].answer for name in names] == ["1", "1", "1", "Agg"]


def test_what_goes_wrong_is_told_in_the_same_words(engine: Engine) -> None:
    wrong = [
        task("raise", "two\nlines"),
        task("known", "odd"),
        task("exit", 3),
        task("memory_error", "no room"),
    ]
    done = by_key(engine, [*wrong, task("echo", "after")])
    assert {key: one.status for key, one in done.items()} == {
        "raise": "error",
        "known": "error",
        "exit": "error",
        "memory_error": "memory",
        "echo": "done",
    }
    assert done["known"].reason == "drive.csv, line 7: odd"
    assert done["raise"].reason.startswith("ValueError: two lines (engine_tasks, line ")
    assert done["raise"].reason.endswith(", in _unknown_error)")
    assert done["exit"].reason.startswith("called sys.exit(3) (engine_tasks, line ")
    assert done["memory_error"].reason.startswith("ran out of memory: no room (engine_tasks, line ")


def test_an_answer_that_is_no_text_is_an_error(engine: Engine) -> None:
    (done,) = engine.map("engine_tasks:number", [Task("n", "")], NO_LIMITS)
    assert (done.status, done.answer) == ("error", "")
    assert "answered int, not text" in done.reason


def test_what_a_task_prints_stays_off_stdout(engine: Engine, capsys: pytest.CaptureFixture[str]) -> None:
    # os.write(1, …) in the task of `print` would be stdout's in the engine that has no other process
    words = "echo" if engine.name == "serial" else "print"
    done = by_key(engine, [task(words, "rubbish"), task("echo", "after", "after")])
    assert {one.status for one in done.values()} == {"done"}
    assert capsys.readouterr().out == ""


def test_tasks_are_taken_as_they_are_needed(engine: Engine) -> None:
    taken = 0

    def tasks() -> Iterator[Task]:
        nonlocal taken
        for k in range(1_000_000):
            taken += 1
            yield Task(str(k), "")

    ended = engine.map("engine_tasks:empty", tasks(), NO_LIMITS)
    for got in range(1, 21):
        next(ended)
        assert taken <= got + 4
    ended.close()  # type: ignore[attr-defined]
    assert taken <= 24


def test_no_tasks_no_results(engine: Engine) -> None:
    assert list(engine.map(FUNCTION, [], NO_LIMITS)) == []


def test_a_function_that_does_not_exist_is_an_error_of_the_engine(engine: Engine) -> None:
    with pytest.raises(EngineError, match='cannot import "engine_tasks:nothing"'):
        list(engine.map("engine_tasks:nothing", [Task("a", "")], NO_LIMITS))


@pytest.mark.parametrize(
    ("word", "argument", "status", "reason"),
    [
        ("os_exit", 3, "crashed", r"its process ended itself \(exit code 3\)$"),
        ("os_exit", 0, "crashed", r"its process ended itself \(exit code 0\)$"),
        (
            "segfault",
            0,
            "crashed",
            r"a segmentation fault \(signal 11, SIGSEGV\) \(engine_tasks.py, line \d+, in <lambda>\)$",
        ),
        (
            "kill",
            int(signal.SIGKILL),
            "crashed",
            r"killed by the system \(signal 9\), most likely out of memory$",
        ),
        ("kill", int(signal.SIGTERM), "crashed", r"ended by signal 15 \(SIGTERM\)$"),
        ("deaf", 60, "timeout", r"^took longer than 0.7 s \(limit\)$"),
        ("hold", 60, "timeout", r"^took longer than 0.7 s \(limit\)$"),
        ("allocate", 600, "memory", r"^took more than 200 MiB \(limit\)$"),
        ("child", 400, "memory", r"^took more than 200 MiB \(limit\)$"),
    ],
)
def test_a_task_that_dies_costs_itself_alone(
    guarded: Engine, word: str, argument: object, status: str, reason: str
) -> None:
    tasks = [
        task("echo", 1, "before"),
        task(word, argument, "bad"),
        task("echo", 2, "b"),
        task("echo", 3, "c"),
    ]
    limits = Limits(memory_bytes=200 << 20) if status == "memory" else Limits(seconds=0.7)
    done = by_key(guarded, tasks, limits)
    bad = done.pop("bad")
    assert bad.status == status
    assert re.search(reason, bad.reason), bad.reason
    assert {one.status for one in done.values()} == {"done"}


def test_closing_ends_all_workers_at_once(guarded: Engine, request: pytest.FixtureRequest) -> None:
    pids = [os.getpid()]
    if guarded.name == "dask":
        pids.append(request.getfixturevalue("cluster")[1])
    ended = guarded.map(
        FUNCTION, [task("echo", 1), task("deaf", 60), task("hold", 60), task("echo", 4, "d")], NO_LIMITS
    )
    next(ended)
    assert workers_of(*pids)
    ended.close()  # type: ignore[attr-defined]
    assert wait_until(lambda: not workers_of(*pids), 5.0)
