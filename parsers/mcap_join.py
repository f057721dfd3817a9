"""Small parts of a topic joined to larger ones, so that whoever takes them does not get thousands of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from parsers.allocator import Slabs
from parsers.channels import FloatArray, IntArray
from parsers.mcap_parts import ENOUGH_CELLS, Part
from parsers.ros.contract import MISFIT, Decoded

ENOUGH_ROWS = 1 << 16


class Joiner:
    """Holds the parts of each topic until there are enough."""

    def __init__(self, topics: int, slabs: Slabs) -> None:
        """slabs: memory for what is joined."""
        self._slabs = slabs
        self._held: list[list[Part]] = [[] for _ in range(topics)]
        self._rows = [0] * topics

    def add(self, part: Part) -> Iterator[Part]:
        """Take a part in; yields what there is of its topic where that is enough."""
        held = self._held[part.number]
        held.append(part)
        self._rows[part.number] += part.log_ns.size
        rows = self._rows[part.number]
        if rows >= ENOUGH_ROWS or rows * len(part.decoded.columns) >= ENOUGH_CELLS:
            yield self._take(part.number)

    def rest(self) -> Iterator[Part]:
        """What is still held, at the end."""
        for number, held in enumerate(self._held):
            if held:
                yield self._take(number)

    def _take(self, number: int) -> Part:
        held, self._held[number] = self._held[number], []
        self._rows[number] = 0
        return held[0] if len(held) == 1 else _join(held, self._slabs)


def _join(parts: Sequence[Part], slabs: Slabs) -> Part:
    rows = sum(part.log_ns.size for part in parts)
    decoded = [part.decoded for part in parts]
    columns: dict[str, FloatArray] = {
        path: np.concatenate([each.columns[path] for each in decoded], out=slabs.cells(rows))
        for path in decoded[0].columns
    }
    stamps: list[IntArray] = [each.stamp_ns for each in decoded if each.stamp_ns is not None]
    stamp_ns = np.concatenate(stamps) if len(stamps) == len(parts) else None
    log_ns = np.concatenate([part.log_ns for part in parts])
    why_bad = next((each.why_bad for each in decoded if each.bad), MISFIT)
    bad = sum(each.bad for each in decoded)
    return Part(parts[0].number, log_ns, Decoded(columns, stamp_ns, bad, why_bad))
