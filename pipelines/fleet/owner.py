"""Which process something belongs to, and whether it is still alive: for claims, and for files half written."""

from __future__ import annotations

import os
import re
import socket
from dataclasses import dataclass
from functools import cache


@dataclass(frozen=True)
class Owner:
    """host: where process numbers mean something (a machine, or a container on it). started: when the process began, in
    ms since 1970 (0 = not known): a number that was given again to another process is told apart."""

    host: str
    pid: int
    started: int

    @property
    def text(self) -> str:
        """As part of a file's name."""
        return f"{self.host}~{self.pid}~{self.started}"


@cache
def _host() -> str:
    try:
        space = f"-{os.stat('/proc/self/ns/pid').st_ino}"
    except OSError:
        # no Linux: one space of process numbers a machine
        space = ""
    return re.sub(r"[^A-Za-z0-9.-]", "-", socket.gethostname())[:80] + space


def _started(pid: int) -> int | None:
    """When a process began; None where there is none, 0 where the system does not say."""
    import psutil

    try:
        process = psutil.Process(pid)
        if process.status() == psutil.STATUS_ZOMBIE:
            return None
        return round(process.create_time() * 1000)
    except psutil.NoSuchProcess:
        return None
    except psutil.Error:
        return 0


def this_process() -> Owner:
    """The owner of what this process makes."""
    pid = os.getpid()
    return Owner(_host(), pid, _started(pid) or 0)


def owner_from(text: str) -> Owner | None:
    """The owner again, None where the text is none."""
    match = re.fullmatch(r"([A-Za-z0-9.-]+)~(\d{1,10})~(\d{1,15})", text)
    return Owner(match[1], int(match[2]), int(match[3])) if match else None


def alive(owner: Owner) -> bool | None:
    """Whether the process still runs; None where that cannot be known here (another machine or container)."""
    if owner.host != _host():
        return None
    if not 0 < owner.pid < 2**31:
        return False
    started = _started(owner.pid)
    if started is None:
        return False
    # the clock that start times are taken from may be set by some ms while a system runs
    return not (started and owner.started) or abs(started - owner.started) < 2000
