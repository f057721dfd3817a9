"""results.json: the results for other programs. Names are fixed (docs); what is not a finite number is null."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from parsers.drive import ImportRecord, MappedChannel
from pipelines.drive_results import DriveResults
from pipelines.results import INNER, Distribution, Estimate, ParameterEstimate, Trace
from pipelines.rollover_results import RolloverLimit, TurnMargin
from reports.files import write_whole
from reports.joint_json import joint_json


def plain(value: Any) -> Any:
    """Bring a value into strict JSON: NaN and infinities become null, keys text, lone surrogates �."""
    if isinstance(value, bool) or value is None:
        return value
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode("utf-8")
    if isinstance(value, int):
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(plain(str(k))): plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [plain(v) for v in value]
    if hasattr(value, "tolist"):  # numpy's numbers and arrays
        return plain(value.tolist())
    return plain(str(value))


def parameter(estimate: ParameterEstimate | None) -> dict[str, Any] | None:
    """One parameter as in the verdict."""
    if estimate is None:
        return None
    prior = estimate.prior
    return {
        "value": estimate.value,
        "std": estimate.std,
        "low": estimate.low,
        "high": estimate.high,
        **{f"interval_{100 * level:.0f}": estimate.interval(level) for level in INNER},
        "status": estimate.status,
        "reason": estimate.reason,
        "prior": None if prior is None else {"value": prior.value, "std": prior.std, "source": prior.source},
        "reference": estimate.reference,
        "sources": list(estimate.sources),
        "refused": estimate.refused or None,
    }


def _estimate(estimate: Estimate) -> dict[str, Any]:
    return {
        "estimator": estimate.estimator,
        "status": estimate.status,
        "reason": estimate.reason,
        "parameters": {name: parameter(p) for name, p in estimate.parameters.items()},
        "witness": estimate.witness,
        "used_fraction": estimate.used_fraction,
        "runtime_s": estimate.runtime_s,
        "diagnostics": dict(estimate.diagnostics),
        "assumptions": [asdict(a) for a in estimate.assumptions],
        "distributions": [_distribution(d) for d in estimate.distributions],
    }


def _distribution(distribution: Distribution) -> dict[str, Any]:
    """Quantiles over time with as many digits as a figure of them can show."""
    return {
        "parameter": distribution.parameter,
        "time_s": np.round(distribution.time_s, 3),
        "levels": list(distribution.levels),
        "quantiles": [np.round(q, 5) for q in distribution.quantiles],
        "note": distribution.note,
    }


def _mapped(channel: MappedChannel) -> dict[str, Any]:
    return asdict(channel)


def _import(record: ImportRecord) -> dict[str, Any]:
    signals: dict[str, Any] = {}
    for channel in record.mapped:
        entry = _mapped(channel)
        signals.setdefault(str(entry.pop("signal")), entry)
    return {
        "status": record.status,
        "format": record.format,
        "messages": record.messages,
        "rejected": dict(record.rejected),
        "gaps": [{"start_s": g.start_s, "end_s": g.end_s, "signal": g.signal} for g in record.gaps],
        "clock": record.clock,
        "start_utc": record.start_utc,
        "duration_s": record.duration_s,
        "out_of_order": record.out_of_order,
        "duplicates": record.duplicates,
        "clock_jumps": record.clock_jumps,
        "signals": signals,
        "mapped": [_mapped(channel) for channel in record.mapped],
        "decisions": [asdict(d) for d in record.decisions],
        "turned": list(record.turned),
        "notes": list(record.notes),
    }


def _series(trace: Trace) -> dict[str, Any]:
    """A trace with as many digits as a figure of it can show."""
    return {
        "name": trace.name,
        "units": dict(trace.units),
        "time_s": np.round(trace.time_s, 3),
        "columns": {name: np.round(values, 5) for name, values in trace.columns.items()},
        "note": trace.note,
    }


def _limit(limit: RolloverLimit) -> dict[str, Any]:
    return {
        "name": limit.name,
        "title": limit.title,
        "equation": limit.equation,
        "left": parameter(limit.left),
        "right": parameter(limit.right),
    }


def _turn(turn: TurnMargin) -> dict[str, Any]:
    return {
        "turn": turn.turn,
        "threshold_g": parameter(turn.threshold_g),
        "least_margin_g": parameter(turn.least_margin_g),
        "peak_coefficient": parameter(turn.peak_coefficient),
        "time_s": turn.time_s,
        "lateral_acceleration_g": turn.lateral_acceleration_g,
        "probability": turn.probability,
    }


def _rollover(results: DriveResults) -> dict[str, Any]:
    rollover = results.rollover
    exceedance, check = rollover.exceedance, rollover.check
    return {
        "static_stability_factor": parameter(rollover.static_stability_factor),
        "threshold_g": parameter(rollover.threshold_g),
        "peak_lateral_acceleration_g": rollover.peak_lateral_acceleration_g,
        "peak_rollover_coefficient": rollover.peak_rollover_coefficient,
        "peak_time_s": rollover.peak_time_s,
        "notes": list(rollover.notes),
        "peak_coefficient": parameter(rollover.peak_coefficient),
        "coefficient_source": rollover.coefficient_source,
        "limits": [_limit(limit) for limit in rollover.limits],
        "turns": [_turn(turn) for turn in rollover.turns],
        "wheel_lift": {"source": rollover.lift_source, "events": [asdict(event) for event in rollover.lifts]},
        "exceedance": None if exceedance is None else asdict(exceedance),
        "check": None
        if check is None
        else {
            "slope": parameter(check.slope),
            "rms": check.rms,
            "consistent": check.consistent,
            "text": check.text,
        },
        "series": [_series(trace) for trace in rollover.traces],
        "assumptions": [asdict(a) for a in rollover.assumptions],
    }


def _standing(results: DriveResults) -> dict[str, Any] | None:
    standing = results.standing
    if standing is None:
        return None
    return {
        "body": standing.body,
        "percentile": standing.percentile,
        "measured": int(standing.population.size),
        "measured_of_body": int(standing.same_body.size),
        "nearest": list(standing.nearest),
    }


def to_json(results: DriveResults) -> dict[str, Any]:
    """Results as plain data, ready for `json.dumps(…, allow_nan=False)`."""
    inputs = results.inputs
    first = inputs.logs[0] if inputs.logs else None
    made = {
        "cogest": inputs.version,
        "inputs": {
            "log": {"path": first, "sha256": inputs.log_sha256, "paths": list(inputs.logs)},
            "vehicle": inputs.vehicle,
            "vehicle_sha256": inputs.vehicle_sha256,
            "vehicle_name": results.vehicle_name,
            "map": inputs.map,
            "suspension_map": inputs.suspension_map,
            "suspension_map_sha256": inputs.suspension_map_sha256,
            "settings": inputs.settings,
            "dbc": list(inputs.dbc),
            "seed": inputs.seed,
            "command": inputs.command,
            "created_utc": inputs.created_utc,
        },
        "import": _import(results.record),
        "verdict": {name: parameter(p) for name, p in results.verdict.items()},
        "joint": joint_json(results.joint),
        "estimates": [_estimate(e) for e in results.estimates],
        "rollover": _rollover(results),
        "standing": _standing(results),
        "assumptions": [asdict(a) for a in results.assumptions],
        "limits": list(results.limits),
        "notes": list(results.notes),
    }
    cleaned = plain(made)
    assert isinstance(cleaned, dict)
    return cleaned


def json_text(results: DriveResults) -> str:
    """results.json as text."""
    return json.dumps(to_json(results), ensure_ascii=False, allow_nan=False, indent=2) + "\n"


def write_json(results: DriveResults, path: Path) -> None:
    """Write results.json, whole or not at all. Raises ReportError."""
    write_whole(path, json_text(results).encode("utf-8"))
