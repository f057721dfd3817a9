"""Where a load that nobody tells of may lie: in the vehicle, or a part of it on the roof. Each by its chance, as the log makes it.

Persons, luggage and cargo lie within a third of the empty CG's height about each other, a roof's box twice as high: one normal law
that holds both would leave the height of an ordinary load as open as the roof's. The unknowns before the log have the mean and
spread of both together (`usual_height`); which of them it is, every doubt is weighed with (`pipelines.joint.doubts`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipelines.results import FloatArray
from pipelines.vehicles.kinds import Kind, kind_of
from pipelines.vehicles.vehicle import Vehicle

Figures = Mapping[str, tuple[float, float]]
"""Unknowns by name: where they are, and how surely; SI."""


@dataclass(frozen=True)
class Height:
    """Of a load over that of the empty vehicle's CG. chance: how often; mean, std: a normal law."""

    chance: float
    mean: float
    std: float


INSIDE, ROOF = Height(0.87, 1.3, 0.3), Height(0.13, 1.95, 0.4)
"""Persons, who sit 0.2 m above a hip point of 0.5 to 0.75 m, are at 1.2 to 1.5 of it, luggage and cargo at 0.8 to 1.6. ROOF: a box or ladders at 2.2 to 2.9, with the driver."""

LORRY = Height(1.0, 1.45, 0.65)
"""Cargo on a lorry's bed, or standing passengers."""

ROOF_LOAD = (175.0, 70.0)
"""kg on the roof and of the driver: roofs and racks carry 50 to 150 kg."""
ROOF_X = 0.12
"""Spread of its place over the wheelbase, about the middle."""


MOST_KG = ROOF_LOAD[0] + 2.5 * ROOF_LOAD[1]
"""A load that is stated to weigh more lies in the vehicle."""


def _heights(vehicle: Vehicle) -> tuple[Height, ...]:
    kind: Kind = kind_of(vehicle)
    if kind == "heavy":
        return (LORRY,)
    stated = vehicle.load.get("mass_kg")
    if stated is not None and stated.value > MOST_KG:
        return (replace(INSIDE, chance=1.0),)
    return INSIDE, ROOF


def usual_height(vehicle: Vehicle) -> tuple[float, float]:
    """Mean and standard deviation of a load's height over that of the empty vehicle's CG, wherever it lies."""
    heights = _heights(vehicle)
    mean = sum(h.chance * h.mean for h in heights)
    square = sum(h.chance * (h.std**2 + (h.mean - mean) ** 2) for h in heights)
    return mean, math.sqrt(square)


def in_words(vehicle: Vehicle) -> str:
    """Where a load may lie, for the report's list of assumptions."""
    first, *others = _heights(vehicle)
    if not others:
        return f"{first.mean:g} ± {first.std:g} of the empty CG's height, anywhere in the vehicle"
    kilos, spread = ROOF_LOAD
    return (
        f"{INSIDE.mean:g} ± {INSIDE.std:g} of the empty CG's height in the vehicle ({INSIDE.chance:.0%}), or {ROOF.mean:g} ± {ROOF.std:g} "
        f"where a part is on the roof ({kilos:.0f} ± {spread:.0f} kg with the driver)"
    )


@dataclass(frozen=True)
class LoadPlace:
    """A kind of place. chance: how often a load lies there; figures: the unknowns that are otherwise then."""

    chance: float
    figures: Figures


def places(vehicle: Vehicle, mean: Mapping[str, float]) -> tuple[LoadPlace, ...]:
    """Each kind of place; none where the vehicle file tells the load's height, or one law holds all.

    mean: of the unknowns before the log, by name.
    """
    if vehicle.load.get("height_m") is not None or len(_heights(vehicle)) == 1:
        return ()
    empty = mean["empty_h"]
    inside: Figures = {"load_h": (INSIDE.mean * empty, INSIDE.std * empty)}
    roof: dict[str, tuple[float, float]] = {"load_h": (ROOF.mean * empty, ROOF.std * empty)}
    if vehicle.load.get("mass_kg") is None:
        roof["load"] = ROOF_LOAD
    if vehicle.load.get("behind_front_axle_m") is None:
        roof["load_x"] = (0.5 * mean["wheelbase"], ROOF_X * mean["wheelbase"])
    return LoadPlace(INSIDE.chance, inside), LoadPlace(ROOF.chance, roof)


def placed(
    values: FloatArray, names: Sequence[str], where: Sequence[LoadPlace], rng: np.random.Generator
) -> FloatArray:
    """Draws of the unknowns (n, k) with each load at one of its places. values: SI, columns by `names`."""
    if not where:
        return values
    found = values.copy()
    which = rng.choice(len(where), len(values), p=[place.chance for place in where])
    for i, place in enumerate(where):
        rows = np.flatnonzero(which == i)
        for name, (mean, std) in place.figures.items():
            found[rows, names.index(name)] = rng.normal(mean, std, len(rows))
    return found
