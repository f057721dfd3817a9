"""Text that people write (vehicle, mapping and drive files): its size is checked before it is read."""

from __future__ import annotations

import errno
import stat
from pathlib import Path

MOST_BYTES = 1_000_000
"""No such file is larger; a log that is called like one may be."""


def read_small_text(path: Path) -> str:
    """A text in UTF-8, with or without a byte order mark, with any line ends.

    Raises OSError (of a file that is too large or no plain file, too), UnicodeDecodeError.
    """
    if not stat.S_ISREG(mode := path.stat().st_mode) and not stat.S_ISDIR(mode):
        # a pipe that nobody writes to would be waited for without end
        raise OSError(errno.EINVAL, "no plain file: a pipe or a device")
    with path.open("rb") as file:
        raw = file.read(MOST_BYTES + 1)
    if len(raw) > MOST_BYTES:
        raise OSError(errno.EFBIG, f"larger than {MOST_BYTES // 1000} kB: no such file is")
    return raw.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
