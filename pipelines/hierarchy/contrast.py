"""Was the load the same in two drives? The likelihood of the difference of their loads, without what is usual for loads.

A load is its mass and its first moments, M = (m, m x, m y, m h): the relations are nearly linear in these. With M_a = c - d / 2
and M_b = c + d / 2, c as loads usually are and nothing assumed of d, all else eliminated (what the drives share by the
posterior of all other drives, each drive's own nuisance by its prior), the difference has the likelihood
exp(-d' I d / 2 + v' d). Along the directions of d in which I sees ordinary differences of loads, chi² = v' I⁺ v.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from pipelines.hierarchy.posterior import DrivePart
from pipelines.joint.vehicle.body import empty_corner
from pipelines.joint.vehicle.unknowns import AXLES
from pipelines.results import FloatArray

LOADS = ("load", "load_x", "load_y", "load_h")

SEEN = 4.0
"""Information of a direction, in ordinary differences of loads, from which on it counts: a difference is known to half of
what is ordinary. It is a matter of the drives' relations and not of what they read, so that it leaves chi² as it is."""

ORDINARY = {"load": 0.12, "load_x": 0.35, "load_y": 0.16, "load_h": 0.65}
"""Loads are at least as unlike as this, whatever the vehicle file says of them: of what is in `SCALED_BY`."""

SCALED_BY = {"load": "empty_mass", "load_x": "wheelbase", "load_y": "track_front", "load_h": "empty_h"}

DRIFTS = 0.1
"""Share of the variance of a sensor's scale that is at least each drive's own: what is taken as fixed would cancel, and every
drift of a torque's or a force's scale would be a change of the load."""

BROKEN = 0.25
"""Share of its rate by which a spring may have changed: one that broke, or another kind."""

EMPTY = frozenset(("empty_mass", "empty_x", "wheelbase", "unsprung_front", "unsprung_rear"))

LIGHT_KG = 15.0
"""A load lighter than this at the mode is taken as this: the slopes by its place vanish with it."""


@dataclass(frozen=True)
class Contrast:
    """Two loads compared. chi2 of `figures` directions that are seen, and its probability if the load was the same.

    figures 0: the drives do not see loads. information: (4, 4) of d along those directions, SI; difference: (4,) most likely
    d (0 along what is not seen).
    """

    chi2: float
    figures: int
    probability: float
    information: FloatArray
    difference: FloatArray


@dataclass(frozen=True)
class Share:
    """A drive with its load set free: information (K + 4, K + 4) and vector (K + 4,) of (shared, moments less `at`).

    shared: (K, K) what the drive adds to the shared precision with its load as before the log, and pull (K,). at: (4,)
    moments about which the relations are linear; usual, spread: (4,), (4, 4) those of loads before the log.
    """

    information: FloatArray
    vector: FloatArray
    shared: FloatArray
    pull: FloatArray
    at: FloatArray
    usual: FloatArray
    spread: FloatArray


def moments(load: FloatArray) -> FloatArray:
    """(4,) m, m x, m y, m h of a load (m, x, y, h)."""
    return np.asarray(np.concatenate([load[:1], load[0] * load[1:]]))


def _slopes(load: FloatArray) -> FloatArray:
    """(4, 4) derivatives of the moments by mass and place."""
    found = np.diag([1.0, load[0], load[0], load[0]])
    found[1:, 0] = load[1:]
    return found


