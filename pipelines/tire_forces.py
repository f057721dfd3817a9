"""The four tyre normal forces of a drive with their intervals, wherever they are from: measured, or by a suspension map.

    forces = tire_forces(estimates, drive)         # measured where the log has all four, else the estimator's; or None
    lifted = forces.high["fl"] < 300.0             # surely light;  forces.value["fl"] < 300.0: probably

The estimator "suspension_mapping" gives them in its traces; `forces_of` reads them back, so that whoever needs the forces
(wheel lift, reports, files) knows this record and nothing of how they were made.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from parsers.drive import Drive
from parsers.signals import WHEELS
from pipelines.prepare.signals import prepare_signals
from pipelines.results import Estimate, FloatArray, Trace

MAPPING = "suspension_mapping"
"""The estimator whose traces hold the forces."""
SIGNALS: tuple[str, ...] = tuple(f"tire_normal_force_{w}" for w in WHEELS)

BAND_HZ = 10.0
MEASURED_SHARE, MEASURED_ZERO_N = 0.01, 50.0
"""What a measuring wheel's reading is worth where nothing else is known: std of its scale, and of its zero at its place."""


@dataclass(frozen=True)
class TireForces:
    """Tyre normal forces in N over a drive, low-passed (zero phase) at band_hz.

    time_s: (n,) seconds from the drive's start, NaN never. value, low, high: wheel ("fl") -> (n,); low-high is the 95 %
    interval at each instant; NaN where the forces are not known (gaps). An interval may reach below 0: a force cannot.
    measured: from measuring wheels, else by a suspension map. source: in words.
    """

    time_s: FloatArray
    value: Mapping[str, FloatArray]
    low: Mapping[str, FloatArray]
    high: Mapping[str, FloatArray]
    measured: bool
    source: str
    band_hz: float


def trace_name(wheel: str) -> str:
    """The name of the trace that holds one wheel's force."""
    return f"tyre normal force {wheel}"


def is_force_trace(trace: Trace) -> bool:
    """Whether a trace is one of those that `forces_as_traces` makes."""
    return trace.name in map(trace_name, WHEELS)


def forces_as_traces(
    forces: TireForces, beside: Mapping[str, FloatArray] | None = None, note: str = ""
) -> tuple[Trace, ...]:
    """One trace a wheel: columns "force", "low", "high", and "measured" where `beside` (wheel -> (n,)) has the wheel."""
    traces = []
    for wheel in WHEELS:
        columns = {"force": forces.value[wheel], "low": forces.low[wheel], "high": forces.high[wheel]}
        if beside is not None and wheel in beside:
            columns["measured"] = beside[wheel]
        traces.append(Trace(trace_name(wheel), forces.time_s, columns, dict.fromkeys(columns, "N"), note))
    return tuple(traces)


def forces_of(estimate: Estimate) -> TireForces | None:
    """The forces in an estimate's traces; None where it holds none (skipped, failed, another estimator)."""
    found = {trace.name: trace for trace in estimate.traces}
    traces = [found.get(trace_name(wheel)) for wheel in WHEELS]
    there = [trace for trace in traces if trace is not None]
    if estimate.status != "ran" or len(there) != len(WHEELS):
        return None
    if any(name not in trace.columns for trace in there for name in ("force", "low", "high")):
        return None
    by = dict(zip(WHEELS, there, strict=True))
    return TireForces(
        time_s=there[0].time_s,
        value={w: t.columns["force"] for w, t in by.items()},
        low={w: t.columns["low"] for w, t in by.items()},
        high={w: t.columns["high"] for w, t in by.items()},
        measured=False,
        source=f"{estimate.estimator}: {estimate.reason}" if estimate.reason else estimate.estimator,
        band_hz=float(estimate.diagnostics.get("band_hz", math.nan)),
    )


def measured_forces(drive: Drive, band_hz: float = BAND_HZ) -> TireForces | None:
    """The forces of measuring wheels, all four on one clock; None where one is missing or they never overlap.

    The interval is that of a measuring wheel's zero and scale (MEASURED_ZERO_N, MEASURED_SHARE).
    """
    if any(name not in drive.signals for name in SIGNALS):
        return None
    prepared = prepare_signals(drive, SIGNALS, rate_hz=None, cutoff_hz=band_hz)
    if not prepared.segments:
        return None
    inside = np.zeros(len(prepared.time_s), dtype=bool)
    for segment in prepared.segments:
        inside[segment.start : segment.stop] = True
    value = {
        w: np.where(inside, prepared.columns[name], np.nan) for w, name in zip(WHEELS, SIGNALS, strict=True)
    }
    half = {w: 1.96 * np.hypot(MEASURED_ZERO_N, MEASURED_SHARE * v) for w, v in value.items()}
    return TireForces(
        prepared.time_s,
        value,
        {w: value[w] - half[w] for w in WHEELS},
        {w: value[w] + half[w] for w in WHEELS},
        True,
        "measured by wheel-force transducers",
        prepared.cutoff_hz,
    )


def tire_forces(estimates: Sequence[Estimate], drive: Drive) -> TireForces | None:
    """The best that the drive has: measured, else those of the suspension map; None without either."""
    measured = measured_forces(drive)
    if measured is not None:
        return measured
    found = [forces_of(estimate) for estimate in estimates if estimate.estimator == MAPPING]
    return next((forces for forces in found if forces is not None), None)
