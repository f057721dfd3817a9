"""Payloads one behind the other, as decoders take them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from parsers.channels import IntArray


def laid_out(payloads: Sequence[bytes]) -> tuple[NDArray[np.uint8], IntArray, IntArray]:
    """The bytes, and where each of the payloads begins and how long it is, (n,)."""
    length = np.array([len(p) for p in payloads], dtype=np.int64)
    return np.frombuffer(b"".join(payloads), dtype=np.uint8), np.cumsum(length) - length, length
