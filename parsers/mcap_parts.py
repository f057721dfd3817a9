"""What is wanted of an MCAP file's topics, and what decoding a piece of it gives."""

from __future__ import annotations

from dataclasses import dataclass

from parsers.channels import IntArray
from parsers.ros.contract import Decoded, MessageDecoder

ENOUGH_CELLS = 1 << 15
"""A part of a topic with more is given on as it is; smaller ones are joined."""


@dataclass(frozen=True)
class Want:
    """What is wanted of one topic: the ids of its MCAP channels, its decoder, and field paths."""

    ids: tuple[int, ...]
    decoder: MessageDecoder
    paths: tuple[str, ...]


@dataclass(frozen=True)
class Part:
    """Decoded messages of one topic, in the order of the file."""

    number: int
    log_ns: IntArray
    decoded: Decoded
