"""The same zero-phase low-pass for every column, so that inputs and outputs of a model stay comparable."""

from __future__ import annotations

import numpy as np
from scipy.signal import butter, sosfiltfilt

from pipelines.results import FloatArray

ORDER = 4
PAD_PERIODS = 6


def lowpass(values: FloatArray, rate_hz: float, cutoff_hz: float) -> FloatArray:
    """Butterworth of order 4, forward and backward: no delay, half the amplitude (-6 dB) at `cutoff_hz`.

    values: (n,) finite, evenly spaced. The ends are continued by turning the signal about its end points for six
    periods of the cutoff, so that a drive that starts in a corner is not pulled to zero. Left alone where the rate is
    too low for the cutoff or there are fewer than four samples.
    """
    if cutoff_hz >= 0.45 * rate_hz or len(values) < 4:
        return np.array(values, dtype=np.float64)
    sections = butter(ORDER, cutoff_hz, btype="low", fs=rate_hz, output="sos")
    pad = min(len(values) - 1, round(PAD_PERIODS * rate_hz / cutoff_hz))
    return np.asarray(sosfiltfilt(sections, values, padtype="odd", padlen=pad), dtype=np.float64)
