"""The entry to a kernel's machine code: a function of one address, behind which the arguments lie (`parsers.jit_call`)."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir

from parsers.jit_shape import Leaf


def entry_module(kind: Any, inner: str, leaves: Sequence[Leaf], result: str, name: str) -> Any:
    """A module with the function `name`: reads the block that `parsers.jit_call` tells of, and calls the kernel
    `inner`, whose type is `kind`."""
    module = ir.Module()
    module.triple = llvm.get_process_triple()
    whole = ir.IntType(64)
    called = ir.Function(module, kind, inner)
    entry = ir.Function(module, ir.FunctionType(ir.IntType(32), [ir.IntType(8).as_pointer()]), name)
    builder = ir.IRBuilder(entry.append_basic_block())
    block = entry.args[0]

    def at(place: int, base: Any = block) -> Any:
        return builder.gep(base, [ir.Constant(whole, place)])

    def read(place: Any, what: Any) -> Any:
        return builder.load(builder.bitcast(place, what.as_pointer()))

    args = [builder.bitcast(at(8), kind.args[0]), builder.bitcast(at(0), kind.args[1])]
    place = 8 + -(-struct.calcsize("@" + result.lstrip("(")) // 8) * 8
    for leaf in leaves:
        if leaf.code == "a":
            head = read(at(place), ir.IntType(8).as_pointer())
            args += _array_parts(builder, head, leaf, list(kind.args[len(args) :]))
        elif leaf.code == "?":
            args.append(builder.trunc(read(at(place), whole), ir.IntType(8)))
        else:
            args.append(read(at(place), kind.args[len(args)]))
        place += 8
    builder.ret(builder.call(called, args))
    return module


def _array_parts(builder: Any, head: Any, leaf: Leaf, kinds: Sequence[Any]) -> list[Any]:
    """What numba wants to know of an array, out of numpy's object at `head` (PyArrayObject_fields)."""
    whole, byte = ir.IntType(64), ir.IntType(8).as_pointer()
    # behind what every object has: data, int dimensions (with padding), sizes, steps
    fields = [
        builder.load(
            builder.bitcast(
                builder.gep(head, [ir.Constant(whole, object.__basicsize__ + 8 * k)]), byte.as_pointer()
            )
        )
        for k in (0, 2, 3)
    ]
    numbers = []
    for field in fields[1:]:
        for k in range(leaf.dimensions):
            where = builder.bitcast(builder.gep(field, [ir.Constant(whole, 8 * k)]), whole.as_pointer())
            numbers.append(builder.load(where))
    items: Any = ir.Constant(whole, 1)
    for size in numbers[: leaf.dimensions]:
        items = builder.mul(items, size)
    owner = [ir.Constant(kinds[0], None), ir.Constant(kinds[1], None)]
    data = builder.bitcast(fields[0], kinds[4])
    return [*owner, items, ir.Constant(whole, leaf.item_size), data, *numbers]
