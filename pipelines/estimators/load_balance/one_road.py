"""The wheelbase by the road: the rear wheels meet every bump of it a wheelbase after the front ones.

With the phases of what front and rear springs do at a frequency w, at a speed v,

    arg R - arg F = phi(w) - w L / v

phi is the two axles' own (other springs, other hubs, a late channel) and the same at every speed; L alone turns with 1 / v. So the
front's column is read L back along the way, and the L is sought for which the products of both spectra, window by window, point
the same way at each frequency, whichever that is:

    C(L) = sum over w of |sum over windows of R conj(F_L) / (|R| |F_L|)|

The balances know the wheelbase by the vehicle file alone, and a wrong one goes with its square into the pitch inertia without
contradicting anything. This needs neither mass nor springs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipelines.evidence import Evidence, FloatArray, Values
from pipelines.joint.vehicle.unknowns import Known
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.prepare.spline import spline_at

ComplexArray = NDArray[np.complex128]

CARRIER = "both axles over one road"
TITLE = "rear wheels on the road of the front ones"
SEEN_IN = ("suspension_deflection", "suspension_force", "tire_normal_force")
"""Signals of a front and a rear wheel of one side that a road shakes, the first that is there."""

LOW_HZ, LEAST_BAND_HZ = 3.0, 2.0
"""Below it the body rolls and nods, front and rear at once, above it wheels follow the road; and how much above it must be left."""

WINDOW_S = 2.0
SLOWEST = 2.0
"""m/s that a window is driven at throughout: slower the way back is no time at all, or hours."""

FROM, TO, STEP = 0.72, 1.4, 0.015
"""Wheelbases that are tried, over the one that was known before."""

MOST_WINDOWS, LEAST_WINDOWS = 400, 40
PARTS = 10
"""Parts of the drive that are left out in turn for the spread."""

CLEAR, CONTRAST = 15.0, 1.02
"""Standard deviations of C without any common road that its peak must rise by, and its peak over its median: at one speed every
length does as well as the next, as the axles' own phases make up for it."""

LARGEST_STD = 0.01
MODEL_ERROR = 0.02
"""Over the wheelbase: the largest spread between parts with which it is told, and what speeds and the wheels' own way are off by
(speedometers by one to two per cent; a hub goes back by up to a tenth of its travel)."""


@dataclass(frozen=True)
class SeenLength:
    """Distance of the axles by the road, m; std: between parts of the drive; clear: how far the peak stands out, standard deviations."""

    length: float
    std: float
    clear: float


def _band(column: FloatArray, rate_hz: float, high_hz: float) -> FloatArray:
    """The column between LOW_HZ and high_hz, zero phase."""
    n = len(column)
    frequency = np.fft.rfftfreq(n, 1 / rate_hz)
    return np.fft.irfft(np.fft.rfft(column) * ((frequency >= LOW_HZ) & (frequency <= high_hz)), n)


def _windows(speed: FloatArray, size: int, step: int) -> FloatArray:
    """First rows of the windows that are driven at SLOWEST throughout."""
    slow = np.concatenate(([0], np.cumsum(speed < SLOWEST)))
    first = np.arange(0, len(speed) - size + 1, step)
    return np.asarray(first[slow[first + size] == slow[first]])


def _turned(
    prepared: Prepared, segment: Segment, pairs: list[tuple[str, str]], speed: FloatArray, lengths: FloatArray, step: int
) -> ComplexArray | None:  # fmt: skip
    """(L, windows, frequencies) products of both spectra, over all pairs; None where nothing of the segment can be used."""
    rows = slice(segment.start, segment.stop)
    rate, size = prepared.rate_hz, round(WINDOW_S * prepared.rate_hz)
    here = [[prepared.columns[name][rows] for name in pair] for pair in pairs]
    v = np.maximum(speed[rows], 0.0)
    if len(v) < 2 * size:
        return None
    time = np.arange(len(v)) / rate
    way = np.concatenate(([0.0], np.cumsum(0.5 * (v[1:] + v[:-1])) / rate)) + 1e-9 * np.arange(len(v))
    first = _windows(v, size, step)
    # the front's own record reaches back far enough
    first = first[way[first] > lengths[-1]]
    if len(first) == 0:
        return None
    taken = first[:, None] + np.arange(size)
    frequency = np.fft.rfftfreq(size, 1 / rate)
    used = (frequency >= LOW_HZ) & (frequency <= prepared.cutoff_hz)
    shape = np.hanning(size)
    fronts, rears = zip(*([_band(c, rate, prepared.cutoff_hz) for c in pair] for pair in here), strict=True)
    behind = [np.fft.rfft(rear[taken] * shape)[:, used] for rear in rears]
    found = np.zeros((len(lengths), len(first), int(used.sum())), dtype=np.complex128)
    for i, length in enumerate(lengths.tolist()):
        back = np.interp(way - length, way, time)
        for front, rear in zip(fronts, behind, strict=True):
            ahead = np.fft.rfft(spline_at(time, front, back)[taken] * shape)[:, used]
            power = np.mean(np.abs(ahead) ** 2, axis=1) * np.mean(np.abs(rear) ** 2, axis=1)
            found[i] += rear * np.conj(ahead) / np.sqrt(np.maximum(power, 1e-300))[:, None]
    return found


