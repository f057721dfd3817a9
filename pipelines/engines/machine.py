"""What this machine lets us use: cores, and memory. A container's limits count, not the hardware under it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from parsers.parallel import cores

WORKER_BYTES = 1 << 30
"""What one worker is taken to need where nobody said: measured 0.3 to 0.4 GiB on the sample drives, and a log may be longer."""

CGROUPS = Path("/sys/fs/cgroup")
MEMBERSHIP = Path("/proc/self/cgroup")


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="ascii").strip()
    except (OSError, ValueError):
        return ""


def _folders(controller: str, root: Path, membership: Path) -> Iterator[Path]:
    """The control groups that this process is in, innermost first: a limit of any of them holds."""
    for line in _text(membership).splitlines():
        _, controllers, place = line.split(":", 2)
        if controllers and controller not in controllers.split(","):
            continue
        top = root / controller if controllers else root
        inner = PurePosixPath(place.lstrip("/"))
        yield from (top / folder for folder in (inner, *inner.parents))


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        return math.inf
    return value if value >= 0 else math.inf


def cpu_quota(root: Path = CGROUPS, membership: Path = MEMBERSHIP) -> float:
    """How many cores' time the control groups give this process; infinite without a limit."""
    quota = math.inf
    for folder in _folders("cpu", root, membership):
        both = _text(folder / "cpu.max").split() or [
            _text(folder / "cpu.cfs_quota_us"),
            _text(folder / "cpu.cfs_period_us"),
        ]
        if len(both) == 2:
            share = _number(both[0]) / _number(both[1]) if _number(both[1]) else math.inf
            quota = min(quota, share if share > 0 else math.inf)
    return quota


def memory_left(root: Path = CGROUPS, membership: Path = MEMBERSHIP) -> float:
    """Bytes that may still be taken: of the machine, and of the control groups that this process is in."""
    import psutil

    left = float(psutil.virtual_memory().available)
    for folder in _folders("memory", root, membership):
        for limit, used in (
            ("memory.max", "memory.current"),
            ("memory.limit_in_bytes", "memory.usage_in_bytes"),
        ):
            highest = _number(_text(folder / limit))
            if math.isfinite(highest):
                left = min(left, highest - min(_number(_text(folder / used)), highest))
    return left


def default_workers(memory_bytes: int | None) -> int:
    """One worker a core, and not more than memory has room for. memory_bytes: the limit of one task, if there is one."""
    need = WORKER_BYTES if memory_bytes is None else min(WORKER_BYTES, memory_bytes)
    allowed = min(cores(), cpu_quota(), memory_left() / need)
    return max(1, int(allowed))
