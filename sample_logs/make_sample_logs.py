"""Rebuild every sample log: `python sample_logs/make_sample_logs.py` (needs the `test` extra).

One simulated drive with known truth in every format that cogest reads, each in a folder of its own.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from rosbags.rosbag2 import StoragePlugin  # noqa: E402

from pipelines.simulation.roll_drive import RollVehicle, SimulatedDrive, simulate_roll_drive  # noqa: E402
from sample_logs.writers import can, ros, text  # noqa: E402

SEED = 20251009


def vehicle_file(drive: SimulatedDrive, vehicle: RollVehicle) -> str:
    """A vehicle file as a data sheet gives it (rates to 2 %), with the truth as reference."""
    reference = "\n".join(f"{name} = {value:.6g}" for name, value in drive.truth.items())
    return f"""# The simulated vehicle of the sample logs: what a data sheet would say, and the truth to compare with.
[vehicle]
name = "Simulated SUV"
body = "SUV"
mass_kg = {{value = {vehicle.mass_kg - 75:g}, std = 10}}
unsprung_mass_front_kg = {vehicle.unsprung_mass_kg / 2:g}
unsprung_mass_rear_kg = {vehicle.unsprung_mass_kg / 2:g}
wheelbase_m = {vehicle.wheelbase_m:g}
track_front_m = {vehicle.track_m:g}
track_rear_m = {vehicle.track_m:g}
cg_to_front_axle_m = {{value = {vehicle.cg_to_front_axle_m:g}, std = 0.02}}
roll_center_height_front_m = {{value = 0.09, std = 0.02}}
roll_center_height_rear_m = {{value = 0.13, std = 0.02}}
roll_stiffness_nmprad = {{value = {vehicle.roll_stiffness_nmprad * 1.01:g}, std = {vehicle.roll_stiffness_nmprad * 0.02:g}}}
tire_vertical_rate_npm = {{value = {vehicle.tire_vertical_rate_npm:g}, std = 12500}}
wheel_radius_m = {vehicle.unsprung_height_m:g}

[load]  # the driver
mass_kg = {{value = 75, std = 10}}
height_m = {{value = 0.75, std = 0.1}}

[sensors]
imu_above_ground_m = {{value = {vehicle.imu_above_ground_m:g}, std = 0.05}}

[reference]
{reference}
"""


def _folder(root: Path, name: str) -> Path:
    folder = root / name
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def write_all(root: Path) -> None:
    """Write every sample log below `root`; what stood there under the same names is replaced."""
    vehicle = RollVehicle()
    drive = simulate_roll_drive(np.random.default_rng(SEED), vehicle)
    (root / "vehicle.toml").write_text(vehicle_file(drive, vehicle), encoding="utf-8")

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
    shutil.rmtree(root / "__pycache__", ignore_errors=True)


if __name__ == "__main__":
    write_all(HERE)
