"""Where libzstd lies, for kernels to call: out of the package `zstandard`.

The package's own functions unpack a chunk as fast, but come back for the interpreter's lock at every chunk.
Source: https://facebook.github.io/zstd/zstd_manual.html.
"""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import sys
import weakref
from dataclasses import dataclass
from typing import Any

_HOLDS_IT = "zstandard._cffi"
"""Of the package's two ways to libzstd the one that lets others call it too. Only its file is opened."""


@dataclass(frozen=True)
class _Library:
    """libzstd's functions for a context, of which `decompress` is an address."""

    make: Any
    free: Any
    decompress: int


@functools.cache
def _library() -> _Library | None:
    """None where the package keeps its library to itself."""
    if sys.maxsize < 1 << 32:
        return None
    try:
        spec = importlib.util.find_spec(_HOLDS_IT)
        if spec is None or spec.origin is None:
            return None
        # both are done in no time: the interpreter's lock is kept
        found = ctypes.PyDLL(spec.origin)
        make, free = found.ZSTD_createDCtx, found.ZSTD_freeDCtx
        address = ctypes.cast(found.ZSTD_decompressDCtx, ctypes.c_void_p).value
    except (AttributeError, OSError, ValueError):
        return None
    make.argtypes, make.restype = (), ctypes.c_void_p
    free.argtypes, free.restype = (ctypes.c_void_p,), ctypes.c_size_t
    return _Library(make, free, address) if address else None


class ZstdContext:
    """libzstd's state for unpacking one chunk after the other; of one thread at a time.

    decompress, context: where ZSTD_decompressDCtx and its context lie; 0 where they cannot be had.
    """

    def __init__(self) -> None:
        self.decompress = self.context = 0
        library = _library()
        if library is None:
            return
        self.context = library.make() or 0
        if self.context:
            self.decompress = library.decompress
            weakref.finalize(self, library.free, self.context)
