"""A drive's results as what the fleet's tables need of them, stored beside them: gathering never reads a big file again."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pipelines.drive_results import DriveResults
from pipelines.fleet.doubts import doubts_of
from pipelines.fleet.plain import from_plain, json_bytes, read_json
from pipelines.prepare.standstill import SPEEDS
from pipelines.results import ParameterEstimate, Trace

FILE_NAME = "rows.json"
MOST_BYTES = 16 * 2**20
PACE_S, PACE_STEPS = 5.0, 60
"""Of `DriveRows.pace`: its steps, and how many there are at most."""

_REFUSED_BEFORE = re.compile(
    r"(?:the log and what was known contradict each other beyond doubt|the vehicle file has|no measured).*?(?:; |\? )"
)
"""How reasons of older rows.json begin that say so."""


@dataclass(frozen=True)
class RolloverFigures:
    """The drive's figures on rollover, as in drives.parquet; None where not known."""

    static_stability_factor: float | None = None
    rollover_threshold_g: float | None = None
    least_margin_g: float | None = None
    peak_lateral_acceleration_g: float | None = None
    peak_rollover_coefficient: float | None = None
    exceedance_probability: float | None = None
    wheel_lifts: int | None = None


@dataclass(frozen=True)
class DriveRows:
    """What the tables take from one drive's results. verdict: by parameter. body: the vehicle's, where known. signals: that the logs hold, sorted.
    pace: speed in m/s every PACE_S seconds of the first minutes, by which a drive is told from another; () where none is known. doubts: what it says against its own figures, in words.
    Nothing in here depends on when, where or how long the drive was worked on."""

    start_utc: str | None
    duration_s: float | None
    format: str
    import_status: str
    log_sha256: str
    cogest: str
    rollover: RolloverFigures
    verdict: Mapping[str, ParameterEstimate]
    body: str | None = None
    notes: tuple[str, ...] = field(default=())
    signals: tuple[str, ...] = ()
    pace: tuple[float, ...] = ()
    doubts: tuple[str, ...] = ()


def figure(value: float | None) -> float | None:
    """A finite number, or None: there is nothing to say."""
    return None if value is None or not math.isfinite(value) else float(value)


def _value(estimate: ParameterEstimate | None) -> float | None:
    return None if estimate is None else figure(estimate.value)


def _told(estimate: ParameterEstimate | None) -> float | None:
    """A figure that the drive told: what was known before it is none, and would stand in a fleet's tables as one."""
    return None if estimate is None or estimate.status == "not_identifiable" else figure(estimate.value)


def _rollover(results: DriveResults) -> RolloverFigures:
    rollover = results.rollover
    margins = [value for turn in rollover.turns if (value := _value(turn.least_margin_g)) is not None]
    exceedance = rollover.exceedance
    # without tyre forces and without accelerations that say how the load moves, no lift could have been seen
    known_lifts = bool(rollover.lifts) or rollover.peak_coefficient is not None
    return RolloverFigures(
        static_stability_factor=_told(rollover.static_stability_factor),
        rollover_threshold_g=_told(rollover.threshold_g),
        least_margin_g=min(margins) if margins else None,
        peak_lateral_acceleration_g=figure(rollover.peak_lateral_acceleration_g),
        peak_rollover_coefficient=figure(rollover.peak_rollover_coefficient),
        exceedance_probability=None if exceedance is None else figure(exceedance.probability),
        wheel_lifts=len(rollover.lifts) if known_lifts else None,
    )


def _pace(traces: Sequence[Trace]) -> tuple[float, ...]:
    """The drive's speed in even steps from its start; of the first signal of a speed that there is."""
    by_name = {trace.name: trace for trace in traces}
    for name in SPEEDS:
        trace = by_name.get(name)
        values = None if trace is None else trace.columns.get(name)
        if trace is None or values is None:
            continue
        known = np.isfinite(values)
        if known.any():
            at = np.arange(PACE_STEPS) * PACE_S
            at = at[at <= float(trace.time_s[known][-1])]
            return tuple(np.round(np.interp(at, trace.time_s[known], values[known]), 2).tolist())
    return ()


def rows_of(results: DriveResults) -> DriveRows:
    """What the tables take from a drive's results."""
    record = results.record
    return DriveRows(
        start_utc=record.start_utc,
        duration_s=figure(record.duration_s),
        format=record.format,
        import_status=record.status,
        log_sha256=results.inputs.log_sha256,
        cogest=results.inputs.version,
        rollover=_rollover(results),
        verdict=dict(results.verdict),
        body=None if results.standing is None else results.standing.body,
        notes=(*record.notes, *results.notes),
        signals=tuple(sorted({channel.signal for channel in record.mapped})),
        pace=_pace(results.signals),
        doubts=doubts_of(results),
    )


def rows_bytes(rows: DriveRows) -> bytes:
    """As a file; the same for the same results."""
    return json_bytes(rows)


def rows_from(content: bytes) -> DriveRows:
    """The rows of such a file. Raises StoreError."""
    raw = read_json(content)
    rows = from_plain(DriveRows, raw)
    verdict = {name: _with_field(entry, raw["verdict"][name]) for name, entry in rows.verdict.items()}
    return replace(rows, verdict=verdict)


def _with_field(entry: ParameterEstimate, raw: Mapping[str, Any]) -> ParameterEstimate:
    """An entry of a file from before `refused` was a field, which said it at the beginning of its reason alone; any other as it is."""
    found = None if "refused" in raw else _REFUSED_BEFORE.match(entry.reason)
    return entry if found is None else replace(entry, refused=found[0])
