"""The formats that cogest reads: one line each. Order matters only where two formats could claim one file."""

from __future__ import annotations

import importlib
import itertools
import stat
from functools import cache
from pathlib import Path
from typing import cast

from parsers.errors import LogError
from parsers.importer import HEAD_BYTES, Importer
from parsers.wide_text import narrow, wide_encoding

FORMATS: tuple[str, ...] = (
    # binary formats, by their magic bytes
    "parsers.mcap_log:McapImporter",
    "parsers.rosbag1_log:RosBag1Importer",
    "parsers.rosbag2_log:RosBag2Importer",
    "parsers.mf4_log:Mf4Importer",
    "parsers.blf_log:BlfImporter",
    "parsers.parquet_log:ParquetImporter",
    # text formats, by their first lines; CSV claims what no other does
    "parsers.vbo_log:VboImporter",
    "parsers.trc_log:TrcImporter",
    "parsers.asc_log:AscImporter",
    "parsers.candump_log:CandumpImporter",
    "parsers.csv_log:CsvImporter",
)

_OF_FRAMES = ("parsers.trc_log", "parsers.asc_log", "parsers.candump_log")

_PACKED = ((b"\x1f\x8b", "gzip", "gunzip"), (b"PK\x03\x04", "ZIP", "unzip"), (b"7z\xbc\xaf\x27\x1c", "7-Zip", "7z x"),
           (b"Rar!", "RAR", "unrar x"), (b"\xfd7zXZ\x00", "xz", "unxz"))  # fmt: skip
"""Archives by their first bytes: what they are called, and what unpacks them."""


@cache
def importer_at(line: str) -> Importer:
    """The importer that a registry line "module:Class" names. Loaded when first asked for."""
    module, _, name = line.partition(":")
    return cast("Importer", getattr(importlib.import_module(module), name)())


def importers() -> tuple[Importer, ...]:
    """All importers, in the order in which they are asked."""
    return tuple(importer_at(line) for line in FORMATS)


def _kind(path: Path) -> str:
    """ "file" or "folder". Raises LogError for what is neither: it could block for ever, or never end."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        raise LogError("no such file", path=path) from None
    except (OSError, ValueError) as error:
        raise LogError(
            f"cannot be opened ({getattr(error, 'strerror', None) or error})", path=path
        ) from error
    if stat.S_ISDIR(mode):
        return "folder"
    if not stat.S_ISREG(mode):
        raise LogError("is a pipe or a device, not a file", path=path, hint="write the log to a file first")
    return "file"


def read_head(path: Path) -> bytes:
    """The first bytes of a file, b"" for a folder. Raises LogError where there is nothing to read."""
    if _kind(path) == "folder":
        return b""
    try:
        with path.open("rb") as file:
            head = file.read(HEAD_BYTES)
    except OSError as error:
        raise LogError(f"cannot be opened ({error.strerror})", path=path) from error
    if not head:
        raise LogError(
            "the file is empty (0 bytes)", path=path, hint="check that the recording was copied whole"
        )
    return head


def _logs_inside(folder: Path) -> list[str]:
    """Names of files in a folder that look like logs, by their suffix."""
    suffixes = {suffix for importer in importers() for suffix in importer.suffixes}
    entries = itertools.islice(folder.iterdir(), 1000)
    return sorted(entry.name for entry in entries if entry.suffix.lower() in suffixes and entry.is_file())


def _unknown(path: Path, head: bytes) -> LogError:
    """The error for a file or folder that no importer claims."""
    if path.is_dir():
        logs = _logs_inside(path)
        found = f"; it holds {', '.join(logs[:3])}{', …' if len(logs) > 3 else ''}" if logs else ""
        return LogError(
            f"the folder is neither a ROS 2 bag nor a folder of Parquet files alone{found}",
            path=path,
            hint="give the log file itself" if logs else "give a log file",
        )
    if path.suffix.lower() in (".xlsx", ".xlsm", ".xls", ".ods"):
        return LogError("a spreadsheet", path=path, hint="save its sheet as CSV")
    for magic, packed, unpack in _PACKED:
        if head.startswith(magic):
            return LogError(
                f"a {packed} file", path=path, hint=f"unpack it ({unpack}) and give the log that is in it"
            )
    titles = ", ".join(importer.title for importer in importers())
    return LogError(
        f"not a format that cogest knows (its first bytes are {head[:8]!r})",
        path=path,
        hint=f"cogest reads {titles}",
    )


def _of_wide_frames(path: Path, head: bytes) -> Importer | None:
    """The importer of a text log of frames that was saved as UTF-16, as PowerShell's ">" does: a table it is not."""
    encoding = wide_encoding(head)
    if encoding is None:
        return None
    text = narrow(head, encoding)
    lines = (line for line in FORMATS if line.startswith(_OF_FRAMES))
    return next((importer_at(line) for line in lines if importer_at(line).claims(path, text)), None)


def find_importer(path: Path) -> Importer:
    """The importer for a log, by its first bytes. Raises LogError where none claims it."""
    head = read_head(path)
    try:
        wide = _of_wide_frames(path, head)
        if wide is not None:
            return wide
        for line in FORMATS:
            importer = importer_at(line)
            if importer.claims(path, head):
                return importer
        error = _unknown(path, head)
    except OSError as failure:
        raise LogError(f"cannot be read ({failure.strerror or failure})", path=path) from failure
    raise error
