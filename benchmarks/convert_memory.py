"""Memory of `cogest convert` on logs of growing length: what a run needs over the imports, as a table.

    python benchmarks/convert_memory.py [--minutes 600,2400] [--formats blf,csv] [--save]

Makes the logs (a seed, deterministic) one after the other, converts each in a fresh process, and prints how far the process
grew beyond what it had after the imports and a first log of two seconds.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import deflate
import numpy as np
import polars as pl

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from benchmarks.import_logs.memory import peak_mib  # noqa: E402

SEED = 20261121
LIMIT_MIB = 256
CONTAINER = 128 * 1024
FRAMES_PER_SECOND = 2111
KNOWN, OTHERS = 12, 28
SIGNALS = tuple((m, k) for m in range(KNOWN) for k in range(3 if m < 8 else 2))
NAMES = (
    "accel_x", "accel_y", "accel_z", "roll_rate", "pitch_rate", "yaw_rate", "roll", "pitch", "speed", "gps_speed_2d",
    "wheel_speed_fl", "wheel_speed_fr", "wheel_speed_rl", "wheel_speed_rr", "steering_wheel_angle", "brake_pressure",
    "accel_z_sprung_fl", "accel_z_sprung_fr", "accel_z_sprung_rl", "accel_z_sprung_rr",
    "suspension_deflection_fl", "suspension_deflection_fr", "suspension_deflection_rl", "suspension_deflection_rr",
    "suspension_force_fl", "suspension_force_fr", "suspension_force_rl", "suspension_force_rr",
    "axle_load_front", "axle_load_rear", "road_grade", "drive_torque",
)  # fmt: skip
_OBJECT = np.dtype(
    [
        ("sig", "S4"), ("hs", "<u2"), ("hv", "<u2"), ("size", "<u4"), ("kind", "<u4"), ("flags", "<u4"),
        ("client", "<u2"), ("version", "<u2"), ("time", "<u8"), ("bus", "<u2"), ("f", "u1"), ("dlc", "u1"),
        ("id", "<u4"), ("data", "u1", (8,)),
    ]
)  # fmt: skip


def write_settings(folder: Path) -> None:
    """The CAN database, and mapping files that give each channel a signal whose range its values keep."""
    from parsers.signals import SIGNALS as SPECS
    from parsers.units import SI_TEXT

    lines = ['VERSION ""', "", "NS_ :", "", "BS_:", "", "BU_: X", ""]
    for number in range(KNOWN):
        lines.append(f"BO_ {256 + number} Message{number}: 8 X")
        lines += [
            f' SG_ Signal{k} : {16 * k}|16@1- (0.00003,0) [-1|1] "" X' for m, k in SIGNALS if m == number
        ]
        lines.append("")
    (folder / "bench.dbc").write_text("\n".join(lines), encoding="ascii")
    for form, channels in (
        ("blf", [f"Message{m}.Signal{k}" for m, k in SIGNALS]),
        ("csv", [f"channel{number}" for number in range(len(NAMES))]),
    ):
        text = []
        for name, channel in zip(NAMES, channels, strict=True):
            spec = SPECS[name]
            reach = min(spec.high, -spec.low) if spec.low < 0 else spec.high / 2
            shift = 0.0 if spec.low < 0 else spec.high / 2
            text.append(f'[signals.{name}]\nchannel = "{channel}"\nunit = "{SI_TEXT[spec.quantity]}"')
            text.append(f"scale = {0.2 * reach}\noffset = {shift}\n")
        (folder / f"{form}.toml").write_text("\n".join(text), encoding="utf-8")


def smooth(n: int, start: int, count: int, rate: float) -> np.ndarray:
    """(n, count) values in -1 to 1 that bend slowly, the same wherever a block begins."""
    t = (start + np.arange(n))[:, None] / rate
    return np.sin(t / (2 + np.arange(count)) + np.arange(count))


def write_blf(path: Path, minutes: float) -> None:
    """CAN_MESSAGE objects in compressed containers, minute by minute."""
    rng = np.random.default_rng(SEED)
    per_minute = 60 * FRAMES_PER_SECOND
    total, raw_size = round(minutes * per_minute), 0
    with path.open("wb") as file:
        file.write(bytes(144))
        for start in range(0, total, per_minute):
            n = min(per_minute, total - start)
            objects = np.zeros(n, dtype=_OBJECT)
            objects["sig"], objects["hs"], objects["hv"] = b"LOBJ", 32, 1
            objects["size"], objects["kind"], objects["flags"] = _OBJECT.itemsize, 1, 2
            objects["bus"], objects["dlc"] = 1, 8
            objects["time"] = (start + np.arange(n)) * (10**9 // FRAMES_PER_SECOND)
            number = rng.integers(0, KNOWN, n)
            known = rng.random(n) < 0.3
            objects["id"] = np.where(known, 256 + number, 1024 + rng.integers(0, OTHERS, n))
            values = smooth(n, start, 3, FRAMES_PER_SECOND) * 30_000 + rng.integers(-300, 300, (n, 3))
            objects["data"][:, :6] = values.astype("<i2").view(np.uint8).reshape(n, 6)
            raw = objects.tobytes()
            raw_size += len(raw)
            for at in range(0, len(raw), CONTAINER):
                part = raw[at : at + CONTAINER]
                packed = deflate.zlib_compress(part, 1)
                file.write(b"LOBJ" + struct.pack("<HHII", 16, 1, 32 + len(packed), 10))
                file.write(
                    struct.pack("<HxxxxxxIxxxx", 2, len(part)) + packed + bytes((32 + len(packed)) % 4)
                )
        head = bytearray(144)
        struct.pack_into("<4sI", head, 0, b"LOGG", 144)
        struct.pack_into("<QQII", head, 16, file.tell(), 144 + raw_size, total, 0)
        struct.pack_into("<8H", head, 40, 2025, 10, 4, 9, 8, 53, 20, 0)
        struct.pack_into("<8H", head, 56, 2025, 10, 4, 9, 9, 23, 20, 0)
        file.seek(0)
        file.write(head)


def write_csv(path: Path, minutes: float) -> None:
    """One table at 75 Hz with all channels, minute by minute."""
    rng = np.random.default_rng(SEED)
    rate = 75
    total = round(minutes * 60 * rate)
    with path.open("wb") as file:
        for start in range(0, total, 60 * rate):
            n = min(60 * rate, total - start)
            values = smooth(n, start, len(NAMES), rate) + 0.01 * rng.standard_normal((n, len(NAMES)))
            columns = {"time_s": (start + np.arange(n)) / rate}
            columns |= {f"channel{k}": values[:, k].round(5) for k in range(len(NAMES))}
            pl.DataFrame(columns).write_csv(file, include_header=start == 0)


WRITERS = {"blf": write_blf, "csv": write_csv}
MINUTES = {"blf": (640.0, 2560.0), "csv": (440.0, 1760.0)}
"""Lengths whose wanted columns are ten and forty times what is kept in memory."""


def child(form: str, log: Path, small: Path, folder: Path) -> None:
    """What runs in the fresh process: the imports and a small log, then the log that is measured."""
    from parsers.convert import convert_logs
    from parsers.load import LoadOptions
    from parsers.mapping import read_map

    options = LoadOptions(read_map(folder / f"{form}.toml"), (folder / "bench.dbc",) if form == "blf" else ())
    convert_logs([small], options, folder / "small_out")
    peak, before = peak_mib(), resource.getrusage(resource.RUSAGE_SELF)
    start = time.perf_counter()
    found = convert_logs([log], options, folder / "out")
    wall = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_SELF)
    values = sum(entry.samples for entry in found.record.mapped)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    grown = peak_mib() - peak
    print(json.dumps({"values": values, "grown_mib": grown, "wall_s": wall, "cpu_s": cpu}))


def main() -> None:
    """Run and print the table; exit code 1 where a run grew by more than LIMIT_MIB."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", help="default: about ten and forty times what is kept")
    parser.add_argument("--formats", default="blf,csv")
    parser.add_argument("--save", action="store_true")
    parser.add_argument("--child", nargs=4)
    arguments = parser.parse_args()
    if arguments.child:
        form, *paths = arguments.child
        child(form, *(Path(path) for path in paths))
        return
    from parsers.intake import Budget

    kept = Budget(Path()).rows / 2**20
    rows = [
        "| log | minutes | file MiB | columns MiB | times what is kept | grown MiB | wall s | CPU s |",
        "|" + " --- |" * 8,
    ]
    worst = 0.0
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        write_settings(folder)
        for form in arguments.formats.split(","):
            small = folder / f"small.{form}"
            WRITERS[form](small, 2 / 60)
            for minutes in map(float, arguments.minutes.split(",")) if arguments.minutes else MINUTES[form]:
                log = folder / f"drive.{form}"
                WRITERS[form](log, minutes)
                command = [sys.executable, __file__, "--child", form, *map(str, (log, small, folder))]
                done = subprocess.run(command, check=True, capture_output=True, text=True)
                found = json.loads(done.stdout.splitlines()[-1])
                columns = found["values"] * 8 / 2**20
                worst = max(worst, found["grown_mib"])
                rows.append(
                    f"| {form} | {minutes:g} | {log.stat().st_size / 2**20:.0f} | {columns:.0f} | {columns / kept:.1f} "
                    f"| {found['grown_mib']:.0f} | {found['wall_s']:.1f} | {found['cpu_s']:.1f} |"
                )
                print(rows[-1], file=sys.stderr)
                log.unlink()
    shown = (
        f"`python benchmarks/convert_memory.py --minutes {arguments.minutes} --save`"
        if arguments.minutes
        else ""
    )
    head = f"{shown or '`python benchmarks/convert_memory.py --save`'}: limit {LIMIT_MIB} MiB, seed {SEED}; {platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}"
    table = "\n".join(["# Memory of convert", "", head, "", *rows, ""])
    print(table)
    if arguments.save:
        results = HERE / "results"
        results.mkdir(exist_ok=True)
        (results / "convert_memory.md").write_text(table, encoding="utf-8")
    sys.exit(worst > LIMIT_MIB)


if __name__ == "__main__":
    main()
