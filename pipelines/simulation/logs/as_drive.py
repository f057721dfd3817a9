"""What the sensors of a simulated drive gave, as the drive that an importer would make of it."""

from __future__ import annotations

import numpy as np

from parsers.drive import Drive, ImportRecord, Signal
from pipelines.simulation.sensors.units import SensorLog


def drive_of(log: SensorLog, start_ns: int = 0) -> Drive:
    """The drive on a clock that begins at start_ns. A signal that was lost as a whole has no samples and is not in it."""
    signals: dict[str, Signal] = {}
    for group in log.groups:
        for name, values in group.columns.items():
            there = np.isfinite(values)
            if np.count_nonzero(there) > 1:
                signals[name] = Signal(
                    name, group.time_ns[there] + start_ns, values[there], "simulated", group=group.name
                )
    duration = max(float(group.time_ns[-1]) for group in log.groups) / 1e9
    record = ImportRecord(
        format="simulation", paths=(), sha256="", status="complete", messages=len(signals), rejected={}, gaps=(),
        clock="simulated", start_utc=None, duration_s=duration, mapped=(),
    )  # fmt: skip
    return Drive(signals, record, start_ns)
