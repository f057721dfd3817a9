"""CAN: one DBC, and the same frames as BLF, ASC, candump (two dialects), TRC and MF4 bus logging; MF4 channels."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import can
import cantools
import numpy as np
from asammdf import MDF, Signal

from parsers.signals import SIGNALS
from parsers.units import SI_TEXT
from sample_logs.writers.common import START_NS, SampleDrive, stamps_ns

DBC = """VERSION ""

NS_ :

BS_:

BU_: Chassis

BO_ 257 Inertial1: 8 Chassis
 SG_ AccelX : 0|16@1- (0.001,0) [-32|32] "m/s^2" Vector__XXX
 SG_ AccelY : 16|16@1- (0.001,0) [-32|32] "m/s^2" Vector__XXX
 SG_ AccelZ : 32|16@1- (0.001,0) [-32|32] "m/s^2" Vector__XXX
 SG_ SteeringWheelAngle : 55|16@0- (0.05,0) [-1600|1600] "deg" Vector__XXX

BO_ 258 Inertial2: 8 Chassis
 SG_ RollRate : 0|16@1- (0.005,0) [-160|160] "deg/s" Vector__XXX
 SG_ PitchRate : 16|16@1- (0.005,0) [-160|160] "deg/s" Vector__XXX
 SG_ YawRate : 32|16@1- (0.005,0) [-160|160] "deg/s" Vector__XXX
 SG_ VehicleSpeed : 48|16@1+ (0.01,0) [0|655] "km/h" Vector__XXX

BO_ 259 Attitude: 4 Chassis
 SG_ RollAngle : 7|16@0- (0.002,0) [-65|65] "deg" Vector__XXX
 SG_ PitchAngle : 23|16@0- (0.002,0) [-65|65] "deg" Vector__XXX

BO_ 260 WheelSpeeds: 8 Chassis
 SG_ SpeedFL : 0|16@1+ (0.01,0) [0|655] "km/h" Vector__XXX
 SG_ SpeedFR : 16|16@1+ (0.01,0) [0|655] "km/h" Vector__XXX
 SG_ SpeedRL : 32|16@1+ (0.01,0) [0|655] "km/h" Vector__XXX
 SG_ SpeedRR : 48|16@1+ (0.01,0) [0|655] "km/h" Vector__XXX

BO_ 261 Torques: 6 Chassis
 SG_ BrakePressure : 0|16@1- (0.01,0) [-327|327] "bar" Vector__XXX
 SG_ BrakeTorque : 16|16@1- (1,0) [-32768|32767] "Nm" Vector__XXX
 SG_ DriveTorque : 32|16@1- (1,0) [-32768|32767] "Nm" Vector__XXX

BO_ 2566868996 SuspensionTravel: 8 Chassis
 SG_ DeflectionFL : 0|16@1- (0.01,0) [-327|327] "mm" Vector__XXX
 SG_ DeflectionFR : 16|16@1- (0.01,0) [-327|327] "mm" Vector__XXX
 SG_ DeflectionRL : 32|16@1- (0.01,0) [-327|327] "mm" Vector__XXX
 SG_ DeflectionRR : 48|16@1- (0.01,0) [-327|327] "mm" Vector__XXX
