"""CAN frames in columns: what every CAN format yields and what the DBC decoder takes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, IntArray

EXTENDED = 0x8000_0000
"""Set in `CanFrames.can_id` for a 29-bit identifier (as socketcan and DBC files have it)."""


class FrameColumns(NamedTuple):
    """`CanFrames` of one type and layout a column."""

    time_ns: IntArray
    can_id: NDArray[np.uint32]
    bus: NDArray[np.int16]
    length: ByteArray
    offset: IntArray
    data: ByteArray


@dataclass(frozen=True)
class CanFrames:
    """A batch of data frames (no error and no remote frames: the format counts those as rejected).

    time_ns: (n,) int64. can_id: (n,) uint32, EXTENDED bit included. bus: (n,) int16, 1 for the first channel.
    length: (n,) uint8, payload bytes (0-64), or uint16 (J1939 messages of several packets have up to 1785). offset: (n,) int64, where each payload begins in `data`.
    data: (m,) uint8, the buffer that holds the payloads; it may hold anything else between them. The arrays may be used
    again for the next batch: a batch is good until then.
    """

    time_ns: IntArray
    can_id: NDArray[np.uint32]
    bus: NDArray[np.int16]
    length: NDArray[np.uint8] | NDArray[np.uint16]
    offset: IntArray
    data: ByteArray

    def columns(self) -> FrameColumns:
        """As kernels take them. Of frames as they were sent alone: a message of several packets is longer than its column can say."""
        return FrameColumns(
            np.ascontiguousarray(self.time_ns, np.int64), np.ascontiguousarray(self.can_id, np.uint32),
            np.ascontiguousarray(self.bus, np.int16), np.ascontiguousarray(self.length, np.uint8),
            np.ascontiguousarray(self.offset, np.int64), np.ascontiguousarray(self.data, np.uint8),
        )  # fmt: skip


class FrameSource(Protocol):
    """An opened CAN log: what `parsers.can.reader.CanReader` needs of a format.

    clock, absolute, start_utc_ns as in `parsers.importer.LogReader`. `frames` yields batches bounded by a chunk, from
    the log's beginning at each call. The first pass, on opening, is made with `counting` and writes into the log book
    (messages, rejected, truncation); only where its frames do not fit into memory is there a second, without.
    """

    @property
    def clock(self) -> str:
        """Which clock the stamps are from, in words."""
        ...

    @property
    def absolute(self) -> bool:
        """Whether stamps count from 1970."""
        ...

    @property
    def start_utc_ns(self) -> int | None:
        """Wall clock of stamp 0; None where the stamps say it themselves or nothing is known."""
        ...

    def frames(self, *, counting: bool) -> Iterator[CanFrames]:
        """Yield all frames in batches; with counting also into the log book."""
        ...
