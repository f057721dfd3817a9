"""Descriptions of a bus that are no DBC: told by what they begin with, so that the user hears what to do."""

from __future__ import annotations

import re
from pathlib import Path

from parsers.errors import DatabaseError

_HEAD = 4096
_KINDS = (
    (re.compile(rb"<(\w+:)?AUTOSAR\b"), "an AUTOSAR description (ARXML)"),
    (re.compile(rb"<(\w+:)?NetworkDefinition\b"), "a Kayak network definition (KCD)"),
    (re.compile(rb"<(\w+:)?FIBEX\b"), "a FIBEX description"),
    (re.compile(rb"\A\s*FormatVersion\s*="), "a PEAK symbol file (SYM)"),
    (re.compile(rb"\A\s*(\[DATABASE_VERSION\]|\[BUSMASTER_VERSION\])"), "a BUSMASTER database (DBF)"),
)
_CONVERTED = (".arxml", ".kcd", ".sym")


def refuse_other(raw: bytes, path: Path) -> None:
    """Raise DatabaseError, with the way to a DBC, where a file is a description of another kind."""
    head = raw[:_HEAD]
    for beginning, kind in _KINDS:
        if not beginning.search(head):
            continue
        way = "export a DBC from the tool that wrote it"
        if path.suffix.lower() in _CONVERTED:
            way += f", or write one with `cantools convert {path.name} {path.stem}.dbc`"
        raise DatabaseError(
            f"{kind}, where a DBC was expected", path=path, hint=f"{way}, and give it with --dbc"
        )
