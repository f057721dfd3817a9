"""What a compiled kernel's machine code depends on in its arguments: their shapes, not their values."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

Shape = Any
"""One argument: see `shape_of`."""

_LOW, _HIGH = -(1 << 63), (1 << 63) - 1


def shape_of(argument: Any) -> Shape:
    """What sort of argument it is.

    An array: (dtype, dimensions, layout, may be written to); a tuple: its type and its items' shapes; else its type. None
    for what only numba itself can tell apart.
    """
    kind = type(argument)
    if kind is np.ndarray:
        flags = argument.flags
        if not flags.aligned:
            return None
        layout = "C" if flags.c_contiguous else "F" if flags.f_contiguous else "A"
        return argument.dtype, argument.ndim, layout, flags.writeable
    if kind is int:
        return int if _LOW <= argument <= _HIGH else None
    if kind is float or kind is bool:
        return kind
    if isinstance(argument, tuple):
        return kind, *map(shape_of, argument)
    return kind if isinstance(argument, np.generic) else None


@dataclass(frozen=True)
class Leaf:
    """One thing that is handed over. code: a an array, q or Q an integer of 64 bits, d a double, ? a truth value."""

    code: str
    dimensions: int = 0
    item_size: int = 0


def leaves_of(shapes: Iterable[Shape]) -> list[Leaf] | None:
    """What is handed over for arguments of these shapes, tuples spelt out. None where it cannot be done."""
    found: list[Leaf] = []
    for shape in shapes:
        if isinstance(shape, tuple) and isinstance(shape[0], np.dtype):
            if shape[0].kind not in "biufc" or not shape[0].isnative:
                return None
            found.append(Leaf("a", shape[1], shape[0].itemsize))
        elif isinstance(shape, tuple):
            parts = leaves_of(shape[1:])
            if not parts:
                return None
            found += parts
        elif shape in _SCALARS:
            found.append(_SCALARS[shape])
        else:
            return None
    return found


_SCALARS: dict[Shape, Leaf] = {
    int: Leaf("q"),
    np.int64: Leaf("q"),
    np.uint64: Leaf("Q"),
    float: Leaf("d"),
    np.float64: Leaf("d"),
    bool: Leaf("?"),
    np.bool_: Leaf("?"),
}


def spelt_out(arguments: Iterable[Any]) -> Iterator[Any]:
    """Arguments as `leaves_of` has them."""
    for argument in arguments:
        if isinstance(argument, tuple):
            yield from spelt_out(argument)
        else:
            yield argument
