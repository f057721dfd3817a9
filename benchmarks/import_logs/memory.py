"""How much memory a program has had at its most."""

from __future__ import annotations

from pathlib import Path


def peak_mib() -> float:
    """MiB of this program (Linux). Not ru_maxrss: a process begins with the peak of the one that started it."""
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(status.partition("VmHWM:")[2].split()[0]) / 1024
