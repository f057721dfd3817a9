"""Failed drives, grouped by what went wrong: reasons that differ only in names and figures are one."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from reports.fleet.records import DriveView

KINDS = {
    "error": "could not be read or analysed",
    "crashed": "crashed the worker",
    "timeout": "took too long",
    "memory": "took too much memory",
}
"""How a drive that is not done ended, in words."""

_QUOTED = re.compile(r"'[^']*'|\"[^\"]*\"|`[^`]*`")
_PATH = re.compile(r"\S*[/\\]\S*")
_FILE = re.compile(r"\b[\w.-]+\.[A-Za-z][A-Za-z0-9]{1,5}\b")
_FIGURE = re.compile(r"\d+(?:[.,]\d+)*")


@dataclass(frozen=True)
class FailureGroup:
    """Drives that failed alike. example: the first one's reason, as it stands."""

    status: str
    example: str
    drives: tuple[DriveView, ...]


def pattern_of(reason: str) -> str:
    """A reason without names, paths and figures."""
    text = _QUOTED.sub("…", reason)
    text = _PATH.sub("…", text)
    return _FIGURE.sub("0", _FILE.sub("…", text)).casefold()


def groups_of(failed: Sequence[DriveView]) -> tuple[FailureGroup, ...]:
    """Groups, the largest first."""
    found: dict[tuple[str, str], list[DriveView]] = {}
    for drive in failed:
        found.setdefault((drive.status, pattern_of(drive.reason)), []).append(drive)
    groups = [FailureGroup(status, drives[0].reason, tuple(drives)) for (status, _), drives in found.items()]
    return tuple(sorted(groups, key=lambda g: (-len(g.drives), g.status, g.example)))
