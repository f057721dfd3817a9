"""The formats that are compared: file, peers, floor and what is promised."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

SEED = 20261121


@dataclass(frozen=True)
class Case:
    """One format. target: times the peer's CPU time, at least. floor: a function of `floors`, what no reader can do without."""

    name: str
    file: str
    peers: tuple[str, ...]
    target: float
    floor: str | None = None


CASES = (
    Case("blf", "drive.blf", ("python_can",), 40, "inflate_blf"),
    Case("candump", "drive.log", ("python_can",), 35, "count_lines"),
    Case("asc", "drive.asc", ("python_can",), 35, "count_lines"),
    Case("trc", "drive.trc", ("python_can",), 20, "count_lines"),
    Case("blf fd", "drive_fd.blf", ("python_can",), 13, "inflate_blf"),
    Case("mf4 plain", "plain.mf4", ("asammdf",), 7, "read_file"),
    Case("mf4 deflate", "deflate.mf4", ("asammdf",), 7, "inflate_mf4"),
    Case("mf4 transposed", "transposed.mf4", ("asammdf",), 7, "inflate_mf4"),
    Case("ros1 none", "none.bag", ("rosbags",), 60, "read_file"),
    Case("ros1 lz4", "lz4.bag", ("rosbags",), 60, "unpack_bag"),
    Case("ros2 sqlite3", "sqlite3", ("rosbags",), 5, "read_file"),
    Case("ros2 mcap", "ros2.mcap", ("rosbags",), 35, "unpack_mcap"),
    Case("mcap protobuf", "protobuf.mcap", ("mcap_protobuf",), 35, "unpack_mcap"),
    Case("mcap json", "json.mcap", ("mcap_json",), 3.5, "unpack_mcap"),
    Case("csv", "drive.csv", ("polars_csv", "pandas_csv"), 1, "count_lines"),
    Case("vbo", "drive.vbo", ("polars_vbo",), 1, "count_lines"),
)


def case_named(name: str) -> Case:
    """The case of that name. Raises StopIteration."""
    return next(case for case in CASES if case.name == name)


def database_of(case: Case, folder: Path) -> Path:
    """The DBC of a CAN case."""
    return folder / ("bench_fd.dbc" if case.name == "blf fd" else "bench.dbc")


def make_logs(folder: Path, seconds: float, names: set[str]) -> None:
    """Write the logs of the chosen cases, the same bytes each time."""
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
            writers[case.name](folder / case.file)
