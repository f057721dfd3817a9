"""Calls machine code of kernels without numba: a block of memory with the arguments in, the result out.

The block is, in slots of eight bytes: the address of an error, the result, then each argument; of an array its object's
address (`parsers.jit_compile` makes the function that reads all this and calls the kernel).
"""

from __future__ import annotations

import ctypes
import struct
import sys
from collections.abc import Sequence
from functools import cache
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from parsers.jit import Call, Kernel
from parsers.jit_shape import Leaf, Shape, leaves_of, spelt_out
from parsers.jit_store import key_of, read_code, write_code

_FINE = (0, -2)
"""A result, or none."""


def native_call(kernel: Kernel, shapes: tuple[Shape, ...], args: tuple[Any, ...]) -> Call | None:
    """How to call a kernel with arguments of these shapes: machine code from the disk, or compiled now and kept there.

    None where it can be called through numba only.
    """
    leaves = leaves_of(shapes)
    if leaves is None or not _arrays_are_known():
        return None
    key = key_of(kernel, shapes)
    name = f"cogest_{key}"
    found = read_code(kernel, key)
    if found is None:
        from parsers.jit_compile import NotAloneError, compile_alone

        try:
            found = compile_alone(kernel.py_func, kernel.manner, args, leaves, name)
        except NotAloneError:
            found = b"", ""
        write_code(kernel, key, *found)
    code, result = found
    nested = any(isinstance(each, tuple) for each in args)
    return _native(kernel, _address(code, name), leaves, result, nested=nested) if code else None


@cache
def _arrays_are_known() -> bool:
    """Whether numpy's arrays lie in memory as the entries of machine code read them: data, dimensions, sizes, steps."""
    if ctypes.sizeof(ctypes.c_void_p) != 8 or sys.implementation.name != "cpython":
        return False
    array = np.zeros((3, 5), np.int16)[:, 1:3]
    data, dimensions, sizes, steps = struct.unpack(
        "@PiPP", ctypes.string_at(id(array) + object.__basicsize__, 32)
    )
    if data != array.ctypes.data or dimensions != 2:
        return False
    return tuple(
        struct.unpack("@2n", ctypes.string_at(place, 2 * ctypes.sizeof(ctypes.c_ssize_t)))
        for place in (sizes, steps)
    ) == ((3, 2), (10, 2))


@cache
def _engine() -> Any:
    """What links object files into this process; it lives as long as the code in it.

    One for all: making one takes five times as long as linking a kernel. Their names do not meet, for an object file shows
    one name only, with the key in it.
    """
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine()
    return llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)


@cache
def _address(code: bytes, name: str) -> int:
    """Where the function of an object file is. One thread at a time links: see `parsers.jit`."""
    engine = _engine()
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return int(engine.get_function_address(name))


def _native(kernel: Kernel, address: int, leaves: Sequence[Leaf], result: str, *, nested: bool) -> Call:
    """A call of the function at an address. result: what it gives back, in the letters of `struct`. nested: there are
    tuples among the arguments."""
    function = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p)(address)
    several = result.startswith("(")
    given = struct.Struct("@" + result.lstrip("("))
    before = 8 + -(-given.size // 8) * 8
    block = struct.Struct("@" + "".join({"a": "P", "?": "q"}.get(leaf.code, leaf.code) for leaf in leaves))
    room = ctypes.c_char * (before + block.size)
    arrays = [leaf.code == "a" for leaf in leaves]
    put, take = block.pack_into, given.unpack_from

    def call(args: tuple[Any, ...]) -> Any:
        parts = tuple(spelt_out(args)) if nested else args
        memory = room()
        put(memory, before, *[id(part) if array else part for part, array in zip(parts, arrays, strict=True)])
        if function(memory) not in _FINE:
            # numba says what is wrong
            return kernel.by_numba(args)
        found = take(memory, 8)
        return found if several else found[0] if found else None

    return call
