"""The two moments that the log itself tells: M_h = m h and M_c = m (a - share L), with their covariance."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pipelines.estimators.axle_load_gls.data import AxleData
from pipelines.estimators.axle_load_gls.fit import Colour, Fit, few_rows, fit
from pipelines.estimators.axle_load_gls.hills import hills_covariance
from pipelines.filters.whiten import whiten
from pipelines.models.axle_load import GRAVITY
from pipelines.prepare.lowpass import lowpass
from pipelines.results import FloatArray

CORRELATION_S = 2.0
SLOW_HZ = 0.5
SLOW_FORM_HZ = 1.0
GAP_SHARE = 0.12
DIRECT_DOUBT, FORCE_DOUBT = 0.5, 0.25


@dataclass(frozen=True)
class Balance:
    """moments: (M_h, M_c) in kg·m, effective: all parts that go with the force are still in M_h. covariance (2, 2).

    force, moment (n,): specific force and L times load, as fitted; fitted (n,): the model's moment, or speed where
    by_speed. unexplained: share of the moment's variance, both slow (below 0.5 Hz),
    that goes neither with the force nor with the other columns. track_rows, track, track_std: M_h and M_c after the data up to these rows, (k,), (k, 2), (k, 2).
    rows_told: how many rows that do not hang together it rests on.
    """

    moments: FloatArray
    covariance: FloatArray
    fit: Fit
    by_speed: bool
    force: FloatArray
    moment: FloatArray
    measured: FloatArray
    fitted: FloatArray
    track_rows: np.ndarray
    track: FloatArray
    track_std: FloatArray
    force_spread: float
    unexplained: float
    rows_told: float = math.inf


def noise_of(values: FloatArray, starts: FloatArray) -> float:
    """Standard deviation of a column's white noise, from its second differences by median; 0 where it has none."""
    second = values[2:] - 2 * values[1:-1] + values[:-2]
    inside = (starts[2:] < 0.5) & (starts[1:-1] < 0.5)
    if not inside.any():
        return 0.0
    return float(np.median(np.abs(second[inside]))) * 1.4826 / math.sqrt(6.0)


def integrate(values: FloatArray, starts: FloatArray, dt: float) -> FloatArray:
    """Integral over time from the first row of each run (trapezoid: half a step's delay would be an error); (n,)."""
    total = np.cumsum(values) * dt - 0.5 * values * dt
    begin = np.flatnonzero(starts > 0.5)
    base = np.repeat(total[begin], np.diff([*begin, len(values)]))
    return np.asarray(total - base)


