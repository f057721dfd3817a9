"""A speed of a vehicle that hardly moves, while its bends are those of one that drives: another velocity's channel."""

from __future__ import annotations

from collections.abc import Mapping

from parsers.checks.grid import compare, make_grid, size
from parsers.drive import Decision, Signal

SPEEDS = ("speed", "gps_speed_2d", "gps_speed_3d")
_FELT = ("accel_y", "yaw_rate")
SLOW_MPS = 1.5
"""What such a speed never exceeds: velocities to the side and upwards stay below, but for drifting."""

TIMES = 6.0
"""Bends must tell of a speed so many times as large: no unit of speed that is taken for another makes as much."""

DRIVES_MPS = (4.0, 70.0)
TURNS_RADPS = 0.04
ACROSS_MPS2 = 1.0
GOES_ALONG = 0.85
LEAST_S = 5.0


def slow_speeds(signals: Mapping[str, Signal]) -> dict[str, Decision]:
    """The speeds that are left out for it, each with its decision. signals: as they came."""
    slow = [name for name in SPEEDS if name in signals and 0 < size(signals[name].values) < SLOW_MPS]
    if not slow or any(name not in signals for name in _FELT):
        return {}
    grid = make_grid({name: signals[name] for name in (*slow, *_FELT)})
    across, yaw = grid.get("accel_y"), grid.get("yaw_rate")
    if across is None or yaw is None:
        return {}
    turning = abs(yaw) > TURNS_RADPS
    bends = compare(across, yaw, turning, centred=False)
    if bends is None or bends.seconds < LEAST_S or abs(bends.correlation) < GOES_ALONG:
        return {}
    drives = bends.ratio
    if not DRIVES_MPS[0] < drives < DRIVES_MPS[1] or size(across[turning]) < ACROSS_MPS2:
        return {}
    found = {}
    for name in slow:
        most = size(signals[name].values)
        if most < drives / TIMES:
            found[name] = Decision(
                name, "range",
                f"{name} hardly exceeds {most:.2g} m/s, while the bends are driven at about {drives:.2g} m/s: it is another velocity (to the side, "
                "or upwards), or in another unit",
                "left out; name the right channel and its unit in a mapping file",
                f"accel_y over yaw_rate is {drives:.2g} m/s (correlation {abs(bends.correlation):.2f})", applied=True,
            )  # fmt: skip
    return found
