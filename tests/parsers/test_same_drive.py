"""The same drive in all formats: the same signals, to the precision that each format carries."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_importer_contract import SAMPLES, options_for

from parsers.drive import Drive
from parsers.load import load_drive
from parsers.store import write_drive

# half a step of the coarsest writing: CAN signals as in the sample's DBC, VBO and TSV by their decimals, float32 in bags
TOLERANCE = {
    "accel_x": 6e-4, "accel_y": 6e-4, "accel_z": 6e-4, "roll_rate": 5e-5, "pitch_rate": 5e-5, "yaw_rate": 5e-5,
    "roll": 2e-5, "pitch": 2e-5, "speed": 1.5e-3, "steering_wheel_angle": 5e-4,
    "wheel_speed_fl": 1.5e-3, "wheel_speed_fr": 1.5e-3, "wheel_speed_rl": 1.5e-3, "wheel_speed_rr": 1.5e-3,
    "brake_pressure": 0.6, "brake_torque": 1e-3, "drive_torque": 1e-3,
}  # fmt: skip
DEFLECTION = 6e-6


@pytest.fixture(scope="module")
def reference(samples: Path) -> Drive:
    return load_drive([samples / "parquet/drive.parquet"])


@pytest.mark.parametrize("name", SAMPLES)
def test_same_signals(name: str, samples: Path, reference: Drive) -> None:
    drive = load_drive([samples / name], options_for(samples / name))
    assert set(reference.signals) <= set(drive.signals)
    assert not [d for d in drive.record.decisions if d.applied or d.kind != "offset"]
    for signal_name, expected in reference.signals.items():
        signal = drive.signals[signal_name]
        assert len(signal.values) == len(expected.values), signal_name
        seconds = (signal.time_ns - signal.time_ns[0]) / 1e9
        assert np.abs(seconds - (expected.time_ns - expected.time_ns[0]) / 1e9).max() < 2e-4
        error = np.abs(signal.values - expected.values)
        if signal_name == "speed":
            # CAN and VBO cannot say a negative speed
            error = np.abs(signal.values - np.maximum(expected.values, signal.values.min()))
        assert error.max() <= TOLERANCE.get(signal_name, DEFLECTION), signal_name


@pytest.mark.parametrize("name", ["ros/drive.bag", "can/drive.blf"])
def test_store_round_trip(name: str, samples: Path, tmp_path: Path) -> None:
    drive = load_drive([samples / name], options_for(samples / name))
    write_drive(drive, tmp_path / "store")
    again = load_drive([tmp_path / "store"])
    assert set(again.signals) == set(drive.signals)
    for signal_name, signal in drive.signals.items():
        assert np.array_equal(again.signals[signal_name].values, signal.values)
        assert np.array_equal(again.signals[signal_name].time_ns, signal.time_ns)
