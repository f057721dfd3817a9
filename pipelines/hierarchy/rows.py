"""What the drives of a vehicle say together, as rows of the store's tables (`pipelines.fleet.tables`)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from pipelines.hierarchy.records import LoadChange, Outlier, Trend, VehicleKnowledge
from pipelines.results import ParameterEstimate

Row = dict[str, object]

CHANGED: Mapping[str, str] = {
    "mass_kg": "mass_change{}_kg",
    "cg_height_m": "cg_height_change{}_m",
    "cg_to_front_axle_m": "cg_to_front_axle_change{}_m",
    "cg_lateral_offset_m": "cg_lateral_change{}_m",
}
"""Parameter -> its columns of load_changes.parquet; {} is "" for the change and "_std" for its standard deviation."""


def _figure(value: float | None) -> float | None:
    """A finite number, or null: a table's null is nothing to say, and infinities are that too."""
    return None if value is None or not math.isfinite(value) else float(value)


def _estimate(estimate: ParameterEstimate) -> Row:
    prior = estimate.prior
    return {
        "parameter": estimate.name,
        "value": _figure(estimate.value),
        "std": _figure(estimate.std),
        "low": _figure(estimate.low),
        "high": _figure(estimate.high),
        "status": estimate.status,
        "reason": estimate.reason,
        "prior": None if prior is None else _figure(prior.value),
        "prior_std": None if prior is None else _figure(prior.std),
    }


def parameter_rows(
    vehicle_id: str,
    drive_id: str,
    start_utc: str | None,
    source: str,
    answers: Mapping[str, ParameterEstimate],
) -> list[Row]:
    """One drive's answers as rows of parameters.parquet. source: "drive" (its own verdict) or "fleet" (all drives joined)."""
    return [
        {
            "drive_id": drive_id,
            "vehicle_id": vehicle_id,
            "start_utc": start_utc,
            "source": source,
            "reference": _figure(estimate.reference),
            **_estimate(estimate),
        }
        for _, estimate in sorted(answers.items())
    ]


def drive_rows(knowledge: VehicleKnowledge, starts: Mapping[str, str | None]) -> list[Row]:
    """Every drive's answers with all drives of its vehicle joined. starts: drive_id -> start_utc, where known."""
    return [
        row
        for drive_id, answers in sorted(knowledge.drives.items())
        for row in parameter_rows(knowledge.vehicle_id, drive_id, starts.get(drive_id), "fleet", answers)
    ]


def vehicle_rows(
    knowledge: VehicleKnowledge, vehicle_name: str | None, doubts: Sequence[str] = ()
) -> list[Row]:
    """What belongs to the vehicle whatever its load: rows of vehicles.parquet. doubts: of the drives that it is from, in words."""
    return [
        {
            "vehicle_id": knowledge.vehicle_id,
            "vehicle_name": vehicle_name,
            "title": found.title,
            "unit": found.unit,
            "single_std": _figure(found.single_std),
            "drives": found.drives,
            "doubts": list(doubts),
            **_estimate(found.estimate),
            "parameter": name,
        }
        for name, found in sorted(knowledge.vehicle.items())
    ]


def _change(vehicle_id: str, change: LoadChange, start_utc: str | None) -> Row:
    row: Row = {
        "vehicle_id": vehicle_id,
        "drive_id": change.drive_id,
        "before": change.before,
        "start_utc": start_utc,
        "detected": change.detected,
        "probability": _figure(change.probability),
        "text": change.text,
    }
    for parameter, column in CHANGED.items():
        size, std = change.changes.get(parameter, (None, None))
        row[column.format("")] = _figure(size)
        row[column.format("_std")] = _figure(std)
    return row


def change_rows(knowledge: VehicleKnowledge, starts: Mapping[str, str | None]) -> list[Row]:
    """Load changes in the order of time: rows of load_changes.parquet."""
    return [
        _change(knowledge.vehicle_id, change, starts.get(change.drive_id))
        for change in knowledge.load_changes
    ]


def _trend(vehicle_id: str, trend: Trend) -> Row:
    return {
        "vehicle_id": vehicle_id,
        "parameter": trend.parameter,
        "title": trend.title,
        "unit": trend.unit,
        "per_year": _figure(trend.per_year),
        "std": _figure(trend.std),
        "low": _figure(trend.low),
        "high": _figure(trend.high),
        "probability": _figure(trend.probability),
        "detected": trend.detected,
        "from_utc": trend.from_utc or None,
        "to_utc": trend.to_utc or None,
        "drives": trend.drives,
        "text": trend.text,
    }


def trend_rows(knowledge: VehicleKnowledge) -> list[Row]:
    """Trends by parameter: rows of trends.parquet."""
    return [
        _trend(knowledge.vehicle_id, trend) for trend in sorted(knowledge.trends, key=lambda t: t.parameter)
    ]


def outlier_rows(outliers: Sequence[Outlier], names: Mapping[str, str | None]) -> list[Row]:
    """Vehicles by rank: rows of outliers.parquet. names: vehicle_id -> vehicle_name, where known."""
    return [
        {
            "rank": outlier.rank,
            "vehicle_id": outlier.vehicle_id,
            "vehicle_name": names.get(outlier.vehicle_id),
            "score": _figure(outlier.score),
            "probability": _figure(outlier.probability),
            "parameter": outlier.parameter,
            "value": _figure(outlier.value),
            "others": _figure(outlier.others),
            "others_std": _figure(outlier.others_std),
            "text": outlier.text,
        }
        for outlier in sorted(outliers, key=lambda o: o.rank)
    ]
