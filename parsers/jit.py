"""Compiled kernels: one typed door to numba, so that the rest of the code stays strictly typed.

Kernels are cached on disk: the first call on a machine compiles, every later start loads.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any, ParamSpec, TypeVar, cast

import numba
from numba.core import types
from numba.extending import intrinsic

from parsers.channels import ByteArray

P = ParamSpec("P")
R = TypeVar("R")

_LEAN: dict[str, Any] = {"_nrt": False, "forceinline": True}

_SCIPY_BLAS = "scipy.linalg.cython_blas"


def _without_scipy() -> None:
    """Load the part of numba that looks for scipy's linear algebra, with scipy out of its sight.

    It imports all of scipy.linalg only to see whether it is there, which costs every command a tenth of a second;
    kernels here need no linear algebra, and one that did would still find it.
    """
    if _SCIPY_BLAS in sys.modules:
        return
    sys.modules[_SCIPY_BLAS] = cast("ModuleType", None)
    try:
        importlib.import_module("numba.np.arraymath")
    finally:
        sys.modules.pop(_SCIPY_BLAS, None)


_without_scipy()


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` with numba on its first call: no Python objects, GIL released, cached on disk."""
    return cast("Callable[P, R]", numba.njit(cache=True, nogil=True)(function))


def lean_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """As `kernel`, for a helper that makes no arrays: it is put into its callers, and counts no references to arrays.

    Calling and counting cost more than what a helper does that a kernel needs for each line or value. The outermost
    caller is a `kernel` and holds the arrays. Single rows may be taken as views; no array is returned, and no slice
    assigned.
    """
    return cast("Callable[P, R]", numba.njit(cache=True, nogil=True, **_LEAN)(function))


def _loader(bits: int, result: Any) -> Any:
    """An intrinsic that reads `bits` bits of a byte array at any place, little-endian whatever the machine."""

    def load(_typing: Any, array: Any, at: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            from llvmlite import ir

            kind = ir.IntType(bits)
            data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
            place = builder.bitcast(builder.gep(data, [arguments[1]]), kind.as_pointer())
            value = builder.load(place, align=1)
            if sys.byteorder == "big":
                value = builder.bswap(value)
            return builder.zext(value, ir.IntType(64)) if bits < 64 else value

        return result(array, types.intp), generate

    return intrinsic(load)


_Load = Callable[[ByteArray, int], int]
_LOAD_16: _Load = _loader(16, types.int64)
_LOAD_32: _Load = _loader(32, types.int64)
_LOAD_64: _Load = _loader(64, types.uint64)


@kernel
def load_u16(buffer: ByteArray, at: int) -> int:
    """Two bytes as a number. For kernels, without a check: at + 2 <= buffer.size is the caller's to see to."""
    return _LOAD_16(buffer, at)


@kernel
def load_u32(buffer: ByteArray, at: int) -> int:
    """Four bytes as a number (int64). As unchecked as `load_u16`."""
    return _LOAD_32(buffer, at)


@kernel
def load_u64(buffer: ByteArray, at: int) -> int:
    """Eight bytes as an unsigned number (uint64 in a kernel: mix only with np.uint64). As unchecked as `load_u16`."""
    return _LOAD_64(buffer, at)
