"""A driver's script: phases one after another (rest, reach a speed, hold, steer, coast, brake) become a Demand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.manoeuvres.base import Options, VehicleFigures
from pipelines.simulation.records import Demand, Road, straight_road
from pipelines.simulation.roads.profile import iso_spectrum, roughness, with_roughness

STEP_S = 0.01
"""Time step of every demand."""


class Script:
    """Phases in order. `speed_mps` is the speed planned at the end of what was written so far."""

    def __init__(self, vehicle: VehicleFigures, friction: float, start_mps: float = 0.0) -> None:
        """Begin at start_mps: at rest, or already rolling. friction: what the driven wheels stand on."""
        self._vehicle, self._friction = vehicle, friction
        self.speed_mps = start_mps
        self._columns: list[list[FloatArray]] = [
            [np.array([value])] for value in (0.0, start_mps, 0.0, start_mps)
        ]

    def _add(
        self, planned: FloatArray, *, target: FloatArray | None = None,
        steer: FloatArray | None = None, pressure: FloatArray | None = None,
    ) -> None:  # fmt: skip
        """Append rows: the speed planned, and what the driver does where it is not just that."""
        zero = np.zeros(len(planned))
        rows = (
            zero if steer is None else steer,
            planned if target is None else target,
            zero if pressure is None else pressure,
            planned,
        )
        for column, values in zip(self._columns, rows, strict=True):
            column.append(values)
        if len(planned):
            self.speed_mps = float(planned[-1])

    def _times(self, seconds: float) -> FloatArray:
        return np.asarray(STEP_S * np.arange(1, max(round(seconds / STEP_S), 0) + 1))

    def hold(self, seconds: float) -> None:
        """Keep the speed."""
        self._add(np.full(len(self._times(seconds)), self.speed_mps))

    def rest(self, seconds: float) -> None:
        """Stand still: to be written after a stop."""
        self._add(np.zeros(len(self._times(seconds))))

    def follow(self, speed_mps: FloatArray, steer: FloatArray | None = None) -> None:
        """Follow speeds, one a step, with the steering-wheel angles beside them."""
        self._add(np.asarray(speed_mps, dtype=np.float64), steer=steer)

    def reach(self, speed_mps: float, acceleration_mps2: float) -> None:
        """Change the speed along half a cosine whose peak is the given acceleration, or what 70 % of the power or 60 % of the driven
        wheels' grip gives."""
        start, change = self.speed_mps, speed_mps - self.speed_mps
        peak = acceleration_mps2
        if change > 0:
            # where along the half cosine the power is short: share of the peak against what there is
            phase = np.linspace(0.05, 0.95, 19)
            speeds = start + change * 0.5 * (1 - np.cos(np.pi * phase))
            for share, speed in zip(np.sin(np.pi * phase), speeds, strict=True):
                peak = min(peak, self._vehicle.acceleration_mps2(float(speed), self._friction) / float(share))
        t = self._times(abs(change) * np.pi / (2 * peak))
        if len(t):
            self._add(start + change * 0.5 * (1 - np.cos(np.pi * t / t[-1])))

    def steer(self, angle_rad: FloatArray) -> None:
        """Keep the speed and turn the steering wheel through these angles."""
        self._add(np.full(len(angle_rad), self.speed_mps), steer=np.asarray(angle_rad))

    def coast(self, angle_rad: FloatArray) -> None:
        """Both feet off while the steering wheel turns through these angles."""
        planned = np.empty(len(angle_rad))
        slowing = self._vehicle.resistance_mps2(self.speed_mps)
        planned[:] = np.maximum(self.speed_mps - slowing * STEP_S * np.arange(1, len(planned) + 1), 0.0)
        self._add(planned, target=np.full(len(planned), np.nan), steer=np.asarray(angle_rad))

    def brake_to_rest(self, decel_mps2: float, rest_s: float, build_up_s: float = 0.3) -> None:
        """Press the pedal to the pressure for a deceleration, hold it past the stop, and let go.

        The pressure is held for a quarter longer than the stop should take, so that a heavier load stops too.
        """
        vehicle = self._vehicle
        # the pedal gives what resistance does not
        pressure = vehicle.brake_pressure_pa(max(decel_mps2 - vehicle.resistance_mps2(0.0), 0.1))
        stop_s = self.speed_mps / decel_mps2 + build_up_s / 2
        t = self._times(1.25 * stop_s + rest_s)
        rise = np.clip(t / build_up_s, 0.0, 1.0)
        # let go while already at rest
        fall = np.clip((t[-1] - t) / 0.5, 0.0, 1.0)
        slow = decel_mps2 * np.maximum(np.minimum(t, build_up_s) * rise / 2, t - build_up_s / 2)
        planned = np.maximum(self.speed_mps - slow, 0.0)
        planned[-1] = 0.0
        self._add(planned, target=np.zeros(len(t)), pressure=pressure * np.minimum(rise, fall))

    @property
    def duration_s(self) -> float:
        """How long the script is so far."""
        return STEP_S * (sum(len(part) for part in self._columns[0]) - 1)

    @property
    def distance_m(self) -> float:
        """How far the plan has gone."""
        planned = np.concatenate(self._columns[3])
        return float(np.sum(0.5 * (planned[1:] + planned[:-1])) * STEP_S)

    def demand(self) -> Demand:
        """What was written, as a Demand."""
        steer, target, pressure, _ = (np.concatenate(column) for column in self._columns)
        return Demand(STEP_S, steer, target, pressure, np.zeros(len(target)))


def fitted(write: Callable[[int], Script], options: Options, repeats: int) -> Script:
    """The script of so many repeats as fit the duration asked for (at least one), then rest to its end."""
    if options.duration_s is None:
        return write(repeats)
    one = write(1)
    unit = write(2).duration_s - one.duration_s
    count = 1 + max(int((options.duration_s - one.duration_s) / max(unit, STEP_S)), 0)
    script = write(count)
    # repeats that differ from each other may be longer than the first two
    while count > 1 and script.duration_s > options.duration_s + STEP_S:
        count -= 1
        script = write(count)
    left = options.duration_s - script.duration_s
    if left > 0 and script.speed_mps == 0:
        script.rest(left)
    return script


def steered(
    vehicle: VehicleFigures,
    options: Options,
    own_friction: float,
    speed_mps: float,
    turns: Callable[[Script], None],
    repeats: int,
) -> Script:
    """Rest, reach a speed, steer at it by `turns` as often as fits, stop, rest."""

    def write(count: int) -> Script:
        script = Script(vehicle, options.grip(own_friction))
        script.rest(4.0)
        script.reach(speed_mps, 2.0)
        for _ in range(count):
            turns(script)
        script.hold(2.0)
        script.reach(0.0, 3.0)
        script.rest(4.0)
        return script

    return fitted(write, options, repeats)


def proving_ground(
    distance_m: float,
    own_friction: float,
    options: Options,
    vehicle: VehicleFigures,
    rng: np.random.Generator,
) -> Road:
    """A straight, flat surface, long enough by a fifth; smooth unless an ISO 8608 class was asked for."""
    road = straight_road(1.2 * distance_m + 50.0, options.grip(own_friction))
    if options.surface is None:
        return road
    step = 0.1
    length = road.step_m * (len(road.curvature_1pm) - 1)
    left, right = roughness(iso_spectrum(options.surface), length, step, vehicle.track_m, rng)
    return with_roughness(road, left, right, step)
