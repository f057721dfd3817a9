"""All that is known of one drive once it was analysed: what reports are made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from parsers.drive import ImportRecord
from pipelines.results import Assumption, Estimate, FloatArray, JointVerdict, ParameterEstimate, Trace
from pipelines.rollover_results import Rollover


@dataclass(frozen=True)
class Standing:
    """Where this vehicle stands among the measured ones: their CG heights, and ours with its interval.

    population: (n,) CG heights in m. same_body: (k,) those of the same body style. percentile of our value in
    `same_body` (0-100), None without a value.
    """

    population: FloatArray
    same_body: FloatArray
    body: str | None
    percentile: float | None
    nearest: tuple[str, ...] = ()


@dataclass(frozen=True)
class Inputs:
    """What went in, and its hashes."""

    logs: tuple[str, ...]
    log_sha256: str
    vehicle: str | None
    vehicle_sha256: str | None
    map: str | None
    settings: str | None
    dbc: tuple[str, ...]
    seed: int
    command: str
    version: str
    created_utc: str
    suspension_map: str | None = None
    suspension_map_sha256: str | None = None


@dataclass(frozen=True)
class DriveResults:
    """All that a report is made of. Nothing in here needs the log any more."""

    inputs: Inputs
    record: ImportRecord
    vehicle_name: str | None
    verdict: Mapping[str, ParameterEstimate]
    estimates: tuple[Estimate, ...]
    rollover: Rollover
    standing: Standing | None
    assumptions: tuple[Assumption, ...]
    limits: tuple[str, ...]
    signals: tuple[Trace, ...]
    notes: tuple[str, ...] = ()
    joint: JointVerdict | None = None
