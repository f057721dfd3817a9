"""Drives that lie on tapes in memory, with faults or without, and converted both ways."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import polars as pl

from parsers.channels import ChannelInfo, Chunk
from parsers.convert import Converted, convert_logs
from parsers.intake import Budget
from parsers.load import LoadOptions, load_drive
from parsers.store import write_drive
from parsers.store_folder import RECORD_FILE
from parsers.timebase import JUMP_AHEAD_NS, NS

UNITS = {
    "accel_x": "m/s^2", "accel_y": "m/s^2", "accel_z": "m/s^2", "yaw_rate": "rad/s", "roll_rate": "rad/s", "roll": "rad",
    "speed": "m/s", "steering_wheel_angle": "rad", "latitude": "deg", "longitude": "deg", "brake_pressure": "Pa",
}  # fmt: skip
GROUPS = {
    "/imu": ("accel_x", "accel_y", "accel_z", "yaw_rate", "roll_rate"),
    "/odom": ("speed", "steering_wheel_angle"),
    "/gps": ("latitude", "longitude"),
    "/body": ("roll", "brake_pressure"),
}
PERIODS_MS = {"/imu": 10, "/odom": 20, "/gps": 200, "/body": 50}
SMALL = {"rows": 20_000, "pending": 6_000, "window": 30_000, "evidence": 1 << 40, "evidence_s": 1e9}
Rows = dict[str, tuple[np.ndarray, dict[str, np.ndarray]]]


class Tape:
    """A log in memory that gives its groups in turn, a second or so at a time."""

    name, title, suffixes = "tape", "Tape", (".tape",)
    clock, start_utc_ns, absolute = "the tape's clock", None, True

    def __init__(self, rows: Rows, chunk: int = 100) -> None:
        self.rows, self.chunk = rows, chunk
        self.channels = tuple(
            ChannelInfo(name, group, UNITS[name], "table")
            for group, (_, held) in rows.items()
            for name in held
        )

    def claims(self, path: Path, head: bytes) -> bool:
        return True

    def open(self, path: Path, options: object, log: object) -> Tape:
        self.log = log
        return self

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        for at in range(0, max(len(t) for t, _ in self.rows.values()), self.chunk):
            for group, (time_ns, columns) in self.rows.items():
                part = slice(at, at + self.chunk)
                self.log.messages += len(time_ns[part])
                yield Chunk(group, time_ns[part], {n: v[part] for n, v in columns.items() if n in wanted})


def drive(seconds: float = 240, start_s: float = 1e9, seed: int = 1) -> Rows:
    """A drive that bends to and fro, stops now and then, and is seen by four recorders of different rates."""
    rng = np.random.default_rng(seed)
    rows: Rows = {}
    for group, names in GROUPS.items():
        n = round(seconds * 1000 / PERIODS_MS[group])
        t = np.arange(n) * PERIODS_MS[group] / 1000
        speed = 12 + 6 * np.sin(t / 11)
        turn = 0.25 * np.sin(t / 3.1)
        heading = -0.775 * np.cos(t / 3.1)
        lateral = turn * speed
        true = {
            "accel_x": 6 / 11 * np.cos(t / 11),
            "accel_y": lateral,
            "accel_z": np.full(n, 9.81),
            "yaw_rate": turn,
            "roll_rate": np.gradient(0.03 * lateral / 9.81 * 6, t),
            "roll": 0.03 * lateral / 9.81 * 6,
            "speed": speed,
            "steering_wheel_angle": 40 * turn / speed,
            "latitude": 48 + np.cumsum(speed * np.cos(heading)) * PERIODS_MS[group] / 1e3 / 111_195,
            "longitude": 9 + np.cumsum(-speed * np.sin(heading)) * PERIODS_MS[group] / 1e3 / 74_400,
            "brake_pressure": 1e6 * (np.sin(t / 11) < -0.9),
        }
        noise = {name: 0.01 * np.std(true[name]) * rng.standard_normal(n) for name in names}
        for name in ("latitude", "longitude", "brake_pressure"):
            noise[name if name in names else names[0]] = np.zeros(n)
        time_ns = round(start_s * NS) + np.arange(n) * PERIODS_MS[group] * 1_000_000
        rows[group] = (time_ns, {name: true[name] + noise[name] for name in names})
    return rows


def with_faults(rows: Rows) -> Rows:
    """Late rows, duplicates, a clock that is set, gaps, missing values, spikes and codes everywhere, wrong signs and units."""
    rng = np.random.default_rng(9)
    for group, (time_ns, columns) in rows.items():
        n = len(time_ns)
        for name, values in columns.items():
            size = {"accel_z": 10.0, "yaw_rate": 4.0, "speed": 25.0, "steering_wheel_angle": 20.0}.get(name)
            for at in range(40, n - 10, 3 * PERIODS_MS[group] + 331 if size else n):
                if size:
                    values[at : at + 1 + at % 5] += size if at % 2 else -size / 2
            values[rng.integers(0, n, n // 200)] = np.nan
        if group == "/odom":
            columns["speed"][100:n:333] = 255.996 / 3.6
            columns["speed"][5000:5040] = 255.996 / 3.6
        if group == "/imu":
            columns["yaw_rate"] *= -1
            for name in ("accel_x", "accel_y", "accel_z"):
                columns[name] /= 9.80665
            columns["accel_x"][7] = 1e6
            time_ns[15_000:15_200] += 3 * JUMP_AHEAD_NS
        late = rng.integers(30, n - 30, n // 50)
        time_ns[late] -= rng.integers(1, 20, len(late)) * 1_000_000
        time_ns[n // 3] = time_ns[n // 3 - 1]
        keep = np.ones(n, dtype=np.bool_)
        keep[n // 2 : n // 2 + n // 50] = False
        order = np.arange(n)
        order[200:220] = order[200:220][::-1]
        rows[group] = (time_ns[order][keep], {name: v[order][keep] for name, v in columns.items()})
    return rows


def tables(folder: Path) -> dict[str, pl.DataFrame]:
    return {path.name: pl.read_parquet(path) for path in folder.glob("*.parquet")}


def record(folder: Path) -> dict[str, object]:
    return dict(json.loads((folder / RECORD_FILE).read_text(encoding="utf-8")))


def both(
    paths: list[Path], folder: Path, *, fix: bool = True, **budget: float
) -> tuple[Converted, list[str]]:
    """Convert in memory and through the disk, require the same of both; the notes that only the second has."""
    options = LoadOptions(fix=fix)
    write_drive(load_drive(paths, options), folder / "whole")
    small = Budget(folder / "long", **(SMALL | budget))
    converted = convert_logs(paths, options, folder / "long", small)
    expected, found = tables(folder / "whole"), tables(folder / "long")
    assert sorted(expected) == sorted(found)
    for name, table in expected.items():
        assert found[name].schema == table.schema
        assert found[name].equals(table, null_equal=True), name
    a, b = record(folder / "whole"), record(folder / "long")
    extra = [note for note in b["notes"] if note not in a["notes"]]
    b["notes"] = [note for note in b["notes"] if note in a["notes"]]
    assert a == b
    assert converted.signals == sum(table.width - 1 for table in expected.values())
    assert not [path for path in (folder / "long").iterdir() if path.suffix not in (".parquet", ".json")]
    return converted, extra
