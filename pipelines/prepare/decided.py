"""A drive after a step of preparation, with what was decided in its import record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from parsers.drive import Decision, Drive, Signal


def decided(drive: Drive, said: Sequence[Decision], signals: Mapping[str, Signal] | None = None) -> Drive:
    """The drive with these decisions behind those of its record; itself where there are none. signals: in place of its own."""
    if not said:
        return drive
    record = replace(drive.record, decisions=(*drive.record.decisions, *said))
    return replace(drive, signals=drive.signals if signals is None else dict(signals), record=record)
