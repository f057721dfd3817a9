"""Logs to the store: a drive that fits into the budget is handled in memory, a longer one window by window from disk."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from parsers.drive import ImportRecord
from parsers.intake import Budget, Intake
from parsers.load import find_all, make_drive, options_of_each
from parsers.log_hash import BackgroundHash
from parsers.opened_log import LoadOptions
from parsers.read_log import make_part, take_in
from parsers.store_folder import refuse_strangers, write_errors


@dataclass(frozen=True)
class Converted:
    """What was written: the record, how many signals, and the files."""

    record: ImportRecord
    signals: int
    files: tuple[Path, ...]


def convert_logs(
    paths: Sequence[Path], options: LoadOptions, folder: Path, budget: Budget | None = None
) -> Converted:
    """Write one drive's logs (recorded in parts, or by several recorders) as Parquet, with their import record.

    Memory stays within what the budget gives, however long the logs are. Raises LogError (a log cannot be read, nothing in
    it maps to a signal, or the folder cannot be written), MappingError, DatabaseError.
    """
    budget = budget or Budget(folder)
    find_all(paths)
    if folder.is_dir():
        # said before the work, not after it
        refuse_strangers(folder)
    intake = Intake(budget)
    with BackgroundHash(paths) as digest, _no_trace(folder), contextlib.closing(intake):
        each = options_of_each(paths, options)
        with write_errors(folder):
            taken = [take_in(path, each, intake) for path in paths]
            if intake.spool is not None:
                # the rest of the code, and numba with it, loads only where it is needed
                from parsers.long_drive import LongDrive

                record, count, files = LongDrive(paths, options, folder, budget).convert(taken, digest)
                return Converted(record, count, tuple(files))
        from parsers.store import PackAhead, write_drive

        with contextlib.closing(PackAhead()) as ahead:
            parts = [make_part(taken.pop(0), ahead.signal) for _ in paths]
            drive = make_drive(paths, parts, options, digest)
            del parts
            files = write_drive(drive, folder, ahead)
        return Converted(drive.record, len(drive.signals), tuple(files))


@contextlib.contextmanager
def _no_trace(folder: Path) -> Iterator[None]:
    """Take a folder away again that was made for nothing."""
    made = not folder.exists()
    try:
        yield
    except BaseException:
        if made:
            with contextlib.suppress(OSError):
                folder.rmdir()
        raise
