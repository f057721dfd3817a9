"""CAN frames of a log as rows for the tests, whatever its format."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from parsers.can.frames import CanFrames
from parsers.importer import ImportLog, ReadOptions

Frame = tuple[int, int, int, bytes]
"""(time_ns, id with EXTENDED, bus, payload)."""


def rows_of(batches: Iterable[CanFrames]) -> list[Frame]:
    """Every frame of the batches."""
    rows: list[Frame] = []
    for batch in batches:
        for i in range(batch.time_ns.size):
            at = int(batch.offset[i])
            payload = batch.data[at : at + int(batch.length[i])].tobytes()
            rows.append((int(batch.time_ns[i]), int(batch.can_id[i]), int(batch.bus[i]), payload))
    return rows


def text_frames(importer: Any, path: Path, log: ImportLog | None = None) -> list[Frame]:
    """Every frame of a text log. What opening counted, which may have gone through the log already, is forgotten."""
    log = log or ImportLog()
    reader = importer.open(path, ReadOptions(), log)
    log.messages = 0
    log.rejected.clear()
    log.lost_spans_ns.clear()
    return rows_of(reader._source.frames(counting=True))
