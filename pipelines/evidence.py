"""What one physical relation of a drive says of the vehicle: a few numbers, and what they would be for a given vehicle."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Kind = Literal["vertical", "pitch", "axle", "roll", "longitudinal", "ride", "length"]
"""The physics: forces along the vertical, moments about the pitch axis, about one axle (what loads the other), and about the roll axis,
forces along the road, the body's and the wheels' shaking over a rough road, and lengths that tell themselves."""

Values = Mapping[str, float] | Mapping[str, FloatArray]
"""The unknowns by name in SI: a figure each, or (n,) of many vehicles at once."""


@dataclass(frozen=True)
class Unknown:
    """An unknown that only one relation has: a name of its own, mean and standard deviation before the log."""

    name: str
    mean: float
    std: float


@dataclass(frozen=True)
class Evidence:
    """A relation, reduced: observed = predict(vehicle) + noise with `covariance`.

    kind, carrier: the physics and the signals that carry it ("spring deflections", "torques"): two entries alike in both
    are the same relation, seen by two estimators, and are counted once. observed: (m,). covariance: (m, m), noise and
    the relation's own model error, and nothing of any prior. predict: from the unknowns by name (numbers, or (n,)
    arrays of many vehicles) to (m,), or (m, n). unknowns: names that it depends on. own: unknowns that nobody else has.
    given: figures measured well enough to be taken as they are ("sag": how much lower the body stands than empty, m), and what the
    outputs need to know of the relation ("inertia_by_forces": `pipelines.joint.vehicle.outputs`).
    dedicated: whether the source was made for these signals; it then stands for the relation before a general one.
    """

    kind: Kind
    carrier: str
    title: str
    source: str
    observed: FloatArray
    covariance: FloatArray
    predict: Callable[[Values], FloatArray]
    unknowns: tuple[str, ...]
    own: tuple[Unknown, ...] = ()
    given: Mapping[str, float] = field(default_factory=dict)
    dedicated: bool = False

    def __post_init__(self) -> None:
        """Raises ValueError for an own unknown that is not listed: it would have no slope, and its spread would be lost."""
        if unlisted := {u.name for u in self.own} - {*self.unknowns}:
            raise ValueError(
                f"{self.title}: own unknowns that are not among `unknowns`: {', '.join(sorted(unlisted))}"
            )
