"""What all writers share: the drive, when it was, and its columns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from parsers.signals import SIGNALS
from pipelines.results import FloatArray
from pipelines.simulation.sensors import parts as parts
from pipelines.simulation.sensors.truth import Mount
from pipelines.simulation.sensors.units import SensorLog, SensorSet

START_NS = 1_760_000_000_000_000_000
"""2025-10-09T08:53:20Z."""

DEG = 180 / np.pi
G = 9.80665


@dataclass(frozen=True)
class SampleDrive:
    """time_s (n,) from the start; signals by canonical name, (n,), all on this clock, without gaps."""

    time_s: FloatArray
    signals: Mapping[str, FloatArray]


def stamps_ns(drive: SampleDrive) -> np.ndarray:
    """(n,) absolute stamps."""
    return START_NS + np.round(drive.time_s * 1e9).astype(np.int64)


def quaternion(roll: np.ndarray, pitch: np.ndarray) -> np.ndarray:
    """(n, 4) x, y, z, w of roll about x after pitch about y, without yaw."""
    cr, sr, cp, sp = np.cos(roll / 2), np.sin(roll / 2), np.cos(pitch / 2), np.sin(pitch / 2)
    return np.stack([sr * cp, cr * sp, -sr * sp, cr * cp], axis=1)


def one_clock_sensors(mount: Mount, rate_hz: float) -> SensorSet:
    """What the sample logs measure, all at one rate and without gaps, so that every format can hold it alike."""
    units = (parts.ins(mount), parts.wheels(), parts.driver(), parts.torques(), parts.deflections())
    return SensorSet("samples", "the sample logs' sensors", units).at_rate(rate_hz)


def on_one_clock(log: SensorLog) -> SampleDrive:
    """A log whose groups share their stamps, as one table in the order of the canonical signals."""
    found = log.signals
    return SampleDrive(log.groups[0].time_ns / 1e9, {name: found[name] for name in SIGNALS if name in found})
