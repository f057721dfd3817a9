"""Call a task's function and say how it ended: the same words in this process, in a worker, on another machine."""

from __future__ import annotations

import importlib
import re
import sysconfig
import traceback
from collections.abc import Callable
from dataclasses import dataclass

from parsers.errors import CogestError, EngineError
from pipelines.engines.base import TaskStatus

Function = Callable[[str], str]

_LONGEST_REASON = 600

_INSTALLED = re.compile(r"(?:site|dist)-packages[/\\](\w+)")
_OURS = ("parsers", "pipelines", "reports", "cogest_cli")


@dataclass(frozen=True)
class Outcome:
    """How a call ended: an answer where it is "done", else a reason in one line."""

    status: TaskStatus
    answer: str = ""
    reason: str = ""


def function_at(place: str) -> Function:
    """The function that "module:name" names. Raises EngineError where it cannot be imported."""
    module, _, name = place.partition(":")
    try:
        function: Function = getattr(importlib.import_module(module), name)
    except Exception as error:
        raise EngineError(
            f'a worker cannot import "{place}": {type(error).__name__}: {one_line(str(error))}'
        ) from error
    return function


def one_line(text: str) -> str:
    """Text of any shape as one line that a table can show."""
    line = " ".join(text.split())
    return line if len(line) <= _LONGEST_REASON else line[: _LONGEST_REASON - 1] + "…"


def of_a_library(file: str) -> bool:
    """Whether a source file is Python's own or an installed library's: whoever called it is the place to look at."""
    installed = _INSTALLED.search(file)
    if installed:
        return installed[1] not in _OURS
    return file.startswith((sysconfig.get_path("stdlib"), "<"))


def _place(error: BaseException) -> str:
    """Module, line and function that raised, or that called the library that did; without any machine's paths."""
    frames = list(traceback.walk_tb(error.__traceback__))
    own = [(f, n) for f, n in frames if not of_a_library(f.f_code.co_filename)] or frames
    frame, line = own[-1]
    return f"{frame.f_globals.get('__name__', '?')}, line {line}, in {frame.f_code.co_name}"


def called(function: Function, payload: str) -> Outcome:
    """Call it. Every exception becomes an outcome, except KeyboardInterrupt: that is the user's, not the task's."""
    try:
        answer = function(payload)
        if not isinstance(answer, str):
            raise TypeError(f"the task's function answered {type(answer).__name__}, not text")
    except KeyboardInterrupt:
        raise
    except CogestError as error:
        return Outcome("error", reason=str(error))
    except MemoryError as error:
        return Outcome(
            "memory", reason=one_line(f"ran out of memory: {error or 'MemoryError'} ({_place(error)})")
        )
    except SystemExit as error:
        return Outcome("error", reason=one_line(f"called sys.exit({error.code!r}) ({_place(error)})"))
    except BaseException as error:
        said = one_line(str(error))
        what = f"{type(error).__name__}: {said}" if said else type(error).__name__
        return Outcome("error", reason=f"{what} ({_place(error)})")
    return Outcome("done", answer)
