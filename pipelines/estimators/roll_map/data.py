"""What the roll fit works on: excited stretches of the drive, cut together, with their input ready to be delayed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from parsers.channels import IntArray
from pipelines.estimators.roll_map.spectrum import Band, Shifter, motion_band, sharpened
from pipelines.prepare.bends import road_share
from pipelines.prepare.lowpass import lowpass
from pipelines.prepare.prepared import BoolArray, Prepared
from pipelines.prepare.roll_angle import RollSource
from pipelines.prepare.spans import runs
from pipelines.results import FloatArray

PROBE_ROWS = 256
EDGE_S = 0.3
LOWEST_BAND_HZ = 0.8
WINDOW_S = 6.0
"""The filter's ends are not scored for EDGE_S; WINDOW_S around lively lateral acceleration are kept."""


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
    clean_shifter: Shifter
    band: Band | None
    yaw_shifter: Shifter | None
    against_axles: bool
    has_roll: bool
    has_rate: bool
    has_yaw: bool
    rate_shift_s: float
    band_hz: float
    top_hz: float
    every: int
    slow_share: float
    input_noise: float
    drive_rows: int
    rate_with_accel: bool = False

    @property
    def size(self) -> int:
        """Rows in use."""
        return len(self.rows)

    @cached_property
    def banked_share(self) -> float:
        """How much of the input's power a road's bends may have made, which may lean: slow, and no turn that only pads have."""
        yaw = self.yaw if self.has_yaw else None
        return min(max(self.slow_share, 0.0), 1.0) * road_share(yaw, self.accel, self.step_s, self.starts)

    @cached_property
    def taken(self) -> tuple[IntArray, IntArray, IntArray]:
        """The rows that are compared with the model, and where each segment's start and stop among them."""
        taken = scored_rows(self.starts, self.stops, self.every, 1 / self.step_s)
        return taken, np.searchsorted(taken, self.starts), np.searchsorted(taken, self.stops)

    def cleaned(self) -> RollData:
        """The same with the part of the input that is motion."""
        return replace(self, shifter=self.clean_shifter)

    def probe(self, *, angle: bool = False) -> RollData:
        """A single sample amid quiet on the same channels: 1 m/s² of the acceleration, or 1 rad of the measured angle.

        Where gravity's part is taken out, the angle's noise goes into the input as well (`holds_course`).
        """
        starts, stops = np.array([0]), np.array([PROBE_ROWS])
        sample, quiet = np.zeros(PROBE_ROWS), np.zeros(PROBE_ROWS)
        sample[PROBE_ROWS // 2] = 1.0
        if not self.whole:
            sample = lowpass(sample, 1 / self.step_s, self.band_hz)
        accel, roll = (quiet, sample) if angle else (sample, quiet)
        nothing = np.full(PROBE_ROWS, np.nan)
        return replace(
            self,
            rows=np.arange(PROBE_ROWS),
            starts=starts,
            stops=stops,
            accel=accel,
            roll=roll if self.has_roll else nothing,
            rate=quiet if self.has_rate else nothing,
            whole_roll=roll,
            whole_rate=quiet,
            yaw=quiet,
            shifter=Shifter(accel, starts, stops, 1 / self.step_s, held=True),
            clean_shifter=Shifter(accel, starts, stops, 1 / self.step_s, held=True, band=self.band),
            yaw_shifter=None,
        )

    @property
    def whole(self) -> bool:
        """Whether the whole band is in use."""
        return self.band_hz >= 0.45 / self.step_s

    @property
    def quickness(self) -> float:
        """rad/s: RMS of the acceleration's rate of change over its own RMS."""
        pieces = [self.accel[i:j] for i, j in zip(self.starts, self.stops, strict=True)]
        change = sum(float(np.sum(np.diff(piece) ** 2)) for piece in pieces) / self.step_s**2
        spread = float(np.sum((self.accel - self.accel.mean()) ** 2))
        return float(np.sqrt(change / max(spread, 1e-12)))

    @cached_property
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


LAGS_S = (0.3, 1.0)
"""Within which the roll rate and the angle's rate are looked for in step: filters' lags, and those of channels by way of another unit."""


def _coarse_lag(roll: FloatArray, rate: FloatArray, segments: list[tuple[int, int]], rate_hz: float) -> float:
    """Seconds by which the roll rate comes after the rate of the angle, by cross-correlation; 0 in doubt."""
    found = (_lag_within(reach, roll, rate, segments, rate_hz) for reach in LAGS_S)
    return next((lag for lag in found if lag is not None), 0.0)


def _lag_within(
    reach_s: float, roll: FloatArray, rate: FloatArray, segments: list[tuple[int, int]], rate_hz: float
) -> float | None:
    """None where they go together nowhere within it, or best at its end."""
    most = max(2, round(reach_s * rate_hz))
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
        return None
    left, mid, right = score[best - 1 : best + 2]
    return float((lags[best] + 0.5 * (left - right) / (left - 2 * mid + right)) / rate_hz)


def collect(
    prepared: Prepared,
    roll: RollSource | None,
    least_excitation: float,
    most_rows: int,
    *,
    wide: bool = False,
) -> RollData | None:
    """Cut the excited stretches out of a prepared drive; None where nothing is left. wide: the whole band (see `fit_best`)."""
    if not prepared.segments:
        return None
    rate_hz = prepared.rate_hz
    accel = prepared.columns["accel_y"]
    inside = np.zeros(len(accel), dtype=bool)
    for segment in prepared.segments:
        inside[segment.start : segment.stop] = True
    level = prepared.standstill_offset.get("accel_y", (0.0, 0.0))[0]
    keep = _capped(lively(accel, inside, rate_hz, least_excitation, level), accel, rate_hz, 2 * most_rows)
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
    found = _cut(columns, pieces, rate_hz, prepared.cutoff_hz, against_axles, wide)
    return replace(found, rate_with_accel="roll_rate" in prepared.together)


def _cut(
    columns: dict[str, FloatArray],
    pieces: list[tuple[int, int]],
    prepared_hz: float,
    cutoff_hz: float,
    against_axles: bool,
    wide: bool,
) -> RollData:
    """The pieces of all columns, cut together and taken at twice the cutoff; low-passed to the lively band unless `wide`."""
    rows = np.concatenate([np.arange(a, b, 2) for a, b in pieces])
    rate_hz = prepared_hz / 2
    lengths = np.array([(b - a + 1) // 2 for a, b in pieces])
    stops = np.cumsum(lengths)
    starts = stops - lengths
    segments = list(zip(starts.tolist(), stops.tolist(), strict=True))
    cut = {name: _whole(column, pieces, prepared_hz, cutoff_hz) for name, column in columns.items()}
    band = motion_band(cut["accel"], segments, rate_hz)
    every, band_hz = 1, rate_hz / 2
    if not wide:
        band_hz = min(max(1.2 * band.sure_hz, LOWEST_BAND_HZ), rate_hz / 2)
        every = max(1, int(rate_hz / (2 * band_hz)))
        cut = {name: _narrowed(column, segments, band_hz, rate_hz) for name, column in cut.items()}
    lag = 0.0
    if "roll" in cut and "rate" in cut:
        lag = _coarse_lag(cut["roll"], cut["rate"], segments, rate_hz)
    nothing = np.full(len(rows), np.nan)
    angle, rate, yaw = (cut.get(name, nothing) for name in ("roll", "rate", "yaw"))
    has_yaw = bool(np.isfinite(yaw).all())
    if lag:
        moved = Shifter(np.nan_to_num(rate), starts, stops, rate_hz).delayed(-lag)
        rate = np.where(np.isfinite(rate), moved, np.nan)
    scored = np.zeros(len(rows), dtype=bool)
    scored[scored_rows(starts, stops, every, rate_hz)] = True
    accel = cut["accel"]
    return RollData(
        step_s=1 / rate_hz,
        rows=rows,
        starts=starts,
        stops=stops,
        accel=accel,
        roll=np.where(scored, angle, np.nan),
        rate=np.where(scored, rate, np.nan),
        whole_roll=angle,
        whole_rate=rate,
        yaw=yaw if has_yaw else np.zeros(len(rows)),
        shifter=Shifter(cut["accel"], starts, stops, rate_hz, held=True),
        clean_shifter=Shifter(cut["accel"], starts, stops, rate_hz, held=True, band=band),
        band=band,
        yaw_shifter=Shifter(yaw, starts, stops, rate_hz, held=True) if has_yaw else None,
        against_axles=against_axles,
        has_roll=bool(np.isfinite(angle[scored]).any()),
        has_rate=bool(np.isfinite(rate[scored]).any()),
        has_yaw=has_yaw,
        rate_shift_s=lag,
        band_hz=band_hz,
        top_hz=band.top_hz,
        every=every,
        slow_share=band.slow_share,
        input_noise=band.noise / 2,
        drive_rows=len(columns["accel"]),
    )


def _whole(column: FloatArray, pieces: list[tuple[int, int]], rate_hz: float, cutoff_hz: float) -> FloatArray:
    """The pieces of a column at half the rate; one with holes counts as missing."""
    parts = [column[a:b] for a, b in pieces]
    return np.concatenate(
        [
            sharpened(part, rate_hz, cutoff_hz)
            if np.isfinite(part).all()
            else np.full((len(part) + 1) // 2, np.nan)
            for part in parts
        ]
    )


def _narrowed(
    column: FloatArray, segments: list[tuple[int, int]], band_hz: float, rate_hz: float
) -> FloatArray:
    """A column low-passed to the band; a segment with holes counts as missing."""
    out = np.full(len(column), np.nan)
    for start, stop in segments:
        if np.isfinite(column[start:stop]).all():
            out[start:stop] = lowpass(column[start:stop], rate_hz, band_hz)
    return out


def scored_rows(starts: IntArray, stops: IntArray, every: int, rate_hz: float) -> IntArray:
    """Rows that are compared with the model: at twice the band, and not at the ends, where the filters settle."""
    edge = max(round(EDGE_S * rate_hz), every)
    return np.concatenate([np.arange(a + edge, b - edge, every) for a, b in zip(starts, stops, strict=True)])
