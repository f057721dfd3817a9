"""Why a worker process ended, in words that are the same on every run: no numbers of processes, no paths."""

from __future__ import annotations

import re
import signal
from pathlib import PurePath

from pipelines.engines.call import of_a_library

_KNOWN = {
    "SIGSEGV": "a segmentation fault",
    "SIGBUS": "a bus error",
    "SIGABRT": "an abort",
    "SIGFPE": "an arithmetic error",
    "SIGILL": "an illegal instruction",
}
_WINDOWS = {0xC0000005: "an access violation", 0xC00000FD: "a stack overflow", 0xC0000017: "a lack of memory"}
_FRAME = re.compile(r'^  File "(?P<file>[^"]+)", line (?P<line>\d+) in (?P<name>.+)$', re.MULTILINE)
_FRAME_OF_OURS = re.compile(r"[/\\]pipelines[/\\]engines[/\\](?:worker|call)\.py$")


def _where(stderr: str) -> str:
    """The innermost line of the thread that died, of libraries' callers, as faulthandler wrote it; empty where it wrote nothing."""
    at = stderr.rfind("Fatal Python error")
    if at < 0:
        return ""
    # the thread that died is marked "Current", the others stand before it
    current = stderr.find("Current thread", at)
    frames = [f for f in _FRAME.finditer(stderr, max(current, at)) if not of_a_library(f["file"])]
    if not frames or _FRAME_OF_OURS.search(frames[0]["file"]):
        return ""
    frame = frames[0]
    return f" ({PurePath(frame['file']).name}, line {frame['line']}, in {frame['name']})"


def crash_reason(code: int | None, stderr: str) -> str:
    """Why a process is gone that nobody of us ended. code: as of Popen.returncode. stderr: the last that it wrote."""
    if code is None:
        return "its process closed the connection to cogest"
    if code >= 0:
        windows = _WINDOWS.get(code)
        return f"its process died of {windows}" if windows else f"its process ended itself (exit code {code})"
    number = -code
    if number == int(getattr(signal, "SIGKILL", 9)):
        return f"killed by the system (signal {number}), most likely out of memory"
    try:
        name = signal.Signals(number).name
    except ValueError:
        name = ""
    if name in _KNOWN:
        return f"its process died of {_KNOWN[name]} (signal {number}, {name}){_where(stderr)}"
    return f"its process was ended by signal {number}{f' ({name})' if name else ''}"


def last_line(stderr: str) -> str:
    """The last line that says something."""
    lines = [line.strip() for line in stderr.splitlines() if line.strip()]
    return lines[-1] if lines else ""
