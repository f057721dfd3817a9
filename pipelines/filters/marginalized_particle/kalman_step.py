"""The Kalman filter of one particle: measurement update (8) and time update (9), with the sensors' offsets or without.

The two outputs are taken one after the other (R is diagonal, so that this is exact). State: roll φ, roll rate r and, with
offsets, those of roll o, roll rate p and acceleration a:  y = (φ + o, r + p),  the model's input is the acceleration - a.
Each function takes the row of the particle's tile (`layout`) and its lane i, and changes it in place. m0, m1: 1 where the output is
measured, 0 where it is not (y0 or y1 is then any finite number).
"""

from __future__ import annotations

from parsers.channels import FloatArray
from parsers.jit import vector_kernel
from pipelines.filters.lanes import LANES
from pipelines.filters.marginalized_particle.layout import (
    A00,
    A01,
    A10,
    A11,
    ACCEL_OFFSET,
    AFTER0,
    AFTER1,
    COV,
    COV2,
    LEVEL0,
    LEVEL1,
    RATE,
    RATE_OFFSET,
    ROLL,
    ROLL_OFFSET,
    Start,
)

Innovation = tuple[float, float, float, float]
"""Errors and variances of the first output, and of the second with the first taken."""

FF, FR, RR = COV2, COV2 + LANES, COV2 + 2 * LANES
"""Without offsets: the covariance of roll and roll rate."""


@vector_kernel
def restart(row: FloatArray, i: int, start: Start, first: int, offsets: int) -> None:
    """Forget the roll's state; at the drive's first sample the offsets are set too, later they stay as they are."""
    row[ROLL + i] = 0.0
    row[RATE + i] = 0.0
    if not offsets:
        row[FF + i], row[FR + i], row[RR + i] = start.roll, 0.0, start.rate
        return
    for j in range(9):
        row[COV[j] + i] = 0.0
    row[COV[0] + i], row[COV[5] + i] = start.roll, start.rate
    if first:
        row[ROLL_OFFSET + i], row[RATE_OFFSET + i], row[ACCEL_OFFSET + i] = 0.0, 0.0, 0.0
        row[COV[10] + i], row[COV[11] + i], row[COV[13] + i] = 0.0, 0.0, 0.0
        row[COV[9] + i] = start.roll_offset
        row[COV[12] + i] = start.rate_offset
        row[COV[14] + i] = start.accel_offset


@vector_kernel
def measure_two(
    row: FloatArray, i: int, y0: float, y1: float, m0: float, m1: float, r0: float, r1: float
) -> Innovation:
    """(8) without offsets; what is not measured changes nothing."""
    ff, fr, rr = row[FF + i], row[FR + i], row[RR + i]
    s0 = ff + r0
    e0 = y0 - row[ROLL + i]
    over = m0 / s0
    g0, g1 = ff * over, fr * over
    x0, x1 = row[ROLL + i] + g0 * e0, row[RATE + i] + g1 * e0
    rr -= g1 * fr
    fr -= g0 * fr
    ff -= g0 * ff
    s1 = rr + r1
    e1 = y1 - x1
    over = m1 / s1
    g0, g1 = fr * over, rr * over
    row[ROLL + i], row[RATE + i] = x0 + g0 * e1, x1 + g1 * e1
    row[FF + i], row[FR + i], row[RR + i] = ff - g0 * fr, fr - g0 * rr, rr - g1 * rr
    return e0, s0, e1, s1


@vector_kernel
def forward_two(row: FloatArray, i: int, now: float, change: float, q: float) -> None:
    """(9) without offsets: input `now` at this sample, `change` until the next."""
    a00, a01, a10, a11 = row[A00 + i], row[A01 + i], row[A10 + i], row[A11 + i]
    l0, l1 = row[LEVEL0 + i], row[LEVEL1 + i]
    x0, x1 = row[ROLL + i], row[RATE + i]
    row[ROLL + i] = a00 * x0 + a01 * x1 + l0 * now + row[AFTER0 + i] * change
    row[RATE + i] = a10 * x0 + a11 * x1 + l1 * now + row[AFTER1 + i] * change
    ff, fr, rr = row[FF + i], row[FR + i], row[RR + i]
    cf, cr = a00 * ff + a01 * fr, a00 * fr + a01 * rr
    df, dr = a10 * ff + a11 * fr, a10 * fr + a11 * rr
    row[FF + i] = cf * a00 + cr * a01 + q * l0 * l0
    row[FR + i] = cf * a10 + cr * a11 + q * l0 * l1
    row[RR + i] = df * a10 + dr * a11 + q * l1 * l1


