"""The Kalman filter of one particle: measurement update (8) and time update (9), with the sensors' offsets or without.

The two outputs are taken one after the other (R is diagonal, so that this is exact). State: roll φ, roll rate r and, with
offsets, those of roll o, roll rate p and acceleration a:  y = (φ + o, r + p),  the model's input is the acceleration - a.
Each function takes the particle's row (`layout`) and changes it in place. m0, m1: 1 where the output is measured, 0 where
it is not (y0 or y1 is then any finite number).
"""

from __future__ import annotations

from parsers.channels import FloatArray
from parsers.jit import lean_kernel
from pipelines.filters.marginalized_particle.layout import (
    A00,
    A01,
    A10,
    A11,
    AFTER0,
    AFTER1,
    COV2,
    COV5,
    LEVEL0,
    LEVEL1,
    STATE,
    Start,
)

Innovation = tuple[float, float, float, float]
"""Errors and variances of the first output, and of the second with the first taken."""


@lean_kernel
def restart(row: FloatArray, start: Start, first: int, offsets: int) -> None:
    """Forget the roll's state; at the drive's first sample the offsets are set too, later they stay as they are."""
    row[STATE] = 0.0
    row[STATE + 1] = 0.0
    if not offsets:
        row[COV2], row[COV2 + 1], row[COV2 + 2] = start.roll, 0.0, start.rate
        return
    for i in range(COV5, COV5 + 9):
        row[i] = 0.0
    row[COV5], row[COV5 + 5] = start.roll, start.rate
    if first:
        for i in range(3):
            row[STATE + 2 + i] = 0.0
        for i in range(COV5 + 9, COV5 + 15):
            row[i] = 0.0
        row[COV5 + 9], row[COV5 + 12], row[COV5 + 14] = (
            start.roll_offset,
            start.rate_offset,
            start.accel_offset,
        )


@lean_kernel
def measure_two(
    row: FloatArray, y0: float, y1: float, m0: float, m1: float, r0: float, r1: float
) -> Innovation:
    """(8) without offsets; what is not measured changes nothing."""
    ff, fr, rr = row[COV2], row[COV2 + 1], row[COV2 + 2]
    s0 = ff + r0
    e0 = y0 - row[STATE]
    g0, g1 = m0 * ff / s0, m0 * fr / s0
    x0, x1 = row[STATE] + g0 * e0, row[STATE + 1] + g1 * e0
    rr -= g1 * fr
    fr -= g0 * fr
    ff -= g0 * ff
    s1 = rr + r1
    e1 = y1 - x1
    g0, g1 = m1 * fr / s1, m1 * rr / s1
    row[STATE], row[STATE + 1] = x0 + g0 * e1, x1 + g1 * e1
    row[COV2], row[COV2 + 1], row[COV2 + 2] = ff - g0 * fr, fr - g0 * rr, rr - g1 * rr
    return e0, s0, e1, s1


@lean_kernel
def forward_two(row: FloatArray, now: float, change: float, q: float) -> None:
    """(9) without offsets: input `now` at this sample, `change` until the next."""
    a00, a01, a10, a11 = row[A00], row[A01], row[A10], row[A11]
    l0, l1 = row[LEVEL0], row[LEVEL1]
    x0, x1 = row[STATE], row[STATE + 1]
    row[STATE] = a00 * x0 + a01 * x1 + l0 * now + row[AFTER0] * change
    row[STATE + 1] = a10 * x0 + a11 * x1 + l1 * now + row[AFTER1] * change
    ff, fr, rr = row[COV2], row[COV2 + 1], row[COV2 + 2]
    cf, cr = a00 * ff + a01 * fr, a00 * fr + a01 * rr
    df, dr = a10 * ff + a11 * fr, a10 * fr + a11 * rr
    row[COV2] = cf * a00 + cr * a01 + q * l0 * l0
    row[COV2 + 1] = cf * a10 + cr * a11 + q * l0 * l1
    row[COV2 + 2] = df * a10 + dr * a11 + q * l1 * l1


