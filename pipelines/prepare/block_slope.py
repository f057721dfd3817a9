"""Slopes of columns on one column beside others, with the spread that whole blocks of time scatter by."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from parsers.checks.grid import CELL_S
from pipelines.results import FloatArray

BLOCK_S = 4.0
LEAST_BLOCKS = 4
LARGEST = 1e4
"""Beyond it a column is no motion of a vehicle (m/s², or changes of it)."""


@dataclass(frozen=True)
class BlockSlopes:
    """values: slope of each column, (m,). std: of the first one, by the blocks' scatter. seconds: how long all were there."""

    values: tuple[float, ...]
    std: float
    seconds: float


def block_slopes(
    by: FloatArray, columns: Sequence[FloatArray], others: FloatArray, least: float, row_s: float = CELL_S
) -> BlockSlopes | None:
    """Slopes of `columns`, (n,) each, on `by` (n,), beside a constant and `others` (n, k), one row every row_s seconds.

    None where fewer than LEAST_BLOCKS blocks have all of them, or `by` moves by less than `least` rms beside the others.
    """
    good = (
        np.isfinite(by) & np.isfinite(others).all(axis=1) & np.isfinite(np.column_stack(columns)).all(axis=1)
    )
    size = round(BLOCK_S / row_s)
    count = int(good.sum()) // size
    if count < LEAST_BLOCKS:
        return None
    kept = np.flatnonzero(good)[: count * size]
    table = np.column_stack([np.ones(len(kept)), others[kept]])
    moved = np.column_stack([each[kept] for each in (by, *columns)])
    if max(float(np.abs(moved).max()), float(np.abs(table).max())) > LARGEST:
        return None
    own, first, *rest = (moved - table @ np.linalg.lstsq(table, moved, rcond=None)[0]).T
    power = float(own @ own)
    if math.sqrt(power / len(own)) < least:
        return None
    value = float(own @ first) / power
    scatter = (own * (first - value * own)).reshape(count, size).sum(axis=1)
    values = (value, *(float(own @ each) / power for each in rest))
    return BlockSlopes(values, math.sqrt(float(scatter @ scatter)) / power, len(own) * row_s)
