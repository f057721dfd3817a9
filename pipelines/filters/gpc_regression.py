"""gPC-EKF for regression systems, y = g(u, p) + n, as one compiled loop (dissertation 3.1.2, 3.6-3.7, equation 70).

The parameters' distributions are expansions p = sum_s x_s psi_s. At each sample they are evaluated at the collocation
points, the model g there gives the outputs' expansion (19), covariances follow from the coefficients (20), and the
Kalman update moves the parameters alone: (70), there is no state whose update could be wanted. Two forms of the update of
the higher coefficients: as published (40), which loses R from the covariance and collapses, kept open by the additions
(58), (78), c_i times the second coefficient times mu_i at each sample; and the square-root form, whose spread is the
Kalman posterior's.

The model is one of `pipelines.models.power_products`, so that one kernel serves all of them: y_i = sum_j phi_ij c_j(p).

**Noise on the inputs** (errors in variables): the update believes phi, and its gradient has the expectation of
-sum_i var(phi_ij) c_j dc_j/dp / r_i beside what it should have. The same amount is put back by an observation "c_j = 0" of
negative weight, as in `rls_forgetting`; and r_i grows by sum_j c_j² var(phi_ij).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from parsers.channels import IntArray
from parsers.jit import kernel, lean_kernel
from pipelines.chaos.collocation import Collocation
from pipelines.filters.gpc_points import at_points, expand_row
from pipelines.filters.gpc_update import PUBLISHED, SQUARE_ROOT, gpc_update_with
from pipelines.filters.rls_forgetting import LARGEST_STEP
from pipelines.models.power_products import PowerProducts
from pipelines.results import FloatArray

SMALLEST = 1e-12
TAKE_EVERY = 10
"""Samples between two times that the inputs' noise is taken out: it adds up slowly."""


@lean_kernel
def _products(values: FloatArray, exponents: IntArray, out: FloatArray) -> None:
    """out (C, Q): the coefficients (power products) at parameter values (n, Q)."""
    for j in range(exponents.shape[0]):
        for q in range(values.shape[1]):
            out[j, q] = 1.0
        for i in range(exponents.shape[1]):
            power = exponents[j, i]
            for _ in range(power):
                for q in range(values.shape[1]):
                    out[j, q] *= values[i, q]
            for _ in range(-power):
                for q in range(values.shape[1]):
                    value = values[i, q]
                    out[j, q] /= value if abs(value) > SMALLEST else SMALLEST


@kernel
def _take_out(x: FloatArray, y: FloatArray, weight: float, form: int) -> None:
    """An observation "y[0] = 0" of information -weight, in place; weight times the variance of y is below 1."""
    count = y.shape[1]
    spread = 0.0
    for s in range(1, count):
        spread += y[0, s] * y[0, s]
    variance = -1.0 / weight
    total = spread + variance
    # of the square-root form: (1 + sqrt(r / (spread + r)))^-1, a number that makes the new spread the posterior's
    share = 1.0 if form == 0 else 1.0 / (1.0 + np.sqrt(variance / total))
    for i in range(x.shape[0]):
        gain = 0.0
        for s in range(1, count):
            gain += x[i, s] * y[0, s]
        gain /= total
        x[i, 0] -= gain * y[0, 0]
        for s in range(1, count):
            x[i, s] -= share * gain * y[0, s]


@lean_kernel
def _predict(
    phi: FloatArray,
    k: int,
    products: FloatArray,
    inverse: FloatArray,
    model: FloatArray,
    y: FloatArray,
) -> None:
    """y (m, S): the outputs' expansions at sample k from the coefficients at the points (C, Q); model (m, Q): work."""
    for i in range(model.shape[0]):
        for q in range(model.shape[1]):
            model[i, q] = 0.0
        for j in range(products.shape[0]):
            known = phi[k, i, j]
            if known != 0.0:
                for q in range(model.shape[1]):
                    model[i, q] += known * products[j, q]
        expand_row(model, i, inverse, y, i)


@lean_kernel
def _spread(x: FloatArray, row: int) -> float:
    """Variance of one expansion."""
    total = 0.0
    for s in range(1, x.shape[1]):
        total += x[row, s] * x[row, s]
    return total


@kernel
def _inputs_out(
    x: FloatArray,
    exponents: IntArray,
    basis: FloatArray,
    inverse: FloatArray,
    form: int,
    waiting: FloatArray,
    values: FloatArray,
    products: FloatArray,
    one: FloatArray,
) -> None:
    """Take out what waits (C,) of each coefficient's noise, as far as the filter is sure enough of it by now."""
    for j in range(len(waiting)):
        if waiting[j] > 0.0:
            at_points(x, basis, values)
            _products(values, exponents, products)
            expand_row(products, j, inverse, one, 0)
            if _spread(one, 0) * waiting[j] < LARGEST_STEP:
                _take_out(x, one, waiting[j], form)
                waiting[j] = 0.0


