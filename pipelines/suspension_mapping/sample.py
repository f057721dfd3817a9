"""Training drives as rows: each wheel's regressors and what its measuring wheel read, over all drives."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from parsers.drive import Drive
from parsers.errors import LogError
from pipelines.models.suspension_map import ACROSS, FRONT
from pipelines.results import FloatArray
from pipelines.suspension_mapping.data import (
    BAND_HZ,
    DEFLECTIONS,
    MEASURED,
    STRUTS,
    MapData,
    collect,
    prepare_map,
)
from pipelines.suspension_mapping.fit import Known, fit, prior_of
from pipelines.suspension_mapping.manoeuvres import Manoeuvres, split
from pipelines.suspension_mapping.record import TrainingDrive
from pipelines.suspension_mapping.regressors import (
    Shape,
    Springs,
    carried_by_springs,
    carried_by_struts,
    wheel_columns,
)
from pipelines.suspension_mapping.spread import state_of
from pipelines.vehicles.vehicle import Vehicle

SHORTEST_S = 30.0


@dataclass(frozen=True)
class Training:
    """Rows of one training drive with its manoeuvres."""

    drive: TrainingDrive
    data: MapData
    manoeuvres: Manoeuvres


@dataclass(frozen=True)
class Sample:
    """All drives' rows of one wheel. columns: regressor -> (n,); measured (n,) N; state (n, 5); drive (n,): its number."""

    columns: Mapping[str, FloatArray]
    measured: FloatArray
    state: FloatArray
    starts: FloatArray
    time_s: FloatArray
    fold: np.ndarray
    kind: np.ndarray
    drive: np.ndarray
    rate_hz: float


def _left_out(drive: Drive, names: Collection[str]) -> str | None:
    """Why the first of these signals is not there though the log has it."""
    said = (
        each
        for each in drive.record.decisions
        if each.applied and each.signal in names and each.signal not in drive.signals
    )
    return next((f"{each.found}; {each.action}" for each in said), None)


def training_drive(drive: Drive, name: str, band_hz: float = BAND_HZ) -> Training:
    """Bring a drive into rows. Raises LogError where it lacks what training needs, and says what."""
    missing = [n for n in MEASURED if n not in drive.signals]
    if missing:
        raise LogError(
            f"cannot train a suspension map: no {', '.join(missing)}",
            path=name,
            hint=_left_out(drive, missing)
            or "training needs the normal forces of all four wheels, by wheel-force transducers",
        )
    if not any(all(n in drive.signals for n in names) for names in (STRUTS, DEFLECTIONS)):
        raise LogError(
            "cannot train a suspension map: neither suspension forces nor deflections of all four wheels",
            path=name,
            hint=_left_out(drive, STRUTS)
            or "map suspension_force_fl … or suspension_deflection_fl … in a mapping file (--map)",
        )
    data = collect(prepare_map(drive, band_hz), need_measured=True)
    if data.size < SHORTEST_S * data.rate_hz:
        raise LogError(
            f"cannot train a suspension map: {data.size / data.rate_hz:.0f} s of all signals together, "
            f"expected {SHORTEST_S:.0f} s or more",
            path=name,
            hint="; ".join(data.notes[:2]) or None,
        )
    record = TrainingDrive(name, drive.record.sha256, drive.record.duration_s)
    return Training(record, data, split(data))


def known_of(vehicle: Vehicle, wheel: str) -> Known:
    """What the vehicle file tells of a wheel."""
    axle = "front" if FRONT[wheel] else "rear"
    mass, rate = vehicle.get(f"unsprung_mass_{axle}_kg"), vehicle.get(f"spring_rate_{axle}_npm")
    return Known(
        None if mass is None else (mass.value / 2, max(mass.std / 2, 0.05 * mass.value / 2)),
        None if rate is None else (rate.value, max(rate.std, 0.03 * rate.value)),
    )


def spring_law(drives: Sequence[Training], wheel: str, known: Known) -> Springs:
    """The static law of a wheel's spring, from rows in which the deflection hardly moves and from all others."""
    own = np.concatenate([t.data.columns[f"suspension_deflection_{wheel}"] for t in drives])
    other = np.concatenate([t.data.columns[f"suspension_deflection_{ACROSS[wheel]}"] for t in drives])
    force = np.concatenate([t.data.columns[f"tire_normal_force_{wheel}"] for t in drives])
    starts = np.concatenate([t.data.starts for t in drives])
    names = ("one", "deflection", "stiffening", "bar")
    prior = prior_of(names, float(np.mean(force)), known, springs=True)
    matrix = np.column_stack((np.ones(len(own)), own, own**3, own - other))
    found = fit(matrix, force, prior, starts, drives[0].data.rate_hz)
    return Springs(*(float(x) for x in found.coefficients))


def sample_of(
    drives: Sequence[Training], wheel: str, kind: str, laws: Mapping[str, Springs], shape: Shape
) -> Sample:
    """All drives' rows for one wheel, one below the other, in the columns that every drive has.

    kind: "struts" (measured suspension forces) or "springs" (deflections with `laws`). Forces in N.
    """
    columns: list[dict[str, FloatArray]] = []
    for training in drives:
        data = training.data
        carried = carried_by_struts(data) if kind == "struts" else carried_by_springs(data, laws)
        columns.append(wheel_columns(data, wheel, carried, shape))
    common = [name for name in columns[0] if all(name in found for found in columns)]
    datas, parts = [t.data for t in drives], [t.manoeuvres for t in drives]
    return Sample(
        {name: np.concatenate([found[name] for found in columns]) for name in common},
        np.concatenate([d.columns[f"tire_normal_force_{wheel}"] for d in datas]),
        np.concatenate([state_of(d, wheel) for d in datas]),
        np.concatenate([d.starts for d in datas]),
        np.concatenate([d.time_s for d in datas]),
        np.concatenate([m.fold for m in parts]),
        np.concatenate([m.kind for m in parts]),
        np.repeat(np.arange(len(datas)), [d.size for d in datas]),
        datas[0].rate_hz,
    )


def thinned(sample: Sample, every: int) -> Sample:
    """Every so many rows: enough to compare shapes, as neighbouring rows say the same."""
    return replace(
        sample,
        columns={name: column[::every] for name, column in sample.columns.items()},
        measured=sample.measured[::every],
        state=sample.state[::every],
        starts=np.maximum.reduceat(sample.starts, np.arange(0, len(sample.starts), every)),
        time_s=sample.time_s[::every],
        fold=sample.fold[::every],
        kind=sample.kind[::every],
        drive=sample.drive[::every],
        rate_hz=sample.rate_hz / every,
    )
