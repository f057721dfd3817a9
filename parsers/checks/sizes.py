"""Units that a signal's size alone tells, where the log states none: nothing else is as large or as small."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.grid import Grid, compare, size
from parsers.checks.motion import smooth, speed_names, vehicle_speed
from parsers.drive import Decision
from parsers.signals import WHEELS

_MM = (15.0, 400.0)
"""Travel in mm. A road vehicle's wheel moves less than 15 inches, and one that is driven more than 15 mm."""
_RADIUS_M = (0.292, 0.41)
"""Rolling radii of cars. 0.278 (km/h for m/s) lies below, 0.447 (mph) above."""
_LEAST_PRESSURE_PA = 5e4
_NO_BRAKES_PA_PER_MPS2 = 5e3
"""A vehicle slowed by 1 m/s² with less has no brakes that are known; air brakes take 50 kPa and more. In bar it reads 0.5 to 20, in psi up to
300, in kPa up to 2000."""
_LEAST_PA_PER_MPS2 = 2.5e5
"""Half of what the strongest hydraulic brakes of road vehicles take for 1 m/s². Air brakes take 1 to 2 bar."""
_MOST_PA_PER_MPS2 = 4.5e6
"""Twice what the weakest hydraulic brakes of laden vans take for 1 m/s². Brakes that an electric motor relieves do not go with the loss of speed."""
_GOES_ALONG = 0.7
_SURE = 0.95


def size_faults(grid: Grid, stated: Mapping[str, bool]) -> tuple[dict[str, float], list[Decision]]:
    """Factors of signals whose unit the log does not state and whose size tells it, and all decisions."""
    factors: dict[str, float] = {}
    decisions: list[Decision] = []
    for found, said in (_deflections(grid, stated), _wheel_turns(grid, stated)):
        factors |= found
        decisions += said
    return factors, decisions


def _unstated(grid: Grid, quantity: str, stated: Mapping[str, bool]) -> list[str]:
    names = [f"{quantity}_{wheel}" for wheel in WHEELS]
    return [name for name in names if grid.get(name) is not None and not stated.get(name, True)]


def _deflections(grid: Grid, stated: Mapping[str, bool]) -> tuple[dict[str, float], list[Decision]]:
    names = _unstated(grid, "suspension_deflection", stated)
    largest = max((size(grid.columns[name]) for name in names), default=0.0)
    if not _MM[0] <= largest <= _MM[1]:
        return {}, []
    evidence = f"they reach {largest:.3g}"
    return dict.fromkeys(names, 1e-3), [
        Decision(
            name, "unit", f"{name} is in mm, but was taken for m", "divided by 1000", evidence, applied=True
        )
        for name in names
    ]


def _wheel_turns(grid: Grid, stated: Mapping[str, bool]) -> tuple[dict[str, float], list[Decision]]:
    names, speed = _unstated(grid, "wheel_speed", stated), grid.get("speed")
    if not names or speed is None or not (stated.get("speed", True) or _agrees(grid, speed)):
        return {}, []
    mean = np.mean([grid.columns[name] for name in names], axis=0)
    moving = (np.abs(speed) > 2.0) & (np.abs(mean) > 2.0)
    found = compare(np.abs(mean), np.abs(speed), moving, centred=False)
    if found is None or found.correlation < _SURE or not _RADIUS_M[0] <= 1 / found.ratio <= _RADIUS_M[1]:
        return {}, []
    radius = 1 / found.ratio
    evidence = f"they are {found.ratio:.3g} times the speed (correlation {found.correlation:.2f})"
    return dict.fromkeys(names, radius), [
        Decision(
            name,
            "unit",
            f"{name} is a turn rate in rad/s, but was taken for m/s",
            f"multiplied by the rolling radius that makes it the speed, {radius:.3f} m",
            evidence,
            applied=True,
        )
        for name in names
    ]


def _agrees(grid: Grid, speed: FloatArray) -> bool:
    """Whether the accelerometer says that a speed is in m/s."""
    forward = grid.get("accel_x")
    found = None if forward is None else compare(smooth(forward), grid.rate(smooth(speed)))
    return found is not None and found.correlation > _SURE and 0.8 < found.ratio < 1.25


def pressure_faults(grid: Grid, stated: Mapping[str, bool], units: Collection[Decision]) -> list[Decision]:
    """A pressure in another unit. What is no pascals at all is left out, as bar, MPa, psi and kPa cannot be told apart (lorries
    brake with a tenth of the pressure); what brakes too well or too badly is said, and left alone.

    grid: with all units repaired, as the loss of speed is judged by its size. units: what was decided of them.
    """
    pressure, speed, forward = grid.get("brake_pressure"), vehicle_speed(grid), grid.get("accel_x")
    lost = -grid.rate(speed) if speed is not None else None if forward is None else -forward
    if pressure is None or lost is None:
        return []
    largest = size(pressure)
    found = compare(pressure, lost)
    if found is None or abs(found.correlation) < 0.5:
        return []
    by = "loss of speed" if speed is not None else "longitudinal acceleration"
    evidence = f"correlation {found.correlation:.2f} with the {by}"
    if 0 < largest < _LEAST_PRESSURE_PA and found.ratio < _NO_BRAKES_PA_PER_MPS2:
        text = f"brake_pressure is in bar, MPa, kPa or psi, not in Pa: it reaches {largest:.3g} while the vehicle brakes"
        action = "left out: say the unit in a mapping file"
        return [Decision("brake_pressure", "range", text, action, evidence, applied=True)]
    if speed is None or not stated.get("brake_pressure", True):
        return []
    well = 0 < found.ratio < _LEAST_PA_PER_MPS2
    badly = found.ratio > _MOST_PA_PER_MPS2 and found.correlation > _GOES_ALONG
    if not (well or badly) or not _sure_speed(grid, stated, units):
        return []
    per = found.ratio / 1e5
    text = f"brake_pressure slows the vehicle by 1 m/s² for every {per:.2g} bar: as "
    text += "MPa called bar would, or air brakes" if well else "bar called MPa would"
    evidence += "; hydraulic brakes take 5 to 20 bar"
    action = "left as it is: say the unit in a mapping file"
    return [Decision("brake_pressure", "unit", text, action, evidence, applied=False)]


def _sure_speed(grid: Grid, stated: Mapping[str, bool], units: Collection[Decision]) -> bool:
    """Whether the vehicle's speed is in m/s beyond doubt: stated, repaired or felt, and nothing speaks against it."""
    names = list(speed_names(grid))
    # what is said of all wheels in common stands under one of them
    alike = [name for name in grid.columns if name.startswith("wheel_speed_")] if len(names) > 1 else names
    if any(each.signal in alike and not each.applied for each in units):
        return False
    repaired = {each.signal for each in units}
    known = all(stated.get(name, True) or name in repaired for name in names)
    speed = vehicle_speed(grid)
    return known or (speed is not None and _agrees(grid, speed))
