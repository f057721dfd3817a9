"""Linear algebra on one thread.

The matrices here have tens of rows. On those a second thread waits, spinning, longer than it works: beside another busy
process an analysis took four times as long with two threads as with one. One thread also makes sums the same to the
last bit wherever a drive is analysed.
"""

from __future__ import annotations

import os

ALGEBRA_THREADS = {
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "VECLIB_MAXIMUM_THREADS": "1",
    "BLIS_NUM_THREADS": "1",
}
"""The environment that says so to each of the libraries. They read it once, when they are loaded."""


def one_algebra_thread() -> None:
    """Say so to this process and its children, before numpy and scipy are loaded. What the user has set stays."""
    for name, number in ALGEBRA_THREADS.items():
        os.environ.setdefault(name, number)
