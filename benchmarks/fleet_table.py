"""A fleet table of 100 000 drives: what questions to it cost, through polars, DuckDB and `cogest results`.

    python benchmarks/fleet_table.py [--drives 100000] [--vehicles 500] [--save]

The store holds made-up results, written by the code that writes every store's tables; nothing is analysed. Each question is
asked several times, from the file on: nothing is kept in memory between two. Exit code 1 where one takes a second or more.
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import numpy as np
import polars as pl

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from pipelines.fleet.store import open_store  # noqa: E402
from pipelines.fleet.tables import TABLES  # noqa: E402
from pipelines.parameters import PARAMETERS  # noqa: E402

PROGRAM = Path(sys.executable).parent / "cogest"
LIMIT_S, ROUNDS, SEED = 1.0, 5, 20261121
EXPORT = "all drives as CSV (no question)"
FAILURES = {
    "done": 0.97,
    "error": 0.02,
    "timeout": 0.006,
    "crashed": 0.003,
    "memory": 0.001,
}


def _of(name: str, columns: dict[str, object]) -> pl.DataFrame:
    """A table with the store's columns and types; those that are not given are null."""
    whole = pl.DataFrame(columns)
    return whole.select(
        (pl.col(c) if c in columns else pl.lit(None)).cast(kind).alias(c) for c, kind in TABLES[name].items()
    )


def drives_table(number: int, vehicles: int, rng: np.random.Generator) -> pl.DataFrame:
    """Drives over two years, in the order of a store: by vehicle, start and name."""
    vehicle = np.sort(rng.integers(0, vehicles, number))
    start = np.sort(rng.integers(1_700_000_000, 1_763_000_000, number)).astype("datetime64[s]")
    start = start[rng.permutation(number)]
    order = np.lexsort((start, vehicle))
    vehicle, start = vehicle[order], start[order]
    status = rng.choice(list(FAILURES), number, p=list(FAILURES.values()))
    ok = status == "done"
    margin = np.where(ok, 0.75 - 0.6 * rng.beta(2, 3, number), np.nan)
    ids = [
        f"v{v:04d}-{k:06d}-{h:010x}"
        for k, (v, h) in enumerate(zip(vehicle, rng.integers(0, 2**40, number), strict=True))
    ]
    names = [
        f"v{v:04d}/{s}.mcap" for v, s in zip(vehicle, np.datetime_as_string(start, unit="m"), strict=True)
    ]
    sha = [f"{a:016x}{b:016x}{c:016x}{d:016x}" for a, b, c, d in rng.integers(0, 2**62, (number, 4))]
    frame = _of(
        "drives",
        {
            "drive_id": ids,
            "drive": names,
            "vehicle_id": [f"v{v:04d}" for v in vehicle],
            "vehicle_name": [f"Van {v}" for v in vehicle],
            "status": status,
            "reason": np.where(ok, "", "no time channel: none of 24 columns goes on steadily"),
            "start_utc": [f"{s}Z" for s in np.datetime_as_string(start, unit="s")],
            "duration_s": rng.uniform(60, 7200, number).round(2),
            "format": ["MCAP"] * number,
            "import_status": np.where(ok, "complete", "malformed"),
            "log_bytes": rng.integers(10**5, 10**8, number),
            "logs": [[name] for name in names],
            "log_sha256": sha,
            "key": sha[::-1],
            "cogest": ["0.7.0"] * number,
            "static_stability_factor": rng.normal(1.3, 0.1, number),
            "rollover_threshold_g": rng.normal(1.1, 0.1, number),
            "least_margin_g": margin,
            "peak_lateral_acceleration_g": rng.uniform(0.2, 0.8, number),
            "peak_rollover_coefficient": rng.uniform(0.1, 0.9, number),
            "exceedance_probability": rng.uniform(0, 1e-3, number),
            "wheel_lifts": np.zeros(number, dtype=int),
            "notes": [[]] * number,
            "report": [f"drives/{i[-2:]}/{i}/report.html" for i in ids],
        },
    )
    return frame.with_columns(pl.col("least_margin_g").fill_nan(None))


def parameters_table(drives: pl.DataFrame, rng: np.random.Generator) -> pl.DataFrame:
    """Every parameter of every drive that is done, from the drive alone and with its vehicle's others."""
    done = drives.filter(pl.col("status") == "done").select("drive_id", "vehicle_id", "start_utc")
    kinds = pl.DataFrame({"parameter": list(PARAMETERS)}).join(
        pl.DataFrame({"source": ["drive", "fleet"]}), how="cross"
    )
    rows = done.join(kinds, how="cross")
    value, std = rng.normal(1.0, 0.1, rows.height), rng.uniform(0.01, 0.1, rows.height)
    columns = {name: rows[name] for name in rows.columns} | {
        "value": value,
        "std": std,
        "low": value - 1.96 * std,
        "high": value + 1.96 * std,
        "status": rng.choice(["identified", "weak", "not_identifiable"], rows.height),
        "reason": ["told by the load balance"] * rows.height,
        "prior": value + std,
        "prior_std": 2 * std,
    }
    return _of("parameters", columns)


