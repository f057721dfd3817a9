"""What the report shows of the roll fit: running estimates, fits and residuals, and roll against acceleration."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from pipelines.estimators.roll_map.answers import coefficients_of, likelihood_of
from pipelines.estimators.roll_map.data import RollData
from pipelines.estimators.roll_map.fit import RollFit
from pipelines.estimators.roll_map.model import NOISES, run
from pipelines.estimators.roll_map.posterior import quantiles, sample_posterior
from pipelines.estimators.roll_map.priors import VehicleDraws
from pipelines.models.roll import DEGREES, GRAVITY, roll_gradient_degpg
from pipelines.prepare.prepared import Prepared
from pipelines.prepare.roll_angle import AGAINST_AXLES
from pipelines.results import FloatArray, Prior, Scatter, Trace, Track

MOST_POINTS = 3000
HEIGHT_POINTS = 30


def running(fit: RollFit, k: int) -> tuple[FloatArray, FloatArray]:
    """All parameters and their covariance from the data up to edge k: one scoring step from the final fit.

    The noise parameters stay at their final values. Intervals are widened as the final ones are.
    """
    free = [i for i, known in enumerate(fit.known) if known.name not in NOISES]
    x = np.array([fit.values[known.name] for known in fit.known])
    weight = np.array([1 / known.std**2 for known in fit.known])
    mean = np.array([known.mean for known in fit.known])
    pick = np.ix_(free, free)
    curvature = fit.information[k][pick] + np.diag(weight[free])
    inner = np.linalg.inv(curvature)
    moved = x.copy()
    moved[free] += inner @ (fit.gradient[k][free] - weight[free] * (x[free] - mean[free]))
    low = np.array([known.low for known in fit.known])
    high = np.array([known.high for known in fit.known])
    grown = np.sqrt(np.diag(fit.covariance)[free] / np.diag(fit.white_covariance)[free])
    covariance = np.zeros_like(fit.covariance)
    covariance[pick] = inner * np.outer(grown, grown)
    return np.clip(moved, low, high), covariance


def gradient_track(
    fit: RollFit, time_s: FloatArray, scale_std: float, against_axles: bool, end: float | None
) -> Track:
    """The roll gradient as the drive went on. end: what it comes to, with the tyres' part where that was added."""
    rows = []
    for k in range(len(fit.edges)):
        c = coefficients_of(fit, scale_std, against_axles, *running(fit, k))
        a, std = c.mean[0], math.sqrt(c.covariance[0, 0])
        around = (a, a + 1.96 * std, max(a - 1.96 * std, 5.0))
        rows.append([float(roll_gradient_degpg(each)) for each in around])
    table = np.array(rows)
    if against_axles and end is not None:
        table *= end / float(roll_gradient_degpg(fit.values["a"]))
    return Track("roll_gradient_degpg", time_s, table[:, 0], table[:, 1], table[:, 2])


def height_track(
    fit: RollFit,
    time_s: FloatArray,
    scale_std: float,
    draws: VehicleDraws,
    priors: tuple[Prior | None, Prior | None],
    against_axles: bool,
    rng: np.random.Generator,
) -> Track:
    """The CG height as the drive went on, from fewer draws at fewer places."""
    chosen = np.unique(
        np.linspace(0, len(fit.edges) - 1, min(HEIGHT_POINTS, len(fit.edges))).round().astype(int)
    )
    rows = []
    for k in chosen.tolist():
        c = coefficients_of(fit, scale_std, against_axles, *running(fit, k))
        posterior = sample_posterior(draws, likelihood_of(c, against_axles=against_axles), *priors, rng)
        if posterior.effective < 30:
            rows.append([math.nan] * 3)
            continue
        height = posterior.values["cg_height_m"]
        low, high = quantiles(height, posterior.weight, (0.025, 0.975))
        rows.append([float(posterior.weight @ height), float(low), float(high)])
    table = np.array(rows)
    return Track("cg_height_m", time_s[chosen], table[:, 0], table[:, 1], table[:, 2])


def _parted(data: RollData, column: FloatArray) -> FloatArray:
    """The column with its last value of each segment blanked, so that a line breaks at gaps."""
    out = column.copy()
    out[data.stops - 1] = np.nan
    return out


