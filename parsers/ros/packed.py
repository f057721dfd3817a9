"""Messages that rosbag2 compressed one by one and put into an MCAP file: unpacked before they are decoded.

The file itself does not say so, only the bag's metadata.yaml, which may be elsewhere; plain CDR never looks like zstd.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.ros.bag2_messages import MAX_MESSAGE, ZSTD_MARK, frame_sizes, unpack_at
from parsers.ros.bag2_rows import Rows
from parsers.ros.contract import Cells, Decoded, FieldInfo, MessageDecoder

_MARK = ZSTD_MARK.to_bytes(4, "little")


@dataclass(frozen=True)
class UnpackingDecoder:
    """A decoder of plain messages that also takes compressed ones. A damaged one counts as bad."""

    plain: MessageDecoder

    @property
    def fields(self) -> Sequence[FieldInfo]:
        """All numbers and texts of the type."""
        return self.plain.fields

    @property
    def has_header(self) -> bool:
        """Whether messages have a stamp of their own."""
        return self.plain.has_header

    def decode(
        self,
        data: ByteArray,
        offset: IntArray,
        length: IntArray,
        wanted: Sequence[str],
        cells: Cells = np.empty,
    ) -> Decoded:
        """As `MessageDecoder.decode`."""
        # a recorder compresses all messages or none
        if not len(offset) or data[offset[0] : offset[0] + 4].tobytes() != _MARK:
            return self.plain.decode(data, offset, length, wanted, cells)
        data = data.view()
        data.flags.writeable = False
        sizes = np.empty(len(offset), dtype=np.int64)
        frame_sizes(data, offset, length, sizes)
        at = np.flatnonzero((sizes > 0) & (sizes <= MAX_MESSAGE))
        rows = Rows(np.zeros_like(offset), np.zeros_like(offset), offset, length, data)
        unpacked, found, good = unpack_at(rows, at, sizes[at])
        start, size = np.zeros_like(offset), np.zeros_like(length)
        start[at[good]], size[at[good]] = np.cumsum(found) - found, found
        return self.plain.decode(unpacked, start, size, wanted, cells)