@vector_kernel
def take(
    row: FloatArray, i: int, c0: float, c1: float, c2: float, c3: float, c4: float, share: float
) -> None:
    """Take `share` times the outer product of c from the covariance of five states."""
    d0, d1, d2, d3, d4 = share * c0, share * c1, share * c2, share * c3, share * c4
    row[COV[0] + i] -= d0 * c0
    row[COV[1] + i] -= d0 * c1
    row[COV[2] + i] -= d0 * c2
    row[COV[3] + i] -= d0 * c3
    row[COV[4] + i] -= d0 * c4
    row[COV[5] + i] -= d1 * c1
    row[COV[6] + i] -= d1 * c2
    row[COV[7] + i] -= d1 * c3
    row[COV[8] + i] -= d1 * c4
    row[COV[9] + i] -= d2 * c2
    row[COV[10] + i] -= d2 * c3
    row[COV[11] + i] -= d2 * c4
    row[COV[12] + i] -= d3 * c3
    row[COV[13] + i] -= d3 * c4
    row[COV[14] + i] -= d4 * c4


@vector_kernel
def shift(row: FloatArray, i: int, c0: float, c1: float, c2: float, c3: float, c4: float, by: float) -> None:
    """Move the mean of five states by `by` times c."""
    row[ROLL + i] += by * c0
    row[RATE + i] += by * c1
    row[ROLL_OFFSET + i] += by * c2
    row[RATE_OFFSET + i] += by * c3
    row[ACCEL_OFFSET + i] += by * c4


@vector_kernel
def measure_five(
    row: FloatArray, i: int, y0: float, y1: float, m0: float, m1: float, r0: float, r1: float
) -> Innovation:
    """(8) with offsets; what is not measured changes nothing."""
    c0, c1, c2 = (
        row[COV[0] + i] + row[COV[2] + i],
        row[COV[1] + i] + row[COV[6] + i],
        row[COV[2] + i] + row[COV[9] + i],
    )
    c3, c4 = row[COV[3] + i] + row[COV[10] + i], row[COV[4] + i] + row[COV[11] + i]
    s0 = c0 + c2 + r0
    e0 = y0 - row[ROLL + i] - row[ROLL_OFFSET + i]
    share = m0 / s0
    shift(row, i, c0, c1, c2, c3, c4, share * e0)
    take(row, i, c0, c1, c2, c3, c4, share)
    c0, c1, c2 = (
        row[COV[1] + i] + row[COV[3] + i],
        row[COV[5] + i] + row[COV[7] + i],
        row[COV[6] + i] + row[COV[10] + i],
    )
    c3, c4 = row[COV[7] + i] + row[COV[12] + i], row[COV[8] + i] + row[COV[13] + i]
    s1 = c1 + c3 + r1
    e1 = y1 - row[RATE + i] - row[RATE_OFFSET + i]
    share = m1 / s1
    shift(row, i, c0, c1, c2, c3, c4, share * e1)
    take(row, i, c0, c1, c2, c3, c4, share)
    return e0, s0, e1, s1


@vector_kernel
def forward_five(row: FloatArray, i: int, now: float, change: float, q: float) -> None:
    """(9) with offsets: input `now` at this sample, `change` until the next."""
    a00, a01, a10, a11 = row[A00 + i], row[A01 + i], row[A10 + i], row[A11 + i]
    l0, l1 = row[LEVEL0 + i], row[LEVEL1 + i]
    x0, x1, push = row[ROLL + i], row[RATE + i], now - row[ACCEL_OFFSET + i]
    row[ROLL + i] = a00 * x0 + a01 * x1 + l0 * push + row[AFTER0 + i] * change
    row[RATE + i] = a10 * x0 + a11 * x1 + l1 * push + row[AFTER1 + i] * change
    ff, fr, fa = row[COV[0] + i], row[COV[1] + i], row[COV[4] + i]
    rr, ra, aa = row[COV[5] + i], row[COV[8] + i], row[COV[14] + i]
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
    row[COV[0] + i] = cf * a00 + cr * a01 - ca * l0 + q * l0 * l0
    row[COV[1] + i] = cf * a10 + cr * a11 - ca * l1 + q * l0 * l1
    row[COV[5] + i] = df * a10 + dr * a11 - da * l1 + q * l1 * l1
    row[COV[4] + i], row[COV[8] + i] = ca, da
    fo, ro, oa = row[COV[2] + i], row[COV[6] + i], row[COV[11] + i]
    row[COV[2] + i], row[COV[6] + i] = a00 * fo + a01 * ro - l0 * oa, a10 * fo + a11 * ro - l1 * oa
    fp, rp, pa = row[COV[3] + i], row[COV[7] + i], row[COV[13] + i]
    row[COV[3] + i], row[COV[7] + i] = a00 * fp + a01 * rp - l0 * pa, a10 * fp + a11 * rp - l1 * pa