def _moments_by_speed(beta: FloatArray, covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(1/M_h, M_c/M_h) -> (M_h, M_c) and covariance."""
    height = 1.0 / beta[0]
    jacobian = np.array([[-(height**2), 0.0], [-beta[1] * height**2, height]])
    return np.array([height, beta[1] * height]), jacobian @ covariance[:2, :2] @ jacobian.T


@dataclass(frozen=True)
class Known:
    """Coefficients of the balance that are roughly known, each mean and standard deviation.

    drag: of v², N·m per (m/s)². inertia: of the body's pitch acceleration, kg·m².
    """

    drag: tuple[float, float]
    inertia: tuple[float, float]

    def columns(self, data: AxleData) -> tuple[FloatArray, FloatArray, FloatArray]:
        """v² and the pitch acceleration (n, 2) with their coefficients' means and standard deviations (2,)."""
        speed2 = np.zeros(data.size) if data.speed is None else data.speed**2
        turning = np.zeros(data.size) if data.pitch_accel is None else data.pitch_accel
        both = np.column_stack((speed2, turning))
        mean, std = np.array([self.drag[0], self.inertia[0]]), np.array([self.drag[1], self.inertia[1]])
        return both, mean, np.maximum(std, 1e-9)


def by_force(
    data: AxleData, wheelbase: float, known: Known, huber: float, *, measured: bool = True
) -> Balance:
    """L load = M_h f + M_c f_z + c v² + I q'; the last two with a prior. Autoregressive residual.

    f: the accelerometer's (measured), else dv/dt + g sin(grade).
    """
    force = data.force()
    moment = wheelbase * data.load
    beside, coefficient, std = known.columns(data)
    x = np.column_stack((force, data.vertical, beside))
    columns = np.column_stack((moment, x))
    mean = np.array([0.0, 0.0, *coefficient])
    precision = np.array([0.0, 0.0, *std**-2.0])
    lag = round(CORRELATION_S * data.rate_hz)
    # the engine works in the moment's own unit
    size = float(np.std(moment)) or 1.0
    found = fit(
        columns / size, data.starts, Colour(0.9, 0.1), huber=huber, lag_rows=lag,
        prior_mean=mean, prior_precision=precision,
    )  # fmt: skip
    beta = found.beta
    rest = moment - x @ beta
    covariance = found.wide_covariance[:2, :2] * few_rows(data.size)
    # the force that speed and an assumed slope give; an accelerometer feels the slope itself
    if not measured:
        covariance = covariance + hills_covariance(data, found, x / size, precision, beta[:2], rest, size)
    rows, track, spread = _track(columns / size, data, found, mean, precision)
    return Balance(
        beta[:2], covariance, found, False, force, moment, moment, x @ beta, rows, track, spread,
        float(np.std(force)), _unexplained(data, rest, beta[0] * force), slow_rows(data),
    )  # fmt: skip


def by_speed(data: AxleData, wheelbase: float, known: Known, huber: float) -> Balance:
    """v + g sum(sin) = (1/M_h) sum(L load - c v² - I q') - (M_c/M_h) sum(f_z), from (4). Random-walk residual."""
    assert data.speed is not None
    dt, starts = data.dt, data.starts
    moment = wheelbase * data.load
    beside, coefficient, std = known.columns(data)
    force = data.force()
    shaken = force - np.mean(force)
    slope = float(shaken @ moment) / max(float(shaken @ shaken), 1e-12)
    usual = 1.0 / max(slope, 1e-6 * float(np.mean(np.abs(moment))) + 1e-9)
    y = data.speed + GRAVITY * integrate(np.sin(data.grade), starts, dt)
    x = np.column_stack((
        integrate(moment - beside @ coefficient, starts, dt),
        -integrate(data.vertical, starts, dt),
        -integrate(beside[:, 0], starts, dt),
        -integrate(beside[:, 1], starts, dt),
    ))  # fmt: skip
    mean = np.zeros(4)
    precision = np.array([0.0, 0.0, *np.maximum(std * usual, 1e-12) ** -2.0])
    least = (wheelbase * dt * noise_of(data.load, starts) * usual) ** 2
    columns = np.column_stack((y, x))
    found = fit(
        columns, starts, Colour(1.0, 0.01), huber=huber, lag_rows=round(CORRELATION_S * data.rate_hz),
        prior_mean=mean, prior_precision=precision, least_process=least,
    )  # fmt: skip
    own = found.wide_covariance.copy()
    own *= few_rows(data.size)
    moments, _ = _moments_by_speed(found.beta, own)
    rest = moment - beside @ coefficient - moments[1] * data.vertical - moments[0] * force
    own[:2, :2] += hills_covariance(data, found, x, precision, moments, rest, None)
    moments, covariance = _moments_by_speed(found.beta, own)
    rows, track, spread = _track(columns, data, found, mean, precision)
    for i in range(len(track)):
        if np.isfinite(track[i]).all() and track[i, 0] > 0:
            one, two = _moments_by_speed(track[i], np.diag(spread[i] ** 2))
            track[i], spread[i] = one, np.sqrt(np.diag(two))
        else:
            track[i] = spread[i] = np.nan
    offset = _levels(found.residual, starts)
    return Balance(
        moments, covariance, found, True, force, moment, data.speed, data.speed - found.residual + offset,
        rows, track, spread, float(np.std(force)), _unexplained(data, rest, moments[0] * force), slow_rows(data),
    )  # fmt: skip


def better_form(data: AxleData, wheelbase: float, known: Known, huber: float) -> tuple[AxleData, Balance]:
    """Without an accelerometer: both forms, each by what it may be wrong by; and the data of the weightier one.

    The form against the speed is the efficient one with a noisy speed, but all that the model leaves out of the load
    makes its M_h too large; the form against dv/dt + g sin(grade) hardly suffers from that, and errors of the force itself make its
    M_h too small by little. What the two differ by beyond chance is therefore the first one's error, and a part of it the second one's.
    """
    direct = by_speed(data, wheelbase, known, huber)
    slow = slowed(data, SLOW_FORM_HZ)
    if slow is data:
        return data, doubted(direct, 1.0)
    direct = doubted(direct, DIRECT_DOUBT)
    other = by_force(slow, wheelbase, known, huber, measured=False)
    joined = _joined(direct, other)
    return (data if joined.by_speed else slow), joined


def _joined(direct: Balance, other: Balance) -> Balance:
    """The weightier of the two forms with M_h in their weighted mean, and in its variance what is left of their difference."""
    gap = float(direct.moments[0] - other.moments[0])
    variances = np.array([float(form.covariance[0, 0]) for form in (direct, other)])
    excess = max(gap**2 - float(variances.sum()), 0.0)
    if not np.isfinite(excess) or not (variances > 0).all():
        return direct
    weights = 1 / (variances + excess * np.array([1.0, GAP_SHARE**2]))
    share = weights / weights.sum()
    lead = direct if share[0] >= share[1] else other
    height = float(share[0] * direct.moments[0] + share[1] * other.moments[0])
    # the forms have load, speed and hills in common: the mean of both is no surer than the surer one
    variance = float(share @ variances) + float(share[0] * share[1]) * excess
    variance += (GAP_SHARE * float(share[1])) ** 2 * excess
    covariance = lead.covariance.copy()
    slope = float(covariance[0, 1] / covariance[0, 0])
    moved = height - float(lead.moments[0])
    left = max(float(covariance[1, 1]) - slope**2 * float(covariance[0, 0]), 0.0)
    covariance = np.array([[variance, slope * variance], [slope * variance, left + slope**2 * variance]])
    ratio = height / float(lead.moments[0])
    return replace(
        lead, moments=lead.moments + moved * np.array([1.0, slope]), covariance=covariance,
        track=lead.track * np.array([ratio, 1.0]), rows_told=min(direct.rows_told, other.rows_told),
    )  # fmt: skip


def slow_rows(data: AxleData) -> float:
    """Rows that do not hang together: what is left of quicker ones at the slow form's pace."""
    return data.size * min(1.0, 2 * SLOW_FORM_HZ / data.rate_hz)


def doubted(balance: Balance, share: float) -> Balance:
    """The balance with M_h's variance raised by what the load does not explain, times `share`, of M_h itself."""
    covariance = balance.covariance.copy()
    covariance[0, 0] += (share * balance.unexplained * balance.moments[0]) ** 2
    return replace(balance, covariance=covariance)


def slowed(data: AxleData, cutoff_hz: float) -> AxleData:
    """All columns low-passed alike, run by run, and taken at twice the cutoff; runs that are too short are left out.

    A force that is differentiated from the speed is smooth: what it is compared with must be as smooth.
    """
    cutoff_hz = min(cutoff_hz, 0.2 * data.rate_hz)
    every = max(1, int(data.rate_hz / (2 * cutoff_hz)))
    kept = [(i, j) for i, j in data.runs() if j - i >= 4 * every]
    if not kept:
        return data
    taken = np.concatenate([np.arange(i, j, every) for i, j in kept])
    starts = np.zeros(len(taken))
    starts[np.concatenate(([0], np.cumsum([len(range(i, j, every)) for i, j in kept])[:-1]))] = 1.0

    def slow(values: FloatArray) -> FloatArray:
        parts = [lowpass(values[i:j], data.rate_hz, cutoff_hz)[::every] for i, j in kept]
        return np.asarray(np.concatenate(parts))

    assert data.speed is not None
    return replace(
        data, time_s=data.time_s[taken], rate_hz=data.rate_hz / every, load=slow(data.load), accel=slow(data.force()),
        speed=slow(data.speed), vertical=slow(data.vertical),
        pitch_accel=None if data.pitch_accel is None else slow(data.pitch_accel), grade=data.grade[taken],
        starts=starts, rows=data.rows[taken],
    )  # fmt: skip


def _unexplained(data: AxleData, rest: FloatArray, follows: FloatArray) -> float:
    """Variance of what is left over that of both, slow parts only, without each run's mean."""
    left = total = 0.0
    for first, past in data.runs():
        cutoff = min(SLOW_HZ, 0.4 * data.rate_hz)
        a, b = (lowpass(v[first:past], data.rate_hz, cutoff) for v in (rest, follows))
        left += float(np.sum((a - np.mean(a)) ** 2))
        total += float(np.sum((a + b - np.mean(a + b)) ** 2))
    return min(left / total, 1.0) if total > 0 else 1.0


def _levels(residual: FloatArray, starts: FloatArray) -> FloatArray:
    """The mean residual of each run at each of its rows: the unknown starting speed."""
    begin = np.flatnonzero(starts > 0.5)
    length = np.diff([*begin, len(residual)])
    return np.asarray(np.repeat(np.add.reduceat(residual, begin) / length, length))


TRACK_POINTS = 100


def _track(
    columns: FloatArray, data: AxleData, found: Fit, mean: FloatArray, precision: FloatArray
) -> tuple[np.ndarray, FloatArray, FloatArray]:
    """The first two coefficients and their standard deviations after the data up to each of some rows."""
    colour = found.colour
    white, _ = whiten(
        columns, data.starts, colour.phi, colour.ratio * colour.white, colour.white / found.weights
    )
    edges = np.unique(np.linspace(0, data.size, TRACK_POINTS + 1).round().astype(np.int64))[1:]
    p = columns.shape[1]
    products = np.zeros((len(edges), p, p))
    before = 0
    total = np.zeros((p, p))
    for i, edge in enumerate(edges):
        part = white[before:edge]
        total = total + part.T @ part
        products[i] = total
        before = int(edge)
    scale2 = found.scale**2
    grown = np.sqrt(np.diag(found.wide_covariance) / np.maximum(np.diag(found.covariance), 1e-300))
    values, spread = np.full((len(edges), 2), np.nan), np.full((len(edges), 2), np.nan)
    for i, product in enumerate(products):
        information = product[1:, 1:] + np.diag(precision) * scale2
        size = np.sqrt(np.diag(information))
        if not (size > 0).all():
            continue
        scaled = information / np.outer(size, size)
        if np.linalg.cond(scaled) > 1e11:
            continue
        inverse = np.linalg.inv(scaled) / np.outer(size, size)
        target = product[1:, 0] + precision * scale2 * mean
        values[i] = (inverse @ target)[:2]
        spread[i] = (np.sqrt(np.diag(inverse) * scale2) * grown)[:2]
    return edges - 1, values, spread
