"""A brake pressure that stands at one value for the whole drive while the vehicle brakes.

Motors, retarders and hills slow a vehicle without any friction brake, so that little is certain: a constant pressure may be a right one, offset and all.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import BoolArray, Grid
from parsers.checks.motion import seconds, smooth
from parsers.checks.pedals import change_of_speed
from parsers.checks.wording import show
from parsers.drive import Decision, Signal

_NAME = "brake_pressure"
_SURE = 5.0
"""m/s² of lost speed that no motor, retarder or hill makes: cars that drive with one pedal take up to 3, a slope of 10 % one more."""
_LIKELY = 2.0
_FELT = 0.6
"""Share of it that accel_x must show where it is there: a speed may break off."""
_LEAST_S = 1.0
_LEAST_SAMPLES = 20


def dead_brakes(signals: Mapping[str, Signal], grid: Grid) -> list[Decision]:
    """What is decided of a constant brake pressure: left out where only friction brakes explain the drive, said where they likely do."""
    signal, change = signals.get(_NAME), change_of_speed(grid)
    if signal is None or change is None or len(signal.values) < _LEAST_SAMPLES:
        return []
    if float(np.ptp(signal.values)) > 0.0:
        return []
    there = np.isfinite(grid.columns[_NAME])
    if not _slows(grid, change, _LIKELY, there):
        return []
    sure = _slows(grid, change, _SURE, there)
    found = f"{_NAME} stands at {show(_NAME, float(signal.values[0]))} for the whole drive"
    slowest = _SURE if sure else _LIKELY
    evidence = f"{len(signal.values)} equal samples while the vehicle slows by more than {slowest:g} m/s²"
    action = (
        "left out"
        if sure
        else "left in: a motor or a retarder may have braked; else leave it out in a mapping file"
    )
    return [Decision(_NAME, "range", found, action, evidence, applied=sure)]


def _slows(grid: Grid, change: FloatArray, least: float, there: BoolArray) -> bool:
    """Whether the vehicle loses speed by more than `least` m/s² for a second, accel_x agreeing. change: (n,), its sign that of a drive forwards."""
    speed_falls = (change < -least) & there
    forward = grid.get("accel_x")
    if forward is not None:
        speed_falls &= smooth(forward) < -_FELT * least
    return seconds(speed_falls) >= _LEAST_S
