"""A drive as cogest sees it: canonical signals with their own clocks, and the record of how they were made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from parsers.channels import FloatArray, IntArray
from parsers.importer import Status

DecisionKind = Literal[
    "sign",
    "unit",
    "spikes",
    "offset",
    "scale",
    "range",
    "choice",
    "load",
    "zero",
    "vehicle",
    "delay",
    "mount",
]


@dataclass(frozen=True)
class Signal:
    """One canonical signal: SI, ISO 8855, finite values only, time strictly increasing.

    time_ns: shape (n,), nanoseconds on the drive's clock. values: shape (n,). source: the channel it is from, or
    how it was derived. measured: False for derived signals, which rank below measured ones. group: signals of one
    group come from one table, topic or message of the log and go into one file of the store.
    """

    name: str
    time_ns: IntArray
    values: FloatArray
    source: str
    measured: bool = True
    group: str = ""


@dataclass(frozen=True)
class Gap:
    """A span without samples in a signal or in the whole drive; seconds from the drive's start."""

    start_s: float
    end_s: float
    signal: str | None = None


@dataclass(frozen=True)
class Decision:
    """What a check against physics found in a signal, and what was done about it.

    found: a sentence ("yaw_rate has the sign opposite to lateral acceleration"). action: a sentence ("inverted").
    evidence: the figure behind it ("correlation -0.98 over 41 s"). applied: False under --no-fix or in doubt.
    """

    signal: str
    kind: DecisionKind
    found: str
    action: str
    evidence: str
    applied: bool


@dataclass(frozen=True)
class MappedChannel:
    """Which channel became which signal, and why. `alternatives`: channels that could have been it too.

    used: False where the checks left the signal out, or another log's was taken; `rule` then says so.
    """

    signal: str
    channel: str
    unit: str
    unit_from: str
    rule: str
    samples: int
    rate_hz: float
    scale: float = 1.0
    offset: float = 0.0
    inverted: bool = False
    alternatives: tuple[str, ...] = ()
    used: bool = True


@dataclass(frozen=True)
class ImportRecord:
    """What happened when a log was read. Nothing is dropped without a line in here.

    start_utc: ISO 8601 in UTC; without an offset where nothing says of which time zone the recorder's clock is. turned: signals that
    the checks inverted; one decision may be about several (a unit mounted backwards, an axle's springs). databases: file names of
    the CAN databases of which a message was in the logs.
    """

    format: str
    paths: tuple[Path, ...]
    sha256: str
    status: Status
    messages: int
    rejected: Mapping[str, int]
    gaps: tuple[Gap, ...]
    clock: str
    start_utc: str | None
    duration_s: float
    mapped: tuple[MappedChannel, ...]
    decisions: tuple[Decision, ...] = ()
    notes: tuple[str, ...] = ()
    out_of_order: int = 0
    duplicates: int = 0
    clock_jumps: int = 0
    turned: tuple[str, ...] = ()
    databases: tuple[str, ...] = ()

    @property
    def disorder(self) -> tuple[str, ...]:
        """What was put in order, in words: "9 repeated stamps"."""
        counts = (
            (self.out_of_order, "sample out of order", "samples out of order"),
            (self.duplicates, "repeated stamp", "repeated stamps"),
            (self.clock_jumps, "clock jump", "clock jumps"),
        )
        return tuple(f"{n} {one if n == 1 else many}" for n, one, many in counts if n)


@dataclass(frozen=True)
class Drive:
    """One drive: signals by name ("accel_y"), and their record. start_ns: the first sample on the drive's clock."""

    signals: Mapping[str, Signal]
    record: ImportRecord
    start_ns: int = 0
    truth: Mapping[str, float] = field(default_factory=dict)
