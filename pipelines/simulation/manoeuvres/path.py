"""Paths over the ground for manoeuvres between cones and on circles: curvature over the distance travelled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.manoeuvres.base import Options, VehicleFigures
from pipelines.simulation.manoeuvres.script import Script, fitted, proving_ground
from pipelines.simulation.records import Road

STEP_M = 0.25


class Path:
    """Curvature written piece by piece at the distances where the script wants them; straight elsewhere."""

    def __init__(self) -> None:
        """Begin without a bend."""
        self._pieces: list[tuple[float, FloatArray]] = []

    def add(self, start_m: float, curvature_1pm: FloatArray) -> float:
        """Put curvatures (n,) at even steps of STEP_M from a distance on. Returns where they end."""
        self._pieces.append((start_m, curvature_1pm))
        return start_m + STEP_M * len(curvature_1pm)

    def bend(self, start_m: float, end_m: float, curvature_1pm: float, spiral_m: float) -> None:
        """A circle from start to end, with a spiral (even change of curvature) of spiral_m inside either end."""
        s = np.arange(0.0, end_m - start_m, STEP_M)
        inside = np.minimum(s, (end_m - start_m) - s)
        self.add(start_m, curvature_1pm * np.clip(inside / spiral_m, 0.0, 1.0))

    def road(
        self,
        distance_m: float,
        own_friction: float,
        options: Options,
        vehicle: VehicleFigures,
        rng: np.random.Generator,
    ) -> Road:
        """The proving ground with this path on it."""
        ground = proving_ground(distance_m, own_friction, options, vehicle, rng)
        place = np.arange(len(ground.curvature_1pm)) * ground.step_m
        if ground.step_m > STEP_M:
            length = place[-1]
            fine = np.arange(0.0, length + STEP_M / 2, STEP_M)
            grip = np.full(len(fine), ground.friction_left[0])
            zero = np.zeros(len(fine))
            ground, place = Road(STEP_M, zero, zero, zero, zero, zero, grip, grip), fine
        curvature = np.zeros(len(place))
        for start, values in self._pieces:
            own = start + STEP_M * np.arange(len(values))
            curvature += np.interp(place, own, values, left=0.0, right=0.0)
        return replace(ground, curvature_1pm=curvature)


def fitted_path(
    write: Callable[[int], tuple[Script, Path]], options: Options, repeats: int
) -> tuple[Script, Path]:
    """`fitted` for a script that drives along a path: both."""
    paths: list[Path] = []

    def script_of(count: int) -> Script:
        script, path = write(count)
        paths.append(path)
        return script

    script = fitted(script_of, options, repeats)
    return script, paths[-1]


def curvature_of(offset_m: FloatArray) -> FloatArray:
    """Curvature of a path y(x) from its lateral offsets (n,) at even steps of STEP_M along x: y'' / (1 + y'²)^1.5."""
    slope = np.gradient(offset_m, STEP_M)
    return np.asarray(np.gradient(slope, STEP_M) / (1 + slope**2) ** 1.5)


def shift(x: FloatArray) -> FloatArray:
    """From 0 to 1 for x from 0 to 1, with level slope and curvature at both ends: 10 x³ - 15 x⁴ + 6 x⁵."""
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x**3 * (10 - 15 * x + 6 * x * x))
