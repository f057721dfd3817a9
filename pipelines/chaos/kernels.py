"""Compiled loops of the expansions: polynomials of one variable, index sets, their products at points.

An index set is walked as a tree. Each node multiplies its parent's value by one polynomial of one variable, so that a
term costs one multiplication however many variables it has. Nodes stand in the order of a walk in depth: a parent's
value is the last one that was made one level above, and only one value a level is kept.
"""

from __future__ import annotations

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.jit import kernel

BLOCK = 256
MATRIX_BLOCK = 64
"""Points taken together: their tables stay in the near caches, and the processor works on several at once. Fewer where
the values of all terms are kept."""

TILE = 16
"""Terms turned from columns into rows together."""


@kernel
def polynomials(x: FloatArray, centre: FloatArray, root: FloatArray, out: FloatArray) -> None:
    """Fill out (order + 1, n or more) with the orthonormal polynomials at x (n,). centre, root: (order + 1,)."""
    degrees = centre.shape[0]
    n = x.shape[0]
    for i in range(n):
        out[0, i] = 1.0
    for k in range(degrees - 1):
        shift = centre[k]
        hold = root[k]
        scale = 1.0 / root[k + 1]
        before = out[max(k - 1, 0)]
        now = out[k]
        after = out[k + 1]
        # root[0] is 0, so that the first step asks nothing of the polynomial before p[0]
        for i in range(n):
            after[i] = ((x[i] - shift) * now[i] - hold * before[i]) * scale


@kernel
def fill_total_degree(order: int, out: IntArray) -> None:
    """Fill out (S, d) with all index rows of sum <= order: by sum, then the earlier variables' powers first."""
    rows, d = out.shape
    row = 0
    for degree in range(order + 1):
        for j in range(d):
            out[row, j] = 0
        out[row, 0] = degree
        row += 1
        while row < rows:
            # the next row of this sum: one less of the last power before the final column, the rest right after it
            place = d - 2
            while place >= 0 and out[row - 1, place] == 0:
                place -= 1
            if place < 0:
                break
            for j in range(d):
                out[row, j] = out[row - 1, j]
            rest = out[row, d - 1]
            out[row, d - 1] = 0
            out[row, place] -= 1
            out[row, place + 1] = rest + 1
            row += 1


@kernel
def grow_tree(indices: IntArray, order: IntArray, nodes: IntArray, place: IntArray, path: IntArray) -> int:
    """Fill nodes (T, 3) with level, variable, degree of each; place (S,) with each row's node. Returns their number.

    indices: (S, d). order: (S,), the rows sorted lexicographically. path: (d,), work. Node 0 is the root (all zeros,
    level 0). nodes has room for one node a non-zero index, and the root.
    """
    rows, d = indices.shape
    nodes[0, 0] = 0
    nodes[0, 1] = 0
    nodes[0, 2] = 0
    count = 1
    for j in range(d):
        path[j] = 0
    for i in range(rows):
        row = order[i]
        same = 0
        level = 0
        while same < d and indices[row, same] == path[same]:
            if path[same] != 0:
                level += 1
            same += 1
        for j in range(same, d):
            path[j] = indices[row, j]
            if path[j] != 0:
                level += 1
                nodes[count, 0] = level
                nodes[count, 1] = j
                nodes[count, 2] = path[j]
                count += 1
        # a walk in depth: the row ends at the newest node, or where the one before it did
        place[row] = count - 1
    return count


@kernel
def _tables(
    points: FloatArray, start: int, stop: int, centre: FloatArray, root: FloatArray, table: FloatArray
) -> None:
    """Fill table (d, order + 1, a block or more) for the points from start to stop."""
    column = np.empty(stop - start)
    for j in range(centre.shape[0]):
        # side by side, so that the recurrence runs on several points at once
        for b in range(stop - start):
            column[b] = points[start + b, j]
        polynomials(column, centre[j], root[j], table[j])


@kernel
def fill_matrix(
    points: FloatArray,
    centre: FloatArray,
    root: FloatArray,
    nodes: IntArray,
    place: IntArray,
    levels: int,
    out: FloatArray,
) -> None:
    """Fill out (Q, S) with each row's product of polynomials at each point.

    points: (Q, d). centre, root: (d, order + 1). nodes: (T, 3) and place: (S,) of `grow_tree`. levels: the deepest.
    """
    q = points.shape[0]
    d, degrees = centre.shape
    table = np.empty((d, degrees, MATRIX_BLOCK))
    value = np.empty((nodes.shape[0], MATRIX_BLOCK))
    last = np.zeros(levels + 1, dtype=np.int64)
    for start in range(0, q, MATRIX_BLOCK):
        stop = min(q, start + MATRIX_BLOCK)
        _tables(points, start, stop, centre, root, table)
        for b in range(MATRIX_BLOCK):
            value[0, b] = 1.0
        for t in range(1, nodes.shape[0]):
            level = nodes[t, 0]
            parent = value[last[level - 1]]
            factor = table[nodes[t, 1], nodes[t, 2]]
            mine = value[t]
            for b in range(stop - start):
                mine[b] = parent[b] * factor[b]
            last[level] = t
        # turned over in tiles: neither side is walked across its lines for long
        for first in range(0, place.shape[0], TILE):
            for b in range(stop - start):
                for s in range(first, min(place.shape[0], first + TILE)):
                    out[start + b, s] = value[place[s], b]


@kernel
def fill_values(
    points: FloatArray,
    centre: FloatArray,
    root: FloatArray,
    nodes: IntArray,
    levels: int,
    weights: FloatArray,
    out: FloatArray,
) -> None:
    """Fill out (Q, m) with the sums over the nodes of weights (T, m) times the nodes' products at each point.

    points, centre, root, nodes, levels: as in `fill_matrix`.
    """
    q = points.shape[0]
    d, degrees = centre.shape
    outputs = weights.shape[1]
    table = np.empty((d, degrees, BLOCK))
    value = np.empty((levels + 1, BLOCK))
    total = np.empty((outputs, BLOCK))
    for b in range(BLOCK):
        value[0, b] = 1.0
    for start in range(0, q, BLOCK):
        stop = min(q, start + BLOCK)
        _tables(points, start, stop, centre, root, table)
        for o in range(outputs):
            for b in range(BLOCK):
                total[o, b] = weights[0, o]
        for t in range(1, nodes.shape[0]):
            level = nodes[t, 0]
            parent = value[level - 1]
            factor = table[nodes[t, 1], nodes[t, 2]]
            mine = value[level]
            for b in range(stop - start):
                mine[b] = parent[b] * factor[b]
            for o in range(outputs):
                weight = weights[t, o]
                row = total[o]
                for b in range(stop - start):
                    row[b] += weight * mine[b]
        for o in range(outputs):
            for b in range(stop - start):
                out[start + b, o] = total[o, b]