"""

CHANNELS = {
    "accel_x": ("Inertial1", "AccelX", 1.0, "m/s^2"),
    "accel_y": ("Inertial1", "AccelY", 1.0, "m/s^2"),
    "accel_z": ("Inertial1", "AccelZ", 1.0, "m/s^2"),
    "steering_wheel_angle": ("Inertial1", "SteeringWheelAngle", 180 / np.pi, "deg"),
    "roll_rate": ("Inertial2", "RollRate", 180 / np.pi, "deg/s"),
    "pitch_rate": ("Inertial2", "PitchRate", 180 / np.pi, "deg/s"),
    "yaw_rate": ("Inertial2", "YawRate", 180 / np.pi, "deg/s"),
    "speed": ("Inertial2", "VehicleSpeed", 3.6, "km/h"),
    "roll": ("Attitude", "RollAngle", 180 / np.pi, "deg"),
    "pitch": ("Attitude", "PitchAngle", 180 / np.pi, "deg"),
    "suspension_deflection_fl": ("SuspensionTravel", "DeflectionFL", 1000.0, "mm"),
    "suspension_deflection_fr": ("SuspensionTravel", "DeflectionFR", 1000.0, "mm"),
    "suspension_deflection_rl": ("SuspensionTravel", "DeflectionRL", 1000.0, "mm"),
    "suspension_deflection_rr": ("SuspensionTravel", "DeflectionRR", 1000.0, "mm"),
    "wheel_speed_fl": ("WheelSpeeds", "SpeedFL", 3.6, "km/h"),
    "wheel_speed_fr": ("WheelSpeeds", "SpeedFR", 3.6, "km/h"),
    "wheel_speed_rl": ("WheelSpeeds", "SpeedRL", 3.6, "km/h"),
    "wheel_speed_rr": ("WheelSpeeds", "SpeedRR", 3.6, "km/h"),
    "brake_pressure": ("Torques", "BrakePressure", 1e-5, "bar"),
    "brake_torque": ("Torques", "BrakeTorque", 1.0, "Nm"),
    "drive_torque": ("Torques", "DriveTorque", 1.0, "Nm"),
}

MAP = "".join(
    f'[signals.{signal}]\nchannel = "{message}.{channel}"\nunit = "{unit}"\n\n'
    for signal, (message, channel, _, unit) in CHANNELS.items()
)


def _payloads(drive: SampleDrive) -> Iterator[tuple[int, cantools.database.Message, bytes]]:
    """Frames in time order: stamp, message, payload; messages of one sample follow each other by 100 µs."""
    database = cantools.database.load_string(DBC)
    times = stamps_ns(drive)
    for i in range(len(times)):
        for slot, message in enumerate(sorted(database.messages, key=lambda m: m.name)):
            values = {
                channel: float(drive.signals[signal][i] * scale)
                for signal, (name, channel, scale, _) in CHANNELS.items()
                if name == message.name
            }
            yield int(times[i]) + slot * 100_000, message, message.encode(values, strict=False)


def frames(drive: SampleDrive) -> list[can.Message]:
    """All frames as python-can messages; now and then an id that the DBC does not know."""
    out = []
    for number, (stamp, message, data) in enumerate(_payloads(drive)):
        out.append(
            can.Message(
                timestamp=stamp / 1e9,
                arbitration_id=message.frame_id,
                is_extended_id=message.is_extended_frame,
                data=data,
                channel=0,
                is_rx=True,
            )
        )
        if number % 200 == 0:
            out.append(
                can.Message(
                    timestamp=stamp / 1e9, arbitration_id=0x700, is_extended_id=False, data=b"\x01", channel=0
                )
            )
    return out


def write_with_python_can(messages: list[can.Message], path: Path) -> None:
    """BLF, ASC, TRC or candump (.log) by python-can's writers."""
    with can.Logger(str(path)) as logger:
        for message in messages:
            logger(message)
    if path.suffix == ".trc":
        # python-can writes where on this machine the file lies, which is nobody's business
        whole = str(path.resolve()).encode()
        path.write_bytes(path.read_bytes().replace(whole, path.name.encode(), 1))


def write_candump_console(messages: list[can.Message], path: Path) -> None:
    """The console form of candump -t a."""
    lines = []
    for m in messages:
        name = f"{m.arbitration_id:08X}" if m.is_extended_id else f"{m.arbitration_id:03X}"
        lines.append(
            f" ({m.timestamp:.6f})  can0  {name:>8}   [{m.dlc}]  {' '.join(f'{b:02X}' for b in m.data)}"
        )
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def write_mf4_channels(drive: SampleDrive, path: Path) -> None:
    """MF4 with plain measured channels, named and with SI units."""
    with MDF(version="4.10") as mdf:
        mdf.start_time = datetime.fromtimestamp(START_NS / 1e9, tz=UTC)
        mdf.append(
            [
                Signal(
                    values.astype(np.float32), drive.time_s, name=name, unit=SI_TEXT[SIGNALS[name].quantity]
                )
                for name, values in drive.signals.items()
            ]
        )
        mdf.save(path, overwrite=True, compression=2)


def write_mf4_bus(messages: list[can.Message], path: Path) -> None:
    """MF4 bus logging: the CAN_DataFrame structure of the ASAM bus logging standard."""
    dtype = np.dtype(
        [
            ("CAN_DataFrame.BusChannel", "<u1"),
            ("CAN_DataFrame.ID", "<u4"),
            ("CAN_DataFrame.IDE", "<u1"),
            ("CAN_DataFrame.DLC", "<u1"),
            ("CAN_DataFrame.DataLength", "<u1"),
            ("CAN_DataFrame.DataBytes", "(8,)u1"),
            ("CAN_DataFrame.Dir", "<u1"),
        ]
    )
    table = np.zeros(len(messages), dtype=dtype)
    for i, m in enumerate(messages):
        data = np.zeros(8, dtype=np.uint8)
        data[: m.dlc] = list(m.data)
        table[i] = (1, m.arbitration_id, m.is_extended_id, m.dlc, m.dlc, data, 0)
    times = np.array([m.timestamp for m in messages]) - START_NS / 1e9
    from asammdf.blocks.source_utils import Source

    source = Source(
        name="CAN", path="CAN1", comment="", source_type=Source.SOURCE_BUS, bus_type=Source.BUS_TYPE_CAN
    )
    with MDF(version="4.10") as mdf:
        mdf.start_time = datetime.fromtimestamp(START_NS / 1e9, tz=UTC)
        mdf.append(Signal(table, times, name="CAN_DataFrame", source=source), acq_source=source)
        mdf.save(path, overwrite=True, compression=2)
