"""What the roll fit works on: excited stretches of the drive, cut together, with their input ready to be delayed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.ndimage import uniform_filter1d
from scipy.signal import welch

from parsers.channels import IntArray
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import BoolArray, Prepared
from pipelines.prepare.roll_angle import RollSource
from pipelines.prepare.spans import runs
from pipelines.results import FloatArray

EDGE_S = 0.3
WINDOW_S = 6.0
"""The filter's ends are not scored for EDGE_S; WINDOW_S around lively lateral acceleration are kept."""

LEAST_POWER = 0.005
NOISE_TIMES = 30.0
LOWEST_BAND_HZ = 0.8
SLOW_HZ = 0.17
"""The band ends where the input falls below this share of its peak or this near to its noise, but not below
0.8 Hz; below 0.17 Hz roads' banks change as well."""


@dataclass(frozen=True)
class _Part:
    """One segment's spectrum: rows start..stop, continued by `pad` rows at both ends, less a straight line."""

    start: int
    stop: int
    pad: int
    size: int
    spectrum: NDArray[np.complex128]
    omega: FloatArray
    first: float
    slope: float


class Shifter:
    """A band-limited column that can be read at any delay, segment by segment.

    Works on the spectrum, with the ends continued by turning the signal about its end points, so that a delay of a
    fraction of a sample smooths nothing. `held` prepares it for a first-order hold: straight lines between samples
    weaken a motion by sinc² (5 % at an eighth of the rate), which is made good beforehand.
    """

    def __init__(
        self,
        values: FloatArray,
        starts: IntArray,
        stops: IntArray,
        rate_hz: float,
        *,
        held: bool = False,
    ) -> None:
        """values: (n,) finite inside the segments."""
        self._n = len(values)
        self._rate = rate_hz
        self._parts = [
            self._part(values[start:stop], start, rate_hz, held)
            for start, stop in zip(starts.tolist(), stops.tolist(), strict=True)
        ]

    @staticmethod
    def _part(part: FloatArray, start: int, rate_hz: float, held: bool) -> _Part:
        pad = min(len(part) - 1, int(2 * rate_hz))
        before = 2 * part[0] - part[pad:0:-1]
        after = 2 * part[-1] - part[-2 : -pad - 2 : -1]
        long = np.concatenate((before, part, after))
        first, slope = float(long[0]), float((long[-1] - long[0]) / (len(long) - 1))
        size = next_fast_len(len(long), real=True)
        level = long - first - slope * np.arange(len(long))
        spectrum = rfft(np.concatenate((level, np.zeros(size - len(long)))))
        frequency = rfftfreq(size)
        if held:
            spectrum = spectrum / np.sinc(frequency) ** 2
        return _Part(
            start, start + len(part), pad, size, spectrum, 2 * np.pi * rate_hz * frequency, first, slope
        )

    def slope(self, delay_s: float) -> FloatArray:
        """(n,) the rate of change per second of the column `delay_s` earlier; zero outside the segments."""
        out = np.zeros(self._n)
        for part in self._parts:
            turned = part.spectrum * (1j * part.omega) * np.exp(-1j * part.omega * delay_s)
            turned[-1] = turned[-1].real
            moved = irfft(turned, n=part.size)
            out[part.start : part.stop] = (
                moved[part.pad : part.pad + part.stop - part.start] + part.slope * self._rate
            )
        return out

    def delayed(self, delay_s: float) -> FloatArray:
        """(n,) the column `delay_s` earlier: value(t - delay_s); zero outside the segments."""
        out = np.zeros(self._n)
        for part in self._parts:
            moved = irfft(part.spectrum * np.exp(-1j * part.omega * delay_s), n=part.size)
            rows = np.arange(part.pad, part.pad + part.stop - part.start)
            line = part.first + part.slope * (rows - delay_s * self._rate)
            out[part.start : part.stop] = moved[rows[0] : rows[-1] + 1] + line
        return out


