"""What the second core of this machine is good for at the moment: it may be half of one, or somebody else's.

Without it nobody could tell a reader that does not use two cores from a machine that has not got them.
"""

from __future__ import annotations

import threading
import time
import zlib

import deflate
import numpy as np

ROUNDS = 100


def _block() -> tuple[bytes, int]:
    """A deflated block, so large that its thread seldom waits for the interpreter, and its size."""
    values = np.random.default_rng(0).integers(0, 256, 1 << 19, np.uint8)
    content = np.repeat(values, 4).tobytes()
    return zlib.compress(content, 6), len(content)


def inflating_s(threads: int) -> float:
    """Seconds for ROUNDS blocks, inflated by so many threads that share nothing."""
    block, size = _block()

    def work() -> None:
        for _ in range(ROUNDS // threads):
            deflate.zlib_decompress(block, size)

    each = [threading.Thread(target=work) for _ in range(threads)]
    start = time.perf_counter()
    for thread in each:
        thread.start()
    for thread in each:
        thread.join()
    return time.perf_counter() - start
