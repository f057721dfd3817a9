"""What native libraries write to stderr: dropped where they break down, written where they do not."""

from __future__ import annotations

import os
import threading

import polars as pl
import pytest

from parsers.native_stderr import quiet_panics


def say(text: bytes) -> None:
    os.write(2, text)


def break_down(text: bytes, error: BaseException) -> None:
    with quiet_panics():
        say(text)
        raise error


def test_a_panics_stack_is_dropped_and_the_error_comes_out(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(pl.exceptions.PanicException):
        break_down(b"thread 'x' panicked\n", pl.exceptions.PanicException("assertion failed"))
    say(b"after\n")
    assert capfd.readouterr().err == "after\n"


def test_what_else_is_said_is_said_at_the_end(capfd: pytest.CaptureFixture[str]) -> None:
    with quiet_panics():
        say(b"a warning\n")
        assert capfd.readouterr().err == ""
    assert capfd.readouterr().err == "a warning\n"
    with pytest.raises(ValueError, match="other"):
        break_down(b"why\n", ValueError("other"))
    assert capfd.readouterr().err == "why\n"


def test_threads_share_it_and_the_last_gives_it_back(capfd: pytest.CaptureFixture[str]) -> None:
    inside, go = threading.Barrier(3), threading.Event()

    def hold() -> None:
        with quiet_panics():
            inside.wait(timeout=20)
            go.wait(timeout=20)

    threads = [threading.Thread(target=hold) for _ in range(2)]
    for thread in threads:
        thread.start()
    inside.wait(timeout=20)
    say(b"meanwhile\n")
    go.set()
    for thread in threads:
        thread.join()
    say(b"after\n")
    assert capfd.readouterr().err == "meanwhile\nafter\n"
