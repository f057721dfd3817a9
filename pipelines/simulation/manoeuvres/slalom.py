"""Slaloms round cones in a line, and the three slaloms with two U-turns of Park & Choi."""

from __future__ import annotations

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.manoeuvres.base import Options, Scenario, VehicleFigures
from pipelines.simulation.manoeuvres.path import STEP_M, Path, curvature_of, fitted_path, shift
from pipelines.simulation.manoeuvres.script import Script
from pipelines.simulation.records import GRAVITY

_FRICTION = 0.9
_CLEARANCE_M = 0.6
CONES = 10


def swing_m(vehicle: VehicleFigures) -> float:
    """How far the middle of the vehicle swings to either side of the cones: half its width and 0.6 m."""
    return vehicle.width_m / 2 + _CLEARANCE_M


def slalom_speed_mps(lateral_mps2: float, swing: float, spacing_m: float) -> float:
    """Speed at which a sine path of that swing, with half a wave from cone to cone, has that peak lateral acceleration."""
    return float(np.sqrt(lateral_mps2 / swing) * spacing_m / np.pi)


def slalom_curvature(swing: float, spacing_m: float, cones: int) -> FloatArray:
    """Curvature (n,) of the path round the cones, at even steps of STEP_M: a sine that grows and dies over two gaps,
    one of them before the first cone and one behind the last."""
    gap = spacing_m
    x = np.arange(0.0, (cones + 3) * gap + STEP_M / 2, STEP_M)
    ease = shift(np.minimum(x, x[-1] - x) / (2 * gap))
    return curvature_of(swing * ease * np.sin(np.pi * x / gap))


def _slalom(
    name: str, spacing_m: float, own_speed_mps: float,
    vehicle: VehicleFigures, options: Options, rng: np.random.Generator,
) -> Scenario:  # fmt: skip
    """Reach the speed, go round ten cones, stop; twice."""
    swing = swing_m(vehicle)
    hardest = vehicle.safe_lateral_mps2(4.5, options.grip(_FRICTION))
    own = min(own_speed_mps, slalom_speed_mps(hardest, swing, spacing_m)) * float(np.sqrt(options.severity))
    speed = vehicle.reachable_mps(options.speed(own))
    curvature = slalom_curvature(swing, spacing_m, CONES)

    def write(repeats: int) -> tuple[Script, Path]:
        script, path = Script(vehicle, options.grip(_FRICTION)), Path()
        side = options.signs()[0]
        script.rest(4.0)
        for _ in range(repeats):
            script.reach(speed, 1.5)
            script.hold(2.0)
            end = path.add(script.distance_m, side * curvature)
            script.hold((end - script.distance_m) / speed + 1.5)
            script.reach(0.0, 2.5)
            script.rest(4.0)
        return script, path

    script, path = fitted_path(write, options, repeats=2)
    peak = float(np.max(np.abs(curvature))) * speed**2
    return Scenario(
        name,
        f"Slalom, cones every {spacing_m:g} m",
        "",
        script.demand(),
        path.road(script.distance_m, _FRICTION, options, vehicle, rng),
        (f"{3.6 * speed:.0f} km/h; the path asks for {peak:.1f} m/s²",),
    )


def slalom(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Slalom round ten cones every 18 m, 35 km/h.

    The path is a sine that clears each cone by 0.6 m beside the body; the speed falls where the vehicle cannot take it.
    """
    return _slalom("slalom", 18.0, 35 / 3.6, vehicle, options, rng)


def slalom_36m(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Slalom round ten cones every 36 m, 65 km/h.

    As `slalom`, at a speed where the lag of roll and yaw shows.
    """
    return _slalom("slalom_36m", 36.0, 65 / 3.6, vehicle, options, rng)


def slalom_u_turns(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Three slaloms with two U-turns between, up to 100 km/h.

    Park & Choi section VI-B and their Fig 9: between -0.45 and 0.45 g, 20 km/h at the start (here from rest) and up to
    100 km/h; the U-turns are driven in a steady state, braked into. The spacing of the cones is not printed: it is the
    one that gives 0.45 g with our swing at 45, 70 and 95 km/h (options.speed_mps is the fastest of the three).
    """
    swing = swing_m(vehicle)
    lateral = options.severity * vehicle.safe_lateral_mps2(0.45 * GRAVITY, options.grip(_FRICTION))
    top = vehicle.reachable_mps(options.speed(95 / 3.6))
    turn_radius = 22.0
    turn_speed = float(np.sqrt(0.7 * lateral * turn_radius))
    side = options.signs()[0]

    def write(repeats: int) -> tuple[Script, Path]:
        script, path = Script(vehicle, options.grip(_FRICTION)), Path()
        script.rest(4.0)
        for _ in range(repeats):
            for leg, share in enumerate((45 / 95, 70 / 95, 1.0)):
                if leg:
                    script.reach(turn_speed, 2.5)
                    spiral = 12.0
                    length = np.pi * turn_radius + spiral
                    start = script.distance_m
                    script.hold(length / turn_speed)
                    path.bend(start, script.distance_m, side / turn_radius, spiral)
                    side_of_leg = -side
                else:
                    side_of_leg = side
                script.reach(share * top, 1.8)
                script.hold(2.0)
                spacing = np.pi * share * top * float(np.sqrt(swing / lateral))
                curvature = slalom_curvature(swing, spacing, 6)
                end = path.add(script.distance_m, side_of_leg * curvature)
                script.hold((end - script.distance_m) / (share * top) + 1.0)
            script.reach(0.0, 2.5)
            script.rest(4.0)
        return script, path

    script, path = fitted_path(write, options, repeats=1)
    return Scenario(
        "slalom_u_turns",
        "Three slaloms with U-turns",
        "Park & Choi VI-B",
        script.demand(),
        path.road(script.distance_m, _FRICTION, options, vehicle, rng),
        (f"up to {3.6 * top:.0f} km/h at {lateral:.1f} m/s²; U-turns at {3.6 * turn_speed:.0f} km/h",),
    )
