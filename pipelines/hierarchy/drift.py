"""Do parts of a vehicle change with time? Straight lines in time for springs, bars and dampers, with scatter of each drive.

The value of part j in drive d is base_j (1 + b_j t_d + season_d + e_jd): b the slopes, e what a drive scatters (temperature and
speed move the dampers' rates, what the model leaves out moves all), season a yearly wave of dampers, which a trend must not be
mistaken for. The size of e is not known before: it is summed over a grid, weighed by how well it goes with the drives. With
the drives' own nuisance eliminated, columns Y of (shared, slopes, season) and X of e, a drive has
Y'MY - Y'MX (S⁻¹ + X'MX)⁻¹ X'MY, S the covariance of e, so that the cost is linear in the number of drives.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipelines.hierarchy.contrast import by_unknowns, eliminated
from pipelines.hierarchy.posterior import DrivePart, VehiclePosterior
from pipelines.joint.vehicle.outputs import lacked_by_springs
from pipelines.results import FloatArray

AXLES = ("front", "rear")
DAMPERS = tuple(f"{way}_{axle}" for axle in AXLES for way in ("bump", "rebound"))
SPRINGS = tuple(f"{part}_{axle}" for part in ("spring", "bar") for axle in AXLES)

SLOPE = 0.3
"""Standard deviation of a part's slope a year before the drives, of its value."""

TOGETHER = 0.5
"""Share of the variance of slopes, and of scatters, that parts of a kind have in common: age and temperature are the same."""

SEASON = 0.03
"""Standard deviation of the amplitudes (sine, cosine) of the dampers' yearly wave: oil between winter and summer."""

USUAL_SCATTER: Mapping[str, float] = {"dampers": 0.05, "springs": 0.01}
FACTOR = 2.0
"""The scatter of a drive is within this factor of the usual in two cases of three."""

LEAST = 1e-3
"""Information on a slope, of what was known before, below which the drives say nothing of it (it is the difference of two)."""

GRID = np.linspace(-2.5, 2.5, 11)
"""Scatters looked at, in standard deviations of their logarithm."""


@dataclass(frozen=True)
class Slopes:
    """Slopes a year, of the parts' values, for every scatter of the grid. parts: their names, p.

    weight: (g,) of each scatter; mean: (g, p), covariance: (g, p, p) with the prior; prior: (p, p). base: (p,) SI values.
    """

    parts: tuple[str, ...]
    weight: FloatArray
    scatter: FloatArray
    mean: FloatArray
    covariance: FloatArray
    prior: FloatArray
    base: FloatArray


@dataclass(frozen=True)
class _Told:
    """A drive: Y'MX (q, e), X'MX (e, e), X'Mr (e,)."""

    yx: FloatArray
    xx: FloatArray
    xr: FloatArray


@dataclass(frozen=True)
class _All:
    """Sums over the drives, Y'MY (q, q) and Y'Mr (q,), and what each drive has of its scatter."""

    yy: FloatArray
    yr: FloatArray
    drives: tuple[_Told, ...]


def alike(size: int) -> FloatArray:
    """(size, size) correlation of parts of one kind."""
    return np.asarray(TOGETHER + (1 - TOGETHER) * np.eye(size))


def _present(parts: Sequence[DrivePart], names: Sequence[str]) -> tuple[str, ...]:
    """Those of `names` that are unknowns of every drive."""
    return tuple(name for name in names if all(name in part.names for part in parts))


def _narrow(part: DrivePart, names: Sequence[str]) -> FloatArray:
    """(p, p) what one more of each part, SI, takes off each unknown: springs that stand closer together than the wheels stiffen roll by
    where they stand, and what they lack is in the bar's unknown."""
    found = np.zeros((len(names), len(names)))
    values = dict(zip(part.names, part.mean.tolist(), strict=True))
    for axle in AXLES:
        bar, spring = f"bar_{axle}", f"spring_{axle}"
        if bar in names and spring in names:
            track = np.array(values[f"track_{axle}"] ** 2)
            lacked = lacked_by_springs(track, np.array(values.get(f"spring_base_{axle}", 1.0)))
            found[names.index(bar), names.index(spring)] = float(lacked)
    return found


def _base(posterior: VehiclePosterior, rows: Sequence[int], names: Sequence[str]) -> FloatArray:
    """(p,) the parts' values, mean over the drives; at least a fifth of what was known before."""
    first = posterior.parts[rows[0]]
    whole = np.eye(len(names)) + _narrow(first, names)
    at = [[posterior.parts[i].names.index(name) for name in names] for i in rows]
    mean = np.mean([posterior.mean(i)[places] for i, places in zip(rows, at, strict=True)], axis=0)
    return np.asarray(np.maximum(whole @ mean, 0.2 * (whole @ first.mean[at[0]])))


def _columns(part: DrivePart, names: Sequence[str], base: FloatArray) -> FloatArray:
    """(m, p) by the parts' relative deviations: both what is shared of an unknown and what is the drive's own."""
    rows = [part.names.index(name) for name in names]
    moved = np.eye(len(names)) - _narrow(part, names)
    return np.asarray((by_unknowns(part, rows) / part.std[rows]) @ (moved * base))


