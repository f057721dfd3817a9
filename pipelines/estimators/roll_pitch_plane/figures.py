"""Traces, tracks, assumptions and diagnostics of the plane balances for the report."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pipelines.estimators.roll_pitch_plane.data import Planes
from pipelines.estimators.roll_pitch_plane.fit import LinearFit
from pipelines.prepare.prepared import Prepared
from pipelines.results import Assumption, ParameterEstimate, Trace, Track

TRACK_POINTS = 12
"""Refits that make a track."""


def traces(planes: Planes, fit: LinearFit, moment: str, plane: str) -> tuple[Trace, ...]:
    """The struts' moment, what the balance asks for, and the rest."""
    measured = planes.columns[moment]
    columns = {"struts": measured, "balance": measured - fit.residual, "residual": fit.residual}
    note = f"{plane} moment of the struts about the middle, and what motion and weight ask for"
    return (Trace(f"{plane} moment", planes.time_s, columns, dict.fromkeys(columns, "N·m"), note),)


def assumptions(
    prepared: Prepared, planes: Planes, drawn: Sequence[Assumption], acceleration: str
) -> tuple[Assumption, ...]:
    """What was taken as given."""
    found = [
        *drawn,
        Assumption("angular acceleration", planes.how[acceleration], "log"),
        Assumption("suspension_force", "all that the strut, spring, bar and friction do to the body", "the signal's meaning"),
        Assumption("filter", f"zero-phase low-pass at {prepared.cutoff_hz:.3g} Hz, all signals alike", "settings"),
    ]  # fmt: skip
    if planes.missing:
        words = f"not in the log, taken as zero: {', '.join(sorted(planes.missing))}"
        found.append(Assumption("missing terms", words, "log"))
    return tuple(found)


def growing(
    planes: Planes,
    refit: Callable[[Planes], LinearFit | None],
    entry: ParameterEstimate,
    coefficient: str,
    slope: float,
) -> tuple[Track, ...]:
    """How an answer came about: the balance fitted to more and more of the drive, with the last fit's conversions.

    slope: change of the parameter with the coefficient. None where there is no answer or the drive is short.
    """
    if entry.value is None or entry.std is None or entry.status == "not_identifiable":
        return ()
    rows = [round(len(planes.time_s) * (i + 1) / TRACK_POINTS) for i in range(TRACK_POINTS)]
    fits = [(planes.time_s[n - 1], refit(planes.first(n))) for n in rows if n > 1]
    told = [(at, f.value(coefficient), f.std(coefficient)) for at, f in fits if f is not None]
    if not told:
        return ()
    time_s, values, stds = np.array(told).T
    last = stds[-1] * abs(slope)
    value = entry.value + slope * (values - values[-1])
    half = 1.96 * np.sqrt(np.maximum(entry.std**2 - last**2, 0.0) + (slope * stds) ** 2)
    return (Track(entry.name, time_s, value, value - half, value + half),)


def diagnostics(fit: LinearFit) -> dict[str, float]:
    """Coefficients with their standard deviations, and how good the balance is."""
    found = {
        "explained": fit.explained,
        "residual_std": float(np.std(fit.residual)),
        "blocks": float(fit.blocks),
    }
    for i, name in enumerate(fit.names):
        found[f"{name}"] = float(fit.values[i])
        found[f"{name}_std"] = float(np.sqrt(fit.covariance[i, i]))
        found[f"{name}_told"] = float(fit.told[i])
    return found
