"""Draws of what is known: from a verdict's interval, from the vehicle file, or from what is usual."""

from __future__ import annotations

import math

import numpy as np

from pipelines.results import FloatArray, Identification, ParameterEstimate
from pipelines.vehicles.vehicle import Quantity

COUNT = 4000
SEED = 20_000
"""A fixed seed of their own: these draws carry no information and must not move with anything else."""

LEVELS = (0.025, 0.975)
_95 = 1.959964


def log_normal(value: float, std: float, z: FloatArray) -> FloatArray:
    """(n,) draws of a positive quantity with this mean and spread. z: standard normal."""
    share = math.log(1 + (std / value) ** 2)
    return np.asarray(value * np.exp(math.sqrt(share) * z - share / 2))


def from_interval(estimate: ParameterEstimate, z: FloatArray, *, positive: bool) -> FloatArray:
    """(n,) draws whose median is the value and whose 95 % range is the interval, each side by its own half.

    Positive quantities on a logarithmic scale. Where the ends are missing or not on both sides, value ± 1.96 std.
    """
    value, std = estimate.value, estimate.std or 0.0
    if value is None:
        raise ValueError(f"{estimate.name} has no value to draw from")
    low = estimate.low if estimate.low is not None else value - _95 * std
    high = estimate.high if estimate.high is not None else value + _95 * std
    if positive:
        low = max(low, 0.05 * value)
    if not low <= value <= high:
        low, high = value - _95 * std, value + _95 * std
        low = max(low, 0.05 * value) if positive else low
    if positive:
        below, above = math.log(value / low), math.log(high / value)
        return np.asarray(value * np.exp(np.where(z < 0, below, above) * z / _95))
    return np.asarray(value + np.where(z < 0, value - low, high - value) * z / _95)


def from_quantity(quantity: Quantity, z: FloatArray) -> FloatArray:
    """(n,) draws of a figure of the vehicle file."""
    return np.asarray(quantity.value + quantity.std * z)


def summary(
    name: str, values: FloatArray, status: Identification, reason: str, *,
    reference: float | None = None, sources: tuple[str, ...] = (),
) -> ParameterEstimate:  # fmt: skip
    """Draws as an estimate: median, spread and 95 % range."""
    low, high = (float(q) for q in np.quantile(values, LEVELS))
    value, std = float(np.median(values)), float(values.std())
    return ParameterEstimate(name, value, std, low, high, status, reason, None, reference, sources)
