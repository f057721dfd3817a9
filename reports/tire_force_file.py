"""tyre_normal_forces.parquet: the four tyre normal forces of a drive for other programs."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parsers.signals import WHEELS
from pipelines.drive_results import DriveResults
from pipelines.tire_forces import forces_of
from reports.files import remove_old, write_whole

FILE_NAME = "tire_normal_forces.parquet"


def tire_force_bytes(results: DriveResults) -> bytes | None:
    """A table of time_ns (from the drive's start) and value, low, high of each wheel in N; rows in gaps are left out.

    Columns: tire_normal_force_fl_n, …_fl_low_n, …_fl_high_n. None where no estimator gave the forces.
    """
    import polars as pl

    found = [forces for estimate in results.estimates if (forces := forces_of(estimate)) is not None]
    if not found:
        return None
    forces = found[0]
    there = np.all([np.isfinite(forces.value[w]) for w in WHEELS], axis=0)
    columns: dict[str, NDArray[Any]] = {"time_ns": np.round(forces.time_s[there] * 1e9).astype(np.int64)}
    for wheel in WHEELS:
        columns[f"tire_normal_force_{wheel}_n"] = forces.value[wheel][there]
        columns[f"tire_normal_force_{wheel}_low_n"] = forces.low[wheel][there]
        columns[f"tire_normal_force_{wheel}_high_n"] = forces.high[wheel][there]
    content = io.BytesIO()
    pl.DataFrame(columns).write_parquet(content)
    return content.getvalue()


def write_tire_forces(results: DriveResults, out: Path) -> Path | None:
    """Write the forces (`tire_force_bytes`): the file's path, or None where there are none: a file of an earlier run is
    taken away then. Raises ReportError."""
    path = out / FILE_NAME
    content = tire_force_bytes(results)
    if content is None:
        remove_old(path)
        return None
    write_whole(path, content)
    return path
