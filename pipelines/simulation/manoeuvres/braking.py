"""Braking in a straight line on two surfaces, and launches with stops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipelines.simulation.manoeuvres.base import Options, Scenario, VehicleFigures
from pipelines.simulation.manoeuvres.script import Script, fitted, proving_ground
from pipelines.simulation.records import GRAVITY

_POOR_SHARE = 0.35 / 0.9
"""Friction of the slippery side over that of the better one."""


def _stops(
    name: str, title: str, decel_g: float, own_speed_mps: float, friction: float,
    vehicle: VehicleFigures, options: Options, rng: np.random.Generator, launch_share: float = 1.0,
) -> Scenario:  # fmt: skip
    """Launch, hold the speed, brake to rest by the pedal at a steady pressure, stand; three times.

    launch_share: of the friction, that the launches may count on.
    """
    speed = vehicle.reachable_mps(options.speed(own_speed_mps))
    grip = options.grip(friction)
    # a stop that the wheels can do without locking
    decel = min(options.severity * decel_g, 0.8 * grip) * GRAVITY

    def write(repeats: int) -> Script:
        script = Script(vehicle, grip * launch_share)
        script.rest(4.0)
        for _ in range(repeats):
            script.reach(speed, 0.4 * GRAVITY * min(grip * launch_share, 0.7))
            script.hold(2.7)
            script.brake_to_rest(decel, rest_s=4.0)
        script.rest(1.0)
        return script

    script = fitted(write, options, repeats=3)
    return Scenario(
        name,
        title,
        "Park & Choi VI-A",
        script.demand(),
        proving_ground(script.distance_m, friction, options, vehicle, rng),
        (f"{decel / GRAVITY:.2f} g from {3.6 * speed:.0f} km/h",),
    )


def straight_braking(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Straight braking on dry asphalt, 0.6 g from 80 km/h.

    Park & Choi section VI-A, Fig 6: friction 0.9, a steady -0.6 g by the driver's pedal after 2.7 s at 80 km/h. The stop
    is repeated three times, with standstill between.
    """
    return _stops("straight_braking", "Straight braking, asphalt", 0.6, 80 / 3.6, 0.9, vehicle, options, rng)


def straight_braking_basalt(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Straight braking on wet basalt, 0.25 g from 50 km/h.

    Park & Choi section VI-A, Fig 7: friction 0.45, a steady -0.25 g.
    """
    return _stops(
        "straight_braking_basalt", "Straight braking, basalt", 0.25, 50 / 3.6, 0.45, vehicle, options, rng
    )


def split_friction_braking(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Straight braking with one side on slippery ground, 0.45 g from 60 km/h.

    After ISO 14512 (straight-ahead braking on split friction), with our own speed and surfaces: 0.9 under one side and
    0.35 under the other, whose wheels cannot brake by 0.45 g; options.friction sets the better side. The driver keeps
    the heading. A drive on which a method that takes left and right together must hold its tongue.
    """
    base = _stops(
        "split_friction_braking", "Straight braking, split friction", 0.45, 60 / 3.6, 0.9,
        vehicle, options, rng, _POOR_SHARE,
    )  # fmt: skip
    poor = base.road.friction_left * _POOR_SHARE
    # a curvature too small to see makes the driver of the plant hold the lane
    curvature = np.full(len(poor), 1e-9)
    if options.signs()[0] > 0:
        road = replace(base.road, friction_left=poor, curvature_1pm=curvature)
    else:
        road = replace(base.road, friction_right=poor, curvature_1pm=curvature)
    side = "left" if options.signs()[0] > 0 else "right"
    return replace(
        base, standard="after ISO 14512", road=road, notes=(*base.notes, f"slippery on the {side}")
    )


def launch_and_stop(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Launches and stops, soft to hard, on a straight.

    Our own: pitch and axle loads at rest, under drive and under brakes, which is what a pitch balance lives on. Launches
    of 1 to 3 m/s² (as far as the power goes), stops of 1.5 to 5 m/s², drawn anew for each.
    """
    speed = vehicle.reachable_mps(options.speed(45 / 3.6))
    grip = options.grip(0.9)
    limit = 0.6 * GRAVITY * grip
    draws = rng.uniform(size=(400, 3))

    def write(repeats: int) -> Script:
        script = Script(vehicle, grip)
        script.rest(4.0)
        for k in range(repeats):
            launch, stop, top = draws[k % len(draws)]
            script.reach(speed * (0.75 + 0.25 * top), min(options.severity * (1.0 + 2.0 * launch), limit))
            script.hold(1.0 + top)
            script.brake_to_rest(min(options.severity * (1.5 + 3.5 * stop), limit), rest_s=3.0)
        script.rest(1.0)
        return script

    script = fitted(write, options, repeats=5)
    return Scenario(
        "launch_and_stop",
        "Launches and stops",
        "",
        script.demand(),
        proving_ground(script.distance_m, 0.9, options, vehicle, rng),
        (f"to {3.6 * speed:.0f} km/h and back to rest",),
    )
