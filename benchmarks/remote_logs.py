"""Logs in an S3 store against the same logs on disk: time, requests, and what share of their bytes is fetched.

    python benchmarks/remote_logs.py [--runs 3] [--latency-ms 0] [--save]

A server process (moto) on loopback holds the sample logs of every format, and larger logs most of whose bytes no signal comes
from. Each is loaded to a drive (`parsers.load.load_drive`), from disk and by its s3:// URL in turn, the shortest of some runs
after one that compiles; the signals must be equal. --latency-ms: added to every request for contents, as a network would.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars as pl
from mcap.writer import CompressionType

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests"), str(ROOT / "tests" / "parsers")]

from remote_files import with_camera  # noqa: E402
from remote_store import S3Store, counting, empty_bucket, environment, running_server  # noqa: E402

from parsers import places_fs  # noqa: E402
from parsers.drive import Drive  # noqa: E402
from parsers.load import load_drive  # noqa: E402
from parsers.mapping import read_map  # noqa: E402
from parsers.opened_log import LoadOptions  # noqa: E402
from parsers.places import as_path  # noqa: E402

RESULT = ROOT / "benchmarks" / "results" / "remote_logs.md"
SAMPLES = (
    "csv/drive.csv",
    "vbo/drive.vbo",
    "mcap/drive_json.mcap",
    "mcap/drive_protobuf.mcap",
    "ros/drive.bag",
    "ros/drive_ros2.mcap",
    "ros/drive_mcap",
    "ros/drive_sqlite3",
    "mf4/drive.mf4",
    "parquet/drive.parquet",
    "can/drive.asc",
    "can/drive.blf",
    "can/drive.log",
    "can/drive.mf4",
    "can/drive.trc",
)


@dataclass(frozen=True)
class Case:
    """A log on disk, and the folder with the files that belong to it."""

    name: str
    log: Path
    beside: Path


def options_of(case: Case) -> LoadOptions:
    """The mapping file and databases beside the log."""
    mapping = case.beside / "map.toml"
    return LoadOptions(
        map=read_map(mapping, strict=False) if mapping.exists() else None,
        dbc=tuple(sorted(case.beside.glob("*.dbc"))),
    )


def large_logs(folder: Path) -> Iterator[Case]:
    """Logs most of whose bytes no signal comes from, and one that is all signals."""
    rng, samples = np.random.default_rng(1), ROOT / "sample_logs"
    for compression in (CompressionType.NONE, CompressionType.ZSTD):
        log = folder / f"camera_{compression.name.lower()}.mcap"
        with_camera(samples / "mcap" / "drive_json.mcap", log, 1.0, 50, compression)
        yield Case(f"MCAP, {compression.name.lower()} chunks, camera 50 x", log, samples / "mcap")
    _bag_with_camera(folder / "camera.bag", rng)
    yield Case("ROS 1 bag, uncompressed, camera 50 x", folder / "camera.bag", folder)
    _measured_groups(folder / "groups.mf4", rng)
    yield Case("MF4, a small group of two, the large one of 20 kHz", folder / "groups.mf4", folder)
    n = 200_000
    columns = {f"other_{k}": rng.normal(size=n) for k in range(60)}
    signals = {
        "time_ns": 1_700_000_000_000_000_000 + 10_000_000 * np.arange(n),
        "accel_y_mps2": rng.normal(size=n),
        "speed_mps": 20 + 0.1 * rng.normal(size=n),
    }
    pl.DataFrame({**signals, **columns}).write_parquet(folder / "wide.parquet", row_group_size=50_000)
    yield Case("Parquet, 3 of 63 columns", folder / "wide.parquet", folder)
    frame = pl.DataFrame({**signals, **{k: columns[k] for k in list(columns)[:5]}})
    frame.write_csv(folder / "long.csv")
    yield Case("CSV, 8 columns", folder / "long.csv", folder)


def _bag_with_camera(path: Path, rng: np.random.Generator) -> None:
    """An IMU at 100 Hz, and after every 60 of its messages a picture of 1 MB."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    imu, picture = "sensor_msgs/msg/Imu", "sensor_msgs/msg/CompressedImage"
    make, zeros = store.types, np.zeros(9)
    vector, turn = make["geometry_msgs/msg/Vector3"], make["geometry_msgs/msg/Quaternion"]
    with Writer(path) as writer:
        imus = writer.add_connection("/imu", imu, typestore=store)
        pictures = writer.add_connection("/camera", picture, typestore=store)
        for k in range(3000):
            ns = 1_700_000_000_000_000_000 + 10_000_000 * k
            stamp = make["builtin_interfaces/msg/Time"](sec=ns // 10**9, nanosec=ns % 10**9)
            head = make["std_msgs/msg/Header"](seq=k, stamp=stamp, frame_id="base_link")
            message = make[imu](
                header=head,
                orientation=turn(x=0.0, y=0.0, z=0.0, w=1.0),
                orientation_covariance=zeros,
                angular_velocity=vector(x=0.1, y=0.0, z=float(rng.normal())),
                angular_velocity_covariance=zeros,
                linear_acceleration=vector(x=float(rng.normal()), y=float(rng.normal()), z=9.81),
                linear_acceleration_covariance=zeros,
            )
            writer.write(imus, ns, store.serialize_ros1(message, imu))
            if k % 60 == 0:
                data = np.frombuffer(rng.bytes(1_000_000), np.uint8)
                shot = make[picture](header=head, format="jpeg", data=data)
                writer.write(pictures, ns, store.serialize_ros1(shot, picture))


def _measured_groups(path: Path, rng: np.random.Generator) -> None:
    """Two signals at 100 Hz, and eight other channels at 20 kHz in a group of their own."""
    from asammdf import MDF, Signal

    slow, fast = 0.01 * np.arange(2000), 5e-5 * np.arange(400_000)
    with MDF(version="4.10") as file:
        file.append(
            [
                Signal(rng.normal(size=slow.size), slow, name="accel_y", unit="m/s^2"),
                Signal(20 + 0.1 * rng.normal(size=slow.size), slow, name="speed", unit="m/s"),
            ]
        )
        file.append([Signal(rng.normal(size=fast.size), fast, name=f"noise_{k}") for k in range(8)])
        file.save(path)


def shortest(run: Callable[[], Drive], runs: int) -> tuple[float, Drive]:
    """The shortest of some runs in s, and the drive."""
    times = []
    for _ in range(runs):
        began = time.perf_counter()
        drive = run()
        times.append(time.perf_counter() - began)
    return min(times), drive


def measured(case: Case, store: S3Store, runs: int) -> str:
    """A row of the table."""
    options = options_of(case)
    url = store.put(case.log, case.log.relative_to(case.log.parents[1]).as_posix())
    size = (
        sum(f.stat().st_size for f in case.log.rglob("*") if f.is_file())
        if case.log.is_dir()
        else case.log.stat().st_size
    )
    load_drive([case.log], options)
    here, local = shortest(lambda: load_drive([case.log], options), runs)
    with counting() as counter:
        there, far = shortest(lambda: load_drive([as_path(url)], options), runs)
    for name, signal in local.signals.items():
        np.testing.assert_array_equal(signal.values, far.signals[name].values)
    gets = counter.calls["get_object"] / runs
    asked = (counter.calls.total() - counter.calls["get_object"]) / runs
    share = counter.bytes / runs / size
    return f"| {case.name} | {size / 1e6:.2f} | {100 * share:.0f} % | {gets:.0f} | {asked:.0f} | {here:.3f} | {there:.3f} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--latency-ms", type=float, default=0.0)
    parser.add_argument("--save", action="store_true")
    given = parser.parse_args()
    plain = places_fs.fetch

    def slow(url: str, start: int, stop: int) -> bytes:
        time.sleep(given.latency_ms / 1000)
        return plain(url, start, stop)

    places_fs.fetch = slow if given.latency_ms else plain
    lines = [
        "| log | size, MB | fetched | requests for contents | others | disk, s | S3, s |",
        "|---|---|---|---|---|---|---|",
    ]
    print("\n".join(lines))
    with running_server() as endpoint, tempfile.TemporaryDirectory() as name:
        os.environ.update(environment(endpoint))
        store = empty_bucket(endpoint)
        cases = [
            Case(sample, ROOT / "sample_logs" / sample, (ROOT / "sample_logs" / sample).parent)
            for sample in SAMPLES
        ]
        for case in (*cases, *large_logs(Path(name))):
            lines.append(measured(case, store, given.runs))
            print(lines[-1], flush=True)
    if given.save:
        head = (
            f"Made by `python benchmarks/remote_logs.py --runs {given.runs} --latency-ms {given.latency_ms:g}`. The test server "
            "copies the whole object for every range that is asked of it: the seconds of the large logs are the server's.\n\n"
        )
        RESULT.write_text(head + "\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
