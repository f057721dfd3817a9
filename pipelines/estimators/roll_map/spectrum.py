"""The input's spectrum: what of it is motion and what is noise, and the input read at any delay."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.ndimage import uniform_filter1d
from scipy.signal import welch

from parsers.channels import IntArray
from pipelines.prepare.lowpass import ORDER, PAD_PERIODS, lowpass
from pipelines.results import FloatArray

NOISE_TIMES = 3.0
SURE_POWER, SURE_TIMES = 0.005, 30.0
SLOW_HZ = 0.2
"""Motion is told from noise where the input's power is NOISE_TIMES the noise. It is sure where it is above SURE_POWER of its peak
and SURE_TIMES the noise. Below 0.2 Hz (of the low-pass: of a slalom at 0.25 Hz it leaves 2 % of the power) roads' banks change as well."""


@dataclass(frozen=True)
class Band:
    """What of an input is motion. frequency_hz, gain: (k,) how much of each frequency is kept, from 1 down to 0.

    top_hz: where the gain ends. sure_hz: up to where the motion is sure. slow_share: share of the power below SLOW_HZ, each piece less its mean. noise: density of the noise, in units²/Hz.
    """

    frequency_hz: FloatArray
    gain: FloatArray
    top_hz: float
    sure_hz: float
    slow_share: float
    noise: float


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
        band: Band | None = None,
    ) -> None:
        """values: (n,) finite inside the segments. band: what of each frequency is kept."""
        self._n = len(values)
        self._rate = rate_hz
        self._parts = [
            self._part(values[start:stop], start, rate_hz, held, band)
            for start, stop in zip(starts.tolist(), stops.tolist(), strict=True)
        ]
        # a fit asks again and again with the same delay: of some ten slopes one alone moves it
        self._last: dict[str, list[tuple[float, FloatArray]]] = {}

    def _kept(self, what: str, delay_s: float, make: Callable[[float], FloatArray]) -> FloatArray:
        """One of the last two answers where the delay is the same; read-only, as it may be handed out again."""
        last = self._last.setdefault(what, [])
        for known, column in last:
            if known == delay_s:
                return column
        column = make(delay_s)
        column.flags.writeable = False
        self._last[what] = [*last[-1:], (delay_s, column)]
        return column

    @staticmethod
    def _part(part: FloatArray, start: int, rate_hz: float, held: bool, band: Band | None) -> _Part:
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
        if band is not None:
            spectrum = spectrum * np.interp(rate_hz * frequency, band.frequency_hz, band.gain)
        return _Part(
            start, start + len(part), pad, size, spectrum, 2 * np.pi * rate_hz * frequency, first, slope
        )

    def slope(self, delay_s: float) -> FloatArray:
        """(n,) the rate of change per second of the column `delay_s` earlier; zero outside the segments. Read-only."""
        return self._kept("slope", delay_s, self._slope)

    def _slope(self, delay_s: float) -> FloatArray:
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
        """(n,) the column `delay_s` earlier: value(t - delay_s); zero outside the segments. Read-only."""
        return self._kept("delayed", delay_s, self._delayed)

    def _delayed(self, delay_s: float) -> FloatArray:
        out = np.zeros(self._n)
        for part in self._parts:
            moved = irfft(part.spectrum * np.exp(-1j * part.omega * delay_s), n=part.size)
            rows = np.arange(part.pad, part.pad + part.stop - part.start)
            line = part.first + part.slope * (rows - delay_s * self._rate)
            out[part.start : part.stop] = moved[rows[0] : rows[-1] + 1] + line
        return out


def _lines(part: FloatArray, pad: int) -> tuple[NDArray[np.complex128], FloatArray, int]:
    """Spectrum of a column continued by `pad` rows at both ends, less the straight line through its ends; the line; the size."""
    long = np.concatenate((2 * part[0] - part[pad:0:-1], part, 2 * part[-1] - part[-2 : -pad - 2 : -1]))
    line = np.linspace(long[0], long[-1], len(long))
    size = next_fast_len(len(long), real=True)
    return rfft(long - line, n=size), line, size


def sharpened(part: FloatArray, rate_hz: float, cutoff_hz: float) -> FloatArray:
    """Every second sample of a low-passed column, with the low-pass made good up to its cutoff and nothing above.

    Sampled at twice the cutoff, what a Butterworth filter's slope leaves of white noise is not white, and would be taken for
    roll motion. part: (n,) sampled at four times the cutoff. Returns (ceil(n / 2),).
    """
    if len(part) < 4:
        return part[::2].copy()
    pad = min(len(part) - 1, round(PAD_PERIODS * rate_hz / cutoff_hz))
    spectrum, line, size = _lines(part, pad)
    frequency = rate_hz * rfftfreq(size)
    warped = np.tan(np.pi * np.minimum(frequency, cutoff_hz) / rate_hz) / np.tan(np.pi * cutoff_hz / rate_hz)
    spectrum = np.where(frequency <= cutoff_hz, spectrum * (1 + warped ** (2 * ORDER)), 0.0)
    return np.asarray((irfft(spectrum, n=size)[: len(line)] + line)[pad : pad + len(part) : 2])


def motion_band(values: FloatArray, pieces: list[tuple[int, int]], rate_hz: float) -> Band:
    """The part of an input that is motion and not just noise, by frequency (Wiener's gain, 1 - noise/density).

    An input's noise biases a fit that takes the input as it is (errors in variables): where there is more noise than
    motion, the fit learns that the body does not answer, and b and c came out two to three times too large in a slow
    slalom. What Wiener's filter leaves out is independent of what it lets through, so that the fit sees a smaller input and an
    unknown push, and no bias. The noise is the density in the top third of the band, where no vehicle rolls. The gain
    only falls with frequency: nulls of a manoeuvre's spectrum are not cut out.
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
    floor = density[top]
    # the mean, as the median of a spectrum from few stretches is too low; single lines (an engine's) are left out
    noise = float(np.mean(floor[floor <= 3 * np.median(floor)])) if top.any() else 0.0
    sure = np.flatnonzero(density >= max(SURE_POWER * float(density.max()), SURE_TIMES * noise))
    envelope = np.maximum.accumulate(density[::-1])[::-1]
    gain = np.where(envelope >= NOISE_TIMES * noise, 1 - noise / np.maximum(envelope, 1e-300), 0.0)
    strong = np.flatnonzero(gain > 0)
    highest = float(frequency[strong[-1]]) if len(strong) else 0.0
    surest = float(frequency[sure[-1]]) if len(sure) else 0.0
    return Band(frequency, gain, highest, surest, _slow_share(values, pieces, rate_hz), noise)


def _slow_share(values: FloatArray, pieces: list[tuple[int, int]], rate_hz: float) -> float:
    """By a filter, and not by the spectrum above: its lines, of windows of 12 s, are as wide as what tells a slalom from a road's bends."""
    slow = whole = 0.0
    for start, stop in pieces:
        level = values[start:stop] - np.mean(values[start:stop])
        smooth = lowpass(level, rate_hz, SLOW_HZ)
        slow, whole = slow + float(smooth @ smooth), whole + float(level @ level)
    return min(slow / max(whole, 1e-300), 1.0)
