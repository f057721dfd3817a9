"""Places that are none: accelerations in columns called Lat and Long, which would fly, and heights over the axle, which would leap.

Only places whose unit the log does not state are looked at: a receiver's are in degrees, and mostly say so.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from parsers.checks.grid import make_grid, size
from parsers.drive import Decision, Signal

PLACE = ("latitude", "longitude")
FASTEST_MPS = 1000.0
"""No vehicle's place moves as quickly, and no receiver's noise: that is some metres, and not at every row of a quick log."""

CLIMBS_MPS = 30.0
"""No road makes a vehicle rise as quickly, and no receiver's noise between means over 0.1 s."""

CLOSE_NS = 2_000_000_000
FEWEST = 50
_METRES = 111_195.0
_IN_G, _IN_MPS2 = 1.5, 30.0
"""What accelerations of a vehicle reach, in g and in m/s²: a drive hardly stays below the first in m/s²."""


def no_places(signals: Mapping[str, Signal], stated: Mapping[str, bool]) -> dict[str, Decision]:
    """Both coordinates, each with its decision, where they are no places. stated: signal -> whether its unit is known."""
    latitude, longitude = (signals.get(name) for name in PLACE)
    if latitude is None or longitude is None or any(stated.get(name, True) for name in PLACE):
        return {}
    if not np.array_equal(latitude.time_ns, longitude.time_ns):
        return {}
    flies = _flies_mps(latitude, longitude)
    if flies < FASTEST_MPS:
        return {}
    most = max(size(latitude.values), size(longitude.values))
    unit = "g" if most < _IN_G else "m/s2" if most < _IN_MPS2 else None
    text = f"would move by {flies / 1000:.2g} km a second as places"
    action = "left out"
    if unit is not None:
        text += f", and are as large as accelerations in {unit.replace('2', '²')}"
        action += (
            f'; where they are that, a mapping file says [signals.accel_y] channel = "{latitude.source}", unit = "{unit}" and '
            f'[signals.accel_x] channel = "{longitude.source}", unit = "{unit}"'
        )
    evidence = "the log states no unit, and they change with every row"
    return {
        name: Decision(name, "range", f"latitude and longitude {text}", action, evidence, applied=True)
        for name in PLACE
    }


def no_altitude(signals: Mapping[str, Signal], stated: Mapping[str, bool]) -> dict[str, Decision]:
    """The altitude with its decision, where it is the body's height in mm. stated: as in `no_places`."""
    altitude = signals.get("altitude")
    if altitude is None or stated.get("altitude", True):
        return {}
    grid = make_grid({"altitude": altitude})
    climbs = np.abs(grid.rate(grid.columns["altitude"]))
    climbs = climbs[np.isfinite(climbs)]
    usual = float(np.median(climbs)) if len(climbs) >= FEWEST else 0.0
    if usual < CLIMBS_MPS:
        return {}
    text = f"altitude would rise and fall by {usual:.2g} m/s most of the time: it is no height above the sea"
    action = "left out; name the right channel and its unit in a mapping file"
    evidence = "the log states no unit"
    return {"altitude": Decision("altitude", "range", text, action, evidence, applied=True)}


def _flies_mps(latitude: Signal, longitude: Signal) -> float:
    """The usual step between places that differ, times how many there are, over the time."""
    step_ns = np.diff(latitude.time_ns)
    close = step_ns < CLOSE_NS
    # no cosine: near a pole, where it matters, nobody drives
    steps = np.hypot(np.diff(latitude.values), np.diff(longitude.values))[close] * _METRES
    moved = steps[steps > 0]
    seconds = float(step_ns[close].sum()) / 1e9
    return float(np.median(moved)) * len(moved) / seconds if len(moved) >= FEWEST else 0.0
