"""Vector BLF: binary CAN logs, read container by container. CAN and CAN FD frames; decoded with the DBCs given."""

from __future__ import annotations

from pathlib import Path

from parsers.importer import TAKEN_AS_UTC, ImportLog, LogReader, ReadOptions


class BlfImporter:
    """Vector BLF."""

    name = "blf"
    title = "Vector BLF"
    suffixes = (".blf",)

    def claims(self, path: Path, head: bytes) -> bool:
        """By the letters LOGG."""
        return head.startswith(b"LOGG")

    def open(self, path: Path, options: ReadOptions, log: ImportLog) -> LogReader:
        """Read the header; LogError where there is none. Frames are decoded by `CanReader`."""
        # numba and cantools load only when a BLF file is opened
        from parsers.blf_containers import read_header
        from parsers.blf_frames import BlfFrames
        from parsers.can.reader import CanReader

        header = read_header(path)
        if header.start_ns is None:
            log.note("the BLF file has no start time: its clock counts from the start of the recording")
        else:
            log.without_zone(
                f"a BLF file does not say whether its start time is local or UTC: it is {TAKEN_AS_UTC}"
            )
        return CanReader(BlfFrames(path, header, log, options.progress), options, log, path)
