"""Raw CAN frames that a tool wrote as text: no table of measurements, so that the user hears which export is read."""

from __future__ import annotations

import re
from collections.abc import Collection
from pathlib import Path

from parsers.errors import LogError

_HEAD_LINES = 40
_TABLES = (
    frozenset({"arbitration_id", "dlc", "data"}),
    frozenset({"id", "extended", "bus", "len", "d1"}),
    frozenset({"id", "dlc", "data"}),
    frozenset({"id", "databytes"}),
)
_OF_TOOLS = (
    ("Vehicle Spy", frozenset({"arb_id", "b1", "b2"})),
    ("a Kvaser tool", frozenset({"id", "dlc", "d0", "d1"})),
    ("a Kvaser tool", frozenset({"id", "dlc", "data0", "data1"})),
    ("CANoe or CANalyzer", frozenset({"id", "event_type", "dlc", "data"})),
)
_BUSMASTER = re.compile(r"\s*\*\*\*BUSMASTER\b")
_CL2000 = re.compile(r"#\s*Logger type:\s*CL\d+", re.IGNORECASE)


def tool_of_frames(head: str) -> str | None:
    """Which tool wrote a text whose first lines are those of its log of CAN frames; None where none of those known."""
    if _BUSMASTER.match(head):
        return "BUSMASTER"
    lines = head.split("\n", _HEAD_LINES)[:_HEAD_LINES]
    if any(_CL2000.match(line) for line in lines):
        return "a CL2000 logger"
    for line in lines:
        words = _words(re.split(r"[,;\t]", line))
        for tool, marks in _OF_TOOLS:
            if marks <= words:
                return tool
    return None


def refuse_frames_of_tools(head: str, path: Path) -> None:
    """Raise LogError where `tool_of_frames` knows a text."""
    tool = tool_of_frames(head)
    if tool is not None:
        raise LogError(
            f"a log of raw CAN frames as text of {tool}, which cogest does not read",
            path=path,
            hint="export or convert it to BLF, ASC, MF4, TRC or candump and give its DBC with --dbc",
        )


def refuse_frames(columns: Collection[str], path: Path) -> None:
    """Raise LogError for tables of raw CAN frames, whose cells are bytes and no measurements, by the columns' names."""
    heads = _words(columns)
    for marks in _TABLES:
        if marks <= heads:
            raise LogError(
                f"a table of raw CAN frames (columns {', '.join(sorted(marks))}), which cogest does not read",
                path=path,
                hint="convert it to BLF, ASC or candump (for example `python -m can.logconvert log.csv log.blf`) "
                "and give its DBC with --dbc",
            )


def _words(names: Collection[str]) -> set[str]:
    return {name.strip().strip('"').lower().replace(" ", "_") for name in names}
