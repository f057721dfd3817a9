"""`cogest convert` of a BLF drive, start to Parquet, against a script with python-can, cantools and polars, as whole processes.

    python benchmarks/convert_speed.py [--minutes 30] [--runs 3] [--save]

Both write 32 signals of 12 messages as zstd Parquet; cogest also orders them in time, checks them against physics, hashes the log and
writes the import record.
"""

from __future__ import annotations

import argparse
import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from benchmarks.import_logs import can_logs  # noqa: E402
from benchmarks.import_logs.cases import SEED  # noqa: E402

RESULT = HERE / "results" / "convert_speed.md"
CORNERS = ("fl", "fr", "rl", "rr")
# signal -> factor that brings the benchmark's ±160 to a size that a vehicle has
SIGNALS = (
    {
        "accel_x": 0.02,
        "accel_y": 0.03,
        "roll_rate": 0.001,
        "pitch_rate": 0.001,
        "yaw_rate": 0.003,
        "roll": 0.0005,
    }
    | {"pitch": 0.0004, "steering_wheel_angle": 0.02, "brake_torque": 5.0, "drive_torque": 5.0}
    | {f"suspension_deflection_{corner}": 0.0002 for corner in CORNERS}
    | {f"suspension_force_{corner}": 20.0 for corner in CORNERS}
    | {f"accel_z_sprung_{corner}": 0.02 for corner in CORNERS}
    | {f"accel_z_unsprung_{corner}": 0.1 for corner in CORNERS}
    | {f"brake_torque_{corner}": 5.0 for corner in CORNERS}
    | {"drive_torque_fl": 5.0, "drive_torque_fr": 5.0}
)


def mapping() -> str:
    """The mapping file: every signal of the benchmark's DBC as one of cogest's."""
    names = [f"Message{m}.Signal{k}" for m in range(can_logs.KNOWN) for k in range(3 if m < 8 else 2)]
    entries = zip(SIGNALS.items(), names, strict=True)
    return "\n".join(
        f'[signals.{signal}]\nchannel = "{name}"\nunit = "{unit_of(signal)}"\nscale = {factor}\n'
        for (signal, factor), name in entries
    )


def unit_of(signal: str) -> str:
    """SI."""
    units = {"accel": "m/s²", "suspension_d": "m", "suspension_f": "N", "brake": "Nm", "drive": "Nm"}
    for start, unit in units.items():
        if signal.startswith(start):
            return unit
    return "rad/s" if signal.endswith("rate") else "rad"


def once(command: list[str]) -> tuple[float, float]:
    """Wall and CPU seconds of one process."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Run both in turn and print the medians and the ratios."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--save", action="store_true")
    arguments = parser.parse_args()
    program = Path(sys.executable).parent / "cogest"
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        log, dbc, table = folder / "drive.blf", folder / "bench.dbc", folder / "map.toml"
        frames = can_logs.make_frames(arguments.minutes * 60, 8, SEED)
        can_logs.write_blf(can_logs.with_motion(frames, SEED), log)
        dbc.write_text(can_logs.database(8), encoding="ascii")
        table.write_text(mapping(), encoding="utf-8")
        ours = [
            str(program),
            "convert",
            str(log),
            "--dbc",
            str(dbc),
            "--map",
            str(table),
            "--out",
            str(folder / "a"),
        ]
        peer = [
            sys.executable,
            str(HERE / "import_logs/convert_peer.py"),
            str(log),
            str(dbc),
            str(folder / "b"),
        ]
        once(ours)
        pairs = [(once(ours), once(peer)) for _ in range(arguments.runs)]
        size = log.stat().st_size / 1e6
    wall, cpu = (statistics.median(run[0][k] for run in pairs) for k in (0, 1))
    peer_wall, peer_cpu = (statistics.median(run[1][k] for run in pairs) for k in (0, 1))
    lines = [
        "# Conversion of a BLF drive to Parquet, whole process",
        "",
        f"`python benchmarks/convert_speed.py --minutes {arguments.minutes:g} --runs {arguments.runs} --save`: {len(frames.time_ns)} "
        f"frames, {size:.0f} MB, 32 signals, median; {platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}.",
        "",
        "| | python-can + cantools + polars | cogest convert | ratio | target |",
        "| --- | --- | --- | --- | --- |",
        f"| wall s | {peer_wall:.2f} | {wall:.2f} | {peer_wall / wall:.1f} x | 20 x |",
        f"| CPU s | {peer_cpu:.2f} | {cpu:.2f} | {peer_cpu / cpu:.1f} x | |",
        "",
    ]
    print("\n".join(lines))
    if arguments.save:
        RESULT.parent.mkdir(exist_ok=True)
        RESULT.write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
