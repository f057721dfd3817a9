"""results.json: the results for other programs. Names are fixed (docs); what is not a finite number is null."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from parsers.drive import ImportRecord, MappedChannel
from pipelines.results import DriveResults, Estimate, ParameterEstimate
from reports.files import write_whole


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
        "status": estimate.status,
        "reason": estimate.reason,
        "prior": None if prior is None else {"value": prior.value, "std": prior.std, "source": prior.source},
        "reference": estimate.reference,
        "sources": list(estimate.sources),
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
        "notes": list(record.notes),
    }


def _rollover(results: DriveResults) -> dict[str, Any]:
    rollover = results.rollover
    return {
        "static_stability_factor": parameter(rollover.static_stability_factor),
        "threshold_g": parameter(rollover.threshold_g),
        "peak_lateral_acceleration_g": rollover.peak_lateral_acceleration_g,
        "peak_rollover_coefficient": rollover.peak_rollover_coefficient,
        "peak_time_s": rollover.peak_time_s,
        "notes": list(rollover.notes),
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
            "settings": inputs.settings,
            "dbc": list(inputs.dbc),
            "seed": inputs.seed,
            "command": inputs.command,
            "created_utc": inputs.created_utc,
        },
        "import": _import(results.record),
        "verdict": {name: parameter(p) for name, p in results.verdict.items()},
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