def questions(store: Path, vehicle: str) -> list[tuple[str, str, Callable[[], object]]]:
    """(question, program, what asks it)."""
    import duckdb

    drives, parameters = store / "drives.parquet", store / "parameters.parquet"
    scan = pl.scan_parquet

    def sql(query: str) -> Callable[[], object]:
        return lambda: duckdb.sql(query.format(drives=f"'{drives}'", parameters=f"'{parameters}'")).fetchall()

    def shown(*options: str) -> Callable[[], object]:
        command = [str(PROGRAM), "results", str(store), *options]
        return lambda: subprocess.run(command, check=True, capture_output=True).stdout

    mine = pl.col("vehicle_id") == vehicle
    height = pl.col("parameter") == "cg_height_m"
    return [
        ("one vehicle's drives", "polars", lambda: scan(drives).filter(mine).collect()),
        ("one vehicle's drives", "DuckDB", sql("select * from {drives} where vehicle_id = '" + vehicle + "'")),
        ("one vehicle's drives", "cogest results", shown("--vehicle", vehicle, "--csv")),
        ("drives that failed", "polars", lambda: scan(drives).filter(pl.col("status") != "done").collect()),
        ("drives that failed", "DuckDB", sql("select * from {drives} where status <> 'done'")),
        ("drives that failed", "cogest results", shown("--status", "failed", "--csv")),
        ("drives and least margin by vehicle", "polars", lambda: scan(drives).group_by("vehicle_id").agg(pl.len(), pl.col("least_margin_g").min()).collect()),
        ("drives and least margin by vehicle", "DuckDB", sql("select vehicle_id, count(*), min(least_margin_g) from {drives} group by vehicle_id")),
        ("ten least margins", "polars", lambda: scan(drives).drop_nulls("least_margin_g").sort("least_margin_g").head(10).collect()),
        ("ten least margins", "DuckDB", sql("select * from {drives} where least_margin_g is not null order by least_margin_g limit 10")),
        ("CG height over time of one vehicle", "polars", lambda: scan(parameters).filter(mine & height).sort("start_utc").collect()),
        ("CG height over time of one vehicle", "DuckDB", sql("select * from {parameters} where vehicle_id = '" + vehicle + "' and parameter = 'cg_height_m' order by start_utc")),
        ("CG height over time of one vehicle", "cogest results", shown("--table", "parameters", "--vehicle", vehicle, "--parameter", "cg_height_m", "--csv")),
        ("mean CG height by vehicle", "polars", lambda: scan(parameters).filter(height).group_by("vehicle_id").agg(pl.col("value").mean()).collect()),
        ("mean CG height by vehicle", "DuckDB", sql("select vehicle_id, avg(value) from {parameters} where parameter = 'cg_height_m' group by vehicle_id")),
        ("overview of one vehicle", "cogest results", shown("--vehicle", vehicle)),
        (EXPORT, "cogest results", shown("--csv")),
    ]  # fmt: skip


def main() -> None:
    """Write the tables, ask, print; exit code 1 where a question takes too long."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--drives", type=int, default=100_000)
    parser.add_argument("--vehicles", type=int, default=500)
    parser.add_argument("--save", action="store_true")
    asked = parser.parse_args()
    rng = np.random.default_rng(SEED)
    with tempfile.TemporaryDirectory() as temporary:
        store = Path(temporary) / "store"
        opened = open_store(str(store), create=True)
        drives = drives_table(asked.drives, asked.vehicles, rng)
        parameters = parameters_table(drives, rng)
        began = time.perf_counter()
        opened.write_tables({"drives": drives, "parameters": parameters})
        wrote = time.perf_counter() - began
        sizes = {
            name: (store / f"{name}.parquet").stat().st_size / 2**20 for name in ("drives", "parameters")
        }
        rows = [
            f"drives.parquet {drives.height} rows, {sizes['drives']:.1f} MiB; parameters.parquet {parameters.height} rows, "
            f"{sizes['parameters']:.1f} MiB; written in {wrote:.1f} s",
            "",
            "| question | program | median s | longest s |",
            "| --- | --- | --- | --- |",
        ]
        worst = 0.0
        for question, program, ask in questions(store, f"v{asked.vehicles // 2:04d}"):
            times = []
            for _ in range(ROUNDS):
                began = time.perf_counter()
                ask()
                times.append(time.perf_counter() - began)
            if question != EXPORT:
                worst = max(worst, median(times))
            rows.append(f"| {question} | {program} | {median(times):.3f} | {max(times):.3f} |")
            print(rows[-1], file=sys.stderr, flush=True)
    head = f"`python benchmarks/fleet_table.py`: {asked.drives} drives of {asked.vehicles} vehicles; {platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"
    text = "\n".join(["# A fleet's tables", "", head, "", *rows, ""])
    print(text)
    if asked.save:
        results = ROOT / "benchmarks" / "results"
        results.mkdir(exist_ok=True)
        (results / "fleet_table.md").write_text(text, encoding="utf-8")
    sys.exit(worst >= LIMIT_S)


if __name__ == "__main__":
    main()
