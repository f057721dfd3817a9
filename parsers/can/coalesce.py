"""Small batches of frames drawn together, so that work for each batch is done for many frames at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from parsers.can.frames import CanFrames

ENOUGH_FRAMES = 1 << 17
ENOUGH_BYTES = 8 << 20


def coalesced(batches: Iterable[CanFrames]) -> Iterator[CanFrames]:
    """The same frames in the same order, in batches of ENOUGH_FRAMES or ENOUGH_BYTES where they came smaller."""
    kept: list[CanFrames] = []
    frames = size = 0
    for batch in batches:
        kept.append(batch)
        frames += batch.time_ns.size
        size += batch.data.size
        if frames >= ENOUGH_FRAMES or size >= ENOUGH_BYTES:
            yield _joined(kept)
            kept, frames, size = [], 0, 0
    if kept:
        yield _joined(kept)


def _joined(batches: list[CanFrames]) -> CanFrames:
    if len(batches) == 1:
        return batches[0]
    starts = np.cumsum([0, *(batch.data.size for batch in batches[:-1])])
    return CanFrames(
        time_ns=np.concatenate([batch.time_ns for batch in batches]),
        can_id=np.concatenate([batch.can_id for batch in batches]),
        bus=np.concatenate([batch.bus for batch in batches]),
        length=np.concatenate([batch.length for batch in batches]),
        offset=np.concatenate([batch.offset + start for batch, start in zip(batches, starts, strict=True)]),
        data=np.concatenate([batch.data for batch in batches]),
    )
