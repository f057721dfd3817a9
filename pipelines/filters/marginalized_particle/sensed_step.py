"""The Kalman filter of one particle whose input is measured: a sample's noise is in the step before it and in the one behind it.

With x[k+1] = A x[k] + before (f[k] + n[k]) + after (f[k+1] + n[k+1]), f as measured and n what noise took from it, the state is kept
without its own sample's part, s = x - after n: then n is fresh at every sample, the outputs hold s + after n, and
s[k+1] = A s[k] + before f[k] + after f[k+1] + (before + A after) n[k]. What the outputs tell of n is in the row until the next step.
"""

from __future__ import annotations

from parsers.channels import FloatArray
from parsers.jit import vector_kernel
from pipelines.filters.marginalized_particle.kalman_step import Innovation, shift, take
from pipelines.filters.marginalized_particle.layout import (
    A00,
    A01,
    A10,
    A11,
    ACCEL_OFFSET,
    AFTER0,
    AFTER1,
    COV,
    LEVEL0,
    LEVEL1,
    NOISE_MEAN,
    NOISE_VARIANCE,
    RATE,
    RATE_OFFSET,
    ROLL,
    ROLL_OFFSET,
    WITH_NOISE,
)


@vector_kernel
def _also(
    row: FloatArray, i: int, c0: float, c1: float, c2: float, c3: float, c4: float, noise: float, share: float
) -> None:
    """Take `share` times the outer product of (c, noise) from what the noise has with the states and itself."""
    part = share * noise
    row[WITH_NOISE[0] + i] -= part * c0
    row[WITH_NOISE[1] + i] -= part * c1
    row[WITH_NOISE[2] + i] -= part * c2
    row[WITH_NOISE[3] + i] -= part * c3
    row[WITH_NOISE[4] + i] -= part * c4
    row[NOISE_VARIANCE + i] -= part * noise


@vector_kernel
def measure_sensed(
    row: FloatArray,
    i: int,
    y: tuple[float, float],
    there: tuple[float, float],
    r: tuple[float, float],
    hold: float,
    q: float,
) -> Innovation:
    """(8) with offsets, for an input of noise variance q; what is not measured changes nothing. hold: 1 or 0, as the step had it."""
    after0, after1 = hold * row[AFTER0 + i], hold * row[AFTER1 + i]
    row[NOISE_MEAN + i], row[NOISE_VARIANCE + i] = 0.0, q
    row[WITH_NOISE[0] + i], row[WITH_NOISE[1] + i], row[WITH_NOISE[2] + i] = 0.0, 0.0, 0.0
    row[WITH_NOISE[3] + i], row[WITH_NOISE[4] + i] = 0.0, 0.0
    c0, c1, c2 = (
        row[COV[0] + i] + row[COV[2] + i],
        row[COV[1] + i] + row[COV[6] + i],
        row[COV[2] + i] + row[COV[9] + i],
    )
    c3, c4, noise = row[COV[3] + i] + row[COV[10] + i], row[COV[4] + i] + row[COV[11] + i], after0 * q
    s0 = c0 + c2 + after0 * noise + r[0]
    e0 = y[0] - row[ROLL + i] - row[ROLL_OFFSET + i]
    share = there[0] / s0
    shift(row, i, c0, c1, c2, c3, c4, share * e0)
    row[NOISE_MEAN + i] += share * e0 * noise
    take(row, i, c0, c1, c2, c3, c4, share)
    _also(row, i, c0, c1, c2, c3, c4, noise, share)
    c0 = row[COV[1] + i] + row[COV[3] + i] + after1 * row[WITH_NOISE[0] + i]
    c1 = row[COV[5] + i] + row[COV[7] + i] + after1 * row[WITH_NOISE[1] + i]
    c2 = row[COV[6] + i] + row[COV[10] + i] + after1 * row[WITH_NOISE[2] + i]
    c3 = row[COV[7] + i] + row[COV[12] + i] + after1 * row[WITH_NOISE[3] + i]
    c4 = row[COV[8] + i] + row[COV[13] + i] + after1 * row[WITH_NOISE[4] + i]
    noise = row[WITH_NOISE[1] + i] + row[WITH_NOISE[3] + i] + after1 * row[NOISE_VARIANCE + i]
    s1 = c1 + c3 + after1 * noise + r[1]
    e1 = y[1] - row[RATE + i] - row[RATE_OFFSET + i] - after1 * row[NOISE_MEAN + i]
    share = there[1] / s1
    shift(row, i, c0, c1, c2, c3, c4, share * e1)
    row[NOISE_MEAN + i] += share * e1 * noise
    take(row, i, c0, c1, c2, c3, c4, share)
    _also(row, i, c0, c1, c2, c3, c4, noise, share)
    return e0, s0, e1, s1


