"""Machine code of kernels on disk, named by all that it depends on: the kernel's code, that of its helpers, their constants.

So no change of a helper or a constant, in whatever file, can leave old machine code in use.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import os
import platform
import re
import sys
import threading
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

from parsers.jit import Kernel, Primitive
from parsers.user_cache import drop_oldest, user_cache

SUFFIX = ".kernel"
_MARK = b"cogest kernel 5\n"
_FOREIGN = sys.stdlib_module_names | {"numpy", "numba"}
"""What comes with Python, numpy and numba: its versions are in `environment`."""

_OURS = ("parsers", "pipelines")
"""The packages whose kernels the user's cache keeps."""

_SHARED = "kernels"
MOST_KERNELS = 4000
"""That many are kept in the user's cache: about 100 MB, four versions of all."""

_DOOR = "parsers.jit"
"""Where `kernel` and its like are: no kernel calls them, and what they ask of the environment is no part of any."""


def key_of(kernel: Kernel, *more: object) -> str:
    """A hash of a kernel's code, its helpers', their constants, the machine and `more`."""
    text = "\n".join((*_code(kernel.py_func, set()), environment(), *map(repr, more), kernel.manner))
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:32]


def _code(function: Any, seen: set[int]) -> Iterator[str]:
    """All that makes a function what it is, line by line."""
    if id(function) in seen:
        yield f"again {function.__qualname__}"
        return
    seen.add(id(function))
    yield f"{function.__module__} {function.__qualname__} {function.__defaults__!r}"
    yield from _instructions(function.__code__)
    known = dict(function.__globals__)
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        known[name] = cell.cell_contents
    for name in sorted(_names(function.__code__)):
        if name in known:
            yield name
            yield from _value(known[name], function.__code__, seen)


def _instructions(code: CodeType) -> Iterator[str]:
    yield f"{code.co_code.hex()} {code.co_names} {code.co_varnames} {code.co_argcount} {code.co_flags}"
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _instructions(constant)
        else:
            yield repr(constant)


def _names(code: CodeType) -> set[str]:
    """Names that a function may find outside of itself."""
    inner = (_names(each) for each in code.co_consts if isinstance(each, CodeType))
    return {*code.co_names, *code.co_freevars}.union(*inner)


def _value(value: Any, code: CodeType, seen: set[int]) -> Iterator[str]:
    """What a name stands for."""
    if isinstance(value, Kernel):
        yield f"kernel {value.manner}"
        yield from _code(value.py_func, seen)
    elif isinstance(value, Primitive):
        yield value.name
        yield from _code(value.make, seen)
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype} {value.shape} {hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()}"
    elif isinstance(value, (tuple, list)):
        yield type(value).__qualname__
        for each in value:
            yield from _value(each, code, seen)
    elif isinstance(value, ModuleType):
        yield value.__name__
        if not _foreign(value.__name__):
            for name in sorted(_names(code)):
                if hasattr(value, name):
                    yield from _value(getattr(value, name), code, seen)
    elif isinstance(value, FunctionType) and not _foreign(value.__module__):
        yield from _code(value, seen)
    elif isinstance(value, (type, FunctionType, BuiltinFunctionType)):
        yield f"{value.__module__} {value.__qualname__} {getattr(value, '_fields', '')}"
    else:
        yield f"{type(value).__qualname__} {value!r}"


def _foreign(module: str) -> bool:
    """Whether what a module holds is told by its name alone."""
    return module == _DOOR or module.partition(".")[0] in _FOREIGN


@cache
def environment() -> str:
    """What machine code depends on beside its source: Python, numba, and the processor."""
    import llvmlite
    import llvmlite.binding as llvm

    stamp = _numba_version()
    told = sorted((name, text) for name, text in os.environ.items() if name.startswith("NUMBA_CPU"))
    told += [(name, os.environ[name]) for name in ("NUMBA_OPT", "NUMBA_BOUNDSCHECK") if name in os.environ]
    parts = (sys.version, np.__version__, stamp, llvmlite.__version__, platform.machine(), sys.platform, told)
    return f"{parts} {llvm.get_host_cpu_name()} {llvm.get_host_cpu_features().flatten()}"


