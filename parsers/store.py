"""The columnar store of a drive: Parquet, one file a rate group, with `time_ns` and the signals' columns."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import polars as pl

from parsers.drive import Drive, ImportRecord, Signal
from parsers.errors import LogError
from parsers.signals import SIGNALS
from parsers.timebase import usual_period_s

RECORD_FILE = "import_record.json"


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
    time_ns = np.unique(np.concatenate([s.time_ns for s in signals]))
    columns: dict[str, pl.Series] = {"time_ns": pl.Series(time_ns)}
    for signal in signals:
        values = np.full(len(time_ns), np.nan)
        values[np.searchsorted(time_ns, signal.time_ns)] = signal.values
        columns[SIGNALS[signal.name].column] = pl.Series(values, nan_to_null=True)
    return pl.DataFrame(columns)


def _file_name(signals: Sequence[Signal], taken: set[str]) -> str:
    """A name that tells the rate and the group, safe on every file system."""
    period = usual_period_s(max((s.time_ns for s in signals), key=len))
    rate = f"{1 / period:.0f}hz" if period > 0 else "once"
    group = re.sub(r"[^A-Za-z0-9]+", "_", signals[0].group).strip("_").lower()[:60]
    base = f"{group}_{rate}" if group else rate
    name, number = base, 2
    while name in taken:
        name, number = f"{base}_{number}", number + 1
    taken.add(name)
    return f"{name}.parquet"


def record_dict(record: ImportRecord) -> dict[str, object]:
    """The import record as JSON can hold it."""
    return {**asdict(record), "paths": [str(path) for path in record.paths]}


def write_drive(drive: Drive, folder: Path) -> list[Path]:
    """Write a drive as Parquet files and its import record; the files written. Raises LogError where it cannot."""
    written: list[Path] = []
    taken: set[str] = set()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for signals in rate_groups(list(drive.signals.values())):
            path = folder / _file_name(signals, taken)
            group_frame(signals).write_parquet(path, compression="zstd")
            written.append(path)
        record = folder / RECORD_FILE
        record.write_text(
            json.dumps(record_dict(drive.record), indent=1, ensure_ascii=False), encoding="utf-8"
        )
    except OSError as error:
        raise LogError(f"cannot be written ({error.strerror or error})", path=folder) from error
    return [*written, record]
