"""numba at work: the only part of the house that imports it. Kernels to machine code that stands on its own."""

from __future__ import annotations

import importlib
import struct
import sys
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any, cast

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

import llvmlite.binding as llvm  # noqa: E402
import numba  # noqa: E402
from llvmlite import ir  # noqa: E402
from numba.core import types  # noqa: E402
from numba.core.caching import IndexDataCacheFile  # noqa: E402
from numba.core.runtime import nrtdynmod  # noqa: E402

from parsers.jit import Manner  # noqa: E402
from parsers.jit_entry import entry_module  # noqa: E402
from parsers.jit_shape import Leaf  # noqa: E402

_LEAN: dict[str, Any] = {"_nrt": False, "forceinline": True}

_OPTIONS: dict[Manner, dict[str, Any]] = {
    "whole": {},
    "lean": _LEAN,
    "vector": {**_LEAN, "error_model": "numpy", "fastmath": {"contract"}},
    "sums": {**_LEAN, "error_model": "numpy", "fastmath": {"contract", "reassoc"}},
}

_ALONE = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Without the functions that bring Python's objects in and out."""

_OWNER = "{i64, i8*, i8*, i8*, i64}"
"""What numba keeps of memory that it took: references, two for its end, address, size. See `_RUNTIME`."""

_RUNTIME = """
declare {p} @malloc(i64)
declare void @free({p})
declare double @ldexp(double, i32)
define void @PyErr_SetString({p} %kind, {p} %text) {{
  ret void
}}
define {p} @NRT_Allocate(i64 %size) {{
  %found = call {p} @malloc(i64 %size)
  ret {p} %found
}}
define void @NRT_Free({p} %block) {{
  call void @free({p} %block)
  ret void
}}
define double @numba_ldexp(double %x, i32 %power) {{
  %found = call double @ldexp(double %x, i32 %power)
  ret double %found
}}
define {p} @NRT_MemInfo_alloc(i64 %size) {{
  %found = call {p} @NRT_MemInfo_alloc_aligned(i64 %size, i32 16)
  ret {p} %found
}}
define {p} @NRT_MemInfo_alloc_safe_aligned(i64 %size, i32 %align) {{
  %same = call {p} @NRT_MemInfo_alloc_aligned(i64 %size, i32 %align)
  ret {p} %same
}}
define {p} @NRT_MemInfo_alloc_aligned(i64 %size, i32 %align) {{
  %wide = zext i32 %align to i64
  %room = add i64 %size, %wide
  %all = add i64 %room, 64
  %owner = call {p} @malloc(i64 %all)
  %none = icmp eq {p} %owner, null
  br i1 %none, label %end, label %fill
fill:
  %start = ptrtoint {p} %owner to i64
  %behind = add i64 %start, 63
  %up = add i64 %behind, %wide
  %rest = urem i64 %up, %wide
  %even = sub i64 %up, %rest
  %data = inttoptr i64 %even to {p}
  %head = bitcast {p} %owner to {o}
  %a = getelementptr {h}, {o} %head, i32 0, i32 0
  store i64 1, {n} %a
  %b = getelementptr {h}, {o} %head, i32 0, i32 3
  store {p} %data, {pp} %b
  %c = getelementptr {h}, {o} %head, i32 0, i32 4
  store i64 %size, {n} %c
  br label %end
end:
  ret {p} %owner
}}
define void @NRT_MemInfo_call_dtor({p} %owner) {{
  call void @free({p} %owner)
  ret void
}}
"""
"""What a kernel needs of numba's runtime: memory for arrays of its own, from the C library and back to it.

Where there is none left it ends with an error, which numba tells when it is called in its place: nothing is set here.
"""

_C_LIBRARY = frozenset(
    [
        "malloc",
        "free",
        "memset",
        "memcpy",
        "memmove",
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "atan2",
        "sinh",
        "cosh",
        "tanh",
        "exp",
        "exp2",
        "expm1",
        "log",
        "log2",
        "log10",
        "log1p",
        "pow",
        "sqrt",
        "fabs",
        "floor",
        "ceil",
        "trunc",
        "round",
        "rint",
        "nearbyint",
        "fmod",
        "hypot",
        "cbrt",
        "copysign",
        "fmin",
        "fmax",
        "fma",
        "ldexp",
        "frexp",
        "erf",
        "erfc",
        "lgamma",
        "tgamma",
    ]
)
"""Functions that machine code may call beside itself."""


_typeof: Callable[[Any], Any] = numba.typeof
_cache_file = cast("Callable[..., Any]", IndexDataCacheFile)


def _njit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """numba's decorator, the lock of the interpreter released."""
    return cast("Callable[[Callable[..., Any]], Any]", numba.njit(nogil=True, **options))


def dispatcher(function: Callable[..., Any], *, key: str | None, manner: Manner) -> Any:
    """numba's own object for a function. key: what its machine code on disk is named by; None: it is not kept.

    numba itself looks at the function's own file only, so that a helper changed in another file would leave old code in use.
    """
    if key is None:
        return _njit(**_OPTIONS[manner])(function)
    made = _njit(cache=True, **_OPTIONS[manner])(function)
    try:
        cache = made._cache
        place, name = cache._cache_path, f"{function.__qualname__.rpartition('.')[2]}-{key}"
        cache._cache_file = _cache_file(cache_path=place, filename_base=name, source_stamp=key)
    except AttributeError:
        # another version of numba: compiled at each start, never old
        return _njit(**_OPTIONS[manner])(function)
    return made