def _numba_version() -> str:
    """numba's version without its import, which takes longer than all else that many commands do."""
    found = importlib.util.find_spec("numba")
    if not found or not found.origin:
        return ""
    version = Path(found.origin).with_name("_version.py")
    try:
        return hashlib.sha256(version.read_bytes()).hexdigest()
    except OSError:
        return str(Path(found.origin).stat().st_mtime_ns)


def _folders(kernel: Kernel) -> list[Path]:
    """Where a kernel's machine code may lie: the first that has it is read, all are written.

    Beside the source, so that all users of an installation share it; in the user's cache, so that a second installation, a
    new version or an environment made afresh compile only what changed. Of a caller's own kernels the latter knows nothing.
    """
    source = Path(kernel.py_func.__code__.co_filename).absolute().parent
    told = os.environ.get("NUMBA_CACHE_DIR")
    if told:
        return _writable(Path(told) / f"cogest_{hashlib.sha256(os.fsencode(source)).hexdigest()[:8]}")
    users = user_cache()
    ours = users is not None and kernel.py_func.__module__.partition(".")[0] in _OURS
    found = _writable(source / "__pycache__")
    return [*found, *_own(users / _SHARED)] if users and (ours or not found) else found


@cache
def _writable(folder: Path) -> list[Path]:
    """The folder, made where need be, or nothing where it cannot be written."""
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        if os.access(folder, os.W_OK | os.X_OK):
            return [folder]
    return []


@cache
def _own(folder: Path) -> list[Path]:
    """The folder, made where need be, where nobody else can put code into it."""
    with contextlib.suppress(OSError):
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        found = folder.stat()
        if hasattr(os, "getuid") and (found.st_uid != os.getuid() or found.st_mode & 0o022):
            return []
        return _writable(folder)
    return []


def _file_name(kernel: Kernel, key: str) -> str:
    function: Callable[..., Any] = kernel.py_func
    name = re.sub(
        r"[^A-Za-z0-9_.]+", "_", f"{function.__module__.rpartition('.')[2]}.{function.__qualname__}"
    )
    return f"{name[:80]}-{key}{SUFFIX}"


def read_code(kernel: Kernel, key: str) -> tuple[bytes, str] | None:
    """The object file of that key, and what its function gives back; an empty file for a kernel that needs numba.

    None where there is none.
    """
    name = _file_name(kernel, key)
    for folder in _folders(kernel):
        with contextlib.suppress(OSError):
            found = _content((folder / name).read_bytes())
            if found is not None:
                return found
    return None


def _content(kept: bytes) -> tuple[bytes, str] | None:
    """What `write_code` wrote, or None of what it did not write whole."""
    if not kept.startswith(_MARK):
        return None
    size, _, rest = kept[len(_MARK) :].partition(b"\n")
    result, _, code = rest.partition(b"\n")
    return (code, result.decode("ascii", "replace")) if size == str(len(code)).encode() else None


def write_code(kernel: Kernel, key: str, code: bytes, result: str) -> None:
    """Keep an object file; one that cannot be kept is compiled again next time."""
    name = _file_name(kernel, key)
    content = b"".join((_MARK, f"{len(code)}\n{result}\n".encode("ascii"), code))
    for folder in _folders(kernel):
        # another process may read, or write the same
        with contextlib.suppress(OSError):
            part = folder / f".{name}.{os.getpid()}.{threading.get_ident()}.part"
            try:
                part.write_bytes(content)
                part.replace(folder / name)
            except OSError:
                part.unlink(missing_ok=True)
                raise
        if folder.name == _SHARED:
            drop_oldest(folder, f"*{SUFFIX}", MOST_KERNELS)