@lean_kernel
def take(row: FloatArray, c0: float, c1: float, c2: float, c3: float, c4: float, share: float) -> None:
    """Take `share` times the outer product of c from the covariance of five states."""
    d0, d1, d2, d3, d4 = share * c0, share * c1, share * c2, share * c3, share * c4
    row[COV5] -= d0 * c0
    row[COV5 + 1] -= d0 * c1
    row[COV5 + 2] -= d0 * c2
    row[COV5 + 3] -= d0 * c3
    row[COV5 + 4] -= d0 * c4
    row[COV5 + 5] -= d1 * c1
    row[COV5 + 6] -= d1 * c2
    row[COV5 + 7] -= d1 * c3
    row[COV5 + 8] -= d1 * c4
    row[COV5 + 9] -= d2 * c2
    row[COV5 + 10] -= d2 * c3
    row[COV5 + 11] -= d2 * c4
    row[COV5 + 12] -= d3 * c3
    row[COV5 + 13] -= d3 * c4
    row[COV5 + 14] -= d4 * c4


@lean_kernel
def shift(row: FloatArray, c0: float, c1: float, c2: float, c3: float, c4: float, by: float) -> None:
    """Move the mean of five states by `by` times c."""
    row[STATE] += by * c0
    row[STATE + 1] += by * c1
    row[STATE + 2] += by * c2
    row[STATE + 3] += by * c3
    row[STATE + 4] += by * c4


@lean_kernel
def measure_five(
    row: FloatArray, y0: float, y1: float, m0: float, m1: float, r0: float, r1: float
) -> Innovation:
    """(8) with offsets; what is not measured changes nothing."""
    p = COV5
    c0, c1, c2 = row[p] + row[p + 2], row[p + 1] + row[p + 6], row[p + 2] + row[p + 9]
    c3, c4 = row[p + 3] + row[p + 10], row[p + 4] + row[p + 11]
    s0 = c0 + c2 + r0
    e0 = y0 - row[STATE] - row[STATE + 2]
    share = m0 / s0
    shift(row, c0, c1, c2, c3, c4, share * e0)
    take(row, c0, c1, c2, c3, c4, share)
    c0, c1, c2 = row[p + 1] + row[p + 3], row[p + 5] + row[p + 7], row[p + 6] + row[p + 10]
    c3, c4 = row[p + 7] + row[p + 12], row[p + 8] + row[p + 13]
    s1 = c1 + c3 + r1
    e1 = y1 - row[STATE + 1] - row[STATE + 3]
    share = m1 / s1
    shift(row, c0, c1, c2, c3, c4, share * e1)
    take(row, c0, c1, c2, c3, c4, share)
    return e0, s0, e1, s1


@lean_kernel
def forward_five(row: FloatArray, now: float, change: float, q: float) -> None:
    """(9) with offsets: input `now` at this sample, `change` until the next."""
    a00, a01, a10, a11 = row[A00], row[A01], row[A10], row[A11]
    l0, l1 = row[LEVEL0], row[LEVEL1]
    x0, x1, push = row[STATE], row[STATE + 1], now - row[STATE + 4]
    row[STATE] = a00 * x0 + a01 * x1 + l0 * push + row[AFTER0] * change
    row[STATE + 1] = a10 * x0 + a11 * x1 + l1 * push + row[AFTER1] * change
    p = COV5
    ff, fr, fa, rr, ra, aa = row[p], row[p + 1], row[p + 4], row[p + 5], row[p + 8], row[p + 14]
    cf, cr, ca = (
        a00 * ff + a01 * fr - l0 * fa,
        a00 * fr + a01 * rr - l0 * ra,
        a00 * fa + a01 * ra - l0 * aa,
    )
    df, dr, da = (
        a10 * ff + a11 * fr - l1 * fa,
        a10 * fr + a11 * rr - l1 * ra,
        a10 * fa + a11 * ra - l1 * aa,
    )
    row[p] = cf * a00 + cr * a01 - ca * l0 + q * l0 * l0
    row[p + 1] = cf * a10 + cr * a11 - ca * l1 + q * l0 * l1
    row[p + 5] = df * a10 + dr * a11 - da * l1 + q * l1 * l1
    row[p + 4], row[p + 8] = ca, da
    fo, ro, oa = row[p + 2], row[p + 6], row[p + 11]
    row[p + 2], row[p + 6] = a00 * fo + a01 * ro - l0 * oa, a10 * fo + a11 * ro - l1 * oa
    fp, rp, pa = row[p + 3], row[p + 7], row[p + 13]
    row[p + 3], row[p + 7] = a00 * fp + a01 * rp - l0 * pa, a10 * fp + a11 * rp - l1 * pa
