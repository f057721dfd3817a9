"""Compiled kernels: one typed door to numba, so that the rest of the code stays strictly typed.

The first call on a machine compiles. Every later start loads machine code that was kept on disk (`parsers.jit_store`) and
calls it by itself (`parsers.jit_call`): numba, whose import takes longer than reading a log does, is not even imported.
What cannot be called so (arrays as results, odd arguments) goes through numba and its own cache on disk.
"""

from __future__ import annotations

import functools
import os
import sys
import threading
from collections.abc import Callable
from typing import Any, Literal, ParamSpec, TypeVar, cast

from parsers.channels import ByteArray
from parsers.jit_shape import Shape, shape_of

P = ParamSpec("P")
R = TypeVar("R")

Manner = Literal["whole", "lean", "vector", "sums"]
"""Of `kernel`, `lean_kernel`, `vector_kernel`, `summing_kernel`."""

Call = Callable[[tuple[Any, ...]], Any]
"""Calls a kernel with these arguments."""

_LOCK = threading.RLock()


class Primitive:
    """An instruction that Python has no word for, for kernels to call. make: gives numba's intrinsic, when it is needed."""

    def __init__(self, name: str, make: Callable[[], Any]) -> None:
        self.name, self.make = name, make

    @functools.cached_property
    def _numba_type_(self) -> Any:
        from numba.core.registry import cpu_target

        made = self.make()
        # numba looks for what is new only when it begins to compile
        cpu_target.typing_context.refresh()
        return cpu_target.typing_context.resolve_value_type(made)


class Kernel:
    """A function for numba: see `kernel`. py_func: the function in plain Python. manner: how it is compiled."""

    def __init__(self, function: Callable[..., Any], *, manner: Manner = "whole") -> None:
        functools.update_wrapper(self, function)
        self.py_func, self.manner = function, manner
        self._calls: dict[tuple[Shape, ...], Call] = {}
        self._by_numba = False

    def __call__(self, *args: Any, **named: Any) -> Any:
        """Call the compiled function."""
        if named or self._by_numba:
            return self.dispatcher(*map(_plain, args), **named)
        shapes = tuple(map(shape_of, args))
        call = self._calls.get(shapes)
        if call is None:
            with _LOCK:
                call = self._calls.get(shapes) or self._prepare(shapes, args)
                self._calls[shapes] = call
        return call(args)

    def _prepare(self, shapes: tuple[Shape, ...], args: tuple[Any, ...]) -> Call:
        """How to call the kernel with arguments of these shapes."""
        from parsers.jit_call import native_call

        call = native_call(self, shapes, args)
        # numba is loaded then, and the quickest way for all other arguments too
        self._by_numba = call is None
        return call or self.by_numba

    def by_numba(self, args: tuple[Any, ...]) -> Any:
        """Call the kernel through numba."""
        return self.dispatcher(*map(_plain, args))

    @functools.cached_property
    def dispatcher(self) -> Any:
        """numba's own, kept on disk by all that is compiled into it."""
        from parsers.jit_compile import dispatcher
        from parsers.jit_store import key_of

        return dispatcher(self.py_func, key=key_of(self), manner=self.manner)

    @functools.cached_property
    def helper(self) -> Any:
        """numba's own for kernels that call this one: compiled with them, so that no cache can hold an old one."""
        from parsers.jit_compile import dispatcher

        return dispatcher(self.py_func, key=None, manner=self.manner)

    @property
    def _numba_type_(self) -> Any:
        from numba.core import types

        return types.Dispatcher(self.helper)


def _plain(argument: Any) -> Any:
    """A kernel as an argument, as numba takes it."""
    return argument.helper if isinstance(argument, Kernel) else argument


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` with numba on its first call: no Python objects, GIL released, kept on disk."""
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return function
    return cast("Callable[P, R]", Kernel(function))


def lean_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """As `kernel`, for a helper that makes no arrays: it is put into its callers, and counts no references to arrays.

    Calling and counting cost more than what a helper does that a kernel needs for each line or value. The outermost
    caller is a `kernel` and holds the arrays. Single rows may be taken as views; no array is returned, and no slice
    assigned.
    """
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return function
    return cast("Callable[P, R]", Kernel(function, manner="lean"))


def vector_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """As `lean_kernel`, for loops that are to become vector instructions: what is divided by zero is infinite or no number.

    The check before each division, after which a `kernel` raises ZeroDivisionError, is a jump, and a loop with a jump in it
    stays as it is.
    """
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return function
    return cast("Callable[P, R]", Kernel(function, manner="vector"))


def summing_kernel(function: Callable[P, R]) -> Callable[P, R]:
    """As `vector_kernel`, and sums are added up in any order: one that runs through a loop becomes several side by side.

    (x + 1e16) - 1e16 is x here.
    """
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return function
    return cast("Callable[P, R]", Kernel(function, manner="sums"))


def _loader(bits: int, *, signed: bool) -> Callable[[ByteArray, int], int]:
    """An instruction that reads `bits` bits of a byte array at any place, little-endian whatever the machine."""

    def make() -> Any:
        from llvmlite import ir
        from numba.core import types
        from numba.extending import intrinsic

        def load(_typing: Any, array: Any, at: Any) -> Any:
            def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
                kind = ir.IntType(bits)
                data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
                place = builder.bitcast(builder.gep(data, [arguments[1]]), kind.as_pointer())
                value = builder.load(place, align=1)
                if sys.byteorder == "big":
                    value = builder.bswap(value)
                return builder.zext(value, ir.IntType(64)) if bits < 64 else value

            return (types.int64 if signed else types.uint64)(array, types.intp), generate

        return intrinsic(load)

    return cast("Callable[[ByteArray, int], int]", Primitive(f"load {bits}", make))


_LOAD_16 = _loader(16, signed=True)
_LOAD_32 = _loader(32, signed=True)
_LOAD_64 = _loader(64, signed=False)


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


def _prefetch() -> Any:
    from llvmlite import ir
    from numba.core import types
    from numba.extending import intrinsic

    def prefetch(_typing: Any, array: Any, at: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
            # to be read, and soon
            kinds = [data.type, *[ir.IntType(32)] * 3]
            instruction = builder.module.declare_intrinsic(
                "llvm.prefetch", [data.type], ir.FunctionType(ir.VoidType(), kinds)
            )
            what = [ir.Constant(ir.IntType(32), number) for number in (0, 3, 1)]
            builder.call(instruction, [builder.gep(data, [arguments[1]]), *what])
            return context.get_dummy_value()

        return types.void(array, types.intp), generate

    return intrinsic(prefetch)


_PREFETCH = cast("Callable[[ByteArray, int], None]", Primitive("prefetch", _prefetch))


@kernel
def prefetch(buffer: ByteArray, at: int) -> None:
    """Have the byte brought near, as it will soon be read. For kernels; a place outside of the buffer does no harm."""
    _PREFETCH(buffer, at)
