"""What runs inside a worker process: tasks come through a pipe, one at a time, and answers go back.

The pipes are the process's own: what a library prints goes to stderr and cannot break the protocol. It takes no Ctrl-C,
and it ends when its supervisor is gone, however that ended: the pipe's end says so, and on Linux the kernel does even
where a call into C holds the interpreter.
"""

from __future__ import annotations

import contextlib
import ctypes
import faulthandler
import gc
import os
import signal
import sys
import threading
from pathlib import Path
from queue import SimpleQueue
from typing import BinaryIO

from parsers.errors import EngineError
from pipelines.engines.call import Outcome, called, function_at, one_line
from pipelines.engines.messages import Message, read_message, write_message

_PR_SET_PDEATHSIG = 1
_TAKE_ME_FIRST = "500"
"""For the kernel's choice when memory is out (-1000 to 1000): a worker can be replaced, what started it cannot."""


def _pipes() -> tuple[BinaryIO, BinaryIO]:
    """Where tasks come from and answers go to; what is called standard input and output from now on is neither."""
    tasks, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    return tasks, answers


def _end_with(parent: int) -> None:
    """Have the kernel end this process with the thread that started it, and where that thread is gone already, end now."""
    if sys.platform != "linux":
        return
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def _prepare(parent: int) -> None:
    _end_with(parent)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    faulthandler.enable(all_threads=False)
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text(_TAKE_ME_FIRST, encoding="ascii")


def _listen(tasks: BinaryIO, inbox: SimpleQueue[Message]) -> None:
    """Hand on what comes; end the process, in the middle of a task too, when nobody is there any more."""
    while (message := read_message(tasks)) is not None:
        inbox.put(message)
    os._exit(0)


def _give_back() -> None:
    """Return what a task left behind to the system, so that the next one starts from the same memory.

    What is still alive then (modules, caches) is not looked through again: after the imports of a drive that would take a
    tenth of a second each time.
    """
    gc.collect()
    gc.freeze()
    if sys.platform == "linux":
        # only glibc has it
        with contextlib.suppress(AttributeError):
            ctypes.CDLL(None).malloc_trim(0)


def _outcome(function: str, payload: str) -> Outcome:
    try:
        return called(function_at(function), payload)
    except KeyboardInterrupt:
        return Outcome("error", reason="KeyboardInterrupt raised by the task")


def main() -> None:
    """Serve until the supervisor is gone. sys.argv[1]: its process."""
    tasks, answers = _pipes()
    _prepare(int(sys.argv[1]))
    inbox: SimpleQueue[Message] = SimpleQueue()
    threading.Thread(target=_listen, args=(tasks, inbox), daemon=True).start()
    function = str(inbox.get()["function"])
    try:
        function_at(function)
    except EngineError as error:
        write_message(answers, {"ready": False, "reason": str(error)})
        return
    except BaseException as error:
        write_message(answers, {"ready": False, "reason": one_line(repr(error))})
        return
    _give_back()
    write_message(answers, {"ready": True})
    while True:
        payload = str(inbox.get()["payload"])
        write_message(answers, {"begun": True})
        outcome = _outcome(function, payload)
        _give_back()
        write_message(answers, {"status": outcome.status, "answer": outcome.answer, "reason": outcome.reason})