def _collected(
    posterior: VehiclePosterior,
    rows: Sequence[int],
    years: FloatArray,
    names: Sequence[str],
    base: FloatArray,
) -> _All:
    """All drives with their own nuisance eliminated, but for the parts' scatter."""
    wave = np.array([name in DAMPERS for name in names], dtype=np.float64)
    size = len(posterior.names) + len(names) + 2
    yy, yr, told = np.zeros((size, size)), np.zeros(size), []
    for i, year in zip(rows, years.tolist(), strict=True):
        part = posterior.parts[i]
        x = _columns(part, names, base)
        nuisance = part.f.copy()
        nuisance[:, [part.names.index(name) for name in names]] = 0.0
        season = SEASON * (x @ wave)[:, None] * [math.cos(2 * math.pi * year), math.sin(2 * math.pi * year)]
        columns = np.column_stack([part.a, x * year, season, x])
        information, vector = eliminated(columns, nuisance, part.residual)
        yy += information[:size, :size]
        yr += vector[:size]
        told.append(_Told(information[:size, size:], information[size:, size:], vector[size:]))
    return _All(yy, yr, tuple(told))


def _solved(every: _All, before: FloatArray, scatter: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Mean and covariance of (shared, slopes, season) for a scatter covariance (e, e), and its log likelihood.

    before: (q, q) precision before the drives.
    """
    precision, right, logarithm = before + every.yy, every.yr.copy(), 0.0
    inverse = np.linalg.inv(scatter)
    for drive in every.drives:
        inner = inverse + drive.xx
        gain = np.linalg.solve(inner, np.column_stack([drive.yx.T, drive.xr]))
        precision -= drive.yx @ gain[:, :-1]
        right -= drive.yx @ gain[:, -1]
        logarithm += 0.5 * float(drive.xr @ gain[:, -1]) - 0.5 * float(np.linalg.slogdet(scatter @ inner)[1])
    precision = 0.5 * (precision + precision.T)
    covariance = np.asarray(np.linalg.inv(precision))
    mean = covariance @ right
    logarithm += 0.5 * float(right @ mean) - 0.5 * float(np.linalg.slogdet(precision)[1])
    return mean, covariance, logarithm


def _blocks(names: Sequence[str], dampers: float, springs: float) -> FloatArray:
    """(p, p) covariance of parts of both kinds with these standard deviations."""
    kind = np.array([name in DAMPERS for name in names])
    std = np.where(kind, dampers, springs)
    correlation = np.where(kind[:, None] == kind, alike(len(names)), 0.0)
    return np.asarray(correlation * np.outer(std, std))


def slopes_of(posterior: VehiclePosterior, rows: Sequence[int], years: FloatArray) -> dict[str, Slopes]:
    """Slopes of all parts, once with the scatter of the dampers and once with that of the springs found from the drives.

    rows: of the posterior's drives; years: (n,) their times, centred, so that the parts' values are those of the middle.
    A kind whose parts are no unknowns of these drives is not in what is given back.
    """
    names = _present([posterior.parts[i] for i in rows], (*DAMPERS, *SPRINGS))
    kinds = {"dampers": DAMPERS, "springs": SPRINGS}
    found = [kind for kind, members in kinds.items() if set(members) & set(names)]
    if not found:
        return {}
    base = _base(posterior, rows, names)
    every = _collected(posterior, rows, years, names, base)
    return {kind: _of_kind(every, names, base, len(posterior.names), kind) for kind in found}


def _of_kind(every: _All, names: Sequence[str], base: FloatArray, shared: int, kind: str) -> Slopes:
    """With the scatter of one kind of parts on the grid, that of the other as usual."""
    p = len(names)
    prior = _blocks(names, SLOPE, SLOPE)
    before = np.eye(shared + p + 2)
    before[shared : shared + p, shared : shared + p] = np.linalg.inv(prior)
    logs, means, covariances, scatters = [], [], [], []
    for step in GRID.tolist():
        sizes = dict(USUAL_SCATTER)
        sizes[kind] *= FACTOR**step
        mean, covariance, log = _solved(every, before, _blocks(names, **sizes))
        logs.append(log - 0.5 * step**2)
        means.append(mean[shared : shared + p])
        covariances.append(covariance[shared : shared + p, shared : shared + p])
        scatters.append(sizes[kind])
    weight = np.exp(np.array(logs) - max(logs))
    return Slopes(
        tuple(names), weight / weight.sum(), np.array(scatters), np.array(means), np.array(covariances), prior, base
    )  # fmt: skip


@dataclass(frozen=True)
class Line:
    """One slope a year, of a weighted sum of parts, by the drives alone. probability: of one as far from 0 by chance."""

    slope: float
    std: float
    low: float
    high: float
    probability: float


def line_of(slopes: Slopes, weights: FloatArray) -> Line | None:
    """The slope of weights (p,) @ parts, its prior divided out; None where the drives say nothing of it.

    The law is a mixture over the scatters, whose tails are wider than a normal one's where drives are few.
    """
    from scipy.optimize import brentq
    from scipy.special import ndtr

    mean, variance = slopes.mean @ weights, np.einsum("i,gij,j->g", weights, slopes.covariance, weights)
    before = float(weights @ slopes.prior @ weights)
    information = 1 / variance - 1 / before
    if not bool(np.all(information * before > LEAST)):
        return None
    centre, std, weight = mean / variance / information, information**-0.5, slopes.weight
    slope = float(weight @ centre)
    spread = math.sqrt(float(weight @ (std**2 + (centre - slope) ** 2)))
    probability = float(weight @ (2 * ndtr(-np.abs(centre) / std)))
    reach = 12 * float(std.max()) + float(np.ptp(centre))

    def beyond(at: float, share: float) -> float:
        return float(weight @ ndtr((at - centre) / std)) - share

    low, high = (
        float(brentq(beyond, slope - reach, slope + reach, args=(share,))) for share in (0.025, 0.975)
    )
    return Line(slope, spread, low, high, probability)
