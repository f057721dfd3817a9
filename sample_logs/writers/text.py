"""CSV, TSV, VBO, Parquet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl

from parsers.signals import SIGNALS
from sample_logs.writers.common import DEG, G, SampleDrive, stamps_ns

TSV_MAP = """# An example of a mapping file: one column whose name says nothing that cogest knows.
[signals.accel_x]
channel = "Längsbeschleunigung [g]"
unit = "g"
"""


def write_csv(drive: SampleDrive, path: Path) -> None:
    """A plain table: canonical columns, seconds."""
    columns = {"time_s": drive.time_s.round(4)}
    columns |= {SIGNALS[name].column: values.round(6) for name, values in drive.signals.items()}
    pl.DataFrame(columns).write_csv(path)


def write_german_tsv(drive: SampleDrive, path: Path) -> None:
    """A measuring computer's export: tab, decimal comma, units in the header, degrees and g, Latin-1."""
    names = {
        "accel_x": ("Längsbeschleunigung [g]", 1 / G),
        "accel_y": ("Lateral acceleration [g]", 1 / G),
        "accel_z": ("Vertical acceleration [g]", 1 / G),
        "roll_rate": ("Roll rate [°/s]", DEG),
        "pitch_rate": ("Pitch rate [°/s]", DEG),
        "yaw_rate": ("Yaw rate [°/s]", DEG),
        "roll": ("Roll angle [°]", DEG),
        "pitch": ("Pitch angle [°]", DEG),
        "speed": ("Vehicle speed [km/h]", 3.6),
        "steering_wheel_angle": ("Steering wheel angle [°]", DEG),
        "suspension_deflection_fl": ("Suspension deflection FL [mm]", 1000),
        "suspension_deflection_fr": ("Suspension deflection FR [mm]", 1000),
        "suspension_deflection_rl": ("Suspension deflection RL [mm]", 1000),
        "suspension_deflection_rr": ("Suspension deflection RR [mm]", 1000),
        "wheel_speed_fl": ("Wheel speed FL [km/h]", 3.6),
        "wheel_speed_fr": ("Wheel speed FR [km/h]", 3.6),
        "wheel_speed_rl": ("Wheel speed RL [km/h]", 3.6),
        "wheel_speed_rr": ("Wheel speed RR [km/h]", 3.6),
        "brake_pressure": ("Brake pressure [bar]", 1e-5),
        "brake_torque": ("Brake torque [Nm]", 1),
        "drive_torque": ("Drive torque [Nm]", 1),
    }
    columns = [drive.time_s] + [drive.signals[name] * scale for name, (_, scale) in names.items()]
    header = "\t".join(["t [s]", *(title for title, _ in names.values())])
    rows = ["\t".join(f"{v:.5f}" for v in row).replace(".", ",") for row in np.stack(columns, axis=1)]
    path.write_bytes("\r\n".join([header, *rows, ""]).encode("latin-1"))


def write_parquet(drive: SampleDrive, path: Path) -> None:
    """Canonical columns with time_ns."""
    columns = {SIGNALS[name].column: values for name, values in drive.signals.items()}
    pl.DataFrame({"time_ns": stamps_ns(drive), **columns}).write_parquet(path, compression="zstd")


VBO_CHANNELS = {
    "X_Accel": ("accel_x", 1 / G, "g"),
    "Y_Accel": ("accel_y", 1 / G, "g"),
    "Z_Accel": ("accel_z", 1 / G, "g"),
    "RollRate": ("roll_rate", DEG, "°/s"),
    "PitchRate": ("pitch_rate", DEG, "°/s"),
    "YawRate": ("yaw_rate", DEG, "°/s"),
    "Roll_Angle": ("roll", DEG, "°"),
    "Pitch_Angle": ("pitch", DEG, "°"),
    "SteerAng": ("steering_wheel_angle", DEG, "°"),
    "Damper_FL": ("suspension_deflection_fl", 1000, "mm"),
    "Damper_FR": ("suspension_deflection_fr", 1000, "mm"),
    "Damper_RL": ("suspension_deflection_rl", 1000, "mm"),
    "Damper_RR": ("suspension_deflection_rr", 1000, "mm"),
    "WheelSpd_FL": ("wheel_speed_fl", 3.6, "km/h"),
    "WheelSpd_FR": ("wheel_speed_fr", 3.6, "km/h"),
    "WheelSpd_RL": ("wheel_speed_rl", 3.6, "km/h"),
    "WheelSpd_RR": ("wheel_speed_rr", 3.6, "km/h"),
    "Brake_Press": ("brake_pressure", 1e-5, "bar"),
    "Brake_Torque": ("brake_torque", 1, "Nm"),
    "Drive_Torque": ("drive_torque", 1, "Nm"),
}

VBO_MAP = "".join(
    f'[signals.suspension_deflection_{w}]\nchannel = "Damper_{w.upper()}"\nunit = "mm"\n\n'
    for w in ("fl", "fr", "rl", "rr")
)


def write_vbo(drive: SampleDrive, path: Path) -> None:
    """A VBOX file: UTC time of day, minutes with west positive, km/h, channels after the standard ones."""
    n = len(drive.time_s)
    speed = np.maximum(drive.signals["speed"], 0)
    travelled = np.cumsum(speed) * (drive.time_s[1] - drive.time_s[0])
    latitude = (48.137 + travelled / 111_200) * 60
    start = 8 * 3600 + 53 * 60 + 20
    clock = start + drive.time_s
    hhmmss = (clock // 3600) * 10000 + (clock % 3600 // 60) * 100 + clock % 60
    standard = [
        "satellites",
        "time",
        "latitude",
        "longitude",
        "velocity kmh",
        "heading",
        "height",
        "vertical velocity kmh",
    ]
    names = ["sats", "time", "lat", "long", "velocity", "heading", "height", "vert-vel", *VBO_CHANNELS]
    lines = [
        "File created on 09/10/2025 @ 08:53",
        "",
        "[header]",
        *standard,
        *VBO_CHANNELS,
        "",
        "[channel units]",
    ]
    lines += [unit for _, _, unit in VBO_CHANNELS.values()]
    lines += [
        "",
        "[comments]",
        "Simulated drive of cogest",
        f"Log Rate (Hz) : {1 / (drive.time_s[1] - drive.time_s[0]):.2f}",
        "",
        "[column names]",
        " ".join(names),
        "",
        "[data]",
    ]
    values = [drive.signals[name] * scale for name, scale, _ in VBO_CHANNELS.values()]
    for i in range(n):
        head = f"012 {hhmmss[i]:010.3f} {latitude[i]:+012.5f} {-694.5:+012.5f} {speed[i] * 3.6:07.3f} 000.00 +00520.00 +000.000"
        lines.append(head + "".join(f" {column[i]:+.5E}" for column in values))
    path.write_bytes(("\r\n".join(lines) + "\r\n").encode("latin-1"))