def _usual(mean: FloatArray, std: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean and covariance of the moments of a load of independent mass and place, products exactly."""
    slopes = _slopes(mean)
    covariance = slopes @ np.diag(std**2) @ slopes.T
    covariance[1:, 1:] += np.diag((std[0] * std[1:]) ** 2)
    return moments(mean), covariance


def eliminated(
    columns: FloatArray, nuisance: FloatArray, residual: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Information and vector of the columns' unknowns, those of `nuisance` (N(0, I)) eliminated."""
    inner = np.eye(nuisance.shape[1]) + nuisance.T @ nuisance
    both = np.column_stack([columns, residual])
    seen = nuisance.T @ both
    found = both.T @ both - seen.T @ np.linalg.solve(inner, seen)
    return found[:-1, :-1], found[:-1, -1]


def by_unknowns(part: DrivePart, rows: Sequence[int]) -> FloatArray:
    """(m, r) slopes of a drive's relations by its unknowns u = C s + D e themselves, in their standard deviations."""
    return np.asarray(part.a @ part.shared[rows].T + part.f[:, rows] * part.own[rows])


def _drifts(part: DrivePart) -> FloatArray:
    """(m, r) what the scales drift more than the model of the drives has it."""
    rows = [i for i, name in enumerate(part.names) if "scale" in name.split("_")]
    more = np.maximum(DRIFTS - part.own[rows] ** 2, 0.0)
    return by_unknowns(part, rows) * np.sqrt(more)


def _other_springs(part: DrivePart) -> FloatArray:
    """(m, r) of each axle's springs with another rate and the same length: what they carry of the empty vehicle goes along, and with it
    where its body stands, which deflections show as a zero."""
    values = dict(zip(part.names, part.mean.tolist(), strict=True))
    found = [np.zeros((len(part.residual), 0))]
    for axle in AXLES:
        moves = {f"spring_{axle}": values.get(f"spring_{axle}", 0.0)}
        if values.keys() >= EMPTY:
            moves |= dict.fromkeys((f"zero_{axle[0]}l", f"zero_{axle[0]}r"), empty_corner(values, axle))
        rows = [part.names.index(name) for name in moves if name in part.names]
        sizes = np.array([moves[part.names[i]] for i in rows]) / part.std[rows]
        found.append((by_unknowns(part, rows) @ sizes)[:, None])
    return np.hstack(found)


def _other_sensors(part: DrivePart) -> FloatArray:
    """(m, r) of deflection sensors that are not those of the vehicle's other drives."""
    rows = [
        i
        for i, name in enumerate(part.names)
        if name.rsplit("_", 1)[0] in ("zero", "scale") and part.own[i] < 1
    ]
    return np.asarray(by_unknowns(part, rows) * np.sqrt(1 - part.own[rows] ** 2))


def share_of(part: DrivePart, place: FloatArray, *, replaced: bool = False) -> Share | None:
    """None where the drive has no load of its own. place: (k,) unknowns about which its relations are linear, SI.

    replaced: with springs and deflection sensors that may be others than the vehicle's.
    """
    if not set(LOADS) <= set(part.names):
        return None
    rows = [part.names.index(name) for name in LOADS]
    light = math.copysign(LIGHT_KG, place[rows[0]])
    load = place[rows].copy()
    load[0] = load[0] if abs(load[0]) > LIGHT_KG else light
    by_u = by_unknowns(part, rows)
    by_moments = by_u / part.std[rows] @ np.linalg.inv(_slopes(load))
    nuisance = np.column_stack([part.f, _drifts(part)])
    nuisance[:, rows] = 0.0
    if replaced:
        nuisance = np.column_stack([nuisance, BROKEN * _other_springs(part), _other_sensors(part)])
    # the relations' residual is of the unknowns before the log; with the loads free it is taken at the mode
    away = by_u @ ((load - part.mean[rows]) / part.std[rows])
    # nor does the load that the vehicle usually has say anything of these two
    others = part.a - by_u @ part.shared[rows]
    free, vector = eliminated(np.column_stack([others, by_moments]), nuisance, part.residual - away)
    shared, pull = eliminated(part.a, part.f, part.residual)
    least = [
        ORDINARY[n] * part.mean[part.names.index(by)] if (by := SCALED_BY[n]) in part.names else 0.0
        for n in LOADS
    ]
    usual, spread = _usual(part.mean[rows], np.maximum(part.std[rows], least))
    return Share(free, vector, shared, pull, moments(load), usual, spread)


def _joined(a: Share, b: Share, precision: FloatArray, right: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Information (8, 8) and vector of (c - a.at, d) with the shared unknowns eliminated, nothing said of either."""
    size = len(right)
    by_c = np.hstack([np.eye(4), -0.5 * np.eye(4)])
    by_d = np.hstack([np.eye(4), 0.5 * np.eye(4)])
    h = np.zeros((size + 8, size + 8))
    h[:size, :size] = precision - a.shared - b.shared
    v = np.concatenate([right - a.pull - b.pull, np.zeros(8)])
    for drive, by in ((a, by_c), (b, by_d)):
        info, seen = drive.information, drive.information[:, size:]
        # moments less the drive's own point: c less that of a, and the rest goes over to the vector
        vector = drive.vector - seen @ (a.at - drive.at)
        cross = seen[:size] @ by
        h[:size, :size] += info[:size, :size]
        h[:size, size:] += cross
        h[size:, :size] += cross.T
        h[size:, size:] += by.T @ seen[size:] @ by
        v[:size] += vector[:size]
        v[size:] += by.T @ vector[size:]
    gain = np.linalg.solve(h[:size, :size], np.column_stack([h[:size, size:], v[:size]]))
    return h[size:, size:] - h[size:, :size] @ gain[:, :-1], v[size:] - h[size:, :size] @ gain[:, -1]


def compared(a: Share, b: Share, precision: FloatArray, right: FloatArray) -> Contrast:
    """The loads of two drives. precision (K, K), right (K,): of the shared unknowns, by all drives (these two in it)."""
    from scipy.stats import chi2 as law

    h, v = _joined(a, b, precision, right)
    usual = np.linalg.inv(a.spread)
    common = np.linalg.solve(
        h[:4, :4] + usual, np.column_stack([h[:4, 4:], v[:4] + usual @ (a.usual - a.at)])
    )
    information = h[4:, 4:] - h[4:, :4] @ common[:, :-1]
    vector = v[4:] - h[4:, :4] @ common[:, -1]
    root = np.linalg.cholesky(a.spread + b.spread)
    seen, turned = np.linalg.eigh(root.T @ (0.5 * (information + information.T)) @ root)
    kept = seen > SEEN
    along = turned[:, kept].T @ root.T @ vector
    misfit = float(np.sum(along**2 / seen[kept]))
    figures = int(kept.sum())
    back = np.linalg.solve(root.T, turned[:, kept])
    return Contrast(
        misfit, figures, float(law.sf(misfit, figures)) if figures else 1.0,
        (back * seen[kept]) @ back.T, root @ (turned[:, kept] @ (along / seen[kept])),
    )  # fmt: skip


@cache
def _half(figures: int, chance: float) -> float:
    """Noncentrality with which chi² of these figures passes its limit in half the cases."""
    from scipy.optimize import brentq
    from scipy.stats import chi2, ncx2

    limit = float(chi2.isf(chance, figures))
    return float(brentq(lambda more: float(ncx2.sf(limit, figures, more)) - 0.5, 1e-6, 10 * limit + 10))


def half_seen(contrast: Contrast, direction: Sequence[float], chance: float) -> float:
    """Size of a change along `direction` (4,) of the moments that is found in half the cases; inf where it is not seen."""
    along = np.asarray(direction)
    strength = float(along @ contrast.information @ along)
    if contrast.figures == 0 or strength <= 0:
        return math.inf
    return math.sqrt(_half(contrast.figures, chance) / strength)
