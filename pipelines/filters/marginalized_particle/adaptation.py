"""How many particles (10), and which go on: systematic resampling."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.channels import FloatArray, IntArray
from parsers.jit import lean_kernel, vector_kernel
from pipelines.filters.lanes import LANES

Places = NDArray[np.uint64]


@lean_kernel
def wanted_size(wanted: int, particles: int, squares: float, most: int) -> int:
    """N_k = ceil(N* (1 + Var(q))) of (10), at most `most`.

    Its weights have mean one (those of Algorithm 2's line 5, divided by N, would make the variance vanish): with weights of
    sum one, 1 + Var(q) = N sum w² = N / N_eff. squares: sum w².
    """
    size = np.ceil(wanted * particles * squares * (1.0 - 1e-12))
    return int(min(max(size, 1.0), most * 1.0))


@lean_kernel
def resample(weights: FloatArray, particles: int, size: int, start: float, chosen: IntArray) -> int:
    """Systematic resampling: which particles the first `size` copies are of, into chosen; returns how many different ones went on.

    weights: of the first `particles`, sum one. start: uniform on [0, 1). The expected number of copies of particle i is
    size * weights[i], and its number is that rounded down or up. Copies of one particle are neighbours.
    """
    taken, total, different = 0, 0.0, 0
    for i in range(particles):
        total += weights[i]
        if i == particles - 1:
            total = 2.0
        first = taken
        while taken < size and (taken + start) < total * size:
            chosen[taken] = i
            taken += 1
        if taken > first:
            different += 1
    return different


@lean_kernel
def places_of(tile: int, chosen: IntArray, size: int, width: int, places: Places) -> None:
    """Where the chosen particles of a tile stand in the table, all its numbers in one line; lanes behind the last: where it stands."""
    for i in range(LANES):
        source = chosen[min(tile * LANES + i, size - 1)]
        places[i] = np.uint64(source // LANES * width + source % LANES)


@vector_kernel
def copy_columns(numbers: FloatArray, places: Places, row: FloatArray, first: int, last: int) -> None:
    """A tile's columns from `first` to before `last`. numbers: all of a table, in one line. places: of `places_of`."""
    for column in range(first, last, LANES):
        # unsigned together, or a place might count from the end
        at, values = np.uint64(column), row[column : column + LANES]
        for i in range(LANES):
            values[i] = numbers[places[i] + at]
