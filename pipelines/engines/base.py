"""The contract of an engine: run one function over many tasks, each on its own, and say of each how it ended."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from dataclasses import dataclass
from typing import Literal, Protocol

TaskStatus = Literal["done", "error", "crashed", "timeout", "memory"]
"""done: the function answered. error: it raised. crashed: its process died. timeout, memory: it was ended at a limit."""


@dataclass(frozen=True)
class Task:
    """One piece of work. key: names it, unique. payload: text (JSON) that the function gets."""

    key: str
    payload: str


@dataclass(frozen=True)
class Limits:
    """What one task may take; None = no limit. seconds: wall clock. memory_bytes: resident memory of its process."""

    seconds: float | None = None
    memory_bytes: int | None = None


@dataclass(frozen=True)
class Done:
    """How a task ended. answer: the function's text where it is "done". reason: in words where it is not.

    seconds: wall clock that it took. worker: which process or machine ran it, in words.
    """

    key: str
    status: TaskStatus
    answer: str = ""
    reason: str = ""
    seconds: float = 0.0
    worker: str = ""


class Engine(Protocol):
    """Runs `function` ("module:name", text -> text, importable by every worker) over tasks.

    `map` takes tasks lazily, holds only a few a worker at a time, and yields each as it ends, in any order. A task that
    raises, crashes its process, hangs beyond the limit or takes too much memory costs that task alone. Closing the
    iterator early (or Ctrl-C) ends every worker. `serial` runs in this process and keeps no limits.
    """

    name: str
    title: str

    def map(self, function: str, tasks: Iterable[Task], limits: Limits) -> Generator[Done, None, None]:
        """Run them all. Raises EngineError where no worker can be started or reached."""
        ...
