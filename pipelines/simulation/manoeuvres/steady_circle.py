"""Steady-state circles: speed rising slowly, in steps, and the 35 m circle of Park & Choi."""

from __future__ import annotations

import numpy as np

from pipelines.simulation.manoeuvres.base import Options, Scenario, VehicleFigures
from pipelines.simulation.manoeuvres.path import Path, fitted_path
from pipelines.simulation.manoeuvres.script import STEP_S, Script

_FRICTION = 0.9
_START_MPS2 = 0.5


def _rising(script: Script, radius_m: float, top_mps2: float, rise_mps3: float) -> None:
    """Speeds along which the lateral acceleration grows evenly from where it is to the top."""
    start = script.speed_mps**2 / radius_m
    t = STEP_S * np.arange(1, max(round((top_mps2 - start) / rise_mps3 / STEP_S), 1) + 1)
    script.follow(np.sqrt(radius_m * np.minimum(start + rise_mps3 * t, top_mps2)))


def _stepping(script: Script, radius_m: float, top_mps2: float, step_mps2: float, hold_s: float) -> None:
    """Speeds of even steps of lateral acceleration, each held."""
    start = script.speed_mps**2 / radius_m
    count = max(int(np.ceil((top_mps2 - start) / step_mps2 - 1e-9)), 1)
    for lateral in np.linspace(start, top_mps2, count + 1)[1:]:
        script.reach(float(np.sqrt(radius_m * lateral)), 0.7)
        script.hold(hold_s)


def _circles(
    name: str,
    title: str,
    standard: str,
    vehicle: VehicleFigures,
    options: Options,
    rng: np.random.Generator,
    *,
    radius_m: float,
    top_mps2: float,
    rise_mps3: float,
    in_steps: bool = False,
    grip_share: float = 0.6,
) -> Scenario:
    """Straight, spiral into the circle, rise to the top, slow down, spiral out, stop; for each side.

    options.speed_mps sets the radius's top speed instead of the lateral acceleration.
    """
    friction = options.grip(_FRICTION)
    if options.speed_mps is not None:
        top_mps2 = options.speed_mps**2 / radius_m
    else:
        top_mps2 = options.severity * vehicle.safe_lateral_mps2(top_mps2, friction, grip_share)
    entry = float(np.sqrt(radius_m * min(_START_MPS2, 0.5 * top_mps2)))
    spiral = max(0.25 * radius_m, 2.0 * entry)

    def write(repeats: int) -> tuple[Script, Path]:
        script, path = Script(vehicle, friction), Path()
        script.rest(4.0)
        for _ in range(repeats):
            for side in options.signs():
                script.reach(entry, 1.0)
                script.hold(1.0)
                start = script.distance_m
                script.hold(spiral / entry)
                if in_steps:
                    _stepping(script, radius_m, top_mps2, 0.5, 5.0)
                else:
                    _rising(script, radius_m, top_mps2, rise_mps3)
                script.hold(3.0)
                script.reach(entry, 1.5)
                script.hold(spiral / entry + 1.0)
                path.bend(start, script.distance_m - entry, side / radius_m, spiral)
                script.reach(0.0, 1.5)
                script.rest(4.0)
        return script, path

    script, path = fitted_path(write, options, repeats=1)
    return Scenario(
        name,
        title,
        standard,
        script.demand(),
        path.road(script.distance_m, _FRICTION, options, vehicle, rng),
        (f"radius {radius_m:g} m, up to {top_mps2:.1f} m/s²",),
    )


def steady_circle(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Steady circle of 100 m, speed rising slowly.

    ISO 4138, constant radius with continuous speed increase: radius 100 m (30 m at least), the lateral acceleration
    growing by 0.1 m/s² a second to 5 m/s², both sides.
    """
    return _circles(
        "steady_circle", "Steady circle", "ISO 4138 (constant radius, continuous speed increase)",
        vehicle, options, rng, radius_m=100.0, top_mps2=5.0, rise_mps3=0.1,
    )  # fmt: skip


def steady_circle_steps(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Steady circle of 100 m, speed in steps.

    ISO 4138, constant radius with discrete speeds: steps of lateral acceleration of 0.5 m/s², each held, both sides.
    """
    return _circles(
        "steady_circle_steps", "Steady circle in steps", "ISO 4138 (constant radius, discrete speeds)",
        vehicle, options, rng, radius_m=100.0, top_mps2=5.0, rise_mps3=0.1, in_steps=True,
    )  # fmt: skip


def circle_35m(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Circle of 35 m from rest to 50 km/h.

    Park & Choi section VI-B: radius 35 m, 0 to 50 km/h on dry asphalt (friction 0.9). 50 km/h there is 0.56 g: the
    0.75 g of the text does not fit its own radius. One side only (left) unless asked.
    """
    if options.direction == "both":
        options = Options(
            options.speed_mps, options.severity, options.duration_s, options.friction, "left", options.surface
        )
    top = (50 / 3.6) ** 2 / 35.0
    return _circles(
        "circle_35m", "Circle of 35 m", "Park & Choi VI-B",
        vehicle, options, rng, radius_m=35.0, top_mps2=top, rise_mps3=0.25, grip_share=0.65,
    )  # fmt: skip
