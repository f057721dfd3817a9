"""Which estimators a drive can run, and exactly what each other one lacks."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from pipelines.estimators.base import Estimator
from pipelines.vehicles.vehicle import Vehicle


@dataclass(frozen=True)
class Readiness:
    """Whether an estimator can run; `missing_signals` stop it, `missing_vehicle` widen or stop it. In words."""

    estimator: str
    title: str
    ready: bool
    missing_signals: tuple[str, ...]
    missing_vehicle: tuple[str, ...]


def readiness(estimator: Estimator, signals: Collection[str], vehicle: Vehicle | None) -> Readiness:
    """Compare what an estimator needs with what there is."""

    def words(any_of: tuple[str, ...], why: str) -> str:
        return f"{' or '.join(any_of)} ({why})"

    missing_signals = tuple(
        words(need.any_of, need.why) for need in estimator.signal_needs if not set(need.any_of) & set(signals)
    )
    known = set(vehicle.quantities) if vehicle else set()
    if vehicle is not None and vehicle.suspension_map is not None:
        known.add("suspension_map")
    missing_vehicle = tuple(
        words(need.any_of, need.why) for need in estimator.vehicle_needs if not set(need.any_of) & known
    )
    ready = not missing_signals and not missing_vehicle
    return Readiness(estimator.name, estimator.title, ready, missing_signals, missing_vehicle)
