"""Import speed: cogest against the libraries that engineers use today, as ratios from one run.

    python benchmarks/import_speed.py [--minutes 30] [--runs 3] [--only blf,csv] [--save]

Makes the logs (a seed, deterministic), runs peer and ours in turn in fresh processes, from file to columns in memory, and
prints the median CPU time of each and their ratio. --save writes the table with machine and versions to results/.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib import metadata
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

SEED = 20261121


@dataclass(frozen=True)
class Case:
    """One format. target: what issue and README promise, times the peer."""

    name: str
    file: str
    peers: tuple[str, ...]
    target: float


CASES = (
    Case("blf", "drive.blf", ("python_can",), 40),
    Case("candump", "drive.log", ("python_can",), 35),
    Case("asc", "drive.asc", ("python_can",), 35),
    Case("trc", "drive.trc", ("python_can",), 20),
    Case("blf fd", "drive_fd.blf", ("python_can",), 13),
    Case("mf4 plain", "plain.mf4", ("asammdf",), 7),
    Case("mf4 deflate", "deflate.mf4", ("asammdf",), 7),
    Case("mf4 transposed", "transposed.mf4", ("asammdf",), 7),
    Case("ros1 none", "none.bag", ("rosbags",), 60),
    Case("ros1 lz4", "lz4.bag", ("rosbags",), 60),
    Case("ros2 sqlite3", "sqlite3", ("rosbags",), 5),
    Case("ros2 mcap", "ros2.mcap", ("rosbags",), 35),
    Case("mcap protobuf", "protobuf.mcap", ("mcap_protobuf",), 35),
    Case("mcap json", "json.mcap", ("mcap_json",), 3.5),
    Case("csv", "drive.csv", ("polars_csv", "pandas_csv"), 1),
    Case("vbo", "drive.vbo", ("polars_vbo",), 1),
)


def make_logs(folder: Path, seconds: float, names: set[str]) -> None:
    """Write the logs of the chosen cases."""
    from benchmarks.import_logs import can_logs, ros_logs, table_logs

    folder.mkdir(exist_ok=True)
    (folder / "bench.dbc").write_text(can_logs.database(8), encoding="ascii")
    (folder / "bench_fd.dbc").write_text(can_logs.database(64), encoding="ascii")
    frames = can_logs.make_frames(seconds, 8, SEED)
    writers: dict[str, Callable[[Path], None]] = {
        "blf": lambda path: can_logs.write_blf(frames, path),
        "candump": lambda path: can_logs.write_candump(frames, path),
        "asc": lambda path: can_logs.write_asc(frames, path),
        "trc": lambda path: can_logs.write_trc(frames, path),
        "blf fd": lambda path: can_logs.write_blf_fd(can_logs.make_frames(seconds, 64, SEED), path),
        "mf4 plain": lambda path: table_logs.write_mf4(frames, path, 0),
        "mf4 deflate": lambda path: table_logs.write_mf4(frames, path, 1),
        "mf4 transposed": lambda path: table_logs.write_mf4(frames, path, 2),
        "ros1 none": lambda path: ros_logs.write_bag1(seconds, SEED, path, lz4=False),
        "ros1 lz4": lambda path: ros_logs.write_bag1(seconds, SEED, path, lz4=True),
        "ros2 sqlite3": lambda path: ros_logs.write_bag2(seconds, SEED, path),
        "ros2 mcap": lambda path: ros_logs.write_mcap_ros2(seconds, SEED, path),
        "mcap protobuf": lambda path: ros_logs.write_mcap_protobuf(seconds, SEED, path),
        "mcap json": lambda path: ros_logs.write_mcap_json(seconds, SEED, path),
        "csv": lambda path: table_logs.write_csv(seconds, SEED, path),
        "vbo": lambda path: table_logs.write_vbo(seconds, SEED, path),
    }
    for case in CASES:
        if case.name in names:
            print(f"making {case.file}", file=sys.stderr)
            writers[case.name](folder / case.file)


def _wanted(case: Case, names: list[str]) -> frozenset[str]:
    """All channels of CAN and tables, the chosen ones of ROS."""
    from benchmarks.import_logs.ros_logs import WANTED

    return frozenset(WANTED if case.name.startswith("ros") else names)


def ours(case: Case, folder: Path) -> int:
    """Read with cogest; the number of values."""
    from parsers.importer import ImportLog, ReadOptions
    from parsers.registry import find_importer

    path = folder / case.file
    dbc = folder / ("bench_fd.dbc" if case.name == "blf fd" else "bench.dbc")
    reader = find_importer(path).open(path, ReadOptions(dbc=(dbc,)), ImportLog())
    wanted = _wanted(case, [info.name for info in reader.channels if info.kind == "number"])
    chunks = list(reader.read(wanted))
    return sum(len(values) for chunk in chunks for values in chunk.columns.values())


def theirs(peer: str, case: Case, folder: Path) -> int:
    """Read with a peer; the number of values."""
    from benchmarks.import_logs import peers
    from benchmarks.import_logs.ros_logs import FIELDS, WANTED

    path = folder / case.file
    dbc = folder / ("bench_fd.dbc" if case.name == "blf fd" else "bench.dbc")
    second: dict[str, tuple[object, ...]] = {
        "python_can": (dbc,),
        "asammdf": (dbc,),
        "rosbags": (WANTED,),
        "mcap_json": (FIELDS,),
        "mcap_protobuf": (FIELDS,),
    }
    columns = getattr(peers, peer)(path, *second.get(peer, ()))
    return sum(len(values) for values in columns.values())


def measure(side: str, case: Case, folder: Path) -> dict[str, float]:
    """CPU seconds, values and peak memory of one side in a fresh process."""
    command = [sys.executable, __file__, "--child", side, case.name, str(folder)]
    done = subprocess.run(
        command, check=True, capture_output=True, text=True, env=os.environ | {"POLARS_MAX_THREADS": "1"}
    )
    return dict(json.loads(done.stdout.splitlines()[-1]))


def child(side: str, name: str, folder: Path) -> None:
    """What runs in the fresh process: imports and a first small log are not counted, the reading is."""
    case = next(c for c in CASES if c.name == name)
    read = ours if side == "cogest" else partial(theirs, side)
    read(case, folder / "small")
    before = resource.getrusage(resource.RUSAGE_SELF)
    values = read(case, folder)
    after = resource.getrusage(resource.RUSAGE_SELF)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    grown = (after.ru_maxrss - before.ru_maxrss) / 1024
    print(json.dumps({"cpu_s": cpu, "values": values, "grown_mib": grown}))


def main() -> None:
    """Run and print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--only", default=",".join(case.name for case in CASES))
    parser.add_argument("--save", action="store_true")
    parser.add_argument("--child", nargs=3)
    arguments = parser.parse_args()
    if arguments.child:
        side, name, folder = arguments.child
        child(side, name, Path(folder))
        return
    names = set(arguments.only.split(","))
    rows = [
        "| format | peer | peer CPU s | cogest CPU s | ratio | target |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        make_logs(folder, arguments.minutes * 60, names)
        make_logs(folder / "small", 2, names)
        for case in (case for case in CASES if case.name in names):
            measure("cogest", case, folder)  # compiles and warms the file cache
            runs: dict[str, list[dict[str, float]]] = {side: [] for side in ("cogest", *case.peers)}
            for _ in range(arguments.runs):
                for side in runs:
                    runs[side].append(measure(side, case, folder))
            medians = {side: statistics.median(run["cpu_s"] for run in found) for side, found in runs.items()}
            best = min(case.peers, key=lambda peer: medians[peer])
            ratio = medians[best] / medians["cogest"]
            rows.append(
                f"| {case.name} | {best} | {medians[best]:.2f} | {medians['cogest']:.3f} | {ratio:.1f} x | {case.target:g} x |"
            )
            print(
                rows[-1],
                f"values {runs['cogest'][0]['values']:.0f} / {runs[best][0]['values']:.0f}",
                file=sys.stderr,
            )
    libraries = ("python-can", "cantools", "asammdf", "rosbags", "mcap", "polars", "pandas", "numpy", "numba")
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in libraries)
    head = (
        f"{arguments.minutes:g} minutes, seed {SEED}, median of {arguments.runs}; {platform.machine()}, {os.cpu_count()} cores, "
        f"Python {platform.python_version()}; {versions}"
    )
    table = "\n".join(["# Import speed", "", head, "", *rows, ""])
    print(table)
    if arguments.save:
        results = HERE / "results"
        results.mkdir(exist_ok=True)
        (results / "import_speed.md").write_text(table, encoding="utf-8")


if __name__ == "__main__":
    main()
