"""What is known of a model's parameters before the data: independent distributions, and the coordinates that serve them.

A parameter that is positive by nature is worked with by its logarithm: its range may then be wide, and no point is ever
below zero. Densities are those of the parameter itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pipelines.results import FloatArray

FAR = 4.0
"""A normal prior's support for a surrogate, in its standard deviations."""


@dataclass(frozen=True)
class Uniform:
    """Any value from low to high alike; none beyond."""

    low: float
    high: float

    def __post_init__(self) -> None:
        """Raise ValueError where there is nothing between low and high."""
        _ordered(self.low, self.high)

    @property
    def mean(self) -> float:
        """Middle."""
        return 0.5 * (self.low + self.high)

    @property
    def std(self) -> float:
        """Standard deviation."""
        return (self.high - self.low) / math.sqrt(12)

    @property
    def reach(self) -> tuple[float, float]:
        """Where a first surrogate looks."""
        return self.low, self.high

    def log_density(self, value: FloatArray) -> FloatArray:
        """(n,) -> (n,)"""
        inside = (value >= self.low) & (value <= self.high)
        return np.where(inside, -math.log(self.high - self.low), -np.inf)


@dataclass(frozen=True)
class Normal:
    """About `value` with `std`; nothing below low or above high (the rest is not scaled up: it is meant to be little)."""

    value: float
    std: float
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        """Raise ValueError for a spread that is none, or a value outside of its bounds."""
        if not (math.isfinite(self.value) and 0 < self.std < math.inf):
            raise ValueError("a normal prior needs a value and a spread above 0")
        if not self.low < self.value < self.high:
            raise ValueError(f"{self.value:g} is not between {self.low:g} and {self.high:g}")

    @property
    def mean(self) -> float:
        """Its middle."""
        return self.value

    @property
    def reach(self) -> tuple[float, float]:
        """Where a first surrogate looks: FAR standard deviations, within the bounds."""
        return max(self.low, self.value - FAR * self.std), min(self.high, self.value + FAR * self.std)

    def log_density(self, value: FloatArray) -> FloatArray:
        """(n,) -> (n,)"""
        z = (value - self.value) / self.std
        log = -0.5 * z * z - math.log(self.std * math.sqrt(2 * math.pi))
        return np.where((value >= self.low) & (value <= self.high), log, -np.inf)


@dataclass(frozen=True)
class Beta:
    """Beta(a, b) stretched from low to high."""

    low: float
    high: float
    a: float
    b: float

    def __post_init__(self) -> None:
        """Raise ValueError for shapes that are not above 0, or nothing between low and high."""
        _ordered(self.low, self.high)
        if not (0 < self.a < math.inf and 0 < self.b < math.inf):
            raise ValueError("the shapes a and b of a beta prior must be above 0")

    @property
    def mean(self) -> float:
        """Mean."""
        return self.low + (self.high - self.low) * self.a / (self.a + self.b)

    @property
    def std(self) -> float:
        """Standard deviation."""
        total = self.a + self.b
        return (self.high - self.low) * math.sqrt(self.a * self.b / (total * total * (total + 1)))

    @property
    def reach(self) -> tuple[float, float]:
        """Where a first surrogate looks."""
        return self.low, self.high

    def log_density(self, value: FloatArray) -> FloatArray:
        """(n,) -> (n,)"""
        width = self.high - self.low
        inside = (value > self.low) & (value < self.high)
        u = np.where(inside, (value - self.low) / width, 0.5)
        log = (self.a - 1) * np.log(u) + (self.b - 1) * np.log1p(-u)
        log -= math.lgamma(self.a) + math.lgamma(self.b) - math.lgamma(self.a + self.b) + math.log(width)
        return np.where(inside, log, -np.inf)


Distribution = Uniform | Normal | Beta


def _ordered(low: float, high: float) -> None:
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ValueError(f"there is nothing between {low:g} and {high:g}")


@dataclass(frozen=True)
class Known:
    """A parameter's prior: its name, its distribution, whether it is worked with by its logarithm, where it is from.

    runs: from where to where the model can be run, None = where the prior is: a domain that is turned to fit a long narrow
    posterior has corners, and needs room for them.
    """

    name: str
    distribution: Distribution
    log: bool = False
    source: str = ""
    runs: tuple[float, float] | None = None


@dataclass(frozen=True)
class Priors:
    """The priors of a model's d parameters, independent of each other. Coordinates: the value, or its logarithm."""

    items: tuple[Known, ...]

    def __post_init__(self) -> None:
        """Raise ValueError where there is no parameter, or one by its logarithm can be 0 or less."""
        if not self.items:
            raise ValueError("there is no parameter to estimate")
        for item in self.items:
            if item.log and item.distribution.reach[0] <= 0:
                raise ValueError(f"{item.name} can be 0 or less: it has no logarithm")

    @property
    def dimensions(self) -> int:
        """d"""
        return len(self.items)

    @property
    def names(self) -> tuple[str, ...]:
        """In order."""
        return tuple(item.name for item in self.items)

    def box(self) -> tuple[FloatArray, FloatArray]:
        """Low and high coordinates (d,) of where a first surrogate looks."""
        reach = np.array([item.distribution.reach for item in self.items])
        return self._into(reach[:, 0]), self._into(reach[:, 1])

    def hard(self) -> tuple[FloatArray, FloatArray]:
        """Low and high coordinates (d,) beyond which the density is 0; infinite where there is no such bound."""
        return self._bounds([(item.distribution.low, item.distribution.high) for item in self.items])

    def runs(self) -> tuple[FloatArray, FloatArray]:
        """Low and high coordinates (d,) between which the model can be run."""
        return self._bounds([i.runs or (i.distribution.low, i.distribution.high) for i in self.items])

    def _bounds(self, pairs: list[tuple[float, float]]) -> tuple[FloatArray, FloatArray]:
        bounds = []
        for item, (low, high) in zip(self.items, pairs, strict=True):
            if item.log:
                low, high = (math.log(low) if low > 0 else -math.inf), math.log(high)
            bounds.append((low, high))
        table = np.array(bounds)
        return table[:, 0], table[:, 1]

    def values(self, coordinates: FloatArray) -> FloatArray:
        """Parameters from coordinates, (..., d)."""
        out = np.array(coordinates, dtype=np.float64)
        for j, item in enumerate(self.items):
            if item.log:
                out[..., j] = np.exp(out[..., j])
        return out

    def _into(self, values: FloatArray) -> FloatArray:
        logs = np.array([item.log for item in self.items])
        return np.where(logs, np.log(np.where(logs, values, 1.0)), values)

    def coordinates(self, values: FloatArray) -> FloatArray:
        """Coordinates (d,) of parameters (d,)."""
        return self._into(np.asarray(values, dtype=np.float64))

    def log_density(self, coordinates: FloatArray) -> FloatArray:
        """Of the parameters (not of the coordinates) at coordinates (n, d): (n,)."""
        values = self.values(coordinates)
        return np.asarray(
            sum(item.distribution.log_density(values[:, j]) for j, item in enumerate(self.items)),
            dtype=np.float64,
        )

    def log_stretch(self, coordinates: FloatArray) -> FloatArray:
        """(n,) logarithm of d values / d coordinates, which a density over coordinates has besides."""
        logs = [j for j, item in enumerate(self.items) if item.log]
        return np.asarray(coordinates[:, logs].sum(axis=1))
