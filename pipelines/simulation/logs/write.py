"""Simulated logs to files: CSV or Parquet with one row an instant, or a folder of Parquet tables, one a rate group."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import polars as pl

from parsers.channels import FloatArray, IntArray
from parsers.errors import LogError
from parsers.signals import SIGNALS
from parsers.store import write_drive
from parsers.store_folder import write_errors
from pipelines.simulation.logs.as_drive import drive_of
from pipelines.simulation.sensors.units import SensorLog

START_NS = 1_760_000_000_000_000_000
"""When every simulated drive began: 2025-10-09T08:53:20Z. No clock is read, so that a seed gives the same bytes."""

PARQUET = (".parquet", ".pq", "")
_BESIDE = (".parquet", ".pq", ".json", ".toml", ".md")
"""What may lie in a folder of tables."""

DECIMALS: Mapping[str, int] = {
    "acceleration": 6, "angular_rate": 8, "angle": 8, "slope": 8, "speed": 6, "geographic_angle": 10, "length": 7, "force": 3,
    "torque": 4, "pressure": 1, "count": 2, "ratio": 4,
}  # fmt: skip
"""Digits after the point in a CSV by quantity: far below any sensor's noise."""


def check_file(path: Path) -> None:
    """Raise LogError for a suffix that cannot be written."""
    if path.suffix.lower() not in (".csv", *PARQUET):
        raise LogError(
            f"a simulated log cannot be written as {path.suffix!r}",
            path=path,
            hint="choose .csv or .parquet, or a folder's name for one Parquet table a rate",
            wrong_usage=True,
        )


def write_log(log: SensorLog, path: Path) -> list[Path]:
    """Write a log by its suffix; what was made. A file is one table, with empty cells where rates differ; a name without
    a suffix is a folder of tables, one a rate group.

    Raises LogError where it cannot be written.
    """
    check_file(path)
    with write_errors(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix.lower() == ".csv":
            with _whole(path) as part:
                _table(log, rounded=True).write_csv(part)
            return [path]
        if path.suffix:
            _no_folder(path)
            frame = _table(log, rounded=False)
            absolute = (frame["time_ns"] + START_NS).alias("time_ns")
            with _whole(path) as part:
                frame.with_columns(absolute).write_parquet(part, compression="zstd")
            return [path]
    return _folder(log, path)


@contextmanager
def _whole(path: Path) -> Iterator[Path]:
    """A file beside `path` to write into; it takes that name once it is whole, and leaves nothing behind if it is not."""
    part = path.with_name(f".{path.name}.part")
    try:
        yield part
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def _no_folder(path: Path) -> None:
    """A folder of tables has this name: take it away, if it is ours."""
    if path.is_dir():
        from parsers.store_folder import refuse_strangers

        refuse_strangers(path)
        shutil.rmtree(path)


def _together(log: SensorLog) -> tuple[IntArray, dict[str, FloatArray]]:
    """Every column on the stamps of all groups, NaN where its own group has none."""
    time_ns = np.unique(np.concatenate([group.time_ns for group in log.groups]))
    columns: dict[str, FloatArray] = {}
    for group in log.groups:
        rows = np.searchsorted(time_ns, group.time_ns)
        for signal, values in group.columns.items():
            columns[signal] = np.full(len(time_ns), np.nan)
            columns[signal][rows] = values
    return time_ns, columns


def _table(log: SensorLog, *, rounded: bool) -> pl.DataFrame:
    time_ns, columns = _together(log)
    made = {}
    for name, spec in SIGNALS.items():
        if name not in columns:
            continue
        values = columns[name]
        if rounded:
            # adding 0 turns -0 into 0
            values = np.round(values, DECIMALS[spec.quantity]) + 0.0
        made[spec.column] = pl.Series(values, nan_to_null=True)
    # rows at which everything was lost hold nothing
    time = pl.Series("time_s", time_ns / 1e9) if rounded else pl.Series("time_ns", time_ns)
    frame = pl.DataFrame({time.name: time, **made})
    return frame.filter(pl.any_horizontal(pl.exclude(time.name).is_not_null()))


def _only_tables(path: Path) -> None:
    """Raise LogError where a folder holds files that would keep it from being read as one drive."""
    others = [
        p.name for p in path.iterdir() if p.suffix.lower() not in _BESIDE and not p.name.startswith(".")
    ]
    if others:
        raise LogError(
            f"holds other files ({', '.join(sorted(others)[:3])})", path=path, hint="choose an empty folder"
        )


def _folder(log: SensorLog, path: Path) -> list[Path]:
    if path.is_dir():
        _only_tables(path)
    elif path.is_file():
        path.unlink()
    return write_drive(drive_of(log, START_NS), path)


def write_truth(record: Mapping[str, object], path: Path) -> None:
    """Write a truth record as JSON. Raises LogError where it cannot be written."""
    with write_errors(path):
        path.write_text(json.dumps(record, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def write_vehicle(text: str, log: Path) -> Path:
    """Write a vehicle file beside a log: vehicle.toml, or <log's name>.vehicle.toml where another drive's is there.

    The first line tells whose it is, so that the same command again finds its own file. Raises LogError.
    """
    own = f"# for {log.name}, by cogest simulate"
    path = log.parent / "vehicle.toml"
    with write_errors(path):
        if path.exists() and not path.read_text(encoding="utf-8", errors="replace").startswith(own + "\n"):
            path = log.parent / f"{log.stem}.vehicle.toml"
        path.write_text(f"{own}\n{text}", encoding="utf-8")
    return path
