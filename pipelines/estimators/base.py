"""The contract of an estimator: what it needs, what it gives, and its settings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

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


@dataclass(frozen=True)
class TextSetting:
    """A setting that is a word: one of `choices`."""

    name: str
    default: str
    choices: tuple[str, ...]
    meaning: str


PriorEntry = Mapping[str, float | str]
"""A prior as the settings file has it: `distribution` and its figures."""


@dataclass(frozen=True, eq=False)
class FullSettings(Mapping[str, float]):
    """Settings of an estimator that has words and priors besides: a mapping of its numbers, as all others have.

    texts: by name. priors: the table [estimator.priors.PARAMETER], by parameter, checked.
    """

    numbers: Mapping[str, float]
    texts: Mapping[str, str] = field(default_factory=dict)
    priors: Mapping[str, PriorEntry] = field(default_factory=dict)

    def __getitem__(self, name: str) -> float:
        """A number. Raises KeyError."""
        return self.numbers[name]

    def __iter__(self) -> Iterator[str]:
        """The numbers' names."""
        return iter(self.numbers)

    def __len__(self) -> int:
        """How many numbers."""
        return len(self.numbers)


class Estimator(Protocol):
    """A method. Stateless: no input or output, no clock, no global random state."""

    @property
    def name(self) -> str:
        """Its name in settings and results: "roll_map"."""
        ...

    @property
    def title(self) -> str:
        """As an engineer says it."""
        ...

    @property
    def source(self) -> str:
        """The paper and equations."""
        ...

    @property
    def signal_needs(self) -> tuple[Need, ...]:
        """What the log must hold."""
        ...

    @property
    def vehicle_needs(self) -> tuple[Need, ...]:
        """What the vehicle file must hold."""
        ...

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names (pipelines.parameters) that it can give."""
        ...

    @property
    def settings(self) -> tuple[Setting, ...]:
        """What can be set, each with its default."""
        ...

    def prepare(self, drive: Drive, settings: Settings) -> Prepared:
        """Bring the signals that it needs onto one clock. Raises no error for lack of data: segments may be empty."""
        ...

    def estimate(
        self, prepared: Prepared, vehicle: Vehicle, settings: Settings, rng: np.random.Generator
    ) -> Estimate:
        """Estimate. A drive that cannot tell gives status "ran" with parameters "not_identifiable" and reasons."""
        ...


@runtime_checkable
class Configurable(Protocol):
    """What an estimator has besides where its needs hang on its settings: words to choose from, and priors by parameter."""

    @property
    def text_settings(self) -> tuple[TextSetting, ...]:
        """What can be set in words, each with its choices."""
        ...

    def check_priors(self, texts: Mapping[str, str], priors: Mapping[str, PriorEntry]) -> None:
        """Raise PriorError for an unknown parameter or a prior that cannot be."""
        ...

    def configured(self, settings: Settings) -> Estimator:
        """The estimator with the needs and parameters that it has under these settings."""
        ...


class PriorError(ValueError):
    """A prior in a settings file that cannot be used: where, what, and what to write instead."""

    def __init__(self, place: str, message: str, hint: str = ""):
        super().__init__(message)
        self.place, self.message, self.hint = place, message, hint


def configured(estimator: Estimator, settings: Settings) -> Estimator:
    """The estimator as its settings make it."""
    return estimator.configured(settings) if isinstance(estimator, Configurable) else estimator
