"""The formats that cogest reads: one line each. Order matters only where two formats could claim one file."""

from __future__ import annotations

import importlib
from functools import cache
from pathlib import Path
from typing import cast

from parsers.errors import LogError
from parsers.importer import HEAD_BYTES, Importer

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


@cache
def importer_at(line: str) -> Importer:
    """The importer that a registry line "module:Class" names. Loaded when first asked for."""
    module, _, name = line.partition(":")
    return cast("Importer", getattr(importlib.import_module(module), name)())


def importers() -> tuple[Importer, ...]:
    """All importers, in the order in which they are asked."""
    return tuple(importer_at(line) for line in FORMATS)


def read_head(path: Path) -> bytes:
    """The first bytes of a file, b"" for a folder. Raises LogError where there is nothing to read."""
    if path.is_dir():
        return b""
    try:
        with path.open("rb") as file:
            head = file.read(HEAD_BYTES)
    except FileNotFoundError:
        raise LogError("no such file", path=path) from None
    except OSError as error:
        raise LogError(f"cannot be opened ({error.strerror})", path=path) from error
    if not head:
        raise LogError(
            "the file is empty (0 bytes)", path=path, hint="check that the recording was copied whole"
        )
    return head


def find_importer(path: Path) -> Importer:
    """The importer for a log, by its first bytes. Raises LogError where none claims it."""
    head = read_head(path)
    for line in FORMATS:
        importer = importer_at(line)
        if importer.claims(path, head):
            return importer
    titles = ", ".join(importer.title for importer in importers())
    what = "a folder" if path.is_dir() else f"its first bytes are {head[:8]!r}"
    raise LogError(f"not a format that cogest knows ({what})", path=path, hint=f"cogest reads {titles}")
