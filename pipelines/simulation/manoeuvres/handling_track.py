"""A handling track: cambered and closing bends, a crest, a chicane, a hairpin; several laps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipelines.simulation.manoeuvres.base import Options, Scenario, VehicleFigures
from pipelines.simulation.manoeuvres.public_roads import paved, power_of
from pipelines.simulation.manoeuvres.script import STEP_S
from pipelines.simulation.roads.course import Course, Driver, drive, planned_s

_FRICTION = 0.95
_LAPS = 3


def _lap(course: Course, side: float, lateral: float) -> None:
    """One lap of about 900 m. side: +1 as drawn, -1 its mirror image."""
    fast = 110 / 3.6

    def turn(radius: float, degrees: float, tighten: float = 1.0, camber: float = 0.0) -> None:
        course.turn(
            radius, side * np.radians(degrees), fast,
            lateral_mps2=lateral, tighten=tighten, superelevation=camber,
        )  # fmt: skip

    course.straight(90.0, fast)
    turn(60.0, 90.0, tighten=0.5, camber=0.03)
    course.grade_rad = 0.06
    course.straight(50.0, fast)
    turn(45.0, -70.0, camber=-0.04)
    course.grade_rad = -0.05
    course.straight(40.0, fast)
    turn(30.0, 120.0, camber=0.07)
    course.grade_rad = 0.0
    course.straight(30.0, fast)
    for swing in (-1.0, 1.0, 1.0, -1.0):
        turn(28.0, 35.0 * swing)
    course.straight(60.0, fast)
    turn(15.0, 180.0, camber=0.02)
    course.straight(70.0, fast)
    turn(80.0, -100.0, tighten=0.6, camber=0.04)
    turn(50.0, 140.0, tighten=0.8, camber=0.05)


def handling_track(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Handling track, three laps: cambered and closing bends, crest, chicane, hairpin.

    Our own: bends of 12 to 80 m, two that close up to half and 0.6 of their radius, camber from -4 to +7 % (one bend
    falls outwards), grades of 6 %, driven at 0.6 g (severity) as far as the vehicle is safe there; very good surface.
    direction "right" drives the mirror image.
    """
    friction = options.grip(_FRICTION)
    lateral = options.severity * vehicle.safe_lateral_mps2(0.6 * 9.81, friction)
    driver = Driver((lateral, lateral), 3.0, 5.0, float(rng.uniform(0.5, 0.8)), 0.1, options.speed(110 / 3.6))
    course = Course(driver, rng, rest_s=float(rng.uniform(3.5, 5.0)), tightest_m=vehicle.tightest_m)
    power = replace(power_of(vehicle, friction), power_per_mass_wpkg=0.85 * vehicle.power_w / vehicle.mass_kg)
    # the start belongs to no lap: what follows it is driven again
    _lap(course, options.signs()[0], lateral)
    if options.duration_s is None:
        course.repeat(_LAPS - 1)
    else:
        lap_s = planned_s(course, power)
        course.repeat(int(options.duration_s / (0.8 * lap_s)) + 1)
    course.straight(80.0, 80 / 3.6)
    demand, road = drive(
        course, power, friction, duration_s=options.duration_s, rest_s=4.0, step_s=STEP_S, traffic=False
    )
    return Scenario(
        "handling_track",
        "Handling track",
        "",
        demand,
        paved(road, options.surface or "A", 0.5, vehicle, rng),
        (f"bends at {lateral:.1f} m/s², up to {3.6 * np.max(demand.target_speed_mps):.0f} km/h",),
    )
