"""From the drives' kept relations to what the solver takes: shared and own unknowns, the common error, rows counted once."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.hierarchy.common import common_directions, shared_error
from pipelines.hierarchy.posterior import DrivePart, Extra
from pipelines.hierarchy.relinear import at_place
from pipelines.hierarchy.shared import HEIGHT, LOADED, SENSORS, belongs, own_shares
from pipelines.joint.kept import KeptRelations
from pipelines.joint.posterior import whitener_of
from pipelines.results import FloatArray

FILE = "vehicle file"


@dataclass(frozen=True)
class Source:
    """One drive as it goes into the model. factor: on its relations' standard deviations (misfit, a contradiction).

    place: (k,) where its relations are linear; None = its own mode. other_sensors: whether it is taken as recorded by other
    sensors than the vehicle's other drives, which then say nothing of its own ones' errors.
    """

    drive_id: str
    kept: KeptRelations
    factor: float = 1.0
    place: FloatArray | None = None
    other_sensors: bool = False


@dataclass(frozen=True)
class Before:
    """A drive's unknowns before the log. mean, std: (k,), with what the vehicle's drives agree on; own: (k,) share f."""

    names: tuple[str, ...]
    mean: FloatArray
    std: FloatArray
    own: FloatArray


def agreed(drives: Sequence[KeptRelations]) -> Mapping[str, tuple[float, float]]:
    """What the drives knew before their logs: unknown -> mean and standard deviation.

    It is what most of them knew alike. Where their files differ and neither has most drives, one of them is wrong, and nothing tells
    which: mean and spread of all.
    """
    said: dict[str, Counter[tuple[float, float]]] = {}
    for kept in drives:
        for name, mean, std in zip(kept.names, kept.mean.tolist(), kept.std.tolist(), strict=True):
            said.setdefault(name, Counter())[(mean, std)] += 1
    return {name: _of_all(count) for name, count in said.items()}


def _of_all(count: Counter[tuple[float, float]]) -> tuple[float, float]:
    """What most say; mean and spread of a draw from all that is said, where nothing is said by most."""
    pair, times = count.most_common(1)[0]
    if 2 * times > count.total():
        return pair
    means, stds, weights = (
        np.array([*(mean for mean, _ in count)]), np.array([*(std for _, std in count)]), np.array([*count.values()]),
    )  # fmt: skip
    share = weights / weights.sum()
    middle = float(share @ means)
    return middle, float(np.sqrt(share @ (stds**2 + (means - middle) ** 2)))


def before(source: Source, same: Mapping[str, tuple[float, float]]) -> Before:
    """One drive's unknowns. What it shares with others it knows as they do: its vehicle file may be another one.

    A load that is stated for this drive is this drive's alone.
    """
    kept = source.kept
    own = own_shares(kept.names, kept.mean, kept.std)
    if source.other_sensors:
        own[[belongs(name) in SENSORS for name in kept.names]] = 1.0
    mean, std = kept.mean.copy(), kept.std.copy()
    for row, name in enumerate(kept.names):
        if belongs(name) in (LOADED, HEIGHT):
            if same.get(name) != (mean[row], std[row]):
                own[row] = 1.0
        elif own[row] < 1 and name in same:
            mean[row], std[row] = same[name]
    return Before(kept.names, mean, std, own)


@dataclass(frozen=True)
class _Relation:
    """One relation of one drive, whitened, by the shared list of all unknowns (m, n) in standard deviations."""

    key: str
    slope: FloatArray
    residual: FloatArray


def _relations(source: Source, known: Before, column: Mapping[str, int], width: int) -> list[_Relation]:
    kept = source.kept
    rows, observed = kept.rows, kept.observed
    if source.place is not None:
        rows, observed = at_place(kept.names, rows, observed, kept.mode, source.place)
    residual = observed - rows @ known.mean
    slope = np.zeros((len(rows), width))
    slope[:, [column[name] for name in kept.names]] = rows * known.std
    found = []
    labels = [f"{r} ({s})" for r, s in zip(kept.relation, kept.source, strict=True)]
    for key in dict.fromkeys(labels):
        at = np.flatnonzero(np.array([label == key for label in labels]))
        # what the file states is no measurement of the drive's
        stated = kept.source[int(at[0])] == FILE
        wide = 1.0 if stated else source.factor * kept.widened.get(kept.relation[int(at[0])], 1.0)
        found.append(_Relation(f"{FILE}: {key}" if stated else key, slope[at] / wide, residual[at] / wide))
    return found


@dataclass(frozen=True)
class Layout:
    """The shared unknowns: those of the vehicle, the common errors' directions, extras. directions: relation -> (k, q)."""

    names: tuple[str, ...]
    directions: Mapping[str, FloatArray]
    rho: float