class NotAloneError(Exception):
    """The kernel needs numba beside it when it runs."""


TRIED = frozenset({"0.68"})
"""Versions of numba on which all kernels were compared with numba's own calls. What is used of numba below is not public, so
any other version calls its kernels itself: slower to start, never wrong. `tests/parsers/test_jit.py` is what to run on one."""


def _tried() -> bool:
    return (
        ".".join(numba.__version__.split(".")[:2]) in TRIED
        and sys.implementation.name == "cpython"
        and struct.calcsize("P") == 8
    )


def _result_code(result: Any) -> str:
    """What a kernel gives back, in the letters of `struct`: nothing at all, or one or several numbers. Raises NotAloneError."""
    if isinstance(result, types.BaseNamedTuple):
        raise NotAloneError("a named tuple")
    if isinstance(result, types.UniTuple | types.Tuple):
        return "(" + "".join(map(_result_code, tuple(result)))
    for kind, code in ((types.int64, "q"), (types.uint64, "Q"), (types.float64, "d"), (types.boolean, "?")):
        if result == kind:
            return code
    if result == types.none:
        return ""
    raise NotAloneError(str(result))


_SIMPLE = {"q": "i64", "Q": "i64", "d": "double", "?": "i8"}


def _told(leaves: Sequence[Leaf]) -> list[str]:
    """The parts in which numba hands arguments over. Of an array: two addresses of its owner, the number of items, an item's
    size, the address, sizes, steps."""
    parts: list[str] = []
    for leaf in leaves:
        if leaf.code == "a":
            parts += ["ptr", "ptr", "i64", "i64", "ptr", *["i64"] * (2 * leaf.dimensions)]
        else:
            parts.append(_SIMPLE[leaf.code])
    return parts


def _convention(compiled: Any, leaves: Sequence[Leaf], result: str) -> Any:
    """The type of a kernel's function. Raises NotAloneError where it is not what the entry would call."""
    context = compiled.target_context
    kind = context.call_conv.get_function_type(compiled.signature.return_type, compiled.signature.args)
    given = ["ptr" if isinstance(each, ir.PointerType) else str(each) for each in kind.args]
    back = str(context.get_return_type(compiled.signature.return_type))
    if result[:1] == "(":
        items = [_SIMPLE.get(code, "") for code in result[1:]]
        # a truth value takes a byte in either way
        same = {"{" + ", ".join(items) + "}", f"[{len(items)} x {items[0]}]"} if items else set()
        fits = back.replace("i1}", "i8}").replace("i1,", "i8,").replace("x i1]", "x i8]") in same
    else:
        fits = not result or back == _SIMPLE[result]
    if given != ["ptr", "ptr", *_told(leaves)] or not fits or str(kind.return_type) != "i32":
        raise NotAloneError(f"{given} -> {back}")
    return kind


def _alone(module: Any, entry: Any, name: str) -> Any:
    """A copy of a module with an entry to be called from outside, and what it needs of numba's runtime.

    Raises NotAloneError where it needs more than that and the C library.
    """
    module = llvm.parse_bitcode(module.as_bitcode())
    own = llvm.parse_assembly(str(entry))
    own.data_layout = module.data_layout
    module.link_in(own)
    missing = {each.name for each in module.functions if each.is_declaration}
    if any(each.startswith(("NRT_", "numba_", "PyErr_")) for each in missing):
        if str(nrtdynmod._meminfo_struct_type) != _OWNER:
            raise NotAloneError("numba keeps its memory in another way")
        typed = llvm.llvm_version_info[0] < 15
        names = {"p": "i8*", "h": _OWNER, "o": _OWNER + "*", "n": "i64*", "pp": "i8**"}
        opaque = {"p": "ptr", "h": _OWNER.replace("i8*", "ptr"), "o": "ptr", "n": "ptr", "pp": "ptr"}
        runtime = llvm.parse_assembly(_RUNTIME.format(**(names if typed else opaque)))
        runtime.triple, runtime.data_layout = module.triple, module.data_layout
        module.link_in(runtime)
    for each in module.functions:
        if each.is_declaration:
            # of Python's only what numba would call to make an error's text
            if not each.name.startswith(("llvm.", "Py", "_Py")) and each.name not in _C_LIBRARY:
                raise NotAloneError(each.name)
        elif each.name != name:
            each.linkage = "internal"
    for each in module.global_variables:
        if not each.is_declaration:
            each.linkage = "internal"
        elif not each.name.startswith(("Py", "_Py")):
            raise NotAloneError(each.name)
    module.verify()
    return module


def compile_alone(
    function: Callable[..., Any], manner: Manner, args: Sequence[Any], leaves: Sequence[Leaf], name: str
) -> tuple[bytes, str]:
    """Machine code of a kernel for arguments like these, as an object file with the function `name`; and what it gives back.

    Raises NotAloneError where that cannot be called without numba.
    """
    if not _tried():
        raise NotAloneError(f"numba {numba.__version__}")
    made = _njit(**_ALONE, **_OPTIONS[manner])(function)
    signature = tuple(map(_typeof, args))
    made.compile(signature)
    compiled = made.overloads[signature]
    result = _result_code(compiled.signature.return_type)
    try:
        kind = _convention(compiled, leaves, result)
        entry = entry_module(kind, compiled.fndesc.llvm_func_name, leaves, result, name)
        library = compiled.library
        return library.codegen._tm.emit_object(_alone(library._final_module, entry, name)), result
    except AttributeError as error:
        # what is not public in numba may have another name in another version
        raise NotAloneError(str(error)) from error