def _alike(products: ComplexArray) -> FloatArray:
    """(L,) C."""
    return np.asarray(np.abs(products.sum(axis=1)).sum(axis=1))


def _peak(products: ComplexArray, lengths: FloatArray) -> float:
    """The length at which C is largest, between the steps; NaN at an end."""
    total = _alike(products)
    i = int(np.argmax(total))
    if i in (0, len(lengths) - 1):
        return math.nan
    before, at, after = total[i - 1 : i + 2]
    return float(lengths[i] + 0.5 * (before - after) / (before - 2 * at + after) * (lengths[1] - lengths[0]))


def _clear(products: ComplexArray) -> float:
    """By how many of its standard deviations the largest C is above that of windows which point anywhere."""
    power = np.sum(np.abs(products) ** 2, axis=1)
    usual = np.sum(np.sqrt(0.25 * math.pi * power), axis=1)
    # windows overlap by half and their neighbouring frequencies by as much: each tells half
    spread = np.sqrt(np.sum(4 * (1 - 0.25 * math.pi) * power, axis=1))
    return float(np.max((_alike(products) - usual) / spread))


def seen_length(prepared: Prepared, speed: FloatArray, expected: float) -> SeenLength | None:
    """The wheelbase by the road. speed: (n,) m/s. expected: about how long, m. None where no road shows it."""
    pairs = _pairs(prepared.columns)
    if not pairs or prepared.cutoff_hz < LOW_HZ + LEAST_BAND_HZ:
        return None
    lengths = expected * np.arange(FROM, TO, STEP)
    rows = sum(s.stop - s.start for s in prepared.segments)
    step = max(round(0.5 * WINDOW_S * prepared.rate_hz), rows // MOST_WINDOWS)
    whole = _whole(prepared, pairs, speed)
    parts = [_turned(prepared, s, pairs, speed, lengths, step) for s in whole]
    there = [p for p in parts if p is not None]
    if sum(p.shape[1] for p in there) < LEAST_WINDOWS:
        return None
    products = np.concatenate(there, axis=1)
    count = products.shape[1]
    part = np.arange(count) * PARTS // count
    without = np.array([_peak(products[:, part != k], lengths) for k in range(PARTS)])
    length, clear = _peak(products, lengths), _clear(products)
    std = math.sqrt((PARTS - 1) * float(np.var(without)))
    total = _alike(products)
    told = clear > CLEAR and float(total.max()) > CONTRAST * float(np.median(total))
    # NaN where a peak lies at an end
    return SeenLength(length, std, clear) if told and std < LARGEST_STD * length else None


def _whole(prepared: Prepared, pairs: list[tuple[str, str]], speed: FloatArray) -> list[Segment]:
    """Stretches of the drive in which speed and all of the pairs are there: channels of several buses begin some rows apart."""
    there = np.isfinite(speed)
    for pair in pairs:
        for name in pair:
            there = there & np.isfinite(prepared.columns[name])
    found = []
    for segment in prepared.segments:
        edges = np.flatnonzero(np.diff(there[segment.start : segment.stop], prepend=False, append=False))
        found += [
            Segment(segment.start + a, segment.start + b)
            for a, b in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
        ]
    return found


def _pairs(columns: Mapping[str, FloatArray]) -> list[tuple[str, str]]:
    """Front and rear signal of each side."""
    for form in SEEN_IN:
        found = [(f"{form}_f{side}", f"{form}_r{side}") for side in "lr"]
        if there := [pair for pair in found if all(name in columns for name in pair)]:
            return there
    return []


def road_evidence(prepared: Prepared, speed: FloatArray | None, known: Known) -> tuple[Evidence, ...]:
    """The wheelbase as a relation of its own; none where the road does not show it."""
    expected = float(known.mean[known.index("wheelbase")])
    seen = None if speed is None else seen_length(prepared, speed, expected)
    if seen is None:
        return ()

    def predict(values: Values) -> FloatArray:
        length = np.asarray(values["wheelbase"])
        return length[None] if length.ndim else np.array([length])

    variance = seen.std**2 + (MODEL_ERROR * seen.length) ** 2
    return (
        Evidence(
            "length", CARRIER, TITLE, "load_balance", np.array([seen.length]), np.array([[variance]]), predict, ("wheelbase",)
        ),
    )  # fmt: skip
