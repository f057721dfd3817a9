"""The contract of an estimator: what it needs, what it gives, and its settings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from parsers.drive import Drive
from pipelines.prepare.prepared import Prepared
from pipelines.results import Estimate
from pipelines.vehicles.vehicle import Vehicle

Settings = Mapping[str, float]


@dataclass(frozen=True)
class Need:
    """One requirement. any_of: signal names or vehicle keys, one of which must be there. why: in words."""

    any_of: tuple[str, ...]
    why: str


@dataclass(frozen=True)
class Setting:
    """One setting of an estimator: name, default, unit, meaning, allowed range."""

    name: str
    default: float
    unit: str
    meaning: str
    low: float
    high: float


class Estimator(Protocol):
    """A method. Stateless: no input or output, no clock, no global random state."""

    @property
    def name(self) -> str: ...

    @property
    def title(self) -> str: ...

    @property
    def source(self) -> str:
        """The paper and equations."""
        ...

    @property
    def signal_needs(self) -> tuple[Need, ...]: ...

    @property
    def vehicle_needs(self) -> tuple[Need, ...]: ...

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names (pipelines.parameters) that it can give."""
        ...

    @property
    def settings(self) -> tuple[Setting, ...]: ...

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """Bring the signals that it needs onto one clock. Raises no error for lack of data: segments may be empty."""
        ...

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Estimate. A drive that cannot tell gives status "ran" with parameters "not_identifiable" and reasons."""
        ...
