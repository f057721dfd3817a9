"""The log's channels whose scale is an unknown that no other has: torques and forces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pipelines.evidence import Evidence
from pipelines.joint.vehicle.book import AXLES

TORQUE, FORCE = 1.0, 0.25
"""Spread of a wrong scale about 1. Of a torque its logarithm's: a gearbox's ratio of ten is no surprise then. Of a force: a load cell of another range, or one axle's alone."""

CHANNELS: Mapping[str, tuple[tuple[str, ...], float]] = {
    "drive torque": (("drive_scale",), TORQUE),
    "brake torque": (("brake_scale",), TORQUE),
    "suspension forces": (tuple(f"suspension_scale_{axle}" for axle in AXLES), FORCE),
    "tyre forces": (tuple(f"tyre_scale_{axle}" for axle in AXLES), FORCE),
    "axle loads": (tuple(f"axle_scale_{axle}" for axle in AXLES), FORCE),
}
"""Channels, the unknowns that hold their scale, and how far those are opened."""

WRONG = "{} of a wrong scale"


def channels_of(evidence: Sequence[Evidence]) -> dict[str, tuple[tuple[str, ...], float]]:
    """Those of `CHANNELS` that some relation has."""
    used = {name for e in evidence for name in e.unknowns}
    return {channel: found for channel, found in CHANNELS.items() if used & {*found[0]}}
