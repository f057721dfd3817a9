"""ASAM MDF 4 (MF4): measured channels, and CAN bus logging decoded with the DBCs given; one file may hold both."""

from __future__ import annotations

from pathlib import Path

from parsers.errors import LogError
from parsers.importer import ImportLog, LogReader, ReadOptions


class Mf4Importer:
    """ASAM MDF 4."""

    name = "mf4"
    title = "ASAM MF4 (MDF 4)"
    suffixes = (".mf4", ".mdf", ".dat")

    def claims(self, path: Path, head: bytes) -> bool:
        """By the letters MDF, or UnFinMF for a file that its recorder did not finish; `open` looks at the version."""
        return head.startswith((b"MDF     ", b"UnFinMF "))

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> LogReader:
        """Read the descriptions; LogError where the file is of another version or its first blocks are damaged."""
        # numba and cantools load only when an MF4 file is opened
        from parsers.mf4.reader import open_mf4

        try:
            return open_mf4(path, options, log)
        except RecursionError:
            raise LogError(
                "the file's descriptions are nested without end", path=path, hint="it is damaged"
            ) from None
