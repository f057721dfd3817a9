"""What goes into the model of a vehicle's drives, and what comes out of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from pipelines.joint.kept import KeptRelations
from pipelines.results import ParameterEstimate

Apart = Literal["misfit", "copy"]
"""Why a drive tells its vehicle nothing: it does not go with the others, or another drive is the same recording."""


@dataclass(frozen=True)
class DriveTold:
    """One drive of a vehicle, in the order of time. start_utc: ISO 8601 or None; verdict: its own, by parameter.

    kept: what its relations told; None where it told nothing (no relation could be used).
    """

    drive_id: str
    start_utc: str | None
    verdict: Mapping[str, ParameterEstimate]
    kept: KeptRelations | None


@dataclass(frozen=True)
class VehicleParameter:
    """A parameter that belongs to the vehicle whatever its load, from all drives. single_std: a single drive's, median.

    doubt: standard deviation that the drives' doubts make of the estimate's.
    """

    estimate: ParameterEstimate
    title: str
    unit: str
    single_std: float | None
    drives: int
    doubt: float = 0.0


@dataclass(frozen=True)
class LoadChange:
    """This drive's load against that of the drive before. changes: parameter -> (difference, standard deviation)."""

    drive_id: str
    before: str
    probability: float
    detected: bool
    changes: Mapping[str, tuple[float, float]]
    text: str


@dataclass(frozen=True)
class Trend:
    """Change of a part a year, with its 95 % interval. probability: of one as large by chance."""

    parameter: str
    title: str
    unit: str
    per_year: float
    std: float
    low: float
    high: float
    probability: float
    detected: bool
    from_utc: str
    to_utc: str
    drives: int
    text: str


@dataclass(frozen=True)
class VehicleKnowledge:
    """What all drives of one vehicle say. drives: drive_id -> answers with all drives joined, as in a verdict.

    notes: of the vehicle. drive_notes: drive_id -> what was done with that drive alone. apart: drive_id -> why the joined
    answers do not have it, see `Apart`.
    """

    vehicle_id: str
    vehicle: Mapping[str, VehicleParameter]
    drives: Mapping[str, Mapping[str, ParameterEstimate]]
    load_changes: tuple[LoadChange, ...]
    trends: tuple[Trend, ...]
    notes: tuple[str, ...] = ()
    drive_notes: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    apart: Mapping[str, Apart] = field(default_factory=dict)

    def notes_for(self, drive_id: str) -> tuple[str, ...]:
        """What is said of the vehicle's drives to one of them."""
        return (*self.notes, *self.drive_notes.get(drive_id, ()))


@dataclass(frozen=True)
class Outlier:
    """A vehicle against the others of its kind. score: the largest distance in joint standard deviations."""

    rank: int
    vehicle_id: str
    score: float
    probability: float
    parameter: str
    value: float
    others: float
    others_std: float
    text: str
