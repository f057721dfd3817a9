"""MCAP recordings: how they are recognised. The decoders load only when one is opened."""

from __future__ import annotations

from pathlib import Path

from parsers.importer import ImportLog, LogReader, ReadOptions


class McapImporter:
    """MCAP files, whole or broken off, with or without an index."""

    name = "mcap"
    title = "MCAP"
    suffixes = (".mcap",)

    def claims(self, path: Path, head: bytes) -> bool:
        """By the magic bytes."""
        return head.startswith(b"\x89MCAP0\r\n")

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> LogReader:
        """Raises LogError where there is no topic that could be read."""
        from parsers.mcap_reader import McapReader

        return McapReader(path, options, log)
