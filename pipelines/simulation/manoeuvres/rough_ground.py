"""Rough ground at a constant speed: roads of ISO 8608, and the off-road terrain of Pence, Fathy & Stein."""

from __future__ import annotations

import numpy as np

from pipelines.simulation.manoeuvres.base import Options, Scenario, VehicleFigures
from pipelines.simulation.manoeuvres.script import Script, fitted
from pipelines.simulation.records import Road, straight_road
from pipelines.simulation.roads.profile import (
    CLASS_ROUGHNESS,
    Spectrum,
    iso_spectrum,
    roughness,
    terrain_spectrum,
    with_roughness,
)


def _constant_speed(
    vehicle: VehicleFigures, options: Options, speed: float, seconds: float, friction: float
) -> Script:
    """Rest, reach the speed, hold it; the hold grows with the duration asked for."""

    def write(repeats: int) -> Script:
        script = Script(vehicle, friction)
        script.rest(4.0)
        script.reach(speed, 1.5)
        script.hold(repeats)
        script.reach(0.0, 2.0)
        script.rest(4.0)
        return script

    return fitted(write, options, repeats=round(seconds))


def _rough_road(
    spectrum: Spectrum,
    distance_m: float,
    friction: float,
    step_m: float,
    vehicle: VehicleFigures,
    rng: np.random.Generator,
) -> Road:
    """A straight road with that roughness, longer than the drive."""
    road = straight_road(1.2 * distance_m + 50.0, friction)
    length = road.step_m * (len(road.curvature_1pm) - 1)
    left, right = roughness(spectrum, length, step_m, vehicle.track_m, rng)
    return with_roughness(road, left, right, step_m)


def rough_straight(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Rough straight road at a constant 60 km/h.

    ISO 8608 class C (poor: G_d(n0) = 256e-6 m³), another class by options.surface; severity scales the spectrum's root.
    """
    speed = vehicle.reachable_mps(options.speed(60 / 3.6))
    surface = options.surface or "C"
    script = _constant_speed(vehicle, options, speed, 60.0, options.grip(0.85))
    spectrum = iso_spectrum(surface, options.severity**2)
    return Scenario(
        "rough_straight",
        f"Rough straight, class {surface}",
        f"ISO 8608 class {surface}",
        script.demand(),
        _rough_road(spectrum, script.distance_m, options.grip(0.85), 0.1, vehicle, rng),
        (f"class {surface} at {3.6 * speed:.0f} km/h",),
    )


def off_road(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Off-road terrain at 4 to 8 m/s.

    The terrain of Pence, Fathy & Stein (spectrum: `terrain_spectrum`) with the roughness of ISO 8608 class E at n0
    (F by options.surface); severity scales the spectrum's root. The speed is drawn from 4 to 8 m/s unless given.
    """
    speed = vehicle.reachable_mps(options.speed(float(rng.uniform(4.0, 8.0))))
    surface = options.surface or "E"
    script = _constant_speed(vehicle, options, speed, 60.0, options.grip(0.7))
    spectrum = terrain_spectrum(CLASS_ROUGHNESS[surface] * options.severity**2)
    return Scenario(
        "off_road",
        f"Off-road terrain, class {surface}",
        f"Pence, Fathy & Stein IV-B; ISO 8608 class {surface} at 0.1 cycles/m",
        script.demand(),
        _rough_road(spectrum, script.distance_m, options.grip(0.7), 0.05, vehicle, rng),
        (f"{speed:.1f} m/s",),
    )
