"""The Kalman filter of one particle whose input is measured: a sample's noise is in the step before it and in the one behind it.

With x[k+1] = A x[k] + before (f[k] + n[k]) + after (f[k+1] + n[k+1]), f as measured and n what noise took from it, the state is kept
without its own sample's part, s = x - after n: then n is fresh at every sample, the outputs hold s + after n, and
s[k+1] = A s[k] + before f[k] + after f[k+1] + (before + A after) n[k]. What the outputs tell of n is in the row until the next step.
"""

from __future__ import annotations

from parsers.channels import FloatArray
from parsers.jit import lean_kernel
from pipelines.filters.marginalized_particle.kalman_step import Innovation, shift, take
from pipelines.filters.marginalized_particle.layout import (
    A00,
    A01,
    A10,
    A11,
    AFTER0,
    AFTER1,
    COV5,
    LEVEL0,
    LEVEL1,
    NOISE_COV,
    NOISE_MEAN,
    NOISE_VARIANCE,
    STATE,
)


@lean_kernel
def _also(
    row: FloatArray, c0: float, c1: float, c2: float, c3: float, c4: float, noise: float, share: float
) -> None:
    """Take `share` times the outer product of (c, noise) from what the noise has with the states and itself."""
    part = share * noise
    row[NOISE_COV] -= part * c0
    row[NOISE_COV + 1] -= part * c1
    row[NOISE_COV + 2] -= part * c2
    row[NOISE_COV + 3] -= part * c3
    row[NOISE_COV + 4] -= part * c4
    row[NOISE_VARIANCE] -= part * noise


@lean_kernel
def measure_sensed(
    row: FloatArray,
    y: tuple[float, float],
    there: tuple[float, float],
    r: tuple[float, float],
    hold: int,
    q: float,
) -> Innovation:
    """(8) with offsets, for an input of noise variance q; what is not measured changes nothing. hold: as the step had it."""
    after0, after1 = (row[AFTER0], row[AFTER1]) if hold else (0.0, 0.0)
    p, n = COV5, NOISE_COV
    row[NOISE_MEAN], row[NOISE_VARIANCE] = 0.0, q
    for i in range(5):
        row[n + i] = 0.0
    c0, c1, c2 = row[p] + row[p + 2], row[p + 1] + row[p + 6], row[p + 2] + row[p + 9]
    c3, c4, noise = row[p + 3] + row[p + 10], row[p + 4] + row[p + 11], after0 * q
    s0 = c0 + c2 + after0 * noise + r[0]
    e0 = y[0] - row[STATE] - row[STATE + 2]
    share = there[0] / s0
    shift(row, c0, c1, c2, c3, c4, share * e0)
    row[NOISE_MEAN] += share * e0 * noise
    take(row, c0, c1, c2, c3, c4, share)
    _also(row, c0, c1, c2, c3, c4, noise, share)
    c0 = row[p + 1] + row[p + 3] + after1 * row[n]
    c1 = row[p + 5] + row[p + 7] + after1 * row[n + 1]
    c2 = row[p + 6] + row[p + 10] + after1 * row[n + 2]
    c3 = row[p + 7] + row[p + 12] + after1 * row[n + 3]
    c4 = row[p + 8] + row[p + 13] + after1 * row[n + 4]
    noise = row[n + 1] + row[n + 3] + after1 * row[NOISE_VARIANCE]
    s1 = c1 + c3 + after1 * noise + r[1]
    e1 = y[1] - row[STATE + 1] - row[STATE + 3] - after1 * row[NOISE_MEAN]
    share = there[1] / s1
    shift(row, c0, c1, c2, c3, c4, share * e1)
    row[NOISE_MEAN] += share * e1 * noise
    take(row, c0, c1, c2, c3, c4, share)
    _also(row, c0, c1, c2, c3, c4, noise, share)
    return e0, s0, e1, s1


@lean_kernel
def forward_sensed(row: FloatArray, now: float, after: float, hold: int) -> None:
    """(9) with offsets. now, after: the input at this sample and at the next."""
    a00, a01, a10, a11 = row[A00], row[A01], row[A10], row[A11]
    l0, l1 = row[LEVEL0], row[LEVEL1]
    after0, after1 = (row[AFTER0], row[AFTER1]) if hold else (0.0, 0.0)
    g0 = l0 - after0 + a00 * after0 + a01 * after1
    g1 = l1 - after1 + a10 * after0 + a11 * after1
    x0, x1, push, change = row[STATE], row[STATE + 1], now - row[STATE + 4], after - now
    mean = row[NOISE_MEAN]
    row[STATE] = a00 * x0 + a01 * x1 + l0 * push + after0 * change + g0 * mean
    row[STATE + 1] = a10 * x0 + a11 * x1 + l1 * push + after1 * change + g1 * mean
    p, n = COV5, NOISE_COV
    ff, fr, fa, rr, ra, aa = row[p], row[p + 1], row[p + 4], row[p + 5], row[p + 8], row[p + 14]
    nf, nr, na, nn = row[n], row[n + 1], row[n + 4], row[NOISE_VARIANCE]
    cf, cr = a00 * ff + a01 * fr - l0 * fa + g0 * nf, a00 * fr + a01 * rr - l0 * ra + g0 * nr
    ca, cn = a00 * fa + a01 * ra - l0 * aa + g0 * na, a00 * nf + a01 * nr - l0 * na + g0 * nn
    df, dr = a10 * ff + a11 * fr - l1 * fa + g1 * nf, a10 * fr + a11 * rr - l1 * ra + g1 * nr
    da, dn = a10 * fa + a11 * ra - l1 * aa + g1 * na, a10 * nf + a11 * nr - l1 * na + g1 * nn
    row[p] = cf * a00 + cr * a01 - ca * l0 + cn * g0
    row[p + 1] = cf * a10 + cr * a11 - ca * l1 + cn * g1
    row[p + 5] = df * a10 + dr * a11 - da * l1 + dn * g1
    row[p + 4], row[p + 8] = ca, da
    fo, ro, oa, no = row[p + 2], row[p + 6], row[p + 11], row[n + 2]
    row[p + 2] = a00 * fo + a01 * ro - l0 * oa + g0 * no
    row[p + 6] = a10 * fo + a11 * ro - l1 * oa + g1 * no
    fp, rp, pa, nq = row[p + 3], row[p + 7], row[p + 13], row[n + 3]
    row[p + 3] = a00 * fp + a01 * rp - l0 * pa + g0 * nq
    row[p + 7] = a10 * fp + a11 * rp - l1 * pa + g1 * nq
