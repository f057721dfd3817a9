"""Whether a log was cut within the payload of its last frame: in candump's files "11" of "1122" is a payload too, and a wrong one."""

from __future__ import annotations

from parsers.can.frames import CanFrames

TAIL_BYTES = 1 << 20
"""So much of the log's end is looked at for frames of the same identifier."""


def last_is_cut(frames: CanFrames) -> bool:
    """Whether the last frame has fewer bytes than all others of its identifier and bus; False where there are none."""
    if frames.time_ns.size < 2:
        return False
    same = (frames.can_id[:-1] == frames.can_id[-1]) & (frames.bus[:-1] == frames.bus[-1])
    others = frames.length[:-1][same]
    return bool(others.size and frames.length[-1] < others.min())


def without_last(frames: CanFrames) -> CanFrames:
    """The frames but for the last one."""
    n = frames.time_ns.size - 1
    return CanFrames(
        frames.time_ns[:n],
        frames.can_id[:n],
        frames.bus[:n],
        frames.length[:n],
        frames.offset[:n],
        frames.data,
    )
