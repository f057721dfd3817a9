"""What all writers share: when the drive was, and its columns."""

from __future__ import annotations

import numpy as np

from pipelines.simulation.roll_drive import SimulatedDrive

START_NS = 1_760_000_000_000_000_000
"""2025-10-09T08:53:20Z."""

DEG = 180 / np.pi
G = 9.80665
ORIGIN = (48.137, 11.575, 520.0)


def stamps_ns(drive: SimulatedDrive) -> np.ndarray:
    """(n,) absolute stamps."""
    return START_NS + np.round(drive.time_s * 1e9).astype(np.int64)


def quaternion(roll: np.ndarray, pitch: np.ndarray) -> np.ndarray:
    """(n, 4) x, y, z, w of roll about x after pitch about y, without yaw."""
    cr, sr, cp, sp = np.cos(roll / 2), np.sin(roll / 2), np.cos(pitch / 2), np.sin(pitch / 2)
    return np.stack([sr * cp, cr * sp, -sr * sp, cr * cp], axis=1)
