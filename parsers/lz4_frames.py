"""LZ4 frames unpacked into memory that is there: liblz4, called out of the package `lz4`.

The package's own functions unpack into memory of theirs and copy it to an object while they hold the interpreter's lock: a tenth
of the time that an lz4 bag takes on one core, a sixth on two.
Source: https://github.com/lz4/lz4/blob/dev/lib/lz4frame.h.
"""

from __future__ import annotations

import ctypes
import functools
import weakref
from dataclasses import dataclass
from typing import Any

import lz4.frame
import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel
from parsers.jit_foreign import address_of_byte, address_of_number, call_1, call_6

VERSION = 100
"""LZ4F_VERSION: of the interface."""


class Lz4Error(Exception):
    """A frame is damaged; str() is the reason in words."""


@dataclass(frozen=True)
class _Library:
    make: Any
    free: Any
    reset: Any
    decompress: Any
    is_error: Any


@functools.cache
def _library() -> _Library | None:
    """liblz4's functions for frames; None where the package keeps them to itself."""
    try:
        # the lock is given up during the one call that takes its time; the others are done at once
        slow, quick = (load(lz4.frame._frame.__file__) for load in (ctypes.CDLL, ctypes.PyDLL))
        make, free = quick.LZ4F_createDecompressionContext, quick.LZ4F_freeDecompressionContext
        reset, is_error = quick.LZ4F_resetDecompressionContext, quick.LZ4F_isError
        decompress = slow.LZ4F_decompress
    except (AttributeError, OSError):
        return None
    size, place = ctypes.c_size_t, ctypes.c_void_p
    make.argtypes, make.restype = (place, ctypes.c_uint), size
    free.argtypes, free.restype = (place,), size
    reset.argtypes, reset.restype = (place,), None
    is_error.argtypes, is_error.restype = (size,), ctypes.c_uint
    decompress.argtypes, decompress.restype = (place,) * 6, size
    return _Library(make, free, reset, decompress, is_error)


@dataclass(frozen=True)
class Addresses:
    """Where liblz4's LZ4F_resetDecompressionContext, LZ4F_decompress and a context lie, for kernels; 0 without them."""

    reset: int = 0
    decompress: int = 0
    context: int = 0


class FrameUnpacker:
    """Unpacks one frame after the other; of one thread at a time."""

    def __init__(self) -> None:
        self._library = _library()
        self._context = ctypes.c_void_p()
        if self._library is None:
            return
        if self._library.is_error(self._library.make(ctypes.byref(self._context), VERSION)):
            self._library = None
            return
        weakref.finalize(self, self._library.free, self._context)

    @property
    def addresses(self) -> Addresses:
        """What `unpack` calls, and with what; good as long as this object is."""
        if self._library is None:
            return Addresses()
        reset, decompress = (
            ctypes.cast(function, ctypes.c_void_p).value or 0
            for function in (self._library.reset, self._library.decompress)
        )
        return Addresses(reset, decompress, self._context.value or 0)

    def unpack(self, packed: memoryview | bytes | ByteArray, out: ByteArray) -> int:
        """How many bytes of the frame came to `out`: all that there is room for, or all that `packed` holds.

        The frame's checksums are compared where there is room for more than it holds. Raises Lz4Error where it is damaged.
        """
        source = np.frombuffer(packed, np.uint8)
        if self._library is None:
            return _copied(source, out)
        library, at, done = self._library, 0, 0
        library.reset(self._context)
        while True:
            room, left = ctypes.c_size_t(out.size - done), ctypes.c_size_t(source.size - at)
            found = library.decompress(
                self._context, out.ctypes.data + done, ctypes.byref(room), source.ctypes.data + at, ctypes.byref(left), None
            )  # fmt: skip
            if library.is_error(found):
                raise Lz4Error("lz4 finds an error")
            done, at = done + room.value, at + left.value
            if found == 0 or (room.value == 0 and left.value == 0):
                return done


def _copied(source: ByteArray, out: ByteArray) -> int:
    """The same with the package's own functions."""
    try:
        context = lz4.frame.create_decompression_context()
        unpacked, _, _ = lz4.frame.decompress_chunk(context, source.data, max_length=out.size)
    except (RuntimeError, ValueError, EOFError, MemoryError) as error:
        raise Lz4Error("lz4 finds an error") from error
    out[: len(unpacked)] = np.frombuffer(unpacked, np.uint8)
    return len(unpacked)


@kernel
def unpack_frame(
    data: ByteArray,
    at: int,
    held: int,
    out: ByteArray,
    first: int,
    reset: int,
    decompress: int,
    context: int,
    state: IntArray,
    parts: int,
) -> int:
    """How many bytes of the frame data[at : at + held] came to out[first:]; -1 where it is damaged. For kernels, unchecked.

    reset, decompress, context: `Addresses`. state[parts : parts + 2]: for the calls.
    """
    call_1(reset, context)
    begin, done = at, 0
    while True:
        state[parts], state[parts + 1] = out.size - first - done, at + held - begin
        found = call_6(
            decompress,
            context,
            address_of_byte(out, first + done),
            address_of_number(state, parts),
            address_of_byte(data, begin),
            address_of_number(state, parts + 1),
            0,
        )
        # an error is a number just below 2**64
        if found < 0:
            return -1
        done, begin = done + int(state[parts]), begin + int(state[parts + 1])
        if found == 0 or (state[parts] == 0 and state[parts + 1] == 0):
            return done
