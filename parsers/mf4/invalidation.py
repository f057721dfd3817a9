"""Invalidation bits that are stored apart from the values (column-oriented storage: DI blocks of an LD list)."""

from __future__ import annotations

import bisect
from dataclasses import dataclass

import numpy as np

from parsers.channels import ByteArray
from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.mf4.model import Group
from parsers.mf4.streams import ALL_VALID, UNREADABLE, BitBlocks


@dataclass(frozen=True)
class BitSource:
    """The invalidation bytes of a group's records. blocks: None where the file has none for this group."""

    group: Group
    blocks: BitBlocks | None
    log: ImportLog

    def rows(self, first: int, count: int) -> ByteArray:
        """Of the records from `first` on, shape (count, bytes). All bits are set where they are not to be had, and it is said."""
        width = self.group.size - self.group.invalid_at
        out = np.zeros((count, width), np.uint8)
        if self.blocks is None:
            self.log.note(
                f"channel group {self.group.number} has invalidation bits that are not in the file: "
                "its samples are taken as valid"
            )
            return out
        size = self.group.invalid_at
        starts = self.blocks.values_at
        index = max(bisect.bisect_right(starts, first * size) - 1, 0)
        while index < len(starts) and starts[index] < (first + count) * size:
            # a block of values holds whole records; of one that does not, nobody knows whose bits are whose
            begin = max(starts[index] // size, first)
            last = starts[index + 1] if index + 1 < len(starts) else (first + count) * size
            end = min(last // size, first + count)
            aligned = starts[index] % size == 0
            self._fill(index, begin - starts[index] // size, out[begin - first : end - first], aligned)
            index += 1
        return out

    def _fill(self, index: int, skip: int, out: ByteArray, aligned: bool) -> None:
        """The bytes of some records of one block, behind `skip` records of it."""
        assert self.blocks is not None
        at, bits = self.blocks.bits_at[index], self.blocks.bits
        if at == ALL_VALID or not out.size:
            return
        if at != UNREADABLE and aligned:
            begin = at + skip * out.shape[1]
            try:
                out[:] = bits.read(begin, begin + out.size).reshape(out.shape)
            except LogError:
                pass
            else:
                return
        out[:] = 0xFF
        self.log.worsen(
            "malformed",
            f"invalidation bits of channel group {self.group.number} cannot be read: the samples that they belong to "
            "were left out",
        )
