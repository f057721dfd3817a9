"""A fleet of many short drives, quickly: a few are simulated, the others are copies with their own time and their own noise.

python benchmarks/short_drives.py FOLDER [--drives 1000] [--vehicles 8] [--seconds 60] [--seed 0]

Every vehicle has a folder and a format: CSV, Parquet, MCAP (JSON messages), BLF with its database. Each drive's log differs
from all others (other stamps, and noise far below the sensors' own), so that nothing can be taken for a copy.
"""

from __future__ import annotations

import argparse
import json
import struct
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import polars as pl

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from parsers.signals import SIGNALS  # noqa: E402
from pipelines.simulation.logs.drive import Choice, default_mount, preset, simulate_log  # noqa: E402
from pipelines.simulation.logs.loads import parse_load  # noqa: E402
from pipelines.simulation.logs.vehicle import data_sheet  # noqa: E402
from pipelines.simulation.manoeuvres.base import Options  # noqa: E402
from sample_logs.writers import can  # noqa: E402
from sample_logs.writers.common import SampleDrive, on_one_clock, one_clock_sensors  # noqa: E402

PRESETS = ("suv", "sedan", "van", "truck")
FORMATS = ("csv", "parquet", "mcap", "blf")
LOADS = ("seats:75", "seats:225")
FIRST = datetime(2025, 1, 6, 7, tzinfo=UTC)
NOISE = 1e-5
"""Of the noise that makes a copy's samples its own, as a share of each signal's spread."""

_SYSTEMTIME = 40
"""Where a BLF's header says when the recording began: year, month, weekday, day, hour, minute, second, millisecond."""


@dataclass(frozen=True)
class Template:
    """One simulated drive. blf: its frames in a file, for all copies alike but for the header."""

    drive: SampleDrive
    blf: bytes = b""


def _noisy(drive: SampleDrive, rng: np.random.Generator) -> dict[str, np.ndarray]:
    return {
        name: values + NOISE * (values.std() + 1e-9) * rng.standard_normal(values.size)
        for name, values in drive.signals.items()
    }


def _csv(template: Template, path: Path, start: datetime, rng: np.random.Generator) -> None:
    columns = {"time_s": template.drive.time_s.round(4)}
    columns |= {SIGNALS[name].column: v.round(7) for name, v in _noisy(template.drive, rng).items()}
    pl.DataFrame(columns).write_csv(path)


def _stamps(template: Template, start: datetime) -> np.ndarray:
    return int(start.timestamp()) * 10**9 + np.round(template.drive.time_s * 1e9).astype(np.int64)


def _parquet(template: Template, path: Path, start: datetime, rng: np.random.Generator) -> None:
    columns = {SIGNALS[name].column: v for name, v in _noisy(template.drive, rng).items()}
    pl.DataFrame({"time_ns": _stamps(template, start), **columns}).write_parquet(path, compression="zstd")


def _mcap(template: Template, path: Path, start: datetime, rng: np.random.Generator) -> None:
    from mcap.writer import CompressionType, Writer

    columns = {name: v.round(7).tolist() for name, v in _noisy(template.drive, rng).items()}
    kinds = {
        "timestamp": {"type": "object", "properties": {k: {"type": "integer"} for k in ("sec", "nsec")}}
    } | {name: {"type": "number"} for name in columns}
    schema = {"type": "object", "properties": kinds}
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.LZ4)
        writer.start(library="cogest benchmark")
        number = writer.register_schema("vehicle.State", "jsonschema", json.dumps(schema).encode())
        channel = writer.register_channel("/vehicle", "json", number)
        for place, stamp in enumerate(_stamps(template, start).tolist()):
            sec, nsec = divmod(stamp, 10**9)
            body = {"timestamp": {"sec": sec, "nsec": nsec}}
            body |= {name: values[place] for name, values in columns.items()}
            writer.add_message(channel, stamp, json.dumps(body).encode(), stamp, place)
        writer.finish()


def _blf(template: Template, path: Path, start: datetime, rng: np.random.Generator) -> None:
    head = bytearray(template.blf)
    moment = start + timedelta(milliseconds=int(rng.integers(1000)))
    struct.pack_into(
        "<8H", head, _SYSTEMTIME, moment.year, moment.month, moment.isoweekday() % 7, moment.day, moment.hour,
        moment.minute, moment.second, moment.microsecond // 1000,
    )  # fmt: skip
    path.write_bytes(bytes(head))


WRITERS: dict[str, Callable[[Template, Path, datetime, np.random.Generator], None]] = {
    "csv": _csv,
    "parquet": _parquet,
    "mcap": _mcap,
    "blf": _blf,
}


def simulate(kind: str, form: str, load: str, seconds: float, rate_hz: float, seed: int) -> Template:
    """One drive of a preset; what its format needs of it."""
    vehicle = preset(kind)
    choice = Choice(
        "mixed_minute",
        vehicle,
        loads=tuple(parse_load(load, vehicle)),
        options=Options(duration_s=seconds),
        sensors=one_clock_sensors(default_mount(vehicle), rate_hz),
        seed=seed,
    )
    template = Template(on_one_clock(simulate_log(choice).log))
    if form != "blf":
        return template
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "one.blf"
        can.write_with_python_can(can.frames(template.drive), path)
        return replace(template, blf=path.read_bytes())


def write_short_drives(
    root: Path, drives: int, vehicles: int = 8, seconds: float = 60.0, rate_hz: float = 50.0, seed: int = 0
) -> Iterator[Path]:
    """Write the fleet below `root`, and give each log's path as it is written. BLF copies differ by their start alone."""
    rng = np.random.default_rng(seed)
    templates: list[list[Template]] = []
    folders: list[Path] = []
    for number in range(vehicles):
        kind, form = PRESETS[(number + number // len(PRESETS)) % len(PRESETS)], FORMATS[number % len(FORMATS)]
        folder = root / f"{kind}_{number + 1}"
        folder.mkdir(parents=True, exist_ok=True)
        vehicle = preset(kind)
        sheet = data_sheet(vehicle, default_mount(vehicle), np.random.default_rng([seed, number]))
        (folder / "vehicle.toml").write_text(sheet, encoding="utf-8")
        if form == "blf":
            (folder / "map.toml").write_text(can.MAP, encoding="utf-8")
            (folder / "chassis.dbc").write_text(can.DBC, encoding="utf-8")
        folders.append(folder)
        templates.append(
            [
                simulate(kind, form, load, seconds, rate_hz, seed + 10 * number + k)
                for k, load in enumerate(LOADS)
            ]
        )
    for place in range(drives):
        number, turn = place % vehicles, place // vehicles
        start = FIRST + timedelta(hours=5 * turn, minutes=number)
        form = FORMATS[number % len(FORMATS)]
        path = folders[number] / f"{start:%Y-%m-%dT%H-%M}.{form}"
        WRITERS[form](templates[number][turn % len(LOADS)], path, start, rng)
        yield path


def main() -> None:
    """Write a fleet and say how large it is."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--drives", type=int, default=1000)
    parser.add_argument("--vehicles", type=int, default=8)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--rate", type=float, default=50.0)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    made = write_short_drives(
        asked.folder, asked.drives, asked.vehicles, asked.seconds, asked.rate, asked.seed
    )
    sizes = [path.stat().st_size for path in made]
    print(f"{len(sizes)} drives, {sum(sizes) / 2**20:.1f} MiB")


if __name__ == "__main__":
    main()