def fit_traces(data: RollData, fit: RollFit, prepared: Prepared) -> tuple[Trace, ...]:
    """Measured against simulated roll (the model runs on the acceleration alone), and the innovations."""
    _, _, miss = run(replace(data, roll=data.whole_roll, rate=data.whole_rate), fit.values)
    time_s = prepared.time_s[data.rows]
    channels = [("roll", data.whole_roll, "deg")] if data.has_roll else []
    if data.has_rate:
        channels.append(("roll rate", data.whole_rate, "deg/s"))
    note = f"low-passed at {data.band_hz:.2g} Hz, where the lateral acceleration ends; the model runs on that alone"
    traces = []
    for i, (name, measured, unit) in enumerate(channels):
        seen, off = measured * DEGREES, miss[:, i] * DEGREES
        columns = {
            "measured": _parted(data, seen),
            "model": _parted(data, seen - off),
            "residual": _parted(data, off),
        }
        traces.append(Trace(f"{name} fit", time_s, columns, dict.fromkeys(columns, unit), note))
    scored = np.isfinite(fit.normalised).any(axis=1)
    columns = {name: fit.normalised[scored, i] for i, (name, _, _) in enumerate(channels)}
    traces.append(
        Trace("innovations", time_s[scored], columns, dict.fromkeys(columns, "std"), "in standard deviations")
    )
    return tuple(traces)


def _thinned(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """At most MOST_POINTS points; the highest and lowest of each stretch of x stay."""
    if len(x) <= MOST_POINTS:
        return x, y
    bins = np.linspace(x.min(), x.max(), 100)
    place = np.digitize(x, bins)
    by_y = np.lexsort((y, place))
    first = np.flatnonzero(np.diff(place[by_y], prepend=-1))
    last = np.append(first[1:], len(by_y)) - 1
    even = np.linspace(0, len(x) - 1, MOST_POINTS - 2 * len(first)).astype(int)
    keep = np.unique(np.concatenate((by_y[first], by_y[last], even)))
    return x[keep], y[keep]


def roll_scatter(
    data: RollData,
    fit: RollFit,
    angle: FloatArray,
    made: str,
    gradient_std: float,
    mean_angle: bool,
    told: bool,
) -> Scatter | None:
    """Roll against sensed lateral acceleration, with the fitted steady line and its 95 % band.

    angle: (n,) rad on the fit's rows. mean_angle: the angle has no fitted offset (derived), so that its own middle is
    taken. gradient_std: relative standard deviation of the gradient. told: whether the gradient was identified.
    """
    accel = data.shifter.delayed(fit.values["delay"])
    good = np.isfinite(angle)
    if good.sum() < 10:
        return None
    x, y = accel[good] / GRAVITY, angle[good] * DEGREES
    gradient = float(roll_gradient_degpg(fit.values["a"]))
    if mean_angle:
        offset, offset_std = float(np.mean(y - gradient * x)), 0.0
    else:
        offset, offset_std = fit.values["roll_offset"] * DEGREES, fit.std("roll_offset") * DEGREES
    ends = max(abs(float(x.min())), abs(float(x.max())))
    line = np.linspace(-ends, ends, 41)
    middle = offset + gradient * line
    half = 1.96 * np.sqrt((gradient_std * gradient * line) ** 2 + offset_std**2)
    thin_x, thin_y = _thinned(x, y)
    slope = f", {gradient:.2f} deg/g," if told else " (its slope is not identifiable)"
    beside = ""
    if AGAINST_AXLES in made:
        beside = " What the body rolls on its tyres is not in it, and is in the roll gradient of the table."
    return Scatter(
        "roll_against_lateral_acceleration",
        "Roll against lateral acceleration",
        "sensed lateral acceleration [g]",
        "roll angle [deg]",
        thin_x,
        thin_y,
        line,
        middle,
        middle - half,
        middle + half,
        f"Line: the steady part of the fit{slope} with its 95 % band. Points leave the line where the body "
        f"moves fast (damping and inertia). Roll angle: {made}.{beside}",
    )
