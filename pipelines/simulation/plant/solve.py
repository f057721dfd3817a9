"""The plant's six linear equations: what a wheel on its guide adds to the mass matrix, and their solution."""

from __future__ import annotations

from parsers.jit import lean_kernel
from pipelines.results import FloatArray


@lean_kernel
def add_mass(
    mass: float, path: tuple[float, float, float], place: tuple[float, float, float], work: FloatArray
) -> None:
    """Add a particle that may slide along a guide to the lower triangle of the matrix in rows 0-5 of `work`.

    path: the guide's direction x, y (its z is 1) and the square of its length. place: from the body's CG.
    With N = m (1 - e e'/(e'e)): N to the accelerations, [r] N to the coupling, -[r] N [r] to the turning.
    """
    ex, ey, n = path
    x, y, z = place
    s = mass / n
    n00, n11, n22 = mass - s * ex * ex, mass - s * ey * ey, mass - s
    n01, n02, n12 = -s * ex * ey, -s * ex, -s * ey
    l00, l01, l02 = y * n02 - z * n01, y * n12 - z * n11, y * n22 - z * n12
    l10, l11, l12 = z * n00 - x * n02, z * n01 - x * n12, z * n02 - x * n22
    l20, l21, l22 = x * n01 - y * n00, x * n11 - y * n01, x * n12 - y * n02
    work[0, 0] += n00
    work[1, 0] += n01
    work[1, 1] += n11
    work[2, 0] += n02
    work[2, 1] += n12
    work[2, 2] += n22
    work[3, 0] += l00
    work[3, 1] += l01
    work[3, 2] += l02
    work[4, 0] += l10
    work[4, 1] += l11
    work[4, 2] += l12
    work[5, 0] += l20
    work[5, 1] += l21
    work[5, 2] += l22
    work[3, 3] += l02 * y - l01 * z
    work[4, 3] += l12 * y - l11 * z
    work[4, 4] += l10 * z - l12 * x
    work[5, 3] += l22 * y - l21 * z
    work[5, 4] += l20 * z - l22 * x
    work[5, 5] += l21 * x - l20 * y


@lean_kernel
def solve_six(work: FloatArray) -> None:
    """Solve the symmetric positive definite system of rows 0-5 (lower triangle) with row 6, in place, into row 6."""
    for j in range(6):
        for k in range(j):
            scaled = work[j, k] * work[k, k]
            for i in range(j, 6):
                work[i, j] -= work[i, k] * scaled
        inverse = 1.0 / work[j, j]
        for i in range(j + 1, 6):
            work[i, j] *= inverse
    for i in range(6):
        total = work[6, i]
        for k in range(i):
            total -= work[i, k] * work[6, k]
        work[6, i] = total
    for i in range(6):
        work[6, i] /= work[i, i]
    for m in range(6):
        i = 5 - m
        total = work[6, i]
        for k in range(i + 1, 6):
            total -= work[k, i] * work[6, k]
        work[6, i] = total
