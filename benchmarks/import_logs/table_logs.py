"""Tables of a drive: CSV and VBO at 100 Hz with 20 channels; MF4 bus logging of the CAN frames."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import polars as pl
from asammdf import MDF, Signal
from asammdf.blocks.source_utils import Source

from benchmarks.import_logs.can_logs import Frames

CHANNELS = tuple(f"channel{k}" for k in range(20))


def write_csv(seconds: float, seed: int, path: Path) -> None:
    """A comma separated table."""
    rng = np.random.default_rng(seed)
    n = round(seconds * 100)
    columns = {"time_s": np.arange(n) / 100} | {name: rng.standard_normal(n).round(6) for name in CHANNELS}
    pl.DataFrame(columns).write_csv(path)


def write_vbo(seconds: float, seed: int, path: Path) -> None:
    """A VBOX file."""
    rng = np.random.default_rng(seed)
    n = round(seconds * 100)
    clock = 3600 + np.arange(n) / 100
    hhmmss = clock // 3600 * 10000 + clock % 3600 // 60 * 100 + clock % 60
    head = [
        "File created on 09/10/2025 @ 08:53",
        "",
        "[header]",
        "satellites",
        "time",
        *CHANNELS,
        "",
        "[channel units]",
    ]
    head += [
        *("g" for _ in CHANNELS),
        "",
        "[column names]",
        " ".join(["sats", "time", *CHANNELS]),
        "",
        "[data]",
        "",
    ]
    frame = pl.DataFrame(
        {"sats": pl.Series(["012"] * n), "time": [f"{v:09.2f}" for v in hhmmss]}
        | {name: rng.standard_normal(n).round(6) for name in CHANNELS}
    )
    with path.open("wb") as file:
        file.write("\r\n".join(head).encode("latin-1"))
        file.write(frame.write_csv(include_header=False, separator=" ", line_terminator="\r\n").encode())


def write_mf4(frames: Frames, path: Path, compression: int) -> None:
    """The CAN_DataFrame structure; compression 0 none, 1 deflate, 2 transposed and deflated."""
    kinds = ("BusChannel", "<u1"), ("ID", "<u4"), ("IDE", "<u1"), ("DLC", "<u1"), ("DataLength", "<u1")
    dtype = np.dtype([*((f"CAN_DataFrame.{a}", b) for a, b in kinds), ("CAN_DataFrame.DataBytes", "(8,)u1")])
    table = np.zeros(len(frames.time_ns), dtype=dtype)
    table["CAN_DataFrame.BusChannel"], table["CAN_DataFrame.ID"] = 1, frames.can_id
    table["CAN_DataFrame.DLC"] = table["CAN_DataFrame.DataLength"] = 8
    table["CAN_DataFrame.DataBytes"] = frames.data
    source = Source(
        name="CAN", path="CAN1", comment="", source_type=Source.SOURCE_BUS, bus_type=Source.BUS_TYPE_CAN
    )
    with MDF(version="4.10") as mdf:
        mdf.start_time = datetime(2025, 10, 9, 8, 53, 20, tzinfo=UTC)
        signal = Signal(table, frames.time_ns / 1e9, name="CAN_DataFrame", source=source)
        mdf.append(signal, acq_source=source)
        mdf.save(path, overwrite=True, compression=compression)
