"""The density of a column of samples: a Gaussian kernel laid over a fine histogram, so that its cost is in the counting."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.channels import FloatArray
from parsers.errors import ExpansionError

BINS_A_WIDTH = 8
MOST_BINS = 1 << 16
REACH = 4.0
"""Bins for one kernel width, bins at most, and widths beyond the outermost sample."""


@dataclass(frozen=True)
class Density:
    """value: (n,), equal steps. density: (n,), its integral over them 1. width: of the kernel, standard deviation.

    Where the true density jumps, the estimate is smeared over about two widths.
    """

    value: FloatArray
    density: FloatArray
    width: float

    def at(self, value: FloatArray) -> FloatArray:
        """The density at other values, as `value` in shape; 0 outside."""
        return np.asarray(np.interp(value, self.value, self.density, left=0.0, right=0.0))


def estimate_density(samples: FloatArray) -> Density:
    """The density of independent samples (n,), by Silverman's kernel width.

    Raises ExpansionError where all samples are the same, or one is not finite.
    """
    if samples.ndim != 1 or len(samples) < 2:
        raise ValueError("a density needs a column of at least two samples")
    low, high = float(samples.min()), float(samples.max())
    if not np.isfinite(high - low):
        raise ExpansionError("samples are not finite, they have no density")
    quarters = np.quantile(samples, (0.25, 0.75))
    # more than half of the samples may share one value: then the quartiles say nothing
    spreads = [each for each in (float(samples.std()), float(quarters[1] - quarters[0]) / 1.349) if each > 0]
    width = 0.9 * min(spreads, default=0.0) * len(samples) ** -0.2
    if not width > 1e-14 * max(abs(low), abs(high)):
        raise ExpansionError("the output does not vary, it has no density")
    low, high = low - REACH * width, high + REACH * width
    bins = int(min(MOST_BINS, max(512, np.ceil((high - low) / width * BINS_A_WIDTH))))
    step = (high - low) / bins
    counts = np.histogram(samples, bins, (low, high))[0].astype(float)
    return Density(
        low + step * (np.arange(bins) + 0.5), _smooth(counts, width / step) / (len(samples) * step), width
    )


def _smooth(counts: FloatArray, width: float) -> FloatArray:
    """counts (n,) with a Gaussian of `width` bins laid over each: through the spectrum, with room for its tails."""
    size = 2 * len(counts)
    frequency = np.fft.rfftfreq(size)
    shape = np.exp(-2 * np.square(np.pi * frequency * width))
    smooth = np.fft.irfft(np.fft.rfft(counts, size) * shape, size)[: len(counts)]
    # rounding of the transform leaves small negatives
    return np.maximum(smooth, 0.0)
