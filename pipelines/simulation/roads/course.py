"""A road written piece by piece (straights, turns, lane changes, stops, humps) and the drive along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.records import GRAVITY, Demand, Road
from pipelines.simulation.roads.profile import eased_in, even_places, hump, smoothed
from pipelines.simulation.roads.speed_plan import (
    Limits,
    Power,
    arrival_times,
    fastest,
    over_time,
    slowest_near,
)

STEP_M = 0.5
CROWN_RAD = 0.02
"""Crossfall of a straight lane with traffic on the right: its left side is the higher one."""


@dataclass(frozen=True)
class Driver:
    """How somebody drives. lateral_mps2: least and most lateral acceleration in a bend, drawn anew for each;
    accel, decel: in traffic; smooth_s: how long a change of acceleration takes; weave_mps2: how unsteady the lane
    keeping is (lateral acceleration); top_mps: the fastest driven anywhere."""

    lateral_mps2: tuple[float, float]
    accel_mps2: float
    decel_mps2: float
    smooth_s: float
    weave_mps2: float
    top_mps: float


def drawn_driver(rng: np.random.Generator, severity: float, hardest_mps2: float, top_mps: float) -> Driver:
    """A normal driver: bends of 0.1 to 0.4 g, 1.2 to 2.2 m/s² away from lights, 1.4 to 2.6 m/s² before bends."""
    style = rng.uniform(0.75, 1.0)
    most = min(0.4 * GRAVITY * style * severity, hardest_mps2)
    return Driver(
        (min(0.1 * GRAVITY, 0.6 * most), most),
        rng.uniform(1.2, 2.2),
        rng.uniform(1.4, 2.6),
        rng.uniform(0.8, 1.4),
        rng.uniform(0.05, 0.15),
        top_mps,
    )


class Course:
    """A road under construction. Rows of STEP_M; what is written later lies further along."""

    def __init__(
        self, driver: Driver, rng: np.random.Generator, rest_s: float, tightest_m: float = 0.0
    ) -> None:
        """Begin with a standstill of rest_s on a short straight. tightest_m: the least radius that will be built."""
        self.driver, self.rng, self.tightest_m = driver, rng, tightest_m
        self._rows: list[FloatArray] = []
        self._stops: list[tuple[int, float, float]] = [(0, rest_s, driver.decel_mps2)]
        self._humps: list[tuple[float, float, float]] = []
        self._count = 0
        self.grade_rad = 0.0
        self.straight(8.0, 50 / 3.6)

    @property
    def length_m(self) -> float:
        """How long the road is so far."""
        return self._count * STEP_M

    def _add(self, curvature: FloatArray, limit_mps: float, superelevation: float = 0.0) -> None:
        rows = len(curvature)
        bank = CROWN_RAD - superelevation * np.sign(curvature)
        limit = np.full(rows, min(limit_mps, self.driver.top_mps))
        self._rows.append(np.stack((curvature, limit, np.full(rows, self.grade_rad), bank)))
        self._count += rows

    def straight(self, length_m: float, limit_mps: float) -> None:
        """A straight with a speed limit."""
        self._add(np.zeros(max(round(length_m / STEP_M), 1)), limit_mps)

    def turn(
        self,
        radius_m: float,
        angle_rad: float,
        limit_mps: float,
        *,
        lateral_mps2: float | None = None,
        tighten: float = 1.0,
        superelevation: float = 0.0,
    ) -> None:
        """A bend through an angle (+ left) with spirals; its speed keeps the lateral acceleration (drawn if None).

        tighten: the radius at the end over the one at the beginning (below 1: it closes up). superelevation: the angle
        by which the outer side is raised.
        """
        if lateral_mps2 is None:
            lateral_mps2 = float(self.rng.uniform(*self.driver.lateral_mps2))
        radius_m = max(radius_m, self.tightest_m / min(tighten, 1.0))
        sharpest = radius_m * min(tighten, 1.0)
        speed = min(limit_mps, self.driver.top_mps, float(np.sqrt(lateral_mps2 * sharpest)))
        # the wheel is turned in over about 1.3 s; the mean curvature of a closing bend is that of its mean
        mean = 0.5 * (1 + 1 / tighten) / radius_m
        turned = abs(angle_rad) / mean
        spiral = min(max(1.3 * speed, 3.0), 0.9 * turned)
        length = turned + spiral
        s = STEP_M * (np.arange(max(round(length / STEP_M), 4)) + 0.5)
        length = STEP_M * len(s)
        shape = np.clip(np.minimum(s, length - s) / spiral, 0.0, 1.0)
        closing = 1 + (1 / tighten - 1) * np.clip((s - spiral) / max(length - 2 * spiral, STEP_M), 0.0, 1.0)
        curvature = shape * closing
        curvature *= abs(angle_rad) / (np.sum(curvature) * STEP_M)
        speed = min(speed, float(np.sqrt(lateral_mps2 / np.max(curvature))))
        self._add(np.sign(angle_rad) * curvature, speed, superelevation)

    def change_lane(self, offset_m: float, length_m: float, limit_mps: float) -> None:
        """A shift to a lane beside (+ left), by a fifth-order polynomial."""
        rows = max(round(length_m / STEP_M), 8)
        x = (np.arange(rows) + 0.5) / rows
        curvature = offset_m / (rows * STEP_M) ** 2 * (60 * x - 180 * x**2 + 120 * x**3)
        self._add(curvature, limit_mps)

    def stop(self, wait_s: float, decel_mps2: float | None = None) -> None:
        """Come to rest here and wait; the braking may be softer or harder than the driver's own."""
        self._stops.append((self._count, wait_s, decel_mps2 or self.driver.decel_mps2))
        self.straight(4.0, self.driver.top_mps)

    def hump(self, length_m: float, height_m: float) -> None:
        """A traffic-calming hump, next on the road."""
        self._humps.append((self.length_m, length_m, height_m))
        self.straight(length_m + 3.0, 50 / 3.6)

    def repeat(self, times: int) -> None:
        """Drive what was built since the start again and again: laps over the very same road."""
        lap = self._rows[1:]
        rows = sum(part.shape[1] for part in lap)
        for _ in range(times):
            self._rows.extend(lap)
            self._count += rows

    def arrays(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Curvature, speed limit, grade and bank over the road, each (m,); grade and bank smooth over 40 and 25 m.

        The road begins level, whatever follows.
        """
        curvature, limit, grade, bank = np.concatenate(self._rows, axis=1)
        level = eased_in(even_places(len(grade), STEP_M), 60.0)
        return curvature, limit, level * smoothed(grade, STEP_M, 40.0), smoothed(bank, STEP_M, 25.0)

    def limits(self) -> Limits:
        """What bounds the speed. Bends count from 6 m before to 6 m behind: the car is never quite where planned."""
        _, limit, grade, _ = self.arrays()
        speed = slowest_near(limit, STEP_M, 6.0)
        decel = np.full(len(speed), self.driver.decel_mps2)
        wait = np.zeros(len(speed))
        for row, seconds, hardness in self._stops:
            if row < len(speed):
                before = round(speed[row] ** 2 / (2 * hardness) / STEP_M) + 8
                decel[max(row - before, 0) : row] = hardness
                speed[row], wait[row] = 0.0, seconds
        return Limits(STEP_M, speed, np.full(len(speed), self.driver.accel_mps2), decel, grade, wait)

    def road(self, friction: float, weave_speed_mps: FloatArray) -> Road:
        """The road as built, friction varying by ±0.05 along it, with the driver's lane keeping in the curvature.

        weave_speed_mps: (m,) planned speed, which sets how much curvature the weave is.
        """
        curvature, _, grade, bank = self.arrays()
        place = even_places(len(curvature), STEP_M)
        rows = len(curvature)
        noise = smoothed(self.rng.standard_normal(rows), STEP_M, 60.0)
        weave = self.driver.weave_mps2 * noise / max(float(noise.std()), 1e-12)
        curvature = curvature + eased_in(place, 30.0) * weave / np.maximum(weave_speed_mps, 8.0) ** 2
        change = smoothed(self.rng.standard_normal(rows), STEP_M, 200.0)
        grip = friction * (1 + 0.05 * np.clip(change / max(2 * float(change.std()), 1e-12), -1, 1))
        height = np.zeros(rows)
        for start, length, top in self._humps:
            height += hump(place, start, length, top)
        return Road(STEP_M, curvature, grade, bank, height, height, grip, grip)


def _with_traffic(limits: Limits, rng: np.random.Generator) -> Limits:
    """Others are slower: speeds above 30 km/h vary between 88 and 100 % along the road."""
    waves = smoothed(rng.standard_normal(len(limits.speed_mps)), STEP_M, 150.0)
    share = 0.94 + 0.06 * np.clip(waves / max(2 * float(waves.std()), 1e-12), -1, 1)
    speed = np.where(limits.speed_mps > 30 / 3.6, limits.speed_mps * share, limits.speed_mps)
    return Limits(limits.step_m, speed, limits.accel_mps2, limits.decel_mps2, limits.grade_rad, limits.wait_s)


def _ended(limits: Limits, power: Power, duration_s: float | None, rest_s: float) -> Limits:
    """The limits up to a last stop: at the road's end, or where the rest then fills the duration."""
    last = len(limits.speed_mps) - 1
    if duration_s is not None:
        speed = fastest(limits, power)
        wait = np.where(limits.speed_mps <= 0, limits.wait_s, 0.0)
        reached = arrival_times(speed, limits.step_m) + np.cumsum(wait)
        # a stop there takes this much longer than driving past; soft braking may lie on the way to it
        reached += speed / (2 * slowest_near(limits.decel_mps2, limits.step_m, 60.0))
        last = max(int(np.searchsorted(reached, duration_s - rest_s)), 8)
        last = min(last, len(limits.speed_mps) - 1)
    # the last stop must not follow another at once
    while last > 8 and np.any(limits.speed_mps[last - 4 : last] <= 0):
        last -= 4
    speed, wait = limits.speed_mps[: last + 1].copy(), limits.wait_s[: last + 1].copy()
    speed[last], wait[last] = 0.0, rest_s
    return Limits(
        limits.step_m, speed, limits.accel_mps2[: last + 1], limits.decel_mps2[: last + 1],
        limits.grade_rad[: last + 1], wait,
    )  # fmt: skip


def planned_s(course: Course, power: Power) -> float:
    """How long the drive along the whole course takes, waits included."""
    limits = course.limits()
    return float(arrival_times(fastest(limits, power), limits.step_m)[-1] + np.sum(limits.wait_s))


def drive(
    course: Course,
    power: Power,
    friction: float,
    *,
    duration_s: float | None,
    rest_s: float,
    step_s: float,
    traffic: bool = True,
) -> tuple[Demand, Road]:
    """Drive along the course from rest to rest. duration_s: of the whole run, which is cut or filled with rest.

    A duration too short for the two rests gives a few metres between them.
    """
    limits = course.limits()
    if traffic:
        limits = _with_traffic(limits, course.rng)
    budget = duration_s
    rows = 0 if duration_s is None else round(duration_s / step_s) + 1
    for _ in range(8):
        ended = _ended(limits, power, budget, rest_s)
        speed = fastest(ended, power)
        target = over_time(speed, ended, step_s, course.driver.smooth_s)
        if budget is None or len(target) <= rows:
            break
        # what the stop takes was guessed: stop a little earlier
        budget -= (len(target) - rows) * step_s + 0.05
    target = np.concatenate((target, np.zeros(max(rows - len(target), 0))))
    zero = np.zeros(len(target))
    # the weave beyond the last stop is not driven, but the road has to be whole
    weave_speed = np.concatenate((speed, np.full(len(limits.speed_mps) - len(speed), max(speed.max(), 8.0))))
    return Demand(step_s, zero, target, zero, zero), course.road(friction, weave_speed)
