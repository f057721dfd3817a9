"""How many particles (10), and which go on: systematic resampling."""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray
from parsers.jit import lean_kernel


@lean_kernel
def wanted_size(wanted: int, particles: int, squares: float, most: int) -> int:
    """N_k = ceil(N* (1 + Var(q))) of (10), at most `most`.

    Its weights have mean one (those of Algorithm 2's line 5, divided by N, would make the variance vanish): with weights of
    sum one, 1 + Var(q) = N sum w² = N / N_eff. squares: sum w².
    """
    size = np.ceil(wanted * particles * squares * (1.0 - 1e-12))
    return int(min(max(size, 1.0), most * 1.0))


@lean_kernel
def resample(
    table: FloatArray, weights: FloatArray, particles: int, into: FloatArray, size: int, start: float
) -> int:
    """Systematic resampling: fill the first `size` rows of `into`; returns how many different particles went on.

    table: rows of the first `particles` are read. weights: sum one. start: uniform on [0, 1). The expected number of copies
    of particle i is size * weights[i], and its number is that rounded down or up.
    """
    taken, total, different = 0, 0.0, 0
    width = table.shape[1]
    for i in range(particles):
        total += weights[i]
        if i == particles - 1:
            total = 2.0
        first = taken
        while taken < size and (taken + start) < total * size:
            for j in range(width):
                into[taken, j] = table[i, j]
            taken += 1
        if taken > first:
            different += 1
    return different
