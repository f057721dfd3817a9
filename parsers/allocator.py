"""What the C library does with memory that was freed."""

from __future__ import annotations

import numpy as np

_LARGEST_KEPT = (32 << 20) - (1 << 16)
"""Just below the highest limit that glibc takes, its own header included, in bytes."""


def keep_freed_memory() -> None:
    """Teach the C library's allocator (glibc's) to use the memory of freed pieces of a log again.

    By default it hands blocks of more than 128 KiB back to the system at once, and every new one then costs as many page
    faults as it has pages, which can take longer than all else together. It raises its limit to the largest block that it
    has seen freed. Nothing is written to this one, so that it costs two system calls; elsewhere it does nothing.
    """
    np.empty(_LARGEST_KEPT, np.uint8)
