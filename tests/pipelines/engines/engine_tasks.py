"""Functions that the engines' tests have run: well-behaved ones, and every way to go wrong."""

from __future__ import annotations

import ctypes
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from parsers.errors import LogError


def echo(payload: str) -> str:
    """The payload again."""
    return payload


def empty(payload: str) -> str:
    """As little as a task can do."""
    return ""


def heavy_sum(payload: str) -> str:
    """A figure whose last bits depend on the order of its sums: a product of matrices and a decomposition."""
    rng = np.random.default_rng(int(payload))
    a = rng.normal(size=(300, 300))
    return (a @ a.T).tobytes().hex()[:2000] + float(np.linalg.svd(a)[1].sum()).hex()


def number(payload: str) -> int:
    """Something else than text."""
    return 7


def act(payload: str) -> str:
    """Do what the payload says: a JSON list of a word and its argument."""
    word, argument = json.loads(payload)
    return str(ACTIONS[word](argument))


def _known_error(text: str) -> str:
    raise LogError(text, path="drive.csv", place="line 7")


def _unknown_error(text: str) -> str:
    raise ValueError(text)


def _allocate(mebibytes: int) -> str:
    held = [np.ones(1 << 17) for _ in range(mebibytes)]
    time.sleep(5)
    return str(len(held))


def _in_a_child(mebibytes: int) -> str:
    code = f"x = b'x' * ({mebibytes} << 20); import time; time.sleep(20)"
    return str(subprocess.run([sys.executable, "-c", code], check=False).returncode)


def _memory_error(text: str) -> str:
    raise MemoryError(text)


def _deaf_sleep(seconds: float) -> str:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    time.sleep(seconds)
    return "slept"


def _hold_the_interpreter(seconds: int) -> str:
    # PyDLL keeps the interpreter's lock: no other thread of the process runs meanwhile
    ctypes.PyDLL(None).sleep(seconds)
    return "slept"


def _print(text: str) -> str:
    print(text * 1000)
    os.write(1, text.encode() * 1000)
    sys.stderr.write(text * 10_000)
    return "printed"


_KEPT: list[bytearray] = []


def _keep(mebibytes: int) -> str:
    _KEPT.append(bytearray(b"x") * (mebibytes << 20))
    return str(os.getpid())


def _leave_a_child(file: str) -> str:
    with subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"]) as child:
        Path(file).write_text(str(child.pid), encoding="utf-8")
    return "left"


def _touch_and_sleep(argument: tuple[str, float]) -> str:
    Path(argument[0]).touch()
    time.sleep(argument[1])
    return "slept"


def _flood(size: int) -> str:
    os.write(2, b"x" * size)
    return "flooded"


def _close_everything(_: object) -> str:
    os.closerange(3, 64)
    time.sleep(30)
    return "alone"


ACTIONS = {
    "echo": lambda text: text,
    "raise": _unknown_error,
    "known": _known_error,
    "exit": lambda code: sys.exit(code),
    "os_exit": lambda code: os._exit(code),
    "kill": lambda number: os.kill(os.getpid(), number),
    "segfault": lambda _: ctypes.string_at(0),
    "sleep": lambda seconds: time.sleep(seconds) or "slept",
    "deaf": _deaf_sleep,
    "hold": _hold_the_interpreter,
    "allocate": _allocate,
    "child": _in_a_child,
    "memory_error": _memory_error,
    "print": _print,
    "long": lambda size: "x" * size,
    "pid": lambda _: os.getpid(),
    "close": _close_everything,
    "keep": _keep,
    "leave_a_child": _leave_a_child,
    "flood": _flood,
    "touch_and_sleep": _touch_and_sleep,
    "environment": lambda name: os.environ.get(name, ""),
}
