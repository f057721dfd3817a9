"""Double lane changes between cones: ISO 3888-1 and ISO 3888-2."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.manoeuvres.base import Options, Scenario, VehicleFigures
from pipelines.simulation.manoeuvres.path import STEP_M, Path, curvature_of, fitted_path, shift
from pipelines.simulation.manoeuvres.script import STEP_S, Script

_FRICTION = 0.9


@dataclass(frozen=True)
class Course:
    """Five sections [m]: lane, change over, offset lane, change back, lane; the lanes' widths for a vehicle's width."""

    lengths_m: tuple[float, float, float, float, float]
    widths_m: tuple[float, float, float]
    offset_m: float


def iso_3888_1(width_m: float) -> Course:
    """Severe double lane change: 15, 30, 25, 25 and 15 m (then 15 m to run out); lanes 1.1 w + 0.25, 1.2 w + 0.25 and
    1.3 w + 0.25 m wide; 3.5 m between the lanes' middles."""
    widths = (1.1 * width_m + 0.25, 1.2 * width_m + 0.25, 1.3 * width_m + 0.25)
    return Course((15.0, 30.0, 25.0, 25.0, 15.0), widths, 3.5)


def iso_3888_2(width_m: float) -> Course:
    """Obstacle avoidance: 12, 13.5, 11, 12.5 and 12 m; lanes 1.1 w + 0.25, w + 1 and 1.3 w + 0.25 (3 m at least) wide;
    1 m between the near edges of the first two lanes."""
    widths = (1.1 * width_m + 0.25, width_m + 1.0, max(1.3 * width_m + 0.25, 3.0))
    return Course((12.0, 13.5, 11.0, 12.5, 12.0), widths, 1.0 + (widths[0] + widths[1]) / 2)


def path_offsets(course: Course, width_m: float, use: float = 0.8) -> FloatArray:
    """The driver's line through the course, (n,) lateral offsets at even steps of STEP_M along it, + left.

    From the middle of one lane to the middle of the next; a good driver begins each change within the lane and ends it
    within the next one, by as much as their slack allows (`use` of it). The change is a fifth-order polynomial.
    """
    slack = [use * (lane - width_m) / 2 for lane in course.widths_m]
    over = course.offset_m
    edges = np.cumsum((0.0, *course.lengths_m))
    x = np.arange(0.0, edges[-1] + STEP_M / 2, STEP_M)
    grid = np.linspace(0, 1, 2001)

    def change(start: float, end: float, before: float, after: float) -> FloatArray:
        # shares of the change that may already have happened (still be missing) at the cones
        early = float(np.interp(min(before / over, 0.3), shift(grid), grid))
        late = float(np.interp(min(after / over, 0.3), shift(grid), grid))
        length = (end - start) / (1 - early - late)
        return shift((x - (start - early * length)) / length)

    out = change(edges[1], edges[2], slack[0], slack[1])
    back = change(edges[3], edges[4], slack[1], slack[2])
    return np.asarray(over * (out - back))


def _lane_changes(
    name: str,
    title: str,
    standard: str,
    course: Course,
    vehicle: VehicleFigures,
    options: Options,
    rng: np.random.Generator,
    own_speed_mps: float,
    coasting: bool,
) -> Scenario:
    """Reach the speed, drive the course (throttle off where the standard says so), stop; each side in turn."""
    curvature = curvature_of(path_offsets(course, vehicle.width_m))
    grip = options.grip(_FRICTION)
    sharpest = float(np.max(np.abs(curvature)))
    fastest = float(np.sqrt(1.35 * vehicle.safe_lateral_mps2(9.0, grip) / sharpest))
    speed = vehicle.reachable_mps(
        options.speed(min(own_speed_mps, fastest) * float(np.sqrt(options.severity)))
    )
    # a lead before the course, where the car settles; the drive through it ends 15 m behind
    through_s = (STEP_M * len(curvature) + 15.0) / speed

    def write(repeats: int) -> tuple[Script, Path]:
        script, path = Script(vehicle, grip), Path()
        script.rest(4.0)
        for _ in range(repeats):
            for side in options.signs():
                script.reach(speed, 2.0)
                script.hold(2.0)
                path.add(script.distance_m, side * curvature)
                if coasting:
                    script.hold(10.0 / speed)
                    script.coast(np.zeros(round((through_s - 10.0 / speed) / STEP_S)))
                else:
                    script.hold(through_s)
                script.hold(1.5)
                script.reach(0.0, 3.0)
                script.rest(4.0)
        return script, path

    script, path = fitted_path(write, options, repeats=1)
    return Scenario(
        name,
        title,
        standard,
        script.demand(),
        path.road(script.distance_m, _FRICTION, options, vehicle, rng),
        (f"{3.6 * speed:.0f} km/h; the path asks for {sharpest * speed**2:.1f} m/s²",),
    )


def double_lane_change(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Double lane change between cones at 80 km/h.

    ISO 3888-1: see `iso_3888_1` for the course; constant throttle, 80 km/h unless the vehicle cannot take it.
    """
    return _lane_changes(
        "double_lane_change", "Double lane change", "ISO 3888-1",
        iso_3888_1(vehicle.width_m), vehicle, options, rng, 80 / 3.6, False,
    )  # fmt: skip


def obstacle_avoidance(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Obstacle avoidance between cones, throttle off.

    ISO 3888-2: see `iso_3888_2` for the course; the throttle is let go 2 m before the first lane ends. The standard
    seeks the highest speed without a cone down; 50 km/h here, or less where the vehicle cannot take it.
    """
    return _lane_changes(
        "obstacle_avoidance", "Obstacle avoidance", "ISO 3888-2",
        iso_3888_2(vehicle.width_m), vehicle, options, rng, 50 / 3.6, True,
    )  # fmt: skip
