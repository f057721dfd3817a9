"""What the tables say, brought into the form in which the fleet report speaks of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pipelines.hierarchy.changes import NOT_SEEN
from pipelines.hierarchy.outliers import CHANCE as OUTLYING
from pipelines.results import FloatArray
from reports.fleet.facts import FleetFacts

WIDTH_95 = 2 * 1.96
"""Standard deviations from end to end of a 95 % interval."""

LOAD = ("cg_height_m", "mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m")
"""Parameters that belong to a drive's load: drawn for every vehicle."""

NEAR_G = 0.10
NEAR_PROBABILITY = 0.05
"""A drive is called near rollover from this least margin on, or this probability of having reached it, or a wheel lift."""

Row = Mapping[str, object]

__all__ = [
    "LOAD",
    "NEAR_G",
    "NEAR_PROBABILITY",
    "OUTLYING",
    "Answers",
    "DriveView",
    "FleetView",
    "Row",
    "VehicleView",
]


@dataclass(frozen=True)
class Answers:
    """One parameter from one source for all drives: (n,) arrays in the drives' order, NaN where there is nothing.

    What is not identifiable has no value here: it only repeats the prior. status: 0 none, 1 identified, 2 weak,
    3 not identifiable.
    """

    value: FloatArray
    low: FloatArray
    high: FloatArray
    status: tuple[int, ...]


@dataclass(frozen=True)
class DriveView:
    """One drive. vehicle: its place in `FleetView.vehicles`. start: seconds since 1970 UTC; local: its time zone is not
    known, and it was taken as UTC. href: relative, encoded.

    change: probability where its load was compared with the drive before's. status "done" or how it failed.
    gone: its logs are no longer in the folder. apart: why its vehicle's joined answers do not have it ("misfit", "copy"), or "".
    """

    drive_id: str
    name: str
    vehicle: int
    status: str
    reason: str
    start: int | None
    local: bool
    duration_s: float | None
    format: str
    factor: float | None
    threshold_g: float | None
    margin_g: float | None
    exceedance: float | None
    lifts: int | None
    near: bool
    changed: bool
    gone: bool
    apart: str
    href: str | None
    notes: tuple[str, ...]


@dataclass(frozen=True)
class VehicleView:
    """One vehicle: its drives (places in `FleetView.drives`), and its rows of the other tables."""

    vehicle_id: str
    label: str
    drives: tuple[int, ...]
    failed: int
    shared: tuple[Row, ...]
    changes: tuple[Row, ...]
    trends: tuple[Row, ...]
    outlier: Row | None
    notes: tuple[str, ...]

    @property
    def compared(self) -> int:
        """How many drives could be compared with the one before."""
        return sum(row["text"] != NOT_SEEN for row in self.changes)

    @property
    def looked(self) -> int:
        """Of how many parts the drives could tell whether they drift."""
        return sum(row["per_year"] is not None for row in self.trends)

    @property
    def drifts(self) -> int:
        """How many drifts were detected."""
        return sum(bool(row["detected"]) for row in self.trends)

    @property
    def changed(self) -> int:
        """How many changes of load were detected."""
        return sum(bool(row["detected"]) for row in self.changes)

    @property
    def outlying(self) -> bool:
        """Whether the vehicle stands out from the others of its kind."""
        chance = None if self.outlier is None else self.outlier["probability"]
        return isinstance(chance, float) and chance < OUTLYING


@dataclass(frozen=True)
class FleetView:
    """The whole fleet. own, joined: parameter -> answers of single drives, and with all drives of the vehicle joined."""

    facts: FleetFacts
    drives: tuple[DriveView, ...]
    vehicles: tuple[VehicleView, ...]
    own: Mapping[str, Answers]
    joined: Mapping[str, Answers]
    titles: Mapping[str, tuple[str, str]]
    outliers: tuple[Row, ...]

    @property
    def done(self) -> tuple[DriveView, ...]:
        """The drives that were analysed."""
        return tuple(d for d in self.drives if d.status == "done")

    @property
    def failed(self) -> tuple[DriveView, ...]:
        """The drives that were not."""
        return tuple(d for d in self.drives if d.status != "done")
