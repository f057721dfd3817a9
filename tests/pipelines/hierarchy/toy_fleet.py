"""A made-up vehicle's drives, directly as what their relations told: thousands of comparisons in a second."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

import numpy as np

from pipelines.hierarchy.parts import Source, make_parts
from pipelines.hierarchy.posterior import VehiclePosterior, solve
from pipelines.hierarchy.records import DriveTold
from pipelines.joint.kept import KeptRelations
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.results import FloatArray
from tests.pipelines.joint_parts import vehicle

START = datetime(2024, 1, 1, tzinfo=UTC)
BEFORE: dict[str, tuple[float, float]] = {
    "empty_mass": (1900.0, 30.0), "wheelbase": (2.8, 0.005), "track_front": (1.6, 0.005), "track_rear": (1.6, 0.005),
    "empty_h": (0.65, 0.03), "spring_front": (35e3, 5e3), "spring_rear": (38e3, 5e3), "bar_front": (20e3, 5e3),
    "bar_rear": (8e3, 3e3), "bump_front": (1500.0, 400.0), "rebound_front": (2500.0, 700.0),
    "bump_rear": (1500.0, 400.0), "rebound_rear": (2500.0, 700.0), "offset_x": (0.0, 30.0),
    "load": (190.0, 228.0), "load_x": (1.4, 0.98), "load_y": (0.0, 0.26), "load_h": (0.95, 0.42),
}  # fmt: skip
"""Unknown -> mean and standard deviation before the log; offset_x is half the drive's own."""

LOAD = ("load", "load_x", "load_y", "load_h")


@dataclass(frozen=True)
class Drive:
    """What is true in one drive. load: (4,) kg and m; figures: other unknowns where they differ from the vehicle's."""

    load: FloatArray
    figures: Mapping[str, float]


def of_moments(sees: Mapping[str, float], moments: Sequence[float]) -> dict[str, float]:
    """A relation of unknowns and of the load's mass and moments (m, m x, m y, m h): weights by name."""
    return dict(sees) | {f"moment {i}": weight for i, weight in enumerate(moments)}


SCALES = (
    of_moments({"empty_mass": 1.0}, (1.0, 0.0, 0.0, 0.0)),
    of_moments({"empty_mass": 1.2, "offset_x": 1.0}, (0.0, 1.0, 0.0, 0.0)),
    of_moments({"empty_mass": 0.01}, (0.0, 0.0, 1.0, 0.0)),
    of_moments({"empty_mass": 0.65, "empty_h": 1900.0}, (0.0, 0.0, 0.0, 1.0)),
)
"""Relations that see all four figures of the load."""


def kept(
    drive: Drive, truth: Mapping[str, float], relations: Sequence[Mapping[str, float]], noise: FloatArray, *,
    before: Mapping[str, tuple[float, float]] = BEFORE, mode: FloatArray | None = None,
) -> KeptRelations:  # fmt: skip
    """What the drive told: relations of unit noise (divide the weights by their noise). noise: (m,) of N(0, 1).

    before: the unknowns. mode: (4,) load about which the relations are made linear; the true one if None.
    """
    names = list(before)
    values = dict(truth) | dict(drive.figures) | dict(zip(LOAD, drive.load.tolist(), strict=True))
    at = drive.load if mode is None else mode
    around = values | dict(zip(LOAD, at.tolist(), strict=True))
    rows, observed = np.zeros((len(relations), len(names))), np.zeros(len(relations))
    centre = np.array([around[name] for name in names])
    for i, relation in enumerate(relations):
        seen = predicted = 0.0
        for name, weight in relation.items():
            if not name.startswith("moment"):
                rows[i, names.index(name)] += weight
                seen += weight * values[name]
                predicted += weight * around[name]
                continue
            k = int(name.split()[1])
            place = LOAD[k]
            true, near = (drive.load[0] * (drive.load[k] if k else 1), at[0] * (at[k] if k else 1))
            seen, predicted = seen + weight * true, predicted + weight * near
            rows[i, names.index("load")] += weight * (at[k] if k else 1.0)
            if k:
                rows[i, names.index(place)] += weight * at[0]
        observed[i] = seen + noise[i] - predicted + rows[i] @ centre
    mean, std = (np.array([before[name][i] for name in names]) for i in (0, 1))
    return _kept(tuple(names), mean, std, centre, rows, observed)


def _kept(
    names: tuple[str, ...], mean: FloatArray, std: FloatArray, mode: FloatArray, rows: FloatArray, observed: FloatArray
) -> KeptRelations:  # fmt: skip
    count = len(rows)
    titles = tuple(f"relation {i}" for i in range(count))
    return KeptRelations(
        names, mean, std, mode, rows, observed, titles, ("vertical",) * count, ("by hand",) * count, {}, {}, 1.0, True
    )  # fmt: skip


def told(number: int, relations: KeptRelations | None, days: float | None = None) -> DriveTold:
    """A drive for the vehicle's join. days: after the first of 2024, None = no date is known."""
    start = None if days is None else (START + timedelta(days=days)).isoformat()
    return DriveTold(f"d{number:03d}", start, {}, relations)


def posterior(drives: Sequence[DriveTold]) -> VehiclePosterior:
    """All drives joined, with errors that are each relation's own."""
    sources = [Source(d.drive_id, d.kept) for d in drives if d.kept is not None]
    return solve(*make_parts(sources, 0.0))


def weighed(relations: Sequence[Mapping[str, float]], noise: Sequence[float]) -> list[dict[str, float]]:
    """Relations in units of their noise."""
    return [{n: w / std for n, w in r.items()} for r, std in zip(relations, noise, strict=True)]


def drawn(rng: np.random.Generator) -> dict[str, float]:
    """A vehicle from what is known before."""
    return {name: mean + std * float(rng.standard_normal()) for name, (mean, std) in BEFORE.items()}


def whole(relations: KeptRelations) -> KeptRelations:
    """The same relations of a vehicle with all its unknowns: those that they do not see as before the log."""
    known = before_the_log(vehicle())
    rows = np.zeros((len(relations.rows), len(known.names)))
    mean, std, mode = known.mean.copy(), known.std.copy(), known.mean.copy()
    for i, name in enumerate(relations.names):
        at = known.names.index(name)
        rows[:, at] = relations.rows[:, i]
        mean[at], std[at], mode[at] = relations.mean[i], relations.std[i], relations.mode[i]
    return _kept(known.names, mean, std, mode, rows, relations.observed)
