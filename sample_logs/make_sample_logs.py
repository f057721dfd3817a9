"""Rebuild every sample log: `python sample_logs/make_sample_logs.py` (needs the `test` extra).

One simulated drive with known truth in every format that cogest reads, each in a folder of its own, and a small fleet:
four vehicles with two or three drives each, in several formats, one of them cut off in the middle and one that
cannot be read.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from rosbags.rosbag2 import StoragePlugin  # noqa: E402

from pipelines.simulation.logs.drive import Choice, default_mount, preset, simulate_log, truth_record  # noqa: E402
from pipelines.simulation.logs.loads import parse_load  # noqa: E402
from pipelines.simulation.logs.write import write_truth  # noqa: E402
from pipelines.simulation.plant.vehicle import PlantVehicle  # noqa: E402
from sample_logs.writers import can, fleet, ros, text  # noqa: E402
from sample_logs.writers.common import SampleDrive, on_one_clock, one_clock_sensors  # noqa: E402

SEED = 1
RATE_HZ = 40.0


def sample_choice(vehicle: PlantVehicle, loads: tuple[str, ...], seed: int, rate_hz: float) -> Choice:
    """The drive that every format holds: known driver, a little of everything."""
    return Choice(
        "mixed_minute",
        vehicle,
        loads=tuple(part for spec in loads for part in parse_load(spec, vehicle)),
        sensors=one_clock_sensors(default_mount(vehicle), rate_hz),
        tell_load=True,
        seed=seed,
    )


def _folder(root: Path, name: str) -> Path:
    folder = root / name
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def sample_drive(root: Path) -> SampleDrive:
    """Simulate the drive that every format holds; its vehicle file and truth go into `root`."""
    simulated = simulate_log(sample_choice(preset("suv"), ("seats:75",), SEED, RATE_HZ))
    title = (
        "# The vehicle of the sample logs, simulated with a driver in it, and the truth to compare with.\n"
    )
    (root / "vehicle.toml").write_text(title + simulated.sheet, encoding="utf-8")
    write_truth(truth_record(simulated, "samples"), root / "truth.json")
    return on_one_clock(simulated.log)


def write_formats(drive: SampleDrive, root: Path) -> None:
    """Write one drive in every format below `root`; what stood there under the same names is replaced."""
    text.write_csv(drive, _folder(root, "csv") / "drive.csv")
    text.write_german_tsv(drive, _folder(root, "tsv") / "drive.tsv")
    (root / "tsv" / "map.toml").write_text(text.TSV_MAP, encoding="utf-8")
    text.write_parquet(drive, _folder(root, "parquet") / "drive.parquet")
    text.write_vbo(drive, _folder(root, "vbo") / "drive.vbo")
    (root / "vbo" / "map.toml").write_text(text.VBO_MAP, encoding="utf-8")

    bus = _folder(root, "can")
    (bus / "chassis.dbc").write_text(can.DBC, encoding="utf-8")
    (bus / "map.toml").write_text(can.MAP, encoding="utf-8")
    messages = can.frames(drive)
    for name in ("drive.blf", "drive.asc", "drive.trc", "drive.log"):
        can.write_with_python_can(messages, bus / name)
    can.write_candump_console(messages, bus / "console.txt")
    can.write_mf4_bus(messages, bus / "drive.mf4")
    can.write_mf4_channels(drive, _folder(root, "mf4") / "drive.mf4")

    folder = _folder(root, "ros")
    (folder / "map.toml").write_text(ros.MAP, encoding="utf-8")
    ros.write_bag1(drive, folder / "drive.bag")
    ros.write_bag2(drive, folder / "drive_sqlite3", StoragePlugin.SQLITE3)
    ros.write_bag2(drive, folder / "drive_mcap", StoragePlugin.MCAP)
    # rosbags writes this storage without compression: the same messages in zstd chunks take a third
    ros.write_mcap_ros(drive, folder / "drive_mcap" / "drive_mcap.mcap", ros1=False)
    ros.write_mcap_ros(drive, folder / "drive_ros1.mcap", ros1=True)
    ros.write_mcap_ros(drive, folder / "drive_ros2.mcap", ros1=False)
    ros.write_mcap_json(drive, _folder(root, "mcap") / "drive_json.mcap")
    ros.write_mcap_protobuf(drive, root / "mcap" / "drive_protobuf.mcap")


def write_all(root: Path) -> None:
    """Write every sample log below `root`."""
    write_formats(sample_drive(root), root)
    fleet.write_fleet(_folder(root, "fleet"))
    shutil.rmtree(root / "__pycache__", ignore_errors=True)


if __name__ == "__main__":
    write_all(HERE)
