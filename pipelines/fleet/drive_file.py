"""drive.toml: a user's own word on which recordings of a folder are one drive. It beats every guess."""

from __future__ import annotations

import fnmatch
import tomllib
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from parsers.errors import CogestError

FILE_NAME = "drive.toml"
_KEYS = ("logs", "name", "start_utc", "separate", "leave_out", "drive")
_DRIVE_KEYS = ("logs", "name", "start_utc")


class DriveFileError(CogestError):
    """A drive.toml is wrong."""


@dataclass(frozen=True)
class SaidDrive:
    """One drive as a user put it. logs: names below the file's folder. start_utc: when its stamps' zero was."""

    logs: tuple[str, ...]
    name: str | None = None
    start_utc: str | None = None


@dataclass(frozen=True)
class DriveFile:
    """What a drive.toml says. separate: guess nothing of the other logs in this folder. leave_out: patterns of names."""

    drives: tuple[SaidDrive, ...] = ()
    separate: bool = False
    leave_out: tuple[str, ...] = ()

    def leaves_out(self, name: str) -> bool:
        """Whether a file of the folder is left out."""
        return any(fnmatch.fnmatchcase(name, pattern) for pattern in self.leave_out)


def parse_drive_file(text: str, place: str) -> DriveFile:
    """Read a drive.toml. Raises DriveFileError that names the key, what was found and what was expected."""
    try:
        raw = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise DriveFileError(f"not valid TOML ({error})", path=place) from error
    _known(raw, _KEYS, place)
    tables = raw.get("drive", [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise DriveFileError(
            "`drive` is no list of tables", path=place, hint="write [[drive]] for each drive"
        )
    drives = [_said(table, place) for table in tables]
    if "logs" in raw:
        drives.insert(0, _said({key: raw[key] for key in _DRIVE_KEYS if key in raw}, place))
    elif "name" in raw or "start_utc" in raw:
        raise DriveFileError("says no `logs`", path=place, hint='write logs = ["can.blf", "gps.vbo"]')
    separate = raw.get("separate", False)
    if not isinstance(separate, bool):
        raise DriveFileError(f"separate is {separate!r}, expected true or false", path=place)
    twice = [
        log for k, drive in enumerate(drives) for log in drive.logs if any(log in d.logs for d in drives[:k])
    ]
    if twice:
        raise DriveFileError(f"{twice[0]!r} is in two drives", path=place)
    return DriveFile(tuple(drives), separate, _texts(raw, "leave_out", place, empty=True))


def _known(table: Mapping[str, Any], known: Collection[str], place: str) -> None:
    for key in table:
        if key not in known:
            raise DriveFileError(
                f"unknown key {key!r}", path=place, hint=f"known keys are {', '.join(known)}"
            )


def _said(table: Mapping[str, Any], place: str) -> SaidDrive:
    _known(table, _DRIVE_KEYS, place)
    logs = _texts(table, "logs", place, empty=False)
    for log in logs:
        parts = log.split("/")
        if log.startswith("/") or "\\" in log or ":" in log or any(part in ("", ".", "..") for part in parts):
            raise DriveFileError(
                f"{log!r} is no name below this folder",
                path=place,
                hint='write it as "gps.vbo" or "gps/drive.vbo"',
            )
    if len(set(logs)) < len(logs):
        raise DriveFileError("`logs` names a log twice", path=place)
    name, start = table.get("name"), table.get("start_utc")
    if name is not None and (not isinstance(name, str) or not name.strip() or "/" in name):
        raise DriveFileError(f"name is {name!r}, expected a text without a slash", path=place)
    return SaidDrive(logs, name, None if start is None else _moment(start, place))


def _texts(table: Mapping[str, Any], key: str, place: str, *, empty: bool) -> tuple[str, ...]:
    value = table.get(key, [])
    value = [value] if isinstance(value, str) else value
    if not isinstance(value, list) or not all(isinstance(each, str) and each for each in value):
        raise DriveFileError(f"{key} is {value!r}, expected a list of names", path=place)
    if not value and not empty:
        raise DriveFileError(f"`{key}` names nothing", path=place)
    return tuple(value)


def _moment(value: object, place: str) -> str:
    """A moment as the results write it, in UTC."""
    wrong = DriveFileError(
        f"start_utc is {value!r}, expected a date and a time of day",
        path=place,
        hint='as "2024-05-01T10:00:00Z"',
    )
    if isinstance(value, str):
        try:
            value = datetime.fromisoformat(value)
        except ValueError:
            raise wrong from None
    if not isinstance(value, datetime):
        raise wrong
    zoned = value if value.tzinfo is not None else value.replace(tzinfo=UTC)
    try:
        return zoned.astimezone(UTC).isoformat(timespec="milliseconds")
    except (OverflowError, ValueError):
        raise wrong from None
