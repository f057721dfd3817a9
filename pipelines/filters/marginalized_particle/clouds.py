"""The particles that a drive starts from."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pipelines.filters.marginalized_particle.records import PARAMETERS, Cloud
from pipelines.results import FloatArray

Given = float | tuple[float, float]
"""A quantity that is known, or its mean and standard deviation."""


def _draw(given: Given, count: int, positive: bool, rng: np.random.Generator) -> FloatArray:
    """(count,) normal draws; of what is positive, each below a tenth of the mean is put there."""
    mean, std = (given, 0.0) if isinstance(given, int | float) else given
    if not (np.isfinite(mean) and np.isfinite(std) and std >= 0) or (positive and mean <= 0):
        raise ValueError(f"a quantity has a finite mean and a spread that is not negative, not {given}")
    if std == 0:
        return np.full(count, float(mean))
    drawn = mean + std * rng.standard_normal(count)
    return np.maximum(drawn, 0.1 * mean) if positive else drawn


def mirror_height(mass_kg: FloatArray, roll_inertia_kgm2: FloatArray) -> FloatArray:
    """sqrt(I_x / m): the height at which a particle is its own mirror image (NOTES: K, D, h times I_x / (m h²))."""
    return np.asarray(np.sqrt(roll_inertia_kgm2 / mass_kg))


def cloud_of(
    theta: FloatArray,
    *,
    mass_kg: Given,
    roll_inertia_kgm2: Given,
    input_height_m: Given = 0.0,
    weights: FloatArray | None = None,
    above_mirror: bool = True,
    rng: np.random.Generator,
) -> Cloud:
    """Particles from K, D, h in theta (N, 3), e.g. of a warm start. above_mirror: those below become their mirror image.

    Mass, inertia and height of the input get draws of their own where they have a standard deviation.
    """
    if theta.ndim != 2 or theta.shape[1] != len(PARAMETERS):
        raise ValueError(f"theta is (N, 3): K, D, h; not {theta.shape}")
    count = len(theta)
    mass = _draw(mass_kg, count, True, rng)
    inertia = _draw(roll_inertia_kgm2, count, True, rng)
    above = _draw(input_height_m, count, False, rng)
    values = np.array(theta, dtype=np.float64)
    if not (values > 0).all():
        raise ValueError("K, D and h are positive")
    if above_mirror:
        scale = inertia / (mass * values[:, 2] ** 2)
        values = np.where((scale > 1)[:, None], values * scale[:, None], values)
    table = np.ascontiguousarray(np.column_stack((values, mass, inertia, above)))
    return Cloud(table, np.full(count, 1.0 / count) if weights is None else weights)


def uniform_cloud(
    count: int,
    ranges: Mapping[str, tuple[float, float]],
    *,
    mass_kg: Given,
    roll_inertia_kgm2: Given,
    input_height_m: Given = 0.0,
    above_mirror: bool = True,
    rng: np.random.Generator,
) -> Cloud:
    """NONBO's prior: `count` particles uniform over ranges["K"], ["D"], ["h"].

    above_mirror: the height is uniform over what of its range lies above sqrt(I_x / m).
    Raises ValueError where a range is empty, not positive, or lies below the mirror line.
    """
    low, high = (np.array([ranges[name][end] for name in PARAMETERS], dtype=np.float64) for end in (0, 1))
    if not ((low > 0).all() and (low < high).all() and np.isfinite(high).all()):
        raise ValueError("a range goes from a positive number to a larger one")
    share = rng.random((count, len(PARAMETERS)))
    given = cloud_of(
        np.ones((count, len(PARAMETERS))),
        mass_kg=mass_kg,
        roll_inertia_kgm2=roll_inertia_kgm2,
        input_height_m=input_height_m,
        above_mirror=False,
        rng=rng,
    ).theta
    lows = np.tile(low, (count, 1))
    if above_mirror:
        lows[:, 2] = np.maximum(lows[:, 2], mirror_height(given[:, 3], given[:, 4]))
        if (lows[:, 2] >= high[2]).any():
            raise ValueError("the range of the height lies below sqrt(I_x / m)")
    given[:, :3] = lows + share * (high - lows)
    return Cloud(given, np.full(count, 1.0 / count))
