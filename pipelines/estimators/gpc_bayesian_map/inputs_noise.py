"""What noise of the inputs does to a fit of the outputs: it pulls parameters to where the model answers less to its input.

The residual holds what the model makes of the noise, and so do its derivatives: the mean of their product does not vanish, and no more data make it
smaller. It is had by running the model on inputs with as much noise again. How large the noise is, is seen above the band only, where inputs may hold
more than noise: the shift goes into the spread and is not taken out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pipelines.estimators.base_excitation.blocks import ComplexArray
from pipelines.estimators.gpc_bayesian_map.data import ModelData
from pipelines.results import FloatArray

ABOVE, BELOW = 1.2, 0.8
"""From where to where inputs are taken for noise: of the band's upper end, and of the low-pass."""

AGAIN = 4
"""Times that noise is drawn."""

ROUNDS = 3
"""Times that the pull is asked for at the place that it leaves."""

Slopes = Callable[[ModelData, FloatArray], tuple[ComplexArray, ComplexArray]]
"""Of data and a place (d,): derivatives of the predictions (d, b, f, o), and the residual (b, f, o)."""


def noise_of_inputs(data: ModelData, cutoff_hz: float) -> FloatArray:
    """(i,) standard deviation of white noise of each input on the grid: the median power of the blocks above the band."""
    blocks = data.blocks
    frequency = np.fft.rfftfreq(blocks.rows, data.step_s)
    quick = (frequency > ABOVE * blocks.frequency_hz[-1]) & (frequency < BELOW * cutoff_hz)
    found = np.zeros(data.inputs.shape[1])
    if quick.sum() < 3:
        return found
    window = np.hanning(blocks.rows)
    for i, column in enumerate(data.inputs.T):
        spectrum = np.fft.rfft(blocks.cut(np.ascontiguousarray(column)) * window, axis=1)[:, quick]
        # the power of noise in a bin is exponential: its median is ln 2 of its mean
        found[i] = np.sqrt(np.median(np.abs(spectrum) ** 2) / (np.log(2) * np.sum(window**2)))
    return found


def shift_by_inputs(
    data: ModelData, std: FloatArray, slopes: Slopes, power: FloatArray, place: FloatArray, prior: FloatArray
) -> FloatArray:
    """(d,) by how much noise of the inputs has moved a MAP. std (i,) as of `noise_of_inputs`; power (f, o) of the residual; prior (d, d): precision.

    The pull is that of the true place, which is the MAP less the shift: so it is asked for there.
    """
    rng = np.random.default_rng(0)
    louder = [
        replace(data, inputs=data.inputs + std * rng.standard_normal(data.inputs.shape)) for _ in range(AGAIN)
    ]
    shift, furthest = np.zeros(len(place)), 2 / np.sqrt(np.diag(prior))
    for _ in range(ROUNDS):
        at = place - shift
        plain, residual = slopes(data, at)
        information = np.einsum("pbfo,qbfo,fo->pq", plain.conj(), plain, 2 / power).real + prior
        pull = np.zeros(len(place))
        for noisy in louder:
            more, left = slopes(noisy, at)
            pull += (
                np.einsum("pbfo,bfo,fo->p", (more - plain).conj(), left - residual, 2 / power).real / AGAIN
            )
        shift = np.clip(np.linalg.solve(information, pull), -furthest, furthest)
    return np.asarray(shift)