def make_parts(
    sources: Sequence[Source], rho: float, extras: Sequence[Extra] = ()
) -> tuple[tuple[DrivePart, ...], tuple[str, ...]]:
    """Every drive's part, and the names of the shared unknowns. sources: in order of time."""
    same = agreed([s.kept for s in sources])
    known = [before(s, same) for s in sources]
    every = tuple(dict.fromkeys(name for b in known for name in b.names))
    column = {name: i for i, name in enumerate(every)}
    told = [_relations(s, b, column, len(every)) for s, b in zip(sources, known, strict=True)]
    by_relation: dict[str, list[FloatArray]] = {}
    for relations in told:
        for r in relations:
            if not r.key.startswith(FILE):
                by_relation.setdefault(r.key, []).append(r.slope)
    directions = {key: common_directions(slopes, rho) for key, slopes in by_relation.items()} if rho else {}
    vehicle = tuple(dict.fromkeys(n for b in known for n, f in zip(b.names, b.own, strict=True) if f < 1))
    common = tuple(f"{key} #{i}" for key, root in directions.items() for i in range(root.shape[1]))
    layout = Layout((*vehicle, *common, *(e.name for e in extras)), directions, rho)
    counted: set[str] = set()
    parts = []
    for source, b, relations in zip(sources, known, told, strict=True):
        fresh = [r for r in relations if r.key not in counted]
        counted |= {r.key for r in fresh if r.key.startswith(FILE)}
        parts.append(_part(source, b, fresh, column, layout, extras))
    return tuple(parts), layout.names


def _part(
    source: Source,
    b: Before,
    relations: Sequence[_Relation],
    column: Mapping[str, int],
    layout: Layout,
    extras: Sequence[Extra],
) -> DrivePart:
    """One drive by the shared unknowns and its own, its errors' common share taken out of its own."""
    place = {name: i for i, name in enumerate(layout.names)}
    size, width = len(b.names), len(layout.names)
    shared = np.zeros((size, width))
    for row, (name, f) in enumerate(zip(b.names, b.own, strict=True)):
        if f < 1:
            shared[row, place[name]] = np.sqrt(1 - f)
    for extra in extras:
        for name, move in extra.moves.get(source.drive_id, {}).items():
            if name in b.names:
                row = b.names.index(name)
                shared[row, place[extra.name]] += extra.std * move / b.std[row]
    own = np.sqrt(b.own)
    mine = [column[name] for name in b.names]
    a, f_rows, residual = [np.zeros((0, width))], [np.zeros((0, size))], [np.zeros(0)]
    for r in relations:
        slope = r.slope[:, mine]
        by_shared = slope @ shared
        whitener = np.eye(len(slope))
        root = layout.directions.get(r.key)
        if root is not None and root.shape[1] > 0:
            error, left = shared_error(r.slope, root, layout.rho)
            first = place[f"{r.key} #0"]
            by_shared[:, first : first + root.shape[1]] += error
            whitener = whitener_of(left)
        a.append(whitener @ by_shared)
        f_rows.append(whitener @ (slope * own))
        residual.append(whitener @ r.residual)
    return DrivePart(
        source.drive_id, b.names, b.mean, b.std, shared, own,
        np.concatenate(a), np.concatenate(f_rows), np.concatenate(residual), source.kept.given,
        source.kept.mode if source.place is None else source.place,
    )  # fmt: skip
