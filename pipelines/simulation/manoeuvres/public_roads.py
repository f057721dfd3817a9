"""Drives on public roads, drawn anew for every seed: urban, rural, hills, and the mix of them all."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipelines.simulation.manoeuvres.base import Options, Scenario, VehicleFigures
from pipelines.simulation.manoeuvres.road_blocks import (
    country_road,
    hard_stop,
    motorway,
    ramp,
    roundabout,
    slope,
    soft_stop,
    street,
)
from pipelines.simulation.manoeuvres.script import STEP_S
from pipelines.simulation.records import Demand, Road
from pipelines.simulation.roads.course import Course, drawn_driver, drive, planned_s
from pipelines.simulation.roads.profile import iso_spectrum, roughness, with_roughness
from pipelines.simulation.roads.speed_plan import Power

_ROUGH_STEP_M = 0.1
_FRICTION = 0.85


def power_of(vehicle: VehicleFigures, friction: float) -> Power:
    """70 % of the power and 60 % of the driven wheels' grip: a normal driver does not use all."""
    mass = vehicle.mass_kg
    return Power(
        0.7 * vehicle.power_w / mass,
        vehicle.traction_mps2(friction),
        vehicle.drag_area_m2 / mass,
        vehicle.rolling_resistance,
    )


def paved(road: Road, surface: str, scale: float, vehicle: VehicleFigures, rng: np.random.Generator) -> Road:
    """The road with a roughness of an ISO 8608 class."""
    length = road.step_m * (len(road.curvature_1pm) - 1)
    left, right = roughness(iso_spectrum(surface, scale), length, _ROUGH_STEP_M, vehicle.track_m, rng)
    return with_roughness(road, left, right, _ROUGH_STEP_M)


def driven(
    build: Callable[[Course], None],
    vehicle: VehicleFigures,
    options: Options,
    rng: np.random.Generator,
    *,
    own_duration_s: float,
    top_kmh: float,
    surface: str,
) -> tuple[Demand, Road, tuple[str, ...]]:
    """Build cycles of a road until they last the duration, drive them as one drawn driver, pave them.

    surface: class of the road, taken between its geometric mean and half of it, as roads differ.
    """
    friction = options.grip(_FRICTION)
    hardest = vehicle.safe_lateral_mps2(0.45 * 9.81 * options.severity, friction)
    driver = drawn_driver(rng, options.severity, hardest, options.speed(top_kmh / 3.6))
    course = Course(driver, rng, rest_s=float(rng.uniform(3.5, 5.0)), tightest_m=vehicle.tightest_m)
    power = power_of(vehicle, friction)
    duration = options.duration_s or own_duration_s
    while planned_s(course, power) < duration:
        build(course)
    demand, road = drive(
        course, power, friction, duration_s=duration, rest_s=float(rng.uniform(3.0, 4.5)), step_s=STEP_S
    )
    scale = float(rng.uniform(0.5, 1.0))
    notes = (
        f"bends up to {driver.lateral_mps2[1]:.1f} m/s², starts at {driver.accel_mps2:.1f} m/s²",
        f"{np.sum(demand.target_speed_mps) * STEP_S / 1000:.1f} km, "
        f"up to {3.6 * np.max(demand.target_speed_mps):.0f} km/h",
    )
    return demand, paved(road, options.surface or surface, scale, vehicle, rng), notes


def urban(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Urban drive: 90-degree turns, lights, humps, roundabouts.

    Our own: streets at 30 and 50 km/h with standstills, smooth and hard stops; class B roughness; 4 minutes.
    """

    def cycle(course: Course) -> None:
        # turns to both sides in every cycle
        for turning in (1.0, -1.0, None, None):
            street(course, turning)
        roundabout(course)
        street(course)

    demand, road, notes = driven(
        cycle, vehicle, options, rng, own_duration_s=240.0, top_kmh=50.0, surface="B"
    )
    return Scenario("urban", "Urban drive", "", demand, road, notes)


def rural(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Rural drive: bends of 50 to 300 m at up to 90 km/h.

    Our own: bends with superelevation, some closing up, grades up to 5 %, a stop at a crossing; class B; 4 minutes.
    """

    def cycle(course: Course) -> None:
        country_road(course, 8)
        soft_stop(course)
        country_road(course, 6)
        roundabout(course)

    demand, road, notes = driven(
        cycle, vehicle, options, rng, own_duration_s=240.0, top_kmh=90.0, surface="B"
    )
    return Scenario("rural", "Rural drive", "", demand, road, notes)


def hills(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Hills: grades up to 10 %, with stops and starts on the way up.

    Our own: slopes of 4 to 10 % up and down with bends; the steepest is in every cycle; class B; 5 minutes.
    """
    steepest = 0.10 * min(options.severity, 1.5)

    def cycle(course: Course) -> None:
        for share, stop in ((0.6, False), (1.0, True), (0.4, True)):
            slope(course, steepest * share, float(rng.uniform(160, 240)), stop)
        course.stop(4.0)

    demand, road, notes = driven(
        cycle, vehicle, options, rng, own_duration_s=300.0, top_kmh=60.0, surface="B"
    )
    return Scenario("hills", "Hills", "", demand, road, notes)


def public_road(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Public road: streets, country road, roundabout, ramp, motorway, slope, soft and hard stops.

    Our own, after the public-road test of Park & Choi VI-C (0 to 90 km/h, about 5 minutes, friction about 0.7 to 0.9,
    flat on average); a longer duration_s goes on with further draws of the same mix.
    """

    def cycle(course: Course) -> None:
        street(course, 1.0)
        street(course, -1.0)
        hard_stop(course)
        roundabout(course)
        ramp(course)
        motorway(course, float(rng.uniform(500, 900)))
        soft_stop(course)
        slope(course, float(rng.uniform(0.04, 0.08)), float(rng.uniform(80, 140)), True)
        # what five minutes may cut comes last, and is the kind that was there before
        country_road(course, 4)
        street(course)
        hard_stop(course)

    demand, road, notes = driven(
        cycle, vehicle, options, rng, own_duration_s=300.0, top_kmh=110.0, surface="B"
    )
    return Scenario("public_road", "Public road", "Park & Choi VI-C (kind of drive)", demand, road, notes)
