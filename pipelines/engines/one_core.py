"""One worker, one core: threads of libraries would fight with the other workers, and sums would depend on their number."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator

from parsers.algebra_threads import ALGEBRA_THREADS
from parsers.parallel import CORES_VARIABLE

ONE_CORE = {
    **ALGEBRA_THREADS,
    "OMP_NUM_THREADS": "1",
    "NUMBA_NUM_THREADS": "1",
    "POLARS_MAX_THREADS": "1",
    "RAYON_NUM_THREADS": "1",
    CORES_VARIABLE: "1",
}
"""The environment of a worker. Most libraries read theirs once, when they are loaded."""

DRAWING = {"MPLBACKEND": "Agg"}
"""A worker draws into files, whatever screen its user has."""


@contextlib.contextmanager
def one_core() -> Iterator[None]:
    """This process on one core, as a worker is: the environment for what is not yet loaded, limits for what is.

    polars keeps the number of threads that it was loaded with.
    """
    from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]

    wanted = {**ONE_CORE, **DRAWING}
    before = {name: os.environ.get(name) for name in wanted}
    os.environ.update(wanted)
    try:
        with threadpool_limits(1):
            yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
