"""Columns that are whole from the beginning: all batches are counted first, so that each decodes to where its rows belong.

The pieces of a column then need not be brought together afterwards, which would touch as much memory again.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from parsers.allocator import Slab, room_of
from parsers.can.groups import Group
from parsers.can.spread import Piece
from parsers.channels import FloatArray, IntArray

WHOLE_BYTES = 64 << 20
"""Columns of more than this are decoded batch by batch: whoever takes them may bring them to the disk."""


Columns = Mapping[str, FloatArray]
"""Channel name -> (rows,)."""


@dataclass(frozen=True)
class Places:
    """Where the rows of one piece go. stamps: those of all parts, each part's from stamps_at (parts,) on.

    columns: of each group, None where they get memory of their own: where the group has not all of its message's frames. slab: what
    they lie in, None where they do not.
    """

    stamps: IntArray | None
    stamps_at: IntArray | None
    columns: Sequence[Columns | None]
    slab: Slab | None = None

    @classmethod
    def loose(cls, groups: Sequence[Group]) -> Places:
        """Everything gets memory of its own."""
        return cls(None, None, [None] * len(groups))


def places(
    pieces: deque[Piece], groups: Sequence[Group], parts: Sequence[int], wanted: frozenset[str]
) -> Iterator[tuple[Piece, Places]]:
    """The pieces of a log in order, each with the places of its rows.

    parts: of each group the part of a piece that it is made of. Takes the pieces out of the queue.
    """
    totals = sum((piece.counts for piece in pieces), np.zeros(max(parts) + 1, np.int64))
    names = [
        () if group.gates else tuple(name for name in group.signals if name in wanted) for group in groups
    ]
    sizes = [room_of(8 * int(totals[part])) * len(each) for part, each in zip(parts, names, strict=True)]
    size = sum(sizes) + room_of(8 * int(totals.sum()))
    if size > WHOLE_BYTES:
        while pieces:
            yield pieces.popleft(), Places.loose(groups)
        return
    slab = Slab(size)
    stamps, first = slab.empty(int(totals.sum()), np.int64), np.cumsum(totals) - totals
    columns = [
        {name: slab.empty(int(totals[part]), np.float64) for name in each}
        for part, each in zip(parts, names, strict=True)
    ]
    begin = np.zeros_like(totals)
    while pieces:
        piece = pieces.popleft()
        end = begin + piece.counts
        rows = [
            None if group.gates else {name: column[begin[part] : end[part]] for name, column in whole.items()}
            for group, part, whole in zip(groups, parts, columns, strict=True)
        ]
        yield piece, Places(stamps, first + begin, rows, slab)
        begin = end