@kernel
def _run(
    phi: FloatArray,
    z: FloatArray,
    noise: FloatArray,
    input_noise: FloatArray,
    exponents: IntArray,
    basis: FloatArray,
    inverse: FloatArray,
    additions: FloatArray,
    form: int,
    every: int,
    x: FloatArray,
    track: FloatArray,
    spread: FloatArray,
) -> None:
    """x (n, S) in place; track, spread (k // every, n). basis (S, Q); inverse (Q, S); additions (n, S) a sample."""
    outputs, terms, points, count = z.shape[1], exponents.shape[0], basis.shape[1], x.shape[0]
    values, products, model = (
        np.empty((count, points)),
        np.empty((terms, points)),
        np.empty((outputs, points)),
    )
    y, one = np.empty((outputs, x.shape[1])), np.empty((1, x.shape[1]))
    here, now = np.empty((count, 1)), np.empty((terms, 1))
    none, work = np.empty((0, 0)), np.empty((outputs, outputs + 4))
    variance, waiting = noise.copy(), np.zeros(terms)
    noisy = input_noise.any()
    row, left = 0, every
    for k in range(z.shape[0]):
        for i in range(count):
            here[i, 0] = x[i, 0]
            for s in range(x.shape[1]):
                x[i, s] += additions[i, s]
        at_points(x, basis, values)
        _products(values, exponents, products)
        _predict(phi, k, products, inverse, model, y)
        if noisy:
            _products(here, exponents, now)
            for i in range(outputs):
                variance[i] = noise[i]
                for j in range(terms):
                    variance[i] += now[j, 0] * now[j, 0] * input_noise[i, j]
                for j in range(terms):
                    waiting[j] += input_noise[i, j] / variance[i]
        gpc_update_with(x, y, z[k], variance, form, none, none, work)
        if noisy and (k + 1) % TAKE_EVERY == 0:
            _inputs_out(x, exponents, basis, inverse, form, waiting, values, products, one)
        left -= 1
        if left == 0:
            for i in range(count):
                track[row, i] = x[i, 0]
                spread[row, i] = np.sqrt(_spread(x, i))
            row += 1
            left = every


@dataclass(frozen=True)
class RegressionFilter:
    """What the filter is set up with: prior, points and settings.

    middle, half: (n,), each parameter is middle + half mu before the first sample, mu the basis's variable (for Legendre
    uniform on -1..1: the printed p1 and p2). noise: (m,) variances R of the outputs. addition: (n,) the printed c_i,
    each a share of p2 a sample. form: PUBLISHED or SQUARE_ROOT. input_noise: (m, C) variances of the noise on phi, taken
    out; None: none.
    """

    model: PowerProducts
    collocation: Collocation
    middle: FloatArray
    half: FloatArray
    noise: FloatArray
    addition: FloatArray | None = None
    form: int = SQUARE_ROOT
    input_noise: FloatArray | None = None


@dataclass(frozen=True)
class RegressionRun:
    """track, spread: (n // every, n_p) mean and standard deviation of the parameters; coefficients: the last (n_p, S)."""

    track: FloatArray
    spread: FloatArray
    coefficients: FloatArray


def gpc_regression(phi: FloatArray, z: FloatArray, how: RegressionFilter, *, every: int = 1) -> RegressionRun:
    """Run the filter. phi: (n, m, C) regressors of m outputs; z: (n, m) measured.

    Raises ValueError where shapes do not fit, a variance is not above 0, or there are as many variables as parameters
    not.
    """
    count, (terms, _) = len(how.model.parameters), how.model.exponents.shape
    rows, outputs = z.shape
    if phi.shape != (rows, outputs, terms) or every < 1:
        raise ValueError("the arrays do not fit together")
    if (
        how.collocation.space.dimensions != count
        or how.middle.shape != (count,)
        or how.half.shape != (count,)
    ):
        raise ValueError("one variable, middle and half width for each parameter")
    if how.noise.shape != (outputs,) or not (how.noise > 0).all():
        raise ValueError("a variance above 0 for each output")
    if how.form not in (PUBLISHED, SQUARE_ROOT):
        raise ValueError("the form is 0 (published) or 1 (square root)")
    input_noise = np.zeros((outputs, terms)) if how.input_noise is None else how.input_noise
    if input_noise.shape != (outputs, terms) or not (input_noise >= 0).all():
        raise ValueError("an input variance of 0 or more for each output and coefficient")
    inverse = np.ascontiguousarray(how.collocation.inverse)
    # what mu_i is in the basis, whatever its scale
    of_variable = (inverse @ how.collocation.points).T
    x = of_variable * how.half[:, None]
    x[:, 0] += how.middle
    share = np.zeros(count) if how.addition is None else how.addition
    additions = of_variable * (share * how.half)[:, None]
    track, spread = np.empty((rows // every, count)), np.empty((rows // every, count))
    _run(
        np.ascontiguousarray(phi, dtype=np.float64), np.ascontiguousarray(z, dtype=np.float64),
        how.noise.astype(np.float64), np.ascontiguousarray(input_noise, dtype=np.float64),
        np.ascontiguousarray(how.model.exponents), np.ascontiguousarray(how.collocation.matrix.T),
        np.ascontiguousarray(inverse.T), np.ascontiguousarray(additions), how.form, every, x, track, spread,
    )  # fmt: skip
    return RegressionRun(track, spread, x)
