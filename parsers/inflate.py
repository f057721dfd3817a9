"""Many deflated streams with one call: libdeflate, called by a kernel.

Called from Python for one stream after the other, threads that inflate ask for the interpreter's lock some thousand times in
a log. They stop and wake each other for it, and that takes longer than what a second core inflates meanwhile.
"""

from __future__ import annotations

import ctypes
import functools
import sys
from dataclasses import dataclass
from typing import Any

import deflate
import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel
from parsers.jit_foreign import call_6


@dataclass(frozen=True)
class _Library:
    """libdeflate's functions for zlib streams, of which `inflate` and `crc32` are addresses."""

    make: Any
    inflate: int
    free: Any
    crc32: int


@functools.cache
def _library() -> _Library | None:
    """Out of the package `deflate`; None where it keeps them to itself."""
    if sys.maxsize < 1 << 32:
        return None
    try:
        # both are done in no time: the interpreter's lock is kept
        found = ctypes.PyDLL(deflate._deflate.__file__)
        make, free = found.libdeflate_alloc_decompressor, found.libdeflate_free_decompressor
        address, crc32 = (
            ctypes.cast(function, ctypes.c_void_p).value
            for function in (found.libdeflate_zlib_decompress, found.libdeflate_crc32)
        )
    except (AttributeError, OSError):
        return None
    make.argtypes, make.restype = (), ctypes.c_void_p
    free.argtypes, free.restype = (ctypes.c_void_p,), None
    return _Library(make, address, free, crc32) if address and crc32 else None


def crc32_address() -> int:
    """Where libdeflate_crc32 (checksum so far, address, bytes) lies, for kernels; 0 without it."""
    library = _library()
    return library.crc32 if library else 0


@kernel
def _inflate(
    function: int,
    state: int,
    source: int,
    begins: IntArray,
    sizes: IntArray,
    out: int,
    places: IntArray,
    rooms: IntArray,
    whole: NDArray[np.bool_],
) -> None:
    """function, state, source, out: addresses."""
    for i in range(begins.size):
        # the last: where the size of what came out would go; without, it must be all that there is room for
        got = call_6(function, state, source + begins[i], sizes[i], out + places[i], rooms[i], 0)
        # an enumeration: what is above its 32 bits may be anything
        whole[i] = got & 0xFFFFFFFF == 0


def inflate_all(
    source: ByteArray, begins: IntArray, sizes: IntArray, out: ByteArray, places: IntArray, rooms: IntArray
) -> NDArray[np.bool_] | None:
    """Inflate zlib streams into a buffer; which of them came out whole: (n,) bool.

    begins, sizes: (n,) int64, where each stream is in `source`. places, rooms: (n,) int64, where each goes in `out`, and how
    many bytes exactly it is to give; of one that is not whole anything may stand there. None where it cannot be done with
    one call: the package `deflate` then has to be asked for every stream. Raises ValueError where a stream or its place lies
    outside of the buffers.
    """
    library = _library()
    if library is None:
        return None
    for at, size, buffer in ((begins, sizes, source), (places, rooms, out)):
        if at.size and (min(at.min(), size.min()) < 0 or (at + size).max() > buffer.size):
            raise ValueError("a stream, or its place, lies outside of its buffer")
    whole = np.zeros(begins.size, np.bool_)
    state = library.make()
    if not state:
        return None
    try:
        _inflate(
            library.inflate, state, source.ctypes.data, begins, sizes, out.ctypes.data, places, rooms, whole
        )
    finally:
        library.free(state)
    return whole
