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
from numpy.typing import NDArray

from parsers.jit import Primitive


def _of(name: str, make: Callable[[Any, Any], Any]) -> Any:
    """An instruction for kernels. make: gives, from numba's types and llvmlite's IR, what numba makes an intrinsic of."""

    def intrinsic() -> Any:
        from llvmlite import ir
        from numba import extending
        from numba.core import types

        return extending.intrinsic(make(types, ir))

    return Primitive(name, intrinsic)


def _loader(bits: int, *, signed: bool) -> Any:
    def make(types: Any, ir: Any) -> Any:
        kind, result = ir.IntType(bits), types.int64 if signed else types.uint64

        def load(_typing: Any, _address: Any) -> Any:
            def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
                value = builder.load(builder.inttoptr(arguments[0], kind.as_pointer()), align=1)
                if bits < 64:
                    return builder.zext(value, ir.IntType(64))
                return builder.bswap(value) if sys.byteorder == "big" and not signed else value

            return result(types.int64), generate

        return load

    return _of(f"load {bits} {signed}", make)


def _storer(kind: str) -> Any:
    def make(types: Any, _ir: Any) -> Any:
        def store(_typing: Any, _address: Any, _value: Any) -> Any:
            def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
                builder.store(arguments[1], builder.inttoptr(arguments[0], arguments[1].type.as_pointer()))

            return types.void(types.int64, getattr(types, kind)), generate

        return store

    return _of(f"store {kind}", make)


def _array_address() -> Any:
    def make(types: Any, ir: Any) -> Any:
        def find(_typing: Any, array: Any) -> Any:
            def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
                data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
                return builder.ptrtoint(data, ir.IntType(64))

            return types.int64(array), generate

        return find

    return _of("address", make)


def _counter(name: str) -> Any:
    def make(types: Any, ir: Any) -> Any:
        def count(_typing: Any, _word: Any) -> Any:
            def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
                if name == "ctpop":
                    return builder.ctpop(arguments[0])
                return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 0))

            return types.int64(types.uint64), generate

        return count

    return _of(name, make)


address_of: Callable[[NDArray[Any]], int] = cast("Callable[[NDArray[Any]], int]", _array_address())
"""Where an array's bytes begin."""
byte_at: Callable[[int], int] = cast("Callable[[int], int]", _loader(8, signed=True))
"""The byte at an address."""
word_at: Callable[[int], np.uint64] = cast("Callable[[int], np.uint64]", _loader(64, signed=False))
"""Eight characters, the first in the lowest byte."""
int_at: Callable[[int], int] = cast("Callable[[int], int]", _loader(64, signed=True))
"""An int64 of an array."""
put_int: Callable[[int, int], None] = cast("Callable[[int, int], None]", _storer("int64"))
"""Write an int64 of an array."""
put_float: Callable[[int, float], None] = cast("Callable[[int, float], None]", _storer("float64"))
"""Write a float64 of an array."""
trailing_zeros: Callable[[np.uint64], int] = cast("Callable[[np.uint64], int]", _counter("cttz"))
"""Zero bits below the lowest one; 64 where there is none."""
bit_count: Callable[[np.uint64], int] = cast("Callable[[np.uint64], int]", _counter("ctpop"))
"""How many bits are set."""
