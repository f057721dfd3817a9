"""Channels whose bits lie in one word of eight bytes of the record: what compiled kernels read with one load."""

from __future__ import annotations

from dataclasses import dataclass

from parsers.mf4.model import FIXED, MASTER, Channel, Group
from parsers.mf4.values import FLOAT_LE, INT_LE, UINT_LE, fault

WORD = 8


@dataclass(frozen=True)
class Word:
    """at: the word's first byte in the record. shift, bits: where in it the value is (from the lowest bit)."""

    at: int
    shift: int
    bits: int
    kind: int

    @property
    def mask(self) -> int:
        """The value's bits behind the shift, as an int64: -1 for all 64."""
        return (1 << self.bits) - 1 if self.bits < 64 else -1


def word_of(channel: Channel, group: Group, *kinds: int) -> Word | None:
    """Where a channel of one of the data types is; None where it needs more than one load, or the record is too short.

    The word lies within the record (its part before the invalidation bytes), so that no load leaves it.
    """
    if (
        channel.kind not in (FIXED, MASTER)
        or channel.data_type not in kinds
        or fault(channel, group) is not None
        or channel.byte_count > WORD
        or group.invalid_at < WORD
        or (channel.data_type == FLOAT_LE and channel.bit_count not in (32, 64))
    ):
        return None
    at = min(channel.byte_offset, group.invalid_at - WORD)
    return Word(at, channel.bit_offset + 8 * (channel.byte_offset - at), channel.bit_count, channel.data_type)


NUMBERS = (UINT_LE, INT_LE, FLOAT_LE)
