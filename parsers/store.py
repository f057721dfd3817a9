"""The columnar store of a drive: Parquet, one file a rate group, with `time_ns` and the signals' columns."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import polars as pl

from parsers.drive import Drive, ImportRecord, Signal
from parsers.errors import LogError
from parsers.signals import SIGNALS
from parsers.timebase import usual_period_s

RECORD_FILE = "import_record.json"
SUFFIX = ".parquet"


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
    return f"{name}{SUFFIX}"


def record_dict(record: ImportRecord) -> dict[str, object]:
    """The import record as JSON can hold it."""
    return {**asdict(record), "paths": [str(path) for path in record.paths]}


def _previous(folder: Path) -> set[Path]:
    """The tables that an earlier run wrote here, by the record that it left. Names only: a record leads nowhere else."""
    try:
        names = json.loads((folder / RECORD_FILE).read_text(encoding="utf-8")).get("files", [])
    except (OSError, ValueError, AttributeError, RecursionError):
        return set()
    texts = [name for name in names if isinstance(name, str)] if isinstance(names, list) else []
    return {folder / name for name in texts if name == Path(name).name and name.endswith(SUFFIX)}


def _refuse_strangers(folder: Path, ours: set[Path]) -> None:
    """Raise LogError where tables of others lie in the folder: it would no longer read as one drive."""
    strangers = sorted(
        p.name for p in folder.iterdir() if p.suffix.lower() in (SUFFIX, ".pq") and p not in ours
    )
    if strangers:
        raise LogError(
            f"holds Parquet files that `cogest convert` did not write ({', '.join(strangers[:3])})",
            path=folder,
            hint="choose an empty folder with --out: all tables of a folder are read as one drive",
        )


def _write_record(record: ImportRecord, folder: Path, files: Collection[str]) -> Path:
    path = folder / RECORD_FILE
    text = json.dumps({"files": sorted(files), **record_dict(record)}, indent=1, ensure_ascii=False)
    # the name of a log may hold bytes that are no text
    path.write_bytes(text.encode("utf-8", "replace"))
    return path


def write_drive(drive: Drive, folder: Path) -> list[Path]:
    """Write a drive as Parquet files and its import record; the files written.

    The files take the place of those that an earlier run wrote into the folder; until all are made, nothing there
    changes. Raises LogError where they cannot be written, or where the folder holds tables of others.
    """
    made: dict[Path, Path] = {}
    taken: set[str] = set()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        ours = _previous(folder)
        _refuse_strangers(folder, ours)
        try:
            for signals in rate_groups(list(drive.signals.values())):
                path = folder / _file_name(signals, taken)
                made[path] = folder / f".{path.name}.part"
                group_frame(signals).write_parquet(made[path], compression="zstd")
            # a run that is killed in the middle still leaves a record of all that it may have written
            _write_record(drive.record, folder, {path.name for path in ours | made.keys()})
            for stale in ours - made.keys():
                stale.unlink(missing_ok=True)
            for path, part in made.items():
                part.replace(path)
        finally:
            for part in made.values():
                part.unlink(missing_ok=True)
        record = _write_record(drive.record, folder, {path.name for path in made})
    except (OSError, pl.exceptions.PolarsError) as error:
        reason = getattr(error, "strerror", None) or str(error).partition("\n")[0]
        raise LogError(
            f"cannot be written ({reason})", path=folder, hint="choose another folder with --out"
        ) from error
    return [*made, record]
