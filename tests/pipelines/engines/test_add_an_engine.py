"""A new engine is one file and one registry line: this test adds one."""

from __future__ import annotations

from pathlib import Path

import pytest

from parsers.errors import EngineError
from pipelines.engines.base import Limits, Task
from pipelines.engines.registry import ENGINES, engine_named

MODULE = """
from pipelines.engines.base import Done
from pipelines.engines.call import called, function_at


class Backwards:
    name = "backwards"
    title = "all tasks, the last one first"

    def __init__(self, workers=None, scheduler=None):
        self.workers = workers

    def map(self, function, tasks, limits):
        call = function_at(function)
        for task in reversed(list(tasks)):
            outcome = called(call, task.payload)
            yield Done(task.key, outcome.status, outcome.answer, outcome.reason, 0.0, "here")
"""


def test_one_file_and_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "backwards_engine.py").write_text(MODULE, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setitem(ENGINES, "backwards", "backwards_engine:Backwards")
    engine = engine_named("backwards", 3, None)
    done = list(engine.map("engine_tasks:echo", [Task("a", "1"), Task("b", "2")], Limits()))
    assert [(one.key, one.answer) for one in done] == [("b", "2"), ("a", "1")]


def test_a_wrong_name_names_the_nearest() -> None:
    with pytest.raises(EngineError, match=r'no engine "locl"; did you mean "local"\?'):
        engine_named("locl")
    with pytest.raises(EngineError, match="there are serial, local, dask"):
        engine_named("quantum")


@pytest.mark.parametrize(
    ("name", "workers", "scheduler", "said"),
    [
        ("serial", 4, None, "serial is one worker, and 4 were asked for"),
        ("serial", None, "tcp://x:1", "serial has no scheduler"),
        ("local", 0, None, "at least one worker"),
        ("local", None, "tcp://x:1", "local has no scheduler"),
        ("dask", 0, None, "at least one worker"),
    ],
)
def test_what_an_engine_cannot_do_is_said(
    name: str, workers: int | None, scheduler: str | None, said: str
) -> None:
    with pytest.raises(EngineError, match=said):
        engine_named(name, workers, scheduler)


@pytest.mark.parametrize("name", list(ENGINES))
def test_each_says_what_it_is(name: str) -> None:
    if name == "dask":
        pytest.importorskip("distributed")
    engine = engine_named(name)
    assert engine.name == name
    assert engine.title
