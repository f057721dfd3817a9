"""The roll motion over a whole drive: how far the body leans per unit of lateral acceleration.

    T2 φ'' + T1 φ' + φ = G (f - e f³),    G = m h_lat / k_t,  T1 = c_t / k_t,  T2 = I / k_t    (21) of Park & Choi

with e for what springs stiffen by as the body leans (theirs are straight: e = 0). It is
seen by the roll rate (φ' and an offset), by the gravity that leans into the accelerometer, f - r v = g φ + v_y' (37),
and by a measured roll angle where there is one. v_y' is that of a single-track car, v_y = x r - v (D f + E f³): its
share of (37) is as large as the roll's in a circle that grows faster. All signals pass the same zero-phase low-pass.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from parsers.channels import IntArray
from pipelines.estimators.brake_roll.least import LeastFit, Samples, Unknown, fit_least
from pipelines.filters.linear_response import linear_response
from pipelines.models.roll import GRAVITY, RollCoefficients, discretise
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import BoolArray
from pipelines.results import FloatArray

LEAST_LATERAL = 0.4
"""m/s², spread of the lateral acceleration from which there is something to see."""

ROUGH, ROUGH_BLIND = 0.3, 0.4
"""Share by which the roll per lateral acceleration is off on rough road where next to none of the roll rate follows: the road's own roll
leans gravity into the accelerometer. BLIND: where nothing tells how quick the steering was."""

BLIND_HZ = 1.0
"""What is read at most where nothing tells how quick the steering was: drivers weave at up to 0.7 Hz."""

LEAST_YAW = 0.03
"""rad/s, spread of the yaw rate from which on it tells alone how quick the steering was."""

BLOCK_S = 8.0
SETTLE_S, SETTLE_PERIODS = 1.0, 2.0
"""Left out at both ends of a segment, in s and in periods of the low-pass, whichever is more, yet a quarter of it at most: a filter that
meets an end bends what it reads there, by percent of the roll in a slalom of half a minute."""

GRAVITY_HZ = 0.6
"""Gravity in the accelerometer is read below this frequency: the derivative of v f is noise above it, and noise in
what explains pulls its coefficient to zero (and the roll's share with it)."""


@dataclass(frozen=True)
class LateralKnown:
    """What is known before: lag_s, inertia_s2: T1 and T2 with standard deviations. rear_m: sensor ahead of the rear
    axle, compliance, bend: D in rad/(m/s²), E in rad/(m/s²)³ (a tyre's slip angle, straight and beyond), each with its
    standard deviation. stiffening: e in (m/s²)^-2. Relative and absolute errors of the sensors (standard deviations): scale of r v
    against f, yaw offset rad/s, tilt of the accelerometer about z rad, yaw leak into the roll rate, delay s. pitch: rad per m/s² along, cornering_pitch: rad per (m/s²)² across."""

    lag_s: tuple[float, float] = (0.07, 0.03)
    inertia_s2: tuple[float, float] = (0.009, 0.004)
    rear_m: tuple[float, float] = (1.4, 0.5)
    compliance: tuple[float, float] = (0.006, 0.006)
    bend: tuple[float, float] = (2.5e-5, 2e-5)
    stiffening: tuple[float, float] = (0.0, 0.0)
    scale: float = 0.005
    yaw_offset: float = 0.002
    tilt: float = 0.02
    leak: float = 0.02
    pitch: float = 0.0
    cornering_pitch: float = 0.0
    delay: float = 0.02


@dataclass(frozen=True)
class LateralData:
    """Columns (n,) SI at rate_hz, low-passed alike at band_hz, of which rate_hz is eight times or more: the input runs
    straight between samples. Where speed or yaw rate is missing, gravity in the accelerometer is not used."""

    rate_hz: float
    band_hz: float
    f_y: FloatArray
    roll_rate: FloatArray
    yaw_rate: FloatArray | None
    speed: FloatArray | None
    f_x: FloatArray | None
    roll: FloatArray | None
    rows: BoolArray
    segments: tuple[IntArray, IntArray]


@dataclass(frozen=True)
class LateralFit:
    """gain: G in rad per m/s², std: its standard deviation. fit: all parameters. used: rows. predicted: roll rate (n,).
    explained: share of the roll rate that follows. liveliness: RMS of the lateral acceleration in m/s²."""

    gain: float
    std: float
    fit: LeastFit
    used: BoolArray
    predicted: FloatArray
    explained: float
    liveliness: float


def _along(values: FloatArray, rate_hz: float) -> FloatArray:
    return np.asarray(np.gradient(values) * rate_hz)


def _usable(data: LateralData, band_hz: float) -> BoolArray:
    """Rows well inside segments, moving where the speed is known, and not beyond 0.7 g. band_hz: of the low-pass."""
    used = data.rows.copy()
    settle = round(max(SETTLE_S, SETTLE_PERIODS / band_hz) * data.rate_hz)
    for start, stop in zip(*data.segments, strict=True):
        rows = min(settle, int(stop - start) // 4)
        used[start : start + rows] = used[stop - rows : stop] = False
    if data.speed is not None:
        used &= data.speed > 1.5
    return np.asarray(used & (np.abs(data.f_y) < 7.0))


def _nuisance(data: LateralData, known: LateralKnown) -> list[tuple[Unknown, int, FloatArray]]:
    """(unknown, output, column): what adds to an output in proportion to itself."""
    n = len(data.f_y)
    ones = np.ones(n)
    found = [(Unknown("rate_offset", 0.0, 0.02, 1e-3), 0, ones)]
    if data.yaw_rate is not None:
        found.append((Unknown("yaw_leak", 0.0, known.leak, 1e-3), 0, data.yaw_rate))
        # a body that pitches puts yaw into the roll rate: in circles that grow slowly as much as they roll
        found.append(
            (Unknown("cornering_pitch", 0.0, known.cornering_pitch, 1e-5), 0, data.yaw_rate * data.f_y**2)
        )
        if data.f_x is not None:
            found.append((Unknown("pitch", 0.0, known.pitch, 1e-3), 0, data.yaw_rate * data.f_x))
    if data.yaw_rate is not None and data.speed is not None:
        r, v, f = data.yaw_rate, data.speed, data.f_y
        swing = _along(v * f, data.rate_hz)
        found += [
            (Unknown("accel_offset", 0.0, 0.5, 1e-2), 1, ones),
            (Unknown("rear_m", known.rear_m[0], known.rear_m[1], 1e-2), 1, _along(r, data.rate_hz)),
            (Unknown("compliance", known.compliance[0], known.compliance[1], 1e-4), 1, -swing),
            (Unknown("bend", known.bend[0], known.bend[1], 1e-6), 1, -_along(v * f**3, data.rate_hz)),
            (Unknown("scale", 0.0, known.scale, 1e-3), 1, r * v),
            (Unknown("yaw_offset", 0.0, known.yaw_offset, 1e-4), 1, -v),
        ]
        if data.f_x is not None:
            found.append((Unknown("tilt", 0.0, known.tilt, 1e-3), 1, data.f_x))
    if data.roll is not None:
        found.append((Unknown("roll_offset", 0.0, 0.1, 1e-3), 2, ones))
    return found


def _outputs(data: LateralData) -> FloatArray:
    """(n, 3): roll rate, gravity in the accelerometer, roll angle; those that are missing hold zeros."""
    y = np.zeros((len(data.f_y), 3))
    y[:, 0] = data.roll_rate
    if data.yaw_rate is not None and data.speed is not None:
        y[:, 1] = data.f_y - data.yaw_rate * data.speed
    if data.roll is not None:
        y[:, 2] = data.roll
    return y


def _response(data: LateralData, f: FloatArray, lag: float, inertia: float) -> tuple[FloatArray, FloatArray]:
    """φ and φ' under f (n,) for G = 1."""
    phi, before, after = discretise(RollCoefficients(1.0, lag, inertia), 1 / data.rate_hz)
    out = linear_response(f, phi, before, after, 1.0, data.segments)
    return np.ascontiguousarray(out[:, 0]), np.ascontiguousarray(out[:, 1])


def _filtered(values: FloatArray, data: LateralData, cutoff_hz: float) -> FloatArray:
    """The low-passed column, segment by segment."""
    out = np.zeros(len(values))
    for start, stop in zip(*data.segments, strict=True):
        out[start:stop] = lowpass(values[start:stop], data.rate_hz, cutoff_hz)
    return out


def _steered(data: LateralData) -> FloatArray:
    """What tells how quick the steering was: the lateral acceleration itself where no gyro does."""
    if data.yaw_rate is not None and data.speed is not None:
        turned = data.yaw_rate * data.speed
        # a yaw rate that says nothing is no measure of what was steered
        return turned if float(np.std(turned)) > 0.3 * float(np.std(data.f_y)) else data.f_y
    if data.yaw_rate is not None and float(np.std(data.yaw_rate)) > LEAST_YAW:
        return data.yaw_rate
    return data.f_y


def lively_band(data: LateralData) -> float:
    """Frequency in Hz up to which the roll rate is read: twice that below which 99.9 % of what is steered lies.

    Beyond it f is noise, and its response would stand against roll motion that is not there: a growing circle's roll
    came out 8 % too small that way. On rough road f holds the roll that the road makes (the sensor sits above the roll
    axis) and the share came out 40 % too small: what is steered is told by yaw rate times speed where they are there.
    """
    steered = _steered(data)
    power = np.zeros(513)
    for start, stop in zip(*data.segments, strict=True):
        # a window, or the jump between the ends would look like quick motion
        f = steered[start:stop] - float(np.mean(steered[start:stop]))
        spectrum = np.abs(np.fft.rfft(f * np.hanning(len(f)))) ** 2
        power += np.add.reduceat(spectrum, np.linspace(0, len(spectrum) - 1, 513).astype(np.int64))
    share = np.cumsum(power) / max(float(power.sum()), 1e-12)
    frequency = np.linspace(0.0, data.rate_hz / 2, 513)
    top = 2 * float(frequency[min(int(np.searchsorted(share, 0.999)), len(frequency) - 1)])
    most = BLIND_HZ if steered is data.f_y else data.band_hz
    return min(max(top, GRAVITY_HZ), most, data.band_hz)


def _memory(residual: FloatArray, linked: BoolArray) -> float:
    """First autocorrelation of a channel's residual (n,) over neighbouring rows, between 0 and 0.98."""
    pairs = linked[1:]
    a, b = residual[1:][pairs], residual[:-1][pairs]
    power = float(np.sum(b * b))
    return min(max(float(np.sum(a * b)) / power, 0.0), 0.98) if power > 0 else 0.0


@dataclass(frozen=True)
class _Channel:
    """One output's rows, and whether the one before is its neighbour in time."""

    output: int
    rows: IntArray
    linked: BoolArray


def _channels(data: LateralData, used: BoolArray, band_hz: float) -> list[_Channel]:
    found: list[_Channel] = []
    quick = max(1, round(data.rate_hz / (2 * band_hz)))
    slow = max(1, round(data.rate_hz / (2 * GRAVITY_HZ)))
    outputs = [(0, quick)]
    if data.yaw_rate is not None and data.speed is not None:
        outputs.append((1, slow))
    if data.roll is not None:
        outputs.append((2, quick))
    for output, every in outputs:
        rows = np.flatnonzero(used)
        rows = rows[rows % every == 0]
        linked = np.concatenate(([False], np.diff(rows) == every))
        found.append(_Channel(output, rows, linked))
    return found


HEADS = 5
"""Gain, lag, inertia, delay and stiffening come first of the fit's parameters."""


class _Problem:
    """The fit's model on the rows of all channels, whitened by each channel's memory. quick: Hz up to which the roll rate is read."""

    def __init__(self, data: LateralData, known: LateralKnown, used: BoolArray, quick: float) -> None:
        self.data = data
        bands = (quick, GRAVITY_HZ, quick)
        self.channels = _channels(data, used, quick)
        self.nuisances = [
            (u, output, _filtered(column, data, bands[output]))
            for u, output, column in _nuisance(data, known)
        ]
        raw = _outputs(data)
        self.y = np.stack([_filtered(raw[:, i], data, bands[i]) for i in range(3)], axis=1)
        self.quick_f = _filtered(data.f_y, data, quick)
        self.slow_f = _filtered(data.f_y, data, GRAVITY_HZ)
        self.quick_cube = _filtered(data.f_y**3, data, quick)
        self.slow_cube = _filtered(data.f_y**3, data, GRAVITY_HZ)
        self.memory = np.zeros(3)
        # of one memory: see `remember`
        self._white: list[FloatArray] | None = None
        self._moved: tuple[tuple[float, ...], FloatArray] | None = None
        self._last: tuple[tuple[float, float], tuple[FloatArray, ...]] | None = None

    def _responses(self, lag: float, inertia: float) -> tuple[FloatArray, ...]:
        """φ and φ' under the quick input and φ under the slow one, for G = 1, then under their cubes; most slopes move neither
        lag nor inertia."""
        if self._last is None or self._last[0] != (lag, inertia):
            found: list[FloatArray] = []
            for quick, slow in ((self.quick_f, self.slow_f), (self.quick_cube, self.slow_cube)):
                found += [
                    *_response(self.data, quick, lag, inertia),
                    _response(self.data, slow, lag, inertia)[0],
                ]
            self._last = (lag, inertia), tuple(found)
        return self._last[1]

    def _motion(self, x: FloatArray) -> FloatArray:
        """(n, 3) outputs that gain, lag, inertia, delay and stiffening (x's first five) make."""
        lag, inertia = math.exp(float(np.clip(x[1], -7, 1))), math.exp(float(np.clip(x[2], -10, 0)))
        responses = self._responses(lag, inertia)
        phi, rate, slow = (own - x[4] * cube for own, cube in zip(responses[:3], responses[3:], strict=True))
        quick = (self.quick_f - x[4] * self.quick_cube - phi - lag * rate) / inertia
        # a column in one piece: that is how they are filled and read
        out = np.zeros((3, len(phi))).T
        out[:, 0] = x[0] * (rate - x[3] * quick)
        out[:, 1] = GRAVITY * x[0] * slow
        out[:, 2] = x[0] * phi
        return out

    def whole(self, x: FloatArray) -> FloatArray:
        """(n, 3) outputs for the parameters x."""
        out = self._motion(x)
        for value, (_, output, column) in zip(x[HEADS:], self.nuisances, strict=True):
            out[:, output] += value * column
        return out

    def whiten(self, columns: FloatArray) -> FloatArray:
        """All channels' rows in a line: (rows,)."""
        parts: list[FloatArray] = []
        for channel in self.channels:
            values = columns[channel.rows, channel.output]
            memory = self.memory[channel.output]
            late = np.concatenate(([0.0], values[:-1]))
            fresh = np.where(channel.linked, values - memory * late, math.sqrt(1 - memory**2) * values)
            parts.append(fresh)
        return np.concatenate(parts)

    def samples(self, noise: FloatArray) -> Samples:
        """What is fitted."""
        rows = np.concatenate([c.rows for c in self.channels])
        group = np.concatenate([np.full(len(c.rows), i) for i, c in enumerate(self.channels)])
        # as many stretches as the drive has rows of its own, whatever the channels' steps
        seconds = min(max(len(self.data.f_y) / self.data.rate_hz / 20, 1.0), BLOCK_S)
        block = (rows / (seconds * self.data.rate_hz)).astype(np.int64)
        floor = np.array([1e-5, 1e-3, 1e-5])[[c.output for c in self.channels]]
        return Samples(self.whiten(self.y), group, block, noise, floor)

    def predict(self, x: FloatArray) -> FloatArray:
        """The model on the rows of `samples`: whitened, the nuisances' columns are the same from step to step."""
        if self._white is None:
            self._white = [self.whiten(self._alone(column, output)) for _, output, column in self.nuisances]
        head = tuple(x[:HEADS].tolist())
        if self._moved is None or self._moved[0] != head:
            self._moved = head, self.whiten(self._motion(x))
        found = self._moved[1].copy()
        for value, column in zip(x[HEADS:], self._white, strict=True):
            found += value * column
        return found

    def _alone(self, column: FloatArray, output: int) -> FloatArray:
        """(n, 3) noughts with one output's column."""
        out = np.zeros((3, len(column))).T
        out[:, output] = column
        return out

    def remember(self, x: FloatArray) -> None:
        """Take each channel's memory from the residual."""
        residual = self.y - self.whole(x)
        self._white = self._moved = None
        for c in self.channels:
            self.memory[c.output] = _memory(residual[c.rows, c.output], c.linked)


def fit_lateral(data: LateralData, known: LateralKnown) -> LateralFit | None:
    """Fit G, T1, T2 and the nuisances; None where the lateral acceleration hardly changes.

    Residuals with memory (bank, v_y' beyond the single-track car's) are whitened by their first autocorrelation, and
    the fit is done again.
    """
    quick = lively_band(data)
    used = _usable(data, quick)
    if used.sum() < 4 * data.rate_hz or float(np.std(data.f_y[used])) < LEAST_LATERAL:
        return None
    problem = _Problem(data, known, used, quick)
    heads = (
        Unknown("gain", 0.009, math.inf, 1e-5),
        Unknown("log_lag", math.log(known.lag_s[0]), known.lag_s[1] / known.lag_s[0], 1e-3),
        Unknown(
            "log_inertia", math.log(known.inertia_s2[0]), known.inertia_s2[1] / known.inertia_s2[0], 1e-3
        ),
        Unknown("delay", 0.0, known.delay, 1e-4),
        Unknown("stiffening", *known.stiffening, 1e-5),
    )
    unknowns = (*heads, *(u for u, _, _ in problem.nuisances))
    guess = np.array([0.01, 0.1, 0.005])[[c.output for c in problem.channels]]
    fit = fit_least(problem.predict, problem.samples(guess), unknowns)
    for _ in range(2):
        problem.remember(fit.values)
        started = tuple(
            Unknown(u.name, float(v), u.std, u.step, u.start if u.mean is None else u.mean)
            for u, v in zip(unknowns, fit.values, strict=True)
        )
        fit = fit_least(problem.predict, problem.samples(fit.noise), started)
    predicted = problem.whole(fit.values)[:, 0]
    measured = problem.y[used, 0]
    left = measured - predicted[used]
    level = measured - float(np.mean(measured))
    lively = float(np.sqrt(np.mean((data.f_y[used] - float(np.mean(data.f_y[used]))) ** 2)))
    explained = 1 - float(np.mean(left**2)) / max(float(np.mean(level**2)), 1e-12)
    gain, std = fit.value("gain"), fit.std("gain")
    rough = ROUGH_BLIND if _steered(data) is data.f_y else ROUGH
    std = math.hypot(std, rough * max(1 - explained, 0.0) * gain)
    return LateralFit(gain, std, fit, used, predicted, explained, lively)
