"""What the engines' tests share: tasks, programs that find cogest, and a look at what is left behind."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from pathlib import Path

import psutil

from pipelines.engines.base import Limits, Task

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent

FUNCTION = "engine_tasks:act"
NO_LIMITS = Limits()


def task(word: str, argument: object = None, key: str | None = None) -> Task:
    """A task for `engine_tasks:act`."""
    return Task(key or word, json.dumps([word, argument]))


def environment() -> dict[str, str]:
    """Of a program that finds cogest and the test functions, as installed packages would be found."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(HERE)])}


def workers_of(*pids: int) -> list[int]:
    """Worker processes below these processes."""
    found = []
    for pid in pids:
        for process in psutil.Process(pid).children(recursive=True):
            try:
                if any("pipelines.engines.worker" in part for part in process.cmdline()):
                    found.append(process.pid)
            except psutil.Error:
                continue
    return found


def wait_until(true: Callable[[], bool], seconds: float = 30.0) -> bool:
    """Whether it becomes true in time."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if true():
            return True
        time.sleep(0.02)
    return true()
