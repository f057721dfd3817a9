"""Bytes and numbers at an address, for the kernels that read tables of text.

Addresses and not arrays: numba counts the references to an array in every function that is given one, with locked
instructions that cost more than reading a number does. Nothing is checked: who gives an address answers for it, and for
the array behind it to live on.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, cast

import numpy as np
from numba.core import types
from numba.extending import intrinsic
from numpy.typing import NDArray


def _loader(bits: int, result: Any) -> Any:
    def load(_typing: Any, _address: Any) -> Any:
        def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            from llvmlite import ir

            kind = ir.IntType(bits)
            value = builder.load(builder.inttoptr(arguments[0], kind.as_pointer()), align=1)
            if bits < 64:
                return builder.zext(value, ir.IntType(64))
            return builder.bswap(value) if sys.byteorder == "big" and result is types.uint64 else value

        return result(types.int64), generate

    return intrinsic(load)


def _storer(kind: Any) -> Any:
    def store(_typing: Any, _address: Any, _value: Any) -> Any:
        def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            builder.store(arguments[1], builder.inttoptr(arguments[0], arguments[1].type.as_pointer()))

        return types.void(types.int64, kind), generate

    return intrinsic(store)


def _array_address() -> Any:
    def find(_typing: Any, array: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            from llvmlite import ir

            data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
            return builder.ptrtoint(data, ir.IntType(64))

        return types.int64(array), generate

    return intrinsic(find)


def _counter(name: str) -> Any:
    def count(_typing: Any, _word: Any) -> Any:
        def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            from llvmlite import ir

            if name == "ctpop":
                return builder.ctpop(arguments[0])
            return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 0))

        return types.int64(types.uint64), generate

    return intrinsic(count)


address_of: Callable[[NDArray[Any]], int] = cast("Callable[[NDArray[Any]], int]", _array_address())
"""Where an array's bytes begin."""
byte_at: Callable[[int], int] = cast("Callable[[int], int]", _loader(8, types.int64))
"""The byte at an address."""
word_at: Callable[[int], np.uint64] = cast("Callable[[int], np.uint64]", _loader(64, types.uint64))
"""Eight characters, the first in the lowest byte."""
int_at: Callable[[int], int] = cast("Callable[[int], int]", _loader(64, types.int64))
"""An int64 of an array."""
put_int: Callable[[int, int], None] = cast("Callable[[int, int], None]", _storer(types.int64))
"""Write an int64 of an array."""
put_float: Callable[[int, float], None] = cast("Callable[[int, float], None]", _storer(types.float64))
"""Write a float64 of an array."""
trailing_zeros: Callable[[np.uint64], int] = cast("Callable[[np.uint64], int]", _counter("cttz"))
"""Zero bits below the lowest one; 64 where there is none."""
bit_count: Callable[[np.uint64], int] = cast("Callable[[np.uint64], int]", _counter("ctpop"))
"""How many bits are set."""
