"""The tables of a store: their columns, in order. Written as Parquet, read by polars, DuckDB and pandas."""

from __future__ import annotations

from typing import get_args

import polars as pl

from pipelines.engines.base import TaskStatus
from pipelines.results import Identification

DRIVES: dict[str, pl.DataType] = {
    "drive_id": pl.String(),
    "drive": pl.String(),
    "vehicle_id": pl.String(),
    "vehicle_name": pl.String(),
    "status": pl.String(),
    "reason": pl.String(),
    "start_utc": pl.String(),
    "duration_s": pl.Float64(),
    "format": pl.String(),
    "import_status": pl.String(),
    "log_bytes": pl.Int64(),
    "logs": pl.List(pl.String()),
    "log_sha256": pl.String(),
    "key": pl.String(),
    "cogest": pl.String(),
    "static_stability_factor": pl.Float64(),
    "rollover_threshold_g": pl.Float64(),
    "least_margin_g": pl.Float64(),
    "peak_lateral_acceleration_g": pl.Float64(),
    "peak_rollover_coefficient": pl.Float64(),
    "exceedance_probability": pl.Float64(),
    "wheel_lifts": pl.Int64(),
    "notes": pl.List(pl.String()),
    "report": pl.String(),
    "gone": pl.Boolean(),
    "apart": pl.String(),
}
"""drives.parquet: one row a drive, failed ones too. status: "done" or as TaskStatus; reason: why not, in words. report: the
drive's HTML report below the store, null where none was asked for. gone: its logs are no longer in the folder. apart: why its vehicle's joined answers do not have it, as
`pipelines.hierarchy.records.Apart`; null where they do. Ordered by vehicle_id, start_utc, drive."""

PARAMETERS: dict[str, pl.DataType] = {
    "drive_id": pl.String(),
    "vehicle_id": pl.String(),
    "start_utc": pl.String(),
    "parameter": pl.String(),
    "source": pl.String(),
    "value": pl.Float64(),
    "std": pl.Float64(),
    "low": pl.Float64(),
    "high": pl.Float64(),
    "status": pl.String(),
    "reason": pl.String(),
    "prior": pl.Float64(),
    "prior_std": pl.Float64(),
    "reference": pl.Float64(),
}
"""parameters.parquet: a row a drive, parameter and source: "drive" = that drive's own verdict, "fleet" = with all drives of
its vehicle joined. value, std, low, high: null where nothing can be said."""

VEHICLES: dict[str, pl.DataType] = {
    "vehicle_id": pl.String(),
    "vehicle_name": pl.String(),
    "parameter": pl.String(),
    "title": pl.String(),
    "unit": pl.String(),
    "value": pl.Float64(),
    "std": pl.Float64(),
    "low": pl.Float64(),
    "high": pl.Float64(),
    "status": pl.String(),
    "reason": pl.String(),
    "prior": pl.Float64(),
    "prior_std": pl.Float64(),
    "single_std": pl.Float64(),
    "drives": pl.Int64(),
    "doubts": pl.List(pl.String()),
}
"""vehicles.parquet: a row a vehicle and a parameter that belongs to the vehicle whatever its load: what all drives say.
single_std: median spread of a single drive's answer. drives: how many joined. doubts: the vehicle's, the same in all its rows: which drives
were left out or widened, and what those that were joined say against their own figures."""

LOAD_CHANGES: dict[str, pl.DataType] = {
    "vehicle_id": pl.String(),
    "drive_id": pl.String(),
    "before": pl.String(),
    "start_utc": pl.String(),
    "detected": pl.Boolean(),
    "probability": pl.Float64(),
    "mass_change_kg": pl.Float64(),
    "mass_change_std_kg": pl.Float64(),
    "cg_height_change_m": pl.Float64(),
    "cg_height_change_std_m": pl.Float64(),
    "cg_to_front_axle_change_m": pl.Float64(),
    "cg_to_front_axle_change_std_m": pl.Float64(),
    "cg_lateral_change_m": pl.Float64(),
    "cg_lateral_change_std_m": pl.Float64(),
    "text": pl.String(),
}
"""load_changes.parquet: a row a drive that another of its vehicle went before. probability: of a difference as large by
chance if the load was the same; detected: below the stated false-alarm rate. Changes: this drive less `before`."""

TRENDS: dict[str, pl.DataType] = {
    "vehicle_id": pl.String(),
    "parameter": pl.String(),
    "title": pl.String(),
    "unit": pl.String(),
    "per_year": pl.Float64(),
    "std": pl.Float64(),
    "low": pl.Float64(),
    "high": pl.Float64(),
    "probability": pl.Float64(),
    "detected": pl.Boolean(),
    "from_utc": pl.String(),
    "to_utc": pl.String(),
    "drives": pl.Int64(),
    "text": pl.String(),
}
"""trends.parquet: a row a vehicle and a part that wears (springs, dampers): change a year with its 95 % interval."""

OUTLIERS: dict[str, pl.DataType] = {
    "rank": pl.Int64(),
    "vehicle_id": pl.String(),
    "vehicle_name": pl.String(),
    "score": pl.Float64(),
    "probability": pl.Float64(),
    "parameter": pl.String(),
    "value": pl.Float64(),
    "others": pl.Float64(),
    "others_std": pl.Float64(),
    "text": pl.String(),
}
"""outliers.parquet: every vehicle that can be compared, the farthest from the others (of its kind) first."""

TABLES: dict[str, dict[str, pl.DataType]] = {
    "drives": DRIVES,
    "parameters": PARAMETERS,
    "vehicles": VEHICLES,
    "load_changes": LOAD_CHANGES,
    "trends": TRENDS,
    "outliers": OUTLIERS,
}
"""File name without suffix -> columns."""

STATUSES: dict[str, tuple[str, ...]] = {
    "drives": get_args(TaskStatus),
    "parameters": get_args(Identification),
    "vehicles": get_args(Identification),
}
"""Table -> what may stand in its column `status`; the others have no such column."""


def table(name: str, rows: list[dict[str, object]]) -> pl.DataFrame:
    """Rows as a table with exactly the columns of `TABLES[name]`; what a row lacks is null."""
    return pl.DataFrame(rows, schema=TABLES[name], orient="row", strict=True)
