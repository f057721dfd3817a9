"""What the report shows of the balances: fits with residuals, and the estimates as the drive went on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipelines.estimators.load_balance.answers import outputs_of
from pipelines.estimators.load_balance.data import Columns
from pipelines.estimators.load_balance.relations import IntArray
from pipelines.estimators.load_balance.solve import Fit, jacobian
from pipelines.results import FloatArray, Trace, Track

TRACK_POINTS = 40
TRACKED = ("mass_kg", "cg_height_m", "cg_to_front_axle_m", "cg_lateral_offset_m")


def _running(
    fit: Fit, slopes: Sequence[tuple[FloatArray, FloatArray]], share: float
) -> tuple[FloatArray, FloatArray]:
    """The unknowns and their covariance from the first `share` of each balance's blocks: one step from the final fit.

    slopes: of each balance, its coefficients and their derivative at the final fit.
    """
    curvature, gradient = np.eye(len(fit.u)), fit.u.copy()
    for reduced, (theta, slope) in zip(fit.reduced, slopes, strict=True):
        count = round(share * len(reduced.blocks))
        if count < 1:
            continue
        part = reduced.blocks[:count].sum(axis=0)
        inverse = np.linalg.inv(reduced.covariance * (count / len(reduced.blocks)))
        j = part @ slope
        curvature += j.T @ inverse @ j
        gradient += j.T @ (inverse @ (part @ theta))
    inner = np.linalg.inv(curvature)
    return np.asarray(fit.u - inner @ gradient), np.asarray(inner * fit.inflation**2)


def tracks(fit: Fit, data: Columns) -> tuple[Track, ...]:
    """Mass, place and height over the drive."""
    final, slope = outputs_of(fit.known, fit.u, data.sag)
    shares = np.linspace(0, 1, TRACK_POINTS + 1)[1:]
    slopes = [jacobian(r.relation, fit.known, fit.u) for r in fit.reduced]
    steps = [_running(fit, slopes, float(s)) for s in shares]
    at = data.time_s[np.minimum((shares * (len(data.time_s) - 1)).astype(int), len(data.time_s) - 1)]
    found = []
    for name in TRACKED:
        g = slope[name]
        value = np.array([final[name] + g @ (u - fit.u) for u, _ in steps])
        half = np.array([1.96 * np.sqrt(g @ c @ g) for _, c in steps])
        found.append(Track(name, at, value, value - half, value + half))
    return tuple(found)


def traces(fit: Fit, data: Columns) -> tuple[Trace, ...]:
    """For each balance: what the suspension (or the torques) says, what the accelerations ask for, and the rest."""
    found = []
    for reduced in fit.reduced:
        relation = reduced.relation
        theta = relation.vector(fit.values())
        forces = np.array(
            [name.rsplit("_", 1)[-1] in _ENDS or name in ("brake", "drive") for name in relation.columns]
        )
        seen = relation.table[:, forces] @ theta[forces]
        asked = -relation.table[:, ~forces] @ theta[~forces]
        middle = float(np.median(asked))
        columns = {"measured": seen - middle, "model": asked - middle, "residual": seen - asked}
        columns = {name: _with_gaps(column, relation.rows) for name, column in columns.items()}
        unit = "N" if relation.name.startswith("vertical") else "N·m"
        at = _with_gaps(data.time_s[relation.rows], relation.rows, fill=True)
        found.append(
            Trace(
                relation.title,
                at,
                columns,
                dict.fromkeys(columns, unit),
                "low-passed; about the middle value",
            )
        )
    return tuple(found)


_ENDS = ("fl", "fr", "rl", "rr", "front", "rear")


def _with_gaps(column: FloatArray, rows: IntArray, *, fill: bool = False) -> FloatArray:
    """The column with the last value before a jump of rows blanked, so that a line breaks there."""
    out = np.array(column, dtype=np.float64)
    if not fill:
        out[:-1][np.diff(rows) > 1] = np.nan
    return out
