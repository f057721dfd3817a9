"""The only door to the terminal: text from logs cannot steer it, and a narrow encoding cannot stop the program."""

from __future__ import annotations

import contextlib
import errno
import os
import sys
from io import TextIOWrapper

_NO_SPACE = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
MACHINE_ERRORS = _NO_SPACE | {errno.EACCES, errno.EPERM, errno.EROFS, errno.EIO, errno.EMFILE, errno.ENFILE}
"""Errors of the machine, not of the program: a line, no traceback."""


def forgive_encodings() -> None:
    """Let standard output and error write a plain stand-in for what their encoding lacks, instead of an exception."""
    from reports.layout import never_fail

    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            never_fail(stream)


def one_line(text: object) -> str:
    """A text on one line: white space becomes one space, control characters and the like become "?"."""
    return "".join(c if c.isprintable() else "?" for c in " ".join(str(text).split()))


def show(text: str) -> None:
    """Print lines without control characters: a log's text must not move the cursor or paint the screen."""
    print("\n".join("".join(c if c.isprintable() else "?" for c in line) for line in text.split("\n")))


def show_line(text: object) -> None:
    """Print one line, whatever the text holds: a path with a line break in it stays one line."""
    print("".join(c if c.isprintable() else "?" for c in str(text)))


def complain(text: object) -> None:
    """The one line on stderr that an error gets."""
    with contextlib.suppress(OSError, ValueError):
        print(f"cogest: {one_line(text)}", file=sys.stderr, flush=True)


def speaks_unicode() -> bool:
    """Whether standard output can hold any text."""
    return (sys.stdout.encoding or "").lower().replace("-", "").replace("_", "").startswith("utf")


def drop_output() -> None:
    """Send what is still to be written nowhere: the reader is gone, and Python would complain at its end."""
    with contextlib.suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def machine_error(error: OSError) -> int:
    """Say in a line what the machine refused (a full disk, a folder that cannot be written); the exit code."""
    drop_output()
    if error.errno in _NO_SPACE:
        complain("no space left where the output goes; free some, or write elsewhere")
    else:
        where = f"{error.filename}: " if error.filename else ""
        complain(f"{where}{error.strerror}; check the place and its permissions, or write elsewhere")
    return 1


def finish_output() -> int:
    """Write what is still in the buffer; the exit code where that fails, else 0. A reader that is gone is no failure."""
    try:
        print(end="", flush=True)
    except BrokenPipeError:
        drop_output()
    except OSError as error:
        return machine_error(error)
    return 0
