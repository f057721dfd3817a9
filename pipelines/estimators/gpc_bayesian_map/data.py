"""What the engine takes from a log: inputs and outputs of a model in blocks without gaps, the lively ones only."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipelines.estimators.base_excitation.blocks import Blocks, ComplexArray, lay_blocks
from pipelines.models.record import Model
from pipelines.prepare.prepared import Prepared
from pipelines.results import FloatArray

LONGEST_RUN = 6_000
"""Rows that the model is run over at once: bounds memory whatever the drive's length."""


@dataclass(frozen=True)
class ModelData:
    """inputs (n, i), outputs (n, o): on one grid. blocks: those that are used. seen: the outputs in the band, (b, f, o).

    groups: for each interval the runs (first block, past the last) whose blocks follow each other without a gap.
    settle: rows before a run from which the model starts. rough: share of the usable rows that is lively. why_not: "" or why
    nothing can be used.
    """

    inputs: FloatArray
    outputs: FloatArray
    rate_hz: float
    blocks: Blocks
    seen: ComplexArray
    groups: tuple[tuple[tuple[int, int], ...], ...]
    settle: int
    rough: float
    input_rms: float
    why_not: str = ""

    @property
    def step_s(self) -> float:
        """Between rows."""
        return 1 / self.rate_hz


def _centred(column: FloatArray, prepared: Prepared) -> FloatArray:
    out = np.zeros(len(column))
    for segment in prepared.segments:
        piece = column[segment.start : segment.stop]
        out[segment.start : segment.stop] = piece - piece.mean()
    return out


def _lively(blocks: Blocks, inputs: FloatArray, least: float, most: int) -> tuple[Blocks, FloatArray, float]:
    """The blocks whose inputs move enough in the band (the liveliest `most`), their RMS, and that of all blocks."""
    if blocks.count == 0:
        return blocks, np.zeros(0), 0.0
    power = np.zeros(blocks.count)
    for column in inputs.T:
        cut = blocks.cut(np.ascontiguousarray(column))
        power += np.var(cut, axis=1) / inputs.shape[1]
    rms = np.sqrt(power)
    keep = rms >= least
    if keep.sum() > most:
        keep &= rms >= np.sort(rms[keep])[-most]
    return blocks.only(keep), rms, float(np.sqrt(power.mean()))


def _runs(blocks: Blocks, first: int, past: int) -> tuple[tuple[int, int], ...]:
    """Blocks first .. past - 1 as runs without a gap, none longer than LONGEST_RUN rows."""
    runs: list[tuple[int, int]] = []
    start = first
    for b in range(first + 1, past + 1):
        broken = b == past or blocks.first[b] != blocks.first[b - 1] + blocks.rows
        if broken or blocks.first[b] + blocks.rows - blocks.first[start] > LONGEST_RUN:
            runs.append((start, b))
            start = b
    return tuple(runs)


def collect(
    prepared: Prepared,
    model: Model,
    *,
    band_hz: tuple[float, float],
    block_s: float,
    intervals: int,
    least_input: float,
    most_blocks: int,
) -> ModelData:
    """Cut and choose. Where nothing can be used, `why_not` says it in words."""
    names = (*model.inputs, *model.outputs)
    rows = len(prepared.time_s)
    columns = [prepared.columns[n] if n in prepared.columns else np.zeros(rows) for n in names]
    count = len(model.inputs)
    if model.centred:
        columns = [_centred(c, prepared) for c in columns[:count]] + columns[count:]
    inputs = np.column_stack(columns[:count]) if rows else np.zeros((0, count))
    outputs = np.column_stack(columns[count:]) if rows else np.zeros((0, len(model.outputs)))
    settle = round(model.settle_s * prepared.rate_hz)
    stretches = [(s.start + settle, s.stop) for s in prepared.segments if s.stop > s.start + settle]
    rate = max(prepared.rate_hz, 1e-6)
    laid = lay_blocks(stretches, rate, block_s, band_hz)
    blocks, rms, middle = _lively(laid, inputs, least_input, most_blocks)
    lively = float(np.mean(rms >= least_input)) if len(rms) else 0.0
    why = ""
    if not laid.count:
        why = "; ".join(prepared.notes) or f"no stretch of {block_s + model.settle_s:g} s without a gap"
    elif len(laid.bins) < 3:
        why = f"the signals are too slow for {band_hz[0]:g} to {band_hz[1]:g} Hz in blocks of {block_s:g} s"
    elif blocks.count < 3:
        why = (
            f"the inputs hardly move ({middle:.2g} RMS in their unit, {least_input:g} are needed): "
            "drive with more excitation"
        )
    edges = np.linspace(0, blocks.count, max(1, min(intervals, blocks.count)) + 1).astype(int)
    groups = tuple(_runs(blocks, int(i), int(j)) for i, j in pairwise(edges))
    seen = (
        np.stack([blocks.seen(np.ascontiguousarray(c)) for c in outputs.T], axis=-1)
        if blocks.count and len(blocks.bins)
        else np.zeros((0, 0, outputs.shape[1]), dtype=np.complex128)
    )
    return ModelData(inputs, outputs, rate, blocks, seen, groups, settle, lively, middle, why)
