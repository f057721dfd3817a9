"""Compiled kernels: one typed door to numba, so that the rest of the code stays strictly typed.

Kernels are cached on disk: the first call on a machine compiles, every later start loads.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

import numba

P = ParamSpec("P")
R = TypeVar("R")


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile `function` with numba on its first call: no Python objects, GIL released, cached on disk."""
    return cast("Callable[P, R]", numba.njit(cache=True, nogil=True)(function))
