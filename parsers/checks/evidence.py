"""What physics says of the units of signals: ratios that must lie in a range if all units are right."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray
from parsers.checks.codes import USUAL_MOST
from parsers.checks.grid import BoolArray, Grid, Together, compare, size
from parsers.checks.motion import MIN_SPEED, path_speed, path_turn_rate, smooth
from parsers.checks.pedals import by_pedals
from parsers.checks.springs import springs_tilt
from parsers.quantiles import median

_SHARP = 0.2
_SURE = 6.0
_MOST = 4.0
_HINT = 2.0
_SELDOM = 1.2
"""More than a mistake in a unit that the log does not state, less than one in a unit that it does."""
_VARIED, _ALIKE = 0.1, 0.5
_TURNS_ALIKE = 0.85
_LEAST_ALONG = 0.85
_LEAST_PUSHED, _LEAST_LOOSELY = 0.75, 0.4
_LEAST_BY_ROADS, _MOST_BY_ROADS = 0.001, 0.4
"""Rad per m/s²: drives on roads of all kinds come to 0.002 to 0.05."""
_LEAST_LEAN = 0.0002
"""Rad per m/s²: 0.1 °/g."""
_TWO_THIRDS = 0.68
_LEAST_RATE, _MOST_RATE = 0.0006, 0.5
"""rad/s: 0.001 (standing, a gyro's noise) to 0.1 in drives; in deg/s 0.5 to 4."""
_STANDS = 2.2
"""More than it costs that one axis of a sensor has a unit of its own."""
_TRACKS_M, _WHEELBASES_M = 3.0, 5.5
"""Twice a track, and twice a wheelbase: what `springs_tilt` grows by for one rad."""
_LEAST_OF_SPRINGS, _MOST_OF_SPRINGS = 0.5, 40.0
"""The body's turning over the springs' is 1 to 2.5; deflections in inches called mm make it 60 at the most, deg/s called rad/s 60 and more."""


@dataclass(frozen=True)
class Evidence:
    """A ratio that must lie between low and high.

    powers: how the ratio changes with each signal's factor. cost: at most this much for a ratio out of range. text:
    the finding in words, with "{ratio}" for the ratio. seldom: below that the ratio is one that few vehicles have.
    """

    powers: Mapping[str, float]
    ratio: float
    low: float
    high: float
    cost: float
    text: str
    seldom: float = 0.0

    def after(self, factors: Mapping[str, float]) -> float:
        """The ratio when signals are multiplied by factors."""
        ratio = self.ratio
        for name, power in self.powers.items():
            ratio *= math.pow(factors.get(name, 1.0), power)
        return ratio

    def penalty(self, factors: Mapping[str, float]) -> float:
        """How badly the ratio fits when signals are multiplied by factors: 0 in range, `cost` far outside."""
        ratio = self.after(factors)
        unusual = 0.0
        if ratio < self.seldom:
            unusual = min((math.log(self.seldom / ratio) / _SHARP) ** 2, _SELDOM)
        if self.low <= ratio <= self.high:
            return unusual
        outside = math.log(self.low / ratio if ratio < self.low else ratio / self.high)
        return float(min(unusual + (outside / _SHARP) ** 2, self.cost))

    def words(self) -> str:
        """The finding with its figure."""
        return self.text.format(ratio=f"{self.ratio:.3g}")


def collect(grid: Grid) -> list[Evidence]:
    """All evidence that a drive gives."""
    finders: tuple[Callable[[Grid], Iterator[Evidence]], ...] = (
        _magnitudes,
        _speeds,
        _lateral,
        _long,
        _angles,
        _rates,
    )
    return [
        each for finder in finders for each in finder(grid) if each.ratio > 0 and math.isfinite(each.ratio)
    ]


def _related(
    found: Together | None,
    powers: Mapping[str, float],
    span: tuple[float, float],
    text: str,
    least: float = 0.9,
    seldom: float = 0.0,
) -> Iterator[Evidence]:
    if found is not None and abs(found.correlation) >= least:
        text = f"{text} {{ratio}} (correlation {found.correlation:.2f} over {found.seconds:.0f} s)"
        yield Evidence(powers, found.ratio, span[0], span[1], _SURE, text, seldom)


def _magnitudes(grid: Grid) -> Iterator[Evidence]:
    """Sizes that no drive reaches (or only a rolled-over vehicle: then a hint)."""
    impossible = {
        "roll": 3.3, "pitch": 3.3, "roll_rate": 10.0, "pitch_rate": 10.0, "yaw_rate": 10.0,
        "steering_wheel_angle": 40.0, "speed": 110.0, "gps_speed_2d": 110.0, "accel_x": 60.0, "accel_y": 60.0,
    }  # fmt: skip
    for name, usual in USUAL_MOST.items():
        column = grid.get(name)
        large = 0.0 if column is None else size(column)
        if large > 0:
            cost = _SURE if large > impossible[name] else _HINT
            yield Evidence(
                {name: 1.0}, large, 1e-9, usual, cost, f"{name} reaches {{ratio}} in the unit assumed"
            )
    vertical = grid.get("accel_z")
    if vertical is not None and np.isfinite(vertical).any():
        middle = abs(median(vertical))
        if middle > 0.3:
            text = "accel_z is {ratio} at its median (gravity is 9.81 m/s²)"
            yield Evidence({"accel_z": 1.0}, middle, 8.7, 10.9, _SURE, text)


def _speeds(grid: Grid) -> Iterator[Evidence]:
    """Speeds against each other and against the path over ground."""
    columns = {name: grid.get(name) for name in ("speed", "gps_speed_2d")}
    columns["path"] = path_speed(grid)
    wheels = [grid.columns[name] for name in sorted(grid.columns) if name.startswith("wheel_speed_")]
    columns["wheels"] = np.mean(wheels, axis=0) if wheels else None
    for first, second in (("speed", "path"), ("gps_speed_2d", "path"), ("wheels", "path"), ("wheels", "speed"), ("speed", "gps_speed_2d")):  # fmt: skip
        a, b = columns[first], columns[second]
        if a is None or b is None:
            continue
        moving = (np.abs(a) > 0.5) & (np.abs(b) > 0.5)
        if second == "path" and not _goes_along(b, a, moving):
            continue
        found = compare(np.abs(a), np.abs(b), moving, centred=False)
        powers = {name: power for name, power in ((first, 1.0), (second, -1.0)) if name != "path"}
        if found is not None and found.seconds > 5:
            yield from _related(found, powers, (0.9, 1.1), f"{first} over speed of {second} is")


def _goes_along(path: FloatArray, speed: FloatArray, moving: BoolArray) -> bool:
    """Whether a path's speed changes as another speed does, where that changes: a poor fix creeps while the vehicle drives."""
    values = np.abs(speed[moving & np.isfinite(path)])
    if len(values) == 0 or float(values.std()) < _VARIED * float(values.mean()):
        return True
    found = compare(path, np.abs(speed), moving)
    return found is not None and found.correlation >= _ALIKE


def _lateral(grid: Grid) -> Iterator[Evidence]:
    """Lateral acceleration, yaw rate and speed; steering against the path's curvature."""
    speed, yaw, lateral = grid.get("speed"), grid.get("yaw_rate"), grid.get("accel_y")
    turning, ground = path_turn_rate(grid), path_speed(grid)
    speed_powers, least = {"speed": 1.0}, 1.0
    if speed is None:
        speed_powers, least = {}, MIN_SPEED
        # the path stands for the speed only where it turns as the vehicle does
        along = None if yaw is None or turning is None else compare(yaw, turning, centred=False)
        speed = ground if along is not None and abs(along.correlation) >= _TURNS_ALIKE else None
    if yaw is not None and speed is not None:
        moving: BoolArray = np.abs(speed) > least
        powers = {"yaw_rate": -1.0} | dict.fromkeys(speed_powers, -1.0)
        if lateral is not None:
            found = compare(lateral, yaw * speed, moving, centred=False)
            text = "lateral acceleration over yaw_rate × speed is"
            yield from _related(found, {"accel_y": 1.0} | powers, (0.7, 1.45), text)
        steering = grid.get("steering_wheel_angle")
        if steering is not None:
            curvature = yaw / np.where(np.abs(speed) > MIN_SPEED, np.abs(speed), np.nan)
            found = compare(steering, curvature)
            by = {"steering_wheel_angle": 1.0, "yaw_rate": -1.0} | speed_powers
            yield from _related(found, by, (12, 400), "steering angle over path curvature is [rad·m]", 0.8)
    if turning is not None and ground is not None:
        if yaw is not None:
            found = compare(yaw, turning, centred=False)
            yield from _related(
                found, {"yaw_rate": 1.0}, (0.7, 1.4), "yaw_rate over the path's turn rate is", _TURNS_ALIKE
            )
        if lateral is not None:
            found = compare(smooth(lateral), turning * ground, centred=False)
            text = "lateral acceleration over the path's is"
            yield from _related(found, {"accel_y": 1.0}, (0.65, 1.5), text, 0.85)


def _long(grid: Grid) -> Iterator[Evidence]:
    """Longitudinal acceleration against the change of speed, where pedals make it: grades are in the one and not in the other."""
    forward = grid.get("accel_x")
    for name in ("speed", "gps_speed_2d"):
        speed = grid.get(name)
        if forward is not None and speed is not None:
            found = by_pedals(grid, forward, grid.rate(smooth(speed)), _LEAST_ALONG)
            powers = {"accel_x": 1.0, name: -1.0}
            yield from _related(
                found, powers, (0.7, 1.45), f"accel_x over the change of {name} is", _LEAST_ALONG
            )


def _angles(grid: Grid) -> Iterator[Evidence]:
    """Roll and pitch against their rates and against the acceleration that makes them.

    A body leans 2 to 12 °/g, a racing car's 0.2 to 1; on a banked road a level-headed attitude sensor sees 1 rad per g (0.102 rad per m/s²).
    """
    for angle, rate, drive, span, seldom in (
        ("roll", "roll_rate", "accel_y", (_LEAST_LEAN, 0.125), 0.002),
        ("pitch", "pitch_rate", "accel_x", (0.0003, 0.15), 0.0),
    ):
        tilt, turning, push = grid.get(angle), grid.get(rate), grid.get(drive)
        if tilt is not None and turning is not None:
            found = compare(grid.rate(tilt), turning)
            powers = {angle: 1.0, rate: -1.0}
            yield from _related(found, powers, (0.6, 1.6), f"the change of {angle} over {rate} is", 0.8)
        if tilt is not None and push is not None:
            found = compare(tilt, push)
            powers = {angle: 1.0, drive: -1.0}
            yield from _related(found, powers, span, f"{angle} over {drive} is [rad per m/s²]", 0.75, seldom)
        elif turning is not None and push is not None:
            found = compare(turning, grid.rate(push))
            powers = {rate: 1.0, drive: -1.0}
            text = f"{rate} over the change of {drive} is [rad per m/s²]"
            if found is not None and abs(found.correlation) < _LEAST_PUSHED:
                # roads turn the body as well, by no more than a few times what pushes it
                seldom = min(seldom, _LEAST_BY_ROADS)
                span = (max(span[0], 0.5 * seldom), _MOST_BY_ROADS)
            yield from _related(found, powers, span, text, _LEAST_LOOSELY, seldom)


def _rates(grid: Grid) -> Iterator[Evidence]:
    """Each axis of a gyro by itself: by its size on any drive, and by what the springs show of the same turning.

    Of the springs only too large a rate is told: deflections in cm called m are as much too large as rad/s called deg/s are too small.
    """
    for rate, angle, metres in (("roll_rate", "roll", _TRACKS_M), ("pitch_rate", "pitch", _WHEELBASES_M), ("yaw_rate", "", 1.0)):  # fmt: skip
        turning = grid.get(rate)
        if turning is None or not np.isfinite(turning).any():
            continue
        spread = size(turning - median(turning[np.isfinite(turning)]), _TWO_THIRDS)
        text = f"{rate} is within {{ratio}} rad/s for two thirds of the drive"
        if spread > 0:
            # an axis that stands still is no reason to multiply it, but one not to divide it with the others
            yield Evidence({rate: 1.0}, spread, min(spread, _LEAST_RATE), math.inf, _STANDS, text)
            if angle:
                yield Evidence({rate: 1.0}, spread, 1e-9, _MOST_RATE, _HINT, text)
        springs = springs_tilt(grid, angle) if angle else None
        if springs is not None:
            found = compare(turning, grid.rate(springs) / metres)
            text = f"{rate} over that of the springs is"
            yield from _related(found, {rate: 1.0}, (1e-9, _MOST_OF_SPRINGS), text, _LEAST_OF_SPRINGS)
