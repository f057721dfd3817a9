"""A speed that has nothing to do with the bends that are driven at it: along an axis of the world, of another vehicle, or no speed at all.

Bends tell their speed themselves: what is felt across over the yaw rate. Where those two go together and a speed makes nothing better but all
worse, it is not the vehicle's.
"""

from __future__ import annotations

from collections.abc import Collection

from parsers.checks.grid import Grid, compare, size
from parsers.checks.motion import smooth
from parsers.drive import Decision

_TURNS_RADPS = 0.04
_GOES_ALONG = 0.85
"""Correlation of accel_y with the yaw rate alone from which on bends tell a speed."""

_ASTRAY, _WORSE = 0.6, 0.25
"""Its correlation with yaw_rate × speed, where it is below the one, and by the other below that with the yaw rate alone."""

_ALONG = 0.5
"""Correlation of accel_x with the change of speed from which on that speed is the vehicle's all the same."""

_SMALL = 1.4
"""accel_y over yaw_rate × speed from which on that is too small: roads that bank make it less, a body's lean at most a tenth more."""

_MOVES_MPS2 = 0.7
_DRIVES_MPS = (3.0, 90.0)
_LEAST_S = 10.0


def stray_speed(grid: Grid, doubted: Collection[str]) -> list[Decision]:
    """What is said of it; it is left alone. grid: with all units repaired; doubted: signals of which something is said already."""
    speed, across, yaw = grid.get("speed"), grid.get("accel_y"), grid.get("yaw_rate")
    if speed is None or across is None or yaw is None or "speed" in doubted:
        return []
    turning = abs(yaw) > _TURNS_RADPS
    bends = compare(across, yaw, turning, centred=False)
    driven = compare(across, yaw * speed, turning, centred=False)
    if bends is None or driven is None or bends.seconds < _LEAST_S or driven.seconds < bends.seconds / 2:
        return []
    alone, times = abs(bends.correlation), abs(driven.correlation)
    if alone < _GOES_ALONG:
        return []
    if not _DRIVES_MPS[0] < bends.ratio < _DRIVES_MPS[1]:
        return []
    along = grid.get("accel_x")
    change = None if along is None else compare(smooth(along), grid.rate(smooth(speed)))
    if change is not None and abs(change.correlation) > _ALONG:
        return []
    astray = times < min(_ASTRAY, alone - _WORSE)
    # along an axis of the world that the vehicle keeps to within some tens of degrees it is too small in every bend
    moves = along is not None and min(size(along), size(grid.rate(smooth(speed)))) > _MOVES_MPS2
    if not astray and (change is None or not moves or driven.ratio < _SMALL):
        return []
    return [
        Decision(
            "speed", "scale",
            f"speed does not go with the bends, which are driven at about {bends.ratio:.2g} m/s: it may count along an axis of the world, or be another's",
            "left as it is: name the right channel in a mapping file",
            f"accel_y over yaw_rate × speed is {driven.ratio:.2f} (correlation {times:.2f}, with yaw_rate alone {alone:.2f})"
            + (f"; accel_x with the change of speed: correlation {change.correlation:.2f}" if change is not None else ""),
            applied=False,
        )
    ]  # fmt: skip
