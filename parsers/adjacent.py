"""Pieces of a column that lie one behind the other in memory already."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T", bound=np.generic)


def joined(pieces: Sequence[NDArray[T]]) -> NDArray[T]:
    """One-dimensional pieces end to end: a view where they are neighbours in one block of memory, else a copy."""
    first = pieces[0]
    if len(pieces) == 1:
        return first
    block = first.base
    if not isinstance(block, np.ndarray) or not block.flags.c_contiguous:
        return np.concatenate(pieces)
    begin = at = first.ctypes.data
    for piece in pieces:
        neighbour = piece.base is block and piece.dtype == first.dtype and piece.ctypes.data == at
        if not neighbour or not piece.flags.c_contiguous:
            return np.concatenate(pieces)
        at += piece.nbytes
    shift = begin - block.ctypes.data
    return block.reshape(-1).view(np.uint8)[shift : shift + at - begin].view(first.dtype)
