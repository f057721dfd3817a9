"""The bench of Chapter 5: one road, the hubs' accelerations on it, and what a body makes of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipelines.models.base_excitation_3dof import COLUMNS, Geometry, corner_response
from pipelines.reproduce.gpc_map.plant import FINE, Car, drive
from pipelines.results import FloatArray
from pipelines.simulation.roads.profile import iso_spectrum, roughness, smoothed

RATE_HZ = 100.0
DURATION_S = 60.0
SPEED_MPS = 15.0
SURFACE = "C"
NOISE_MPS2 = 0.5
FIRST_METRES = 15.0
PATCH_M = 0.3
SETTLE_S = 3.0


@dataclass(frozen=True)
class Setting:
    """A row of Table 5.1: means at the start, order, length and number of the intervals; and of Table 5.2: estimates."""

    run: int
    mean: tuple[float, float, float]
    order: int
    interval_s: float
    intervals: int
    printed: tuple[float, float, float]
    error: tuple[float, float, float]

    @property
    def seconds(self) -> float:
        """Of data that are used."""
        return self.interval_s * self.intervals


HIGH, LOW = (2250.0, 3500.0, 1000.0), (1650.0, 2600.0, 1000.0)
SETTINGS = (
    Setting(1, HIGH, 6, 24.0, 1, (1905.685, 3054.9, 785.44), (3.01, 1.83, -1.82)),
    Setting(2, HIGH, 6, 1.0, 24, (1897.915, 3017.19, 823.28), (2.59, 0.57, 2.91)),
    Setting(3, HIGH, 4, 24.0, 1, (1934.36, 3159.0, 780.08), (4.56, 5.3, -2.49)),
    Setting(4, HIGH, 4, 1.0, 24, (1852.405, 2877.0, 833.44), (0.13, -4.1, 4.18)),
    Setting(5, LOW, 6, 24.0, 1, (1914.0, 3069.4, 766.7), (3.46, 2.31, -4.17)),
    Setting(6, HIGH, 4, 6.0, 4, (1897.9, 3048.3, 858.2), (2.59, 2.61, 7.28)),
    Setting(7, HIGH, 4, 60.0, 1, (1802.5, 2876.4, 803.4), (-1.59, -4.12, 0.43)),
    Setting(8, HIGH, 10, 24.0, 1, (1874.2, 3047.3, 777.7), (1.31, 1.58, -2.78)),
)
"""As printed in Tables 5.1 and 5.2."""

NAMES = ("mass", "pitch inertia", "roll inertia")
UNITS = ("kg", "kg·m²", "kg·m²")


@dataclass(frozen=True)
class Bench:
    """The car, the hubs' accelerations (n, 4), and the body's over the wheels: of the seven-degree-of-freedom car, and as the
    three-degree-of-freedom model has it (no warp)."""

    car: Car
    hubs: FloatArray
    seven: FloatArray
    matched: FloatArray

    @property
    def geometry(self) -> Geometry:
        """As the model takes it."""
        return Geometry(self.car.wheelbase_m, self.car.track_m, self.car.track_m)


def table_of(car: Car, values: FloatArray, springs: float = 1.0) -> FloatArray:
    """The model's table (Q, 14) from mass and inertias (Q, 3). springs: factor on springs and dampers."""
    table = np.zeros((len(values), len(COLUMNS)))
    table[:, :3] = values
    table[:, 3] = car.front_m
    table[:, 5], table[:, 6] = springs * car.spring_front_npm, springs * car.spring_rear_npm
    table[:, 7:9], table[:, 9:11] = springs * car.damper_front_nspm, springs * car.damper_rear_nspm
    return table


def road_under_wheels(car: Car, rng: np.random.Generator) -> FloatArray:
    """Heights (2 FINE n + 1, 4) at half integration steps; the rear wheels meet the road a wheelbase later."""
    step = 0.05
    length = SPEED_MPS * DURATION_S + 2 * FIRST_METRES
    left, right = roughness(iso_spectrum(SURFACE, 1.0), length, step, car.track_m, rng)
    way = np.arange(len(left)) * step
    # from flat ground, so that all begins at rest
    rise = 1 - np.exp(-((way / FIRST_METRES) ** 2))
    time = np.arange(round(DURATION_S * RATE_HZ) * 2 * FINE + 1) / (RATE_HZ * 2 * FINE)
    front, rear = SPEED_MPS * time, SPEED_MPS * time - car.wheelbase_m
    columns = []
    for place in (front, rear):
        for side in (left, right):
            height = rise * smoothed(side - side[0], step, PATCH_M)
            columns.append(np.interp(np.maximum(place, 0.0), way, height))
    return np.column_stack(columns)


def bench(rng: np.random.Generator) -> Bench:
    """Make the road from `rng`, and drive over it without noise."""
    car = Car()
    seven, hubs = drive(car, road_under_wheels(car, rng), RATE_HZ)
    geometry = Geometry(car.wheelbase_m, car.track_m, car.track_m)
    matched = corner_response(table_of(car, car.truth[None]), hubs, geometry, 1 / RATE_HZ, warp=False)[0]
    return Bench(car, hubs, seven, matched)
