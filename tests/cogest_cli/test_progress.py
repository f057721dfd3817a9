"""Progress: on a terminal, after two seconds, on one line that is wiped; nothing in pipes."""

from __future__ import annotations

import contextlib
import io
import os
import time

import pytest

from cogest_cli import progress
from cogest_cli.progress import ProgressLine


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    encoding = "utf-8"

    def isatty(self) -> bool:
        return True


@pytest.fixture
def hasty(monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE_S", 0.02)
    monkeypatch.setattr(progress, "REDRAW_S", 0.02)


def test_nothing_where_nobody_looks(hasty):
    stream = io.StringIO()
    with ProgressLine(stream) as line:
        line("reading", 0.5)
        time.sleep(0.1)
    assert stream.getvalue() == ""


def test_nothing_before_two_seconds():
    stream = Terminal()
    with ProgressLine(stream) as line:
        line("reading", 0.5)
        time.sleep(0.1)
    assert progress.PATIENCE_S == 2.0
    assert stream.getvalue() == ""


def test_a_long_silent_step_is_drawn_and_wiped(hasty):
    stream = Terminal()
    with ProgressLine(stream) as line:
        line("read\ning\x1b[31m", 0.5)
        time.sleep(0.3)
    frames = stream.getvalue().split("\r")
    drawn = [frame for frame in frames if frame.startswith("[")]
    assert len(drawn) >= 2
    assert drawn[0].startswith("[" + "█" * 12 + "·" * 12 + "]")
    assert "read ing?[31m" in drawn[0]
    assert "\n" not in stream.getvalue()
    assert "\x1b" not in stream.getvalue()
    # the last two frames are blanks over all that was drawn, and the start of the line
    assert set(frames[-2]) == {" "}
    assert len(frames[-2]) >= max(map(len, drawn))
    assert frames[-1] == ""


def test_a_long_step_stays_on_one_line(hasty):
    stream = Terminal()
    with ProgressLine(stream) as line:
        line("estimating: " + "x" * 300, 7.0)
        time.sleep(0.1)
    assert max(len(frame) for frame in stream.getvalue().split("\r")) < progress.COLUMNS


def test_a_real_terminal_and_one_that_is_gone(hasty):
    if not hasattr(os, "openpty"):
        pytest.skip("no pseudo-terminals on this system")
    ours, theirs = os.openpty()
    stream = os.fdopen(theirs, "w", encoding="ascii")
    with ProgressLine(stream) as line:
        line("reading", 1.0)
        time.sleep(0.15)
        seen = os.read(ours, 4096)
        assert b"\r[########################]" in seen
        os.close(ours)
        time.sleep(0.1)
    with contextlib.suppress(OSError):
        stream.close()
