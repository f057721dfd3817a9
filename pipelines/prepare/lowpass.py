"""The same zero-phase low-pass for every column, so that inputs and outputs of a model stay comparable."""

from __future__ import annotations

import functools

import numpy as np
from scipy.signal import butter, sosfiltfilt

from pipelines.results import FloatArray

ORDER = 4
PAD_PERIODS = 6


@functools.lru_cache(maxsize=64)
def _sections(rate_hz: float, cutoff_hz: float) -> FloatArray:
    """The filter's second-order sections: the same for every column of a drive, and dear beside a short one."""
    return np.asarray(butter(ORDER, cutoff_hz, btype="low", fs=rate_hz, output="sos"), dtype=np.float64)


def lowpass(values: FloatArray, rate_hz: float, cutoff_hz: float) -> FloatArray:
    """Butterworth of order 4, forward and backward: no delay, half the amplitude (-6 dB) at `cutoff_hz`.

    values: (n,) finite, evenly spaced. The ends are continued by turning the signal about its end points for six
    periods of the cutoff, so that a drive that starts in a corner is not pulled to zero. Left alone where the rate is
    too low for the cutoff or there are fewer than four samples.
    """
    if cutoff_hz >= 0.45 * rate_hz or len(values) < 4:
        return np.array(values, dtype=np.float64)
    sections = _sections(rate_hz, cutoff_hz)
    pad = min(len(values) - 1, round(PAD_PERIODS * rate_hz / cutoff_hz))
    return np.asarray(sosfiltfilt(sections, values, padtype="odd", padlen=pad), dtype=np.float64)
