"""gPC-EKF for state-space systems: the compiled parts from which a model's filter is put together (dissertation 3.2, 3.4).

A model's filter is one compiled loop of its own that calls, for each sample,

    points(x, arrays, values)                           additions (51), then states and parameters at the points (13)
    ... its own step: values of the states one sample on, values of the outputs ...
    take(x, values, predicted, z, arrays, work)         coefficients (15), update (38)-(40), covariance addition (49)
    note(x, work, k, record)                            what is kept

(`pipelines.models.mass_spring` is the example; docs/gpc_filter.md shows how to write another.) Rows of x are states, then
parameters. A parameter that must stay positive is kept as its logarithm; `points` hands its value to the model.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from parsers.jit import kernel, lean_kernel
from pipelines.filters.gpc_points import at_points, expand_row
from pipelines.filters.gpc_update import gpc_update_with
from pipelines.results import FloatArray


class FilterArrays(NamedTuple):
    """What does not change over a run.

    basis (S, Q): each term at each point. inverse (Q, S): values to coefficients. additions (n, S): put on the
    coefficients before each step (51). logs (n,): 1 where a row holds a logarithm. variance (m,): R. cross (n, m), inner
    (m, m): D H' and H D H' of the added covariance D (49), (0, 0) for none. states: how many rows are states. form: of the
    update (gpc_update). step_s: of a sample.
    """

    basis: FloatArray
    inverse: FloatArray
    additions: FloatArray
    logs: FloatArray
    variance: FloatArray
    cross: FloatArray
    inner: FloatArray
    states: int
    form: int
    step_s: float


class Work(NamedTuple):
    """Memory of a run: y (m, S) coefficients of the outputs; gains (m, m + 4); error, spread (m,) of the innovation."""

    y: FloatArray
    gains: FloatArray
    error: FloatArray
    spread: FloatArray


class Record(NamedTuple):
    """What a run fills. mean, std (rows, n) after each update; innovation and its std (rows, m).

    coefficients (rows // every, n, S): every so many rows.
    """

    mean: FloatArray
    std: FloatArray
    innovation: FloatArray
    innovation_std: FloatArray
    coefficients: FloatArray
    every: int


@lean_kernel
def points(x: FloatArray, arrays: FilterArrays, values: FloatArray, first: bool) -> None:
    """Values (n, Q) of all rows at the points, after the additions (51) (none before the first sample)."""
    if not first:
        for i in range(x.shape[0]):
            for s in range(x.shape[1]):
                x[i, s] += arrays.additions[i, s]
    at_points(x, arrays.basis, values)
    for i in range(x.shape[0]):
        if arrays.logs[i] > 0.5:
            for q in range(values.shape[1]):
                values[i, q] = np.exp(values[i, q])


@kernel
def take(
    x: FloatArray,
    values: FloatArray,
    predicted: FloatArray,
    z: FloatArray,
    arrays: FilterArrays,
    work: Work,
) -> bool:
    """The measurement z (m,), NaN where there is none, into x; false once the filter has lost itself.

    values (n, Q): states and parameters at the points after the step; predicted (m, Q): the outputs there.
    """
    for i in range(arrays.states):
        expand_row(values, i, arrays.inverse, x, i)
    y = work.y
    for j in range(y.shape[0]):
        expand_row(predicted, j, arrays.inverse, y, j)
        total = arrays.variance[j]
        if arrays.inner.shape[0] > 0:
            total += arrays.inner[j, j]
        for s in range(1, y.shape[1]):
            total += y[j, s] * y[j, s]
        work.error[j] = z[j] - y[j, 0]
        work.spread[j] = np.sqrt(total)
    gpc_update_with(x, y, z, arrays.variance, arrays.form, arrays.cross, arrays.inner, work.gains)
    total = 0.0
    for i in range(x.shape[0]):
        for s in range(x.shape[1]):
            total += abs(x[i, s])
    return bool(np.isfinite(total))


@lean_kernel
def note(x: FloatArray, work: Work, k: int, record: Record) -> None:
    """Keep mean, spread and innovation of sample k."""
    for i in range(x.shape[0]):
        total = 0.0
        for s in range(1, x.shape[1]):
            total += x[i, s] * x[i, s]
        record.mean[k, i] = x[i, 0]
        record.std[k, i] = np.sqrt(total)
    for j in range(work.error.shape[0]):
        record.innovation[k, j] = work.error[j]
        record.innovation_std[k, j] = work.spread[j]
    if k % record.every == 0 and k // record.every < record.coefficients.shape[0]:
        for i in range(x.shape[0]):
            for s in range(x.shape[1]):
                record.coefficients[k // record.every, i, s] = x[i, s]
