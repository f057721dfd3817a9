"""Columns cut into blocks and seen in a frequency band: the common ground of both batch fits.

Within a band the residual of a model is taken as noise of an unknown, smooth spectrum, the same in all blocks. Offsets,
slow drift and gravity lie below the band, what the low-pass or the sensors took away lies above it. Blocks need no
joint history, so that gaps cost only themselves; their scatter shows how far the noise is from what was assumed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipelines.results import FloatArray

ComplexArray = NDArray[np.complex128]
SMOOTH_HZ = 0.4
"""Half width over which the residual's spectrum is smoothed."""


@dataclass(frozen=True)
class Blocks:
    """first: (b,) first rows of the blocks, each `rows` long. frequency_hz: (f,) of the band's bins."""

    first: NDArray[np.int64]
    rows: int
    rate_hz: float
    frequency_hz: FloatArray
    bins: NDArray[np.int64]

    @property
    def count(self) -> int:
        """How many."""
        return len(self.first)

    def cut(self, column: FloatArray) -> FloatArray:
        """The column's blocks, (b, rows)."""
        return np.asarray(column[self.first[:, None] + np.arange(self.rows)])

    def seen(self, column: FloatArray) -> ComplexArray:
        """The column in the band, (b, f); white noise of variance v has E|.|² = v."""
        return np.asarray(np.fft.rfft(self.cut(column), axis=1)[:, self.bins] / np.sqrt(self.rows))

    def only(self, keep: NDArray[np.bool_]) -> Blocks:
        """The blocks of `keep` (b,)."""
        return Blocks(self.first[keep], self.rows, self.rate_hz, self.frequency_hz, self.bins)


def lay_blocks(
    stretches: Sequence[tuple[int, int]], rate_hz: float, length_s: float, band_hz: tuple[float, float]
) -> Blocks:
    """Blocks side by side in `stretches` (first row, row past the last), what is left over at their ends is not used."""
    rows = max(8, round(length_s * rate_hz))
    first = [np.arange(start, stop - rows + 1, rows) for start, stop in stretches]
    frequency = np.asarray(np.fft.rfftfreq(rows, 1 / rate_hz), dtype=np.float64)
    bins = np.flatnonzero((frequency >= band_hz[0]) & (frequency <= band_hz[1]))
    joined = np.concatenate(first) if first else np.zeros(0)
    return Blocks(joined.astype(np.int64), rows, rate_hz, frequency[bins], bins)


def smooth_spectrum(residual: ComplexArray, blocks: Blocks) -> FloatArray:
    """Power of `residual` (b, f) by frequency, over all blocks and SMOOTH_HZ either side, (f,), never 0."""
    power = np.mean(np.abs(residual) ** 2, axis=0)
    half = min(max(1, round(SMOOTH_HZ * blocks.rows / blocks.rate_hz)), len(power) - 1)
    wide = np.pad(power, half, mode="reflect")
    total = np.concatenate(([0.0], np.cumsum(wide)))
    smooth = (total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1)
    return np.asarray(np.maximum(smooth, 1e-12 * max(float(power.max()), 1e-30)))


def noise_floor(power: FloatArray, blocks: Blocks) -> float:
    """The level of white noise that a smoothed spectrum shows: its low end, for all above it may be something else.

    power: (f,), relative to what noise of unit variance would give. A tenth of the bins of pure
    noise lie below the tenth quantile of chi-square (Wilson and Hilferty's formula), which is set right here.
    """
    half = min(max(1, round(SMOOTH_HZ * blocks.rows / blocks.rate_hz)), len(power) - 1)
    share = 2 / (9 * 2 * blocks.count * (2 * half + 1))
    usual = (1 - share - 1.2816 * np.sqrt(share)) ** 3
    return float(np.quantile(power, 0.1) / usual)


def normal_equations(
    slopes: ComplexArray, residual: ComplexArray, power: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Information (p, p) and each block's score (b, p) of a model with `slopes` (p, b, f) and `residual` (b, f).

    Every complex bin counts as two real samples of half the power each.
    """
    weighted = slopes.conj() * (2.0 / power)
    flat = weighted.reshape(len(slopes), -1)
    information = (flat @ slopes.reshape(len(slopes), -1).T).real
    score = np.einsum("pbf,bf->bp", weighted, residual).real
    return np.asarray(information, dtype=np.float64), np.asarray(score, dtype=np.float64)


def block_covariance(
    information: FloatArray, prior_information: FloatArray, score: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Covariance of the estimate as white noise would have it, and as the scatter of the blocks' scores shows it.

    information, prior_information: (p, p). score: (b, p) at the estimate. The second is never below the first: with a
    dozen blocks their scatter is too uncertain to promise less.
    """
    inverse = np.linalg.inv(information + prior_information)
    white = inverse
    count = len(score)
    centred = score - score.mean(axis=0)
    scatter = centred.T @ centred * count / max(count - 1, 1)
    seen = inverse @ (scatter + prior_information) @ inverse
    grown = np.sqrt(np.maximum(np.diag(seen) / np.diag(white), 1.0))
    return np.asarray(white, dtype=np.float64), np.asarray(white * np.outer(grown, grown))
