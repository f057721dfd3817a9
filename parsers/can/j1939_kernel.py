"""Which frames are of a J1939 parameter group on data page 0, by their identifiers alone."""

from __future__ import annotations

import numpy as np

from parsers.can.slots import IdArray
from parsers.jit import kernel

GROUP = 0x83FF0000
"""Of an identifier: that it is extended, its data pages, and its PDU format."""


@kernel
def count_groups(can_id: IdArray, one: int, other: int) -> int:
    """How many frames are of either kind, each an identifier's GROUP bits."""
    count = 0
    for i in range(can_id.size):
        kind = np.int64(can_id[i]) & GROUP
        count += int((kind == one) | (kind == other))
    return count