@vector_kernel
def forward_sensed(row: FloatArray, i: int, now: float, after: float, hold: float) -> None:
    """(9) with offsets. now, after: the input at this sample and at the next."""
    a00, a01, a10, a11 = row[A00 + i], row[A01 + i], row[A10 + i], row[A11 + i]
    l0, l1 = row[LEVEL0 + i], row[LEVEL1 + i]
    after0, after1 = hold * row[AFTER0 + i], hold * row[AFTER1 + i]
    g0 = l0 - after0 + a00 * after0 + a01 * after1
    g1 = l1 - after1 + a10 * after0 + a11 * after1
    x0, x1, push, change = row[ROLL + i], row[RATE + i], now - row[ACCEL_OFFSET + i], after - now
    mean = row[NOISE_MEAN + i]
    row[ROLL + i] = a00 * x0 + a01 * x1 + l0 * push + after0 * change + g0 * mean
    row[RATE + i] = a10 * x0 + a11 * x1 + l1 * push + after1 * change + g1 * mean
    ff, fr, fa, rr, ra, aa = (
        row[COV[0] + i],
        row[COV[1] + i],
        row[COV[4] + i],
        row[COV[5] + i],
        row[COV[8] + i],
        row[COV[14] + i],
    )
    nf, nr, na, nn = (
        row[WITH_NOISE[0] + i],
        row[WITH_NOISE[1] + i],
        row[WITH_NOISE[4] + i],
        row[NOISE_VARIANCE + i],
    )
    cf, cr = a00 * ff + a01 * fr - l0 * fa + g0 * nf, a00 * fr + a01 * rr - l0 * ra + g0 * nr
    ca, cn = a00 * fa + a01 * ra - l0 * aa + g0 * na, a00 * nf + a01 * nr - l0 * na + g0 * nn
    df, dr = a10 * ff + a11 * fr - l1 * fa + g1 * nf, a10 * fr + a11 * rr - l1 * ra + g1 * nr
    da, dn = a10 * fa + a11 * ra - l1 * aa + g1 * na, a10 * nf + a11 * nr - l1 * na + g1 * nn
    row[COV[0] + i] = cf * a00 + cr * a01 - ca * l0 + cn * g0
    row[COV[1] + i] = cf * a10 + cr * a11 - ca * l1 + cn * g1
    row[COV[5] + i] = df * a10 + dr * a11 - da * l1 + dn * g1
    row[COV[4] + i], row[COV[8] + i] = ca, da
    fo, ro, oa, no = row[COV[2] + i], row[COV[6] + i], row[COV[11] + i], row[WITH_NOISE[2] + i]
    row[COV[2] + i] = a00 * fo + a01 * ro - l0 * oa + g0 * no
    row[COV[6] + i] = a10 * fo + a11 * ro - l1 * oa + g1 * no
    fp, rp, pa, nq = row[COV[3] + i], row[COV[7] + i], row[COV[13] + i], row[WITH_NOISE[3] + i]
    row[COV[3] + i] = a00 * fp + a01 * rp - l0 * pa + g0 * nq
    row[COV[7] + i] = a10 * fp + a11 * rp - l1 * pa + g1 * nq