def lively_band(values: FloatArray, pieces: list[tuple[int, int]], rate_hz: float) -> tuple[float, float]:
    """The frequency in Hz up to which lateral acceleration holds motion and not just noise; and the share of its
    power below SLOW_HZ.

    An input's noise biases a fit that takes the input as it is (errors in variables): where there is more noise than
    motion, the fit learns that the body does not answer, and b and c came out two to three times too large in a slow
    slalom. So everything is low-passed once more, alike, where the input's power falls below 1/200 of its peak or 30
    times the noise (the density in the top third of the band, where no vehicle rolls).
    """
    width = min(max(b - a for a, b in pieces), max(16, round(12 * rate_hz)))
    power = np.zeros(width // 2 + 1)
    weight = 0.0
    frequency = np.linspace(0, rate_hz / 2, len(power))
    for start, stop in pieces:
        if stop - start < width:
            continue
        frequency, part = welch(values[start:stop], rate_hz, "hann", nperseg=width, detrend="constant")
        power += part * (stop - start)
        weight += stop - start
    density = uniform_filter1d(power / weight, 3, mode="nearest")
    top = (frequency > 0.3 * rate_hz) & (frequency < 0.45 * rate_hz)
    noise = float(np.median(density[top])) if top.any() else 0.0
    strong = np.flatnonzero(density >= max(LEAST_POWER * float(density.max()), NOISE_TIMES * noise))
    highest = float(frequency[strong[-1]]) if len(strong) else 0.0
    slow = float(power[1:][frequency[1:] <= SLOW_HZ].sum() / max(float(power[1:].sum()), 1e-300))
    return float(np.clip(1.2 * highest, LOWEST_BAND_HZ, 0.5 * rate_hz)), slow


@dataclass(frozen=True)
class RollData:
    """The rows that the fit uses, cut together.

    rows: (n,) their rows in the prepared drive. starts, stops: segments within them. accel: lateral specific force.
    roll, rate: (n,) measured, NaN where not scored or not there; whole_roll, whole_rate: with the rows not scored. yaw: (n,) yaw rate, zeros where it is not there.
    band_hz: all columns are low-passed here once more, and scored at twice this rate only, where the low-passed noise
    is white again. slow_share: how much of the input's power is as slow as bank. against_axles: whether
    the angle is the body's against its axles. rate_with_accel: roll rate and acceleration were sampled
    together. excited_rows, drive_rows: for the used fraction.
    """

    step_s: float
    rows: IntArray
    starts: IntArray
    stops: IntArray
    accel: FloatArray
    roll: FloatArray
    rate: FloatArray
    whole_roll: FloatArray
    whole_rate: FloatArray
    yaw: FloatArray
    shifter: Shifter
    yaw_shifter: Shifter | None
    against_axles: bool
    has_roll: bool
    has_rate: bool
    has_yaw: bool
    rate_shift_s: float
    band_hz: float
    slow_share: float
    drive_rows: int
    rate_with_accel: bool = False

    @property
    def size(self) -> int:
        """Rows in use."""
        return len(self.rows)

    @property
    def quickness(self) -> float:
        """rad/s: RMS of the acceleration's rate of change over its own RMS."""
        pieces = [self.accel[i:j] for i, j in zip(self.starts, self.stops, strict=True)]
        change = sum(float(np.sum(np.diff(piece) ** 2)) for piece in pieces) / self.step_s**2
        spread = float(np.sum((self.accel - self.accel.mean()) ** 2))
        return float(np.sqrt(change / max(spread, 1e-12)))

    @property
    def holds_course(self) -> bool:
        """Whether gravity's part of the acceleration can be taken out: the angle is there against the horizon."""
        return self.has_roll and not self.against_axles and bool(np.isfinite(self.whole_roll).all())


def lively(accel: FloatArray, inside: BoolArray, rate_hz: float, least: float, level: float) -> BoolArray:
    """Rows within a few seconds of lateral acceleration that is steady or moving above `least` m/s² (RMS)."""
    square = np.where(inside, (accel - level) ** 2, 0.0)
    half = max(1, round(WINDOW_S * rate_hz / 2))
    total = np.concatenate(([0.0], np.cumsum(square)))
    count = np.concatenate(([0], np.cumsum(inside)))
    index = np.arange(len(accel))
    low, high = np.maximum(index - half, 0), np.minimum(index + half + 1, len(accel))
    number = np.maximum(count[high] - count[low], 1)
    mean_square = (total[high] - total[low]) / number
    return np.asarray((mean_square >= least**2) & inside)


def _capped(keep: BoolArray, accel: FloatArray, rate_hz: float, most: int) -> BoolArray:
    """At most `most` rows: whole windows, those with the largest lateral acceleration first."""
    if int(keep.sum()) <= most:
        return keep
    width = round(2 * WINDOW_S * rate_hz)
    blocks = [(i, min(i + width, len(keep))) for i in range(0, len(keep), width)]
    spread = [float(np.var(accel[a:b][keep[a:b]])) if keep[a:b].any() else -1.0 for a, b in blocks]
    chosen = np.zeros(len(keep), dtype=bool)
    total = 0
    for i in np.argsort(spread)[::-1]:
        a, b = blocks[int(i)]
        total += int(keep[a:b].sum())
        if total > most:
            break
        chosen[a:b] = keep[a:b]
    return chosen


def _coarse_lag(roll: FloatArray, rate: FloatArray, segments: list[tuple[int, int]], rate_hz: float) -> float:
    """Seconds by which the roll rate comes after the rate of the angle, by cross-correlation; 0 in doubt."""
    most = max(2, round(0.3 * rate_hz))
    lags = np.arange(-most, most + 1)
    score = np.zeros(len(lags))
    power = np.zeros(2)
    for start, stop in segments:
        if stop - start < 6 * most:
            continue
        slope = np.gradient(roll[start:stop]) * rate_hz
        other = rate[start:stop]
        if not (np.isfinite(slope).all() and np.isfinite(other).all()):
            continue
        slope, other = slope - slope.mean(), other - other.mean()
        power += np.array([slope @ slope, other @ other])
        core = slice(most, len(slope) - most)
        score += [float(slope[core] @ other[most + lag : len(other) - most + lag]) for lag in lags]
    best = int(np.argmax(score))
    if power.min() <= 0 or score[best] < 0.6 * np.sqrt(power[0] * power[1]) or best in (0, len(lags) - 1):
        return 0.0
    left, mid, right = score[best - 1 : best + 2]
    return float((lags[best] + 0.5 * (left - right) / (left - 2 * mid + right)) / rate_hz)


def collect(
    prepared: Prepared, roll: RollSource | None, least_excitation: float, most_rows: int
) -> RollData | None:
    """Cut the excited stretches out of a prepared drive; None where nothing is left."""
    if not prepared.segments:
        return None
    rate_hz = prepared.rate_hz
    accel = prepared.columns["accel_y"]
    inside = np.zeros(len(accel), dtype=bool)
    for segment in prepared.segments:
        inside[segment.start : segment.stop] = True
    level = prepared.standstill_offset.get("accel_y", (0.0, 0.0))[0]
    keep = _capped(lively(accel, inside, rate_hz, least_excitation, level), accel, rate_hz, most_rows)
    pieces: list[tuple[int, int]] = []
    for segment in prepared.segments:
        for first, past in runs(keep[segment.start : segment.stop]):
            if past - first >= 2 * rate_hz:
                pieces.append((segment.start + first, segment.start + past))
    if not pieces:
        return None
    use_angle = roll is not None and roll.kind != "gyro_gravity"
    columns = {"accel": accel}
    if use_angle and roll is not None:
        columns["roll"] = roll.angle
    for name, column in (("rate", "roll_rate"), ("yaw", "yaw_rate")):
        if column in prepared.columns:
            columns[name] = prepared.columns[column]
    against_axles = use_angle and roll is not None and roll.against == "axles"
    found = _cut(columns, pieces, rate_hz, against_axles)
    return replace(found, rate_with_accel="roll_rate" in prepared.together)


def _cut(
    columns: dict[str, FloatArray], pieces: list[tuple[int, int]], rate_hz: float, against_axles: bool
) -> RollData:
    """The pieces of all columns, cut together and low-passed alike to the band that holds motion."""
    rows = np.concatenate([np.arange(a, b) for a, b in pieces])
    lengths = np.array([b - a for a, b in pieces])
    stops = np.cumsum(lengths)
    starts = stops - lengths
    segments = list(zip(starts.tolist(), stops.tolist(), strict=True))
    band, slow_share = lively_band(columns["accel"], pieces, rate_hz)
    lag = 0.0
    if "roll" in columns and "rate" in columns:
        lag = _coarse_lag(columns["roll"][rows], columns["rate"][rows], segments, rate_hz)
    cut: dict[str, FloatArray] = {}
    for name, column in columns.items():
        parts = [_narrowed(column[a:b], rate_hz, band) for a, b in pieces]
        cut[name] = np.concatenate(parts)
    nothing = np.full(len(rows), np.nan)
    angle, rate, yaw = (cut.get(name, nothing) for name in ("roll", "rate", "yaw"))
    has_yaw = bool(np.isfinite(yaw).all())
    if lag:
        moved = Shifter(np.nan_to_num(rate), starts, stops, rate_hz).delayed(-lag)
        rate = np.where(np.isfinite(rate), moved, np.nan)
    scored = _scored(len(rows), segments, rate_hz, band)
    return RollData(
        step_s=1 / rate_hz,
        rows=rows,
        starts=starts,
        stops=stops,
        accel=cut["accel"],
        roll=np.where(scored, angle, np.nan),
        rate=np.where(scored, rate, np.nan),
        whole_roll=angle,
        whole_rate=rate,
        yaw=yaw if has_yaw else np.zeros(len(rows)),
        shifter=Shifter(cut["accel"], starts, stops, rate_hz, held=True),
        yaw_shifter=Shifter(yaw, starts, stops, rate_hz, held=True) if has_yaw else None,
        against_axles=against_axles,
        has_roll=bool(np.isfinite(angle[scored]).any()),
        has_rate=bool(np.isfinite(rate[scored]).any()),
        has_yaw=has_yaw,
        rate_shift_s=lag,
        band_hz=band,
        slow_share=slow_share,
        drive_rows=len(columns["accel"]),
    )


def _narrowed(part: FloatArray, rate_hz: float, band_hz: float) -> FloatArray:
    """A piece of a column, low-passed to the band; one with holes counts as missing."""
    if not np.isfinite(part).all():
        return np.full(len(part), np.nan)
    return lowpass(part, rate_hz, band_hz) if band_hz < 0.45 * rate_hz else part


def _scored(n: int, segments: list[tuple[int, int]], rate_hz: float, band_hz: float) -> BoolArray:
    """Rows that are compared with the model: at twice the band, and not at the ends, where the filters settle."""
    scored = np.zeros(n, dtype=bool)
    every = max(1, int(rate_hz / (2 * band_hz)))
    edge = round(max(EDGE_S, 0.5 / band_hz) * rate_hz)
    for start, stop in segments:
        scored[start + edge : stop - edge : every] = True
    return scored
