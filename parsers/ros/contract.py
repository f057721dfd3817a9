"""What a container (bag, MCAP) needs of a message decoder: fields of a type, and payloads to columns in bulk."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from parsers.channels import ByteArray, FloatArray, IntArray


@dataclass(frozen=True)
class FieldInfo:
    """One scalar inside a message type. path: "angular_velocity.z", "wheel_speeds[0]"; kind as in ChannelInfo, or "letter": of
    a text, as the number of its byte, which can be asked for and is no channel. element: what messages call the element of a list that it belongs to."""

    path: str
    kind: str
    unit: str | None = None
    comment: str = ""
    element: str = ""


Cells = Callable[[int], FloatArray]
"""Gives room for so many numbers, with anything in it."""


MISFIT = "message that does not fit its type's definition"


@dataclass(frozen=True)
class Decoded:
    """Columns of a batch of payloads, in their order.

    columns: field path -> (n,) float64, NaN where a message has no such element or could not be decoded.
    stamp_ns: (n,) int64 header stamps, or None where the type has no header (0 where a header is empty).
    bad: how many payloads could not be read; their rows are NaN. why_bad: what they are, for the import record.
    """

    columns: Mapping[str, FloatArray]
    stamp_ns: IntArray | None
    bad: int
    why_bad: str = MISFIT


class MessageDecoder(Protocol):
    """Decodes one message type. `fields` lists what it can give (fixed-size arrays element by element)."""

    @property
    def fields(self) -> Sequence[FieldInfo]:
        """All numbers and texts of the type."""
        ...

    @property
    def has_header(self) -> bool:
        """Whether messages have a stamp of their own."""
        ...

    def decode(
        self,
        data: ByteArray,
        offset: IntArray,
        length: IntArray,
        wanted: Sequence[str],
        cells: Cells = np.empty,
    ) -> Decoded:
        """Decode payload i = data[offset[i] : offset[i] + length[i]] for all i; only the wanted field paths.

        cells: gives the columns' memory.
        """
        ...
