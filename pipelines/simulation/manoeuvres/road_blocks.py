"""Blocks of public roads, each with its own draws: streets, country roads, roundabouts, ramps, slopes, stops."""

from __future__ import annotations

import numpy as np

from pipelines.simulation.roads.course import Course

_KMH = 1 / 3.6


def _side(course: Course) -> float:
    return 1.0 if course.rng.uniform() < 0.5 else -1.0


def _wait(course: Course, low_s: float = 3.0, high_s: float = 9.0) -> float:
    """A wait at a light or a crossing, longer than the driver's foot takes to come to rest."""
    return float(course.rng.uniform(max(low_s, course.driver.smooth_s + 1.0), high_s))


def corner(course: Course, side: float) -> None:
    """A 90-degree turn at a crossing: 7 to 9 m to the right, 10 to 14 m to the left (traffic on the right)."""
    rng = course.rng
    radius = rng.uniform(10.0, 14.0) if side > 0 else rng.uniform(7.0, 9.0)
    course.turn(float(radius), side * np.pi / 2, 30 * _KMH)


def street(course: Course, turning: float | None = None) -> None:
    """40 to 160 m of street, then one of: a turn, a stop at a light and a turn, a stop, a hump, a shift round a bus."""
    rng = course.rng
    limit = float(rng.choice((30.0, 50.0, 50.0))) * _KMH
    course.straight(float(rng.uniform(40, 160)), limit)
    event = rng.uniform()
    side = _side(course) if turning is None else turning
    if event < 0.40:
        corner(course, side)
    elif event < 0.62:
        course.stop(_wait(course), float(rng.uniform(1.2, 3.0)))
        corner(course, side)
    elif event < 0.80:
        course.stop(_wait(course), float(rng.uniform(1.2, 3.5)))
    elif event < 0.90:
        course.straight(8.0, 22 * _KMH)
        course.hump(3.7, float(rng.uniform(0.05, 0.08)))
    else:
        course.change_lane(2.0, 22.0, 35 * _KMH)
        course.straight(float(rng.uniform(10, 20)), 35 * _KMH)
        course.change_lane(-2.0, 22.0, 35 * _KMH)


def hard_stop(course: Course) -> None:
    """A straight at 50 to 70 km/h with a hard stop at its end, 4 to 5.5 m/s²."""
    speed = float(course.rng.uniform(50, 70)) * _KMH
    course.straight(float(course.rng.uniform(90, 140)), speed)
    course.stop(_wait(course, 4.0, 7.0), float(course.rng.uniform(4.0, 5.5)))


def soft_stop(course: Course) -> None:
    """A straight at 50 km/h with a soft stop at its end, 1 to 1.5 m/s²."""
    course.straight(float(course.rng.uniform(100, 150)), 50 * _KMH)
    course.stop(_wait(course, 4.0, 8.0), float(course.rng.uniform(1.0, 1.5)))


def roundabout(course: Course) -> None:
    """Into a roundabout to the right, round it to the left, out to the right."""
    rng = course.rng
    course.straight(float(rng.uniform(40, 90)), 50 * _KMH)
    entry = float(np.radians(rng.uniform(35, 55)))
    round_it = float(np.radians(rng.choice((90.0, 180.0, 180.0, 270.0))))
    course.turn(float(rng.uniform(16, 22)), -entry, 30 * _KMH)
    course.turn(float(rng.uniform(12, 18)), round_it, 40 * _KMH)
    course.turn(float(rng.uniform(18, 26)), -entry, 40 * _KMH)


def country_road(course: Course, bends: int, steepest: float = 0.05) -> None:
    """Bends of 50 to 300 m between straights at 70 to 90 km/h, on changing grades."""
    rng = course.rng
    for _ in range(bends):
        limit = float(rng.uniform(70, 90)) * _KMH
        course.grade_rad = float(rng.uniform(-steepest, steepest))
        course.straight(float(rng.uniform(40, 200)), limit)
        radius = float(np.exp(rng.uniform(np.log(50), np.log(300))))
        angle = _side(course) * float(rng.uniform(0.35, 1.4))
        closing = float(rng.choice((1.0, 1.0, 0.75)))
        course.turn(radius, angle, limit, tighten=closing, superelevation=float(rng.uniform(0.01, 0.05)))
    course.grade_rad = 0.0


def ramp(course: Course) -> None:
    """A loop ramp of 45 to 70 m through 180 to 270 degrees."""
    rng = course.rng
    course.straight(float(rng.uniform(50, 90)), 60 * _KMH)
    course.grade_rad = float(rng.uniform(0.01, 0.04))
    lateral = float(rng.uniform(0.6, 1.0)) * course.driver.lateral_mps2[1]
    course.turn(
        float(rng.uniform(45, 70)),
        -float(np.radians(rng.uniform(180, 270))),
        70 * _KMH,
        lateral_mps2=lateral,
        superelevation=0.05,
    )
    course.grade_rad = 0.0


def motorway(course: Course, length_m: float) -> None:
    """A motorway at 100 to 120 km/h with wide bends and lane changes, left at an exit bend."""
    rng = course.rng
    limit = float(rng.uniform(100, 120)) * _KMH
    end = course.length_m + length_m
    course.straight(180.0, limit)
    course.change_lane(3.5, float(rng.uniform(80, 120)), limit)
    while course.length_m < end:
        course.grade_rad = float(rng.uniform(-0.02, 0.02))
        course.turn(
            float(rng.uniform(500, 900)), _side(course) * float(rng.uniform(0.15, 0.3)), limit,
            superelevation=0.03,
        )  # fmt: skip
        offset = 3.5 * _side(course)
        course.straight(float(rng.uniform(60, 150)), limit)
        course.change_lane(offset, float(rng.uniform(80, 130)), limit)
    course.grade_rad = 0.0
    course.straight(120.0, 80 * _KMH)
    course.turn(float(rng.uniform(45, 80)), -float(rng.uniform(1.0, 1.6)), 60 * _KMH, superelevation=0.04)


def slope(course: Course, steepest: float, length_m: float, stop: bool) -> None:
    """Up a slope and down again, with a bend on either side and, if asked, a stop and a start on the way up."""
    rng = course.rng
    for side in (1.0, -1.0):
        course.grade_rad = side * steepest
        course.straight(0.5 * length_m, 60 * _KMH)
        if stop and side > 0:
            course.stop(_wait(course, 3.5, 6.0))
        course.turn(float(rng.uniform(50, 120)), _side(course) * float(rng.uniform(0.4, 1.0)), 60 * _KMH)
        course.straight(0.4 * length_m, 60 * _KMH)
        course.grade_rad = 0.0
        course.straight(float(rng.uniform(30, 60)), 60 * _KMH)
