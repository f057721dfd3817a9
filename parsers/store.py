"""The columnar store of a drive: Parquet, one file a rate group, with `time_ns` and the signals' columns."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path

import numpy as np
import polars as pl

from parsers.drive import Drive, Signal
from parsers.quantiles import distinct
from parsers.signals import SIGNALS
from parsers.store_folder import Replacement, write_errors
from parsers.timebase import usual_period_s

_LEVEL = 2
"""Of zstd: a quarter less work than the usual level 3, for files a tenth larger."""

_ROW_GROUP = 8 << 20
_CHUNK_COST = 4096
"""What polars keeps in memory of every column of every row group that it has written (measured), bytes."""


def rate_groups(signals: Sequence[Signal]) -> list[list[Signal]]:
    """Signals of one table, topic or message of the log together, in the log's order."""
    groups: dict[str, list[Signal]] = {}
    for signal in signals:
        groups.setdefault(signal.group, []).append(signal)
    return list(groups.values())


def group_frame(signals: Sequence[Signal]) -> pl.DataFrame:
    """One table: time_ns (every stamp of any of the signals) and a column a signal, null where it has no sample."""
    first = signals[0].time_ns
    if all(s.time_ns is first or np.array_equal(s.time_ns, first) for s in signals):
        return pl.DataFrame({"time_ns": first, **{SIGNALS[s.name].column: s.values for s in signals}})
    time_ns = distinct(np.concatenate([s.time_ns for s in signals]))
    columns: dict[str, pl.Series] = {"time_ns": pl.Series(time_ns)}
    for signal in signals:
        values = np.full(len(time_ns), np.nan)
        values[np.searchsorted(time_ns, signal.time_ns)] = signal.values
        columns[SIGNALS[signal.name].column] = pl.Series(values, nan_to_null=True)
    return pl.DataFrame(columns)


def write_drive(drive: Drive, folder: Path) -> list[Path]:
    """Write a drive as Parquet files and its import record; the files written.

    The files take the place of those that an earlier run wrote into the folder; until all are made, nothing there
    changes. Raises LogError where they cannot be written, or where the folder holds tables of others.
    """
    with write_errors(folder), Replacement(folder) as tables:
        groups = rate_groups(list(drive.signals.values()))
        parts = [tables.part() for _ in groups]
        # one after the other: polars works on the columns of a table in all its threads
        for signals, part in zip(groups, parts, strict=True):
            group_frame(signals).write_parquet(part, compression="zstd", compression_level=_LEVEL)
            longest = max((s.time_ns for s in signals), key=len)
            tables.name(part, signals[0].group, usual_period_s(longest))
        return tables.commit(drive.record)


class _StoppedError(Exception):
    """The writing of a table was given up."""


def _row_group(columns: int, rows: int) -> int:
    """Rows that are gathered before they are written: so many that what polars keeps of each row group stays small."""
    width = 8 * columns
    # two row groups are in memory at a time: the sum of both costs is least where they are equal
    best = math.sqrt(_CHUNK_COST / 2 * columns * width * rows)
    return round(max(_ROW_GROUP, best) / width)


def sink_frames(frames: Iterator[pl.DataFrame], columns: Sequence[str], path: Path, rows: int) -> None:
    """Write tables of one layout, one after the other, into one file; only a few of them are in memory at a time.

    columns: the signals' columns, after time_ns. rows: about how many there will be in all. An error of `frames` is
    raised as it is.
    """
    from polars.io.plugins import register_io_source

    failed: list[BaseException] = []
    stop = threading.Event()

    def source(*_: object) -> Iterator[pl.DataFrame]:
        # polars would wrap the error, and lose what it was
        try:
            for frame in frames:
                if stop.is_set():
                    raise _StoppedError
                yield frame
        except BaseException as error:
            failed.append(error)
            raise

    schema = {"time_ns": pl.Int64} | dict.fromkeys(columns, pl.Float64)
    lazy = register_io_source(source, schema=schema)
    group = _row_group(len(schema), rows)
    # in a thread of its own: interrupted itself, polars would go on writing behind our back
    with ThreadPoolExecutor(1) as pool:
        done = pool.submit(
            lazy.sink_parquet, path, compression="zstd", compression_level=_LEVEL, row_group_size=group
        )
        try:
            done.result()
        except Exception as error:
            raise (failed[0] if failed else error) from None
        except BaseException:
            stop.set()
            wait([done])
            raise
