"""C functions for kernels to call, by address: a loop over a library's calls then runs without the interpreter's lock.

Each time that a thread comes back for the lock it may have to wait for another one, and sleep: on two cores that can take
longer than a short call itself.
"""

from __future__ import annotations

import ctypes
import functools
import sys
from collections.abc import Callable
from typing import Any, BinaryIO, cast

from parsers.channels import ByteArray, IntArray
from parsers.jit import Primitive, kernel


def _address() -> Any:
    from llvmlite import ir
    from numba.core import types
    from numba.extending import intrinsic

    def address(_typing: Any, array: Any, at: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
            return builder.ptrtoint(builder.gep(data, [arguments[1]]), ir.IntType(64))

        return types.int64(array, types.intp), generate

    return intrinsic(address)


def _caller(count: int) -> Callable[..., int]:
    """An instruction that calls the function at an address with so many whole numbers or addresses; what it gives back."""

    def make() -> Any:
        from llvmlite import ir
        from numba.core import types
        from numba.extending import intrinsic

        def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            whole = ir.IntType(64)
            kind = ir.FunctionType(whole, [whole] * count)
            return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])

        # numba wants to see each argument
        if count == 1:

            def call_1(_typing: Any, function: Any, a: Any) -> Any:
                return types.int64(*[types.int64] * 2), generate

            return intrinsic(call_1)

        if count == 3:

            def call_3(_typing: Any, function: Any, a: Any, b: Any, c: Any) -> Any:
                return types.int64(*[types.int64] * 4), generate

            return intrinsic(call_3)

        if count == 4:

            def call_4(_typing: Any, function: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
                return types.int64(*[types.int64] * 5), generate

            return intrinsic(call_4)

        if count == 5:

            def call_5(_typing: Any, function: Any, a: Any, b: Any, c: Any, d: Any, e: Any) -> Any:
                return types.int64(*[types.int64] * 6), generate

            return intrinsic(call_5)

        def call_6(_typing: Any, function: Any, a: Any, b: Any, c: Any, d: Any, e: Any, f: Any) -> Any:
            return types.int64(*[types.int64] * 7), generate

        return intrinsic(call_6)

    return cast("Callable[..., int]", Primitive(f"call {count}", make))


_ADDRESS = cast("Callable[[Any, int], int]", Primitive("address", _address))
_CALL_1, _CALL_3, _CALL_4, _CALL_5, _CALL_6 = _caller(1), _caller(3), _caller(4), _caller(5), _caller(6)


@functools.cache
def pread_address() -> int:
    """Where the C library's `pread` lies (descriptor, address, bytes, place; places of 64 bits); 0 where there is none."""
    if ctypes.sizeof(ctypes.c_void_p) != 8 or sys.platform == "win32":
        return 0
    try:
        library = ctypes.CDLL(None)
        function = library.pread64 if sys.platform == "linux" else library.pread
    except (AttributeError, OSError):
        return 0
    return ctypes.cast(function, ctypes.c_void_p).value or 0


def descriptor_of(file: BinaryIO) -> int:
    """The number by which `pread` knows an open file; -1 for one that is not on this machine's disks."""
    try:
        return file.fileno()
    except (AttributeError, OSError):
        return -1


@kernel
def address_of_byte(array: ByteArray, at: int) -> int:
    """The address of a byte of a contiguous array. For kernels, unchecked; the caller of the outermost one holds the array."""
    return _ADDRESS(array, at)


@kernel
def address_of_number(array: IntArray, at: int) -> int:
    """The address of a number in a contiguous array. As `address_of_byte`."""
    return _ADDRESS(array, at)


@kernel
def call_1(function: int, a: int) -> int:
    """Call the C function at an address with one argument. For kernels: what it is given and does is the caller's to see to."""
    return _CALL_1(function, a)


@kernel
def call_3(function: int, a: int, b: int, c: int) -> int:
    """Call the C function at an address with three arguments. As `call_1`."""
    return _CALL_3(function, a, b, c)


@kernel
def call_4(function: int, a: int, b: int, c: int, d: int) -> int:
    """Call the C function at an address with four arguments. As `call_1`."""
    return _CALL_4(function, a, b, c, d)


@kernel
def call_5(function: int, a: int, b: int, c: int, d: int, e: int) -> int:
    """Call the C function at an address with five arguments. As `call_1`."""
    return _CALL_5(function, a, b, c, d, e)


@kernel
def call_6(function: int, a: int, b: int, c: int, d: int, e: int, f: int) -> int:
    """Call the C function at an address with six arguments. As `call_1`."""
    return _CALL_6(function, a, b, c, d, e, f)


@kernel
def read_at(pread: int, file: int, at: int, size: int, data: ByteArray, begin: int) -> int:
    """Read the file's bytes from `at` on to data[begin:]; how many there are, up to `size`. For kernels, unchecked.

    pread: see `pread_address`. file: see `descriptor_of`.
    """
    done = 0
    while done < size:
        got = call_4(pread, file, address_of_byte(data, begin + done), size - done, at + done)
        if got <= 0:
            break
        done += got
    return done
