"""What a user sees of a batch: one live line on a terminal, few plain lines elsewhere, JSON alone on stdout."""

from __future__ import annotations

import io
import json
import os
import re
import sys
import threading
import time
from dataclasses import replace

import pytest

from cogest_cli import progress
from cogest_cli.batch_command import _tell
from cogest_cli.batch_progress import QUIET_S, BatchState, Screen, watching
from cogest_cli.progress import LiveLine, fitted
from pipelines.fleet.batch_log import FILE_NAME
from pipelines.fleet.events import DriveEnded, Event, Finished, Found, Joining, Kept, Reported, Started
from pipelines.fleet.records import BatchSummary

FOUND = Found(12, 10, 2, 0, 1000, "/fleet", "/store", "local", 2, "0.7")


def _ended(number: int, status: str = "done", reason: str = "", name: str = "") -> DriveEnded:
    return DriveEnded(
        f"id{number}", name or f"van/drive{number}", "van", status, reason, 10.0, "w", number, 10, 100
    )


def _started(number: int, name: str = "") -> Started:
    return Started(f"id{number}", name or f"van/drive{number}", 100)


class Clock:
    """A clock that goes on when it is told to."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def hasty(monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE_S", 0.02)
    monkeypatch.setattr(progress, "REDRAW_S", 0.02)


def test_the_state_in_words():
    clock = Clock()
    state = BatchState(clock)
    assert state.parts() == ["finding drives"]
    state(FOUND)
    assert state.parts() == ["0/10"]
    state(Kept("b", "bad", "van", "error", "no time"))
    for number in (1, 2, 3):
        state(_started(number))
        clock.now = 20.0 * number
        state(_ended(number, "crashed" if number == 2 else "done"))
    state(_started(4))
    assert state.parts() == ["3/10", "2 failed", "about 2 min left", "3 a minute"]
    assert list(state.under_work.values()) == ["van/drive4"]
    assert state.share() == 0.3
    state(Joining(1))
    assert state.parts() == ["3/10", "2 failed", "joining the drives of 1 vehicle"]
    state(Reported(()))
    assert state.parts()[-1] == "writing the report"


def test_only_vehicles_with_a_drive_done_anew_are_said_to_be_joined():
    state = BatchState(Clock())
    state(FOUND)
    state(Kept("k", "kept", "truck", "done", ""))
    state(_ended(1))
    state(_ended(2, "kept"))
    state(replace(_ended(3), vehicle_id="suv"))
    state(replace(_ended(4, "crashed"), vehicle_id="bus"))
    state(Joining(4))
    assert state.parts()[-1] == "joining the drives of 2 vehicles"


def test_one_drive_is_not_called_drives(capsys):
    _tell(BatchSummary(found=1, kept=1, done=0, failed=(), gone=0, seconds=0.1), [])
    assert capsys.readouterr().out == "1 drive: 0 done, 1 kept, 0 failed\n"


def test_nothing_to_do_is_all_done():
    state = BatchState(Clock())
    state(Found(2, 0, 2, 0))
    assert state.share() == 1.0
    assert state.parts() == ["0/0"]
    state(Joining(2))
    assert state.parts() == ["no vehicle to join again"]


def _on_a_terminal(act, columns: int) -> str:
    """What stands on a pseudo-terminal of so many columns after `act(screen)`, as it was written."""
    import fcntl
    import struct
    import termios

    ours, theirs = os.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    seen = bytearray()

    def read() -> None:
        while True:
            try:
                part = os.read(ours, 65536)
            except OSError:
                return
            if not part:
                return
            seen.extend(part)

    reader = threading.Thread(target=read, daemon=True)
    reader.start()
    with os.fdopen(theirs, "w", encoding="utf-8") as stream:
        with Screen(stream) as screen:
            act(screen)
        time.sleep(0.05)
    reader.join(5)
    os.close(ours)
    return seen.decode("utf-8")


def _shown(written: str, columns: int) -> list[str]:
    """The lines that such a terminal shows in the end."""
    rows, column = [[]], 0
    for letter in written:
        if letter == "\n":
            rows.append([])
        elif letter == "\r":
            column = 0
        else:
            assert column < columns, "a line wrapped"
            row = rows[-1]
            row += [" "] * (column + 1 - len(row))
            row[column] = letter
            column += 1
    return ["".join(row).rstrip() for row in rows]


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals on this system")
@pytest.mark.parametrize("columns", [24, 40, 80, 160])
def test_a_terminal_keeps_failures_and_wipes_the_live_line(hasty, columns):
    def act(screen: Screen) -> None:
        screen(FOUND)
        for number in range(1, 6):
            screen(_started(number))
        time.sleep(0.1)
        screen(_ended(1))
        screen(_ended(2, "error", "not whole\nJSON \x1b[31m", "van/bad.csv"))
        time.sleep(0.1)
        screen(_ended(3))

    written = _on_a_terminal(act, columns)
    kept = "error: van/bad.csv: not whole JSON ?[31m"
    assert _shown(written.replace(kept, kept[: columns - 1]), columns) == [kept[: columns - 1], ""]
    assert "\x1b" not in written
    frames = [frame for frame in re.split("[\r\n]", written) if frame.startswith("[")]
    assert any("0/10" in frame for frame in frames)
    assert any("2/10, 1 failed" in frame for frame in frames)
    assert max(map(len, frames)) < columns
    names = any("van/drive1" in frame for frame in frames)
    assert names == (columns > 24)


def test_elsewhere_few_lines(monkeypatch):
    clock, stream = Clock(), io.StringIO()
    with Screen(stream, clock) as screen:
        screen(FOUND)
        for number in range(1, 10):
            clock.now += QUIET_S / 3
            screen(_started(number))
            screen(_ended(number, *(("timeout", "over 60 s") if number == 5 else ())))
        screen(Joining(3))
    lines = stream.getvalue().splitlines()
    assert lines[0] == "12 drives, 10 to do, 2 kept"
    assert "timeout: van/drive5: over 60 s" in lines
    said = [line for line in lines if "/10" in line]
    assert [line.split(",")[0] for line in said] == ["3/10", "6/10", "9/10", "9/10"]
    assert said[1].startswith("6/10, 1 failed, about 40 s left, 6 a minute")
    assert said[3].endswith("joining the drives of 1 vehicle")
    assert len(lines) == 6


def test_what_is_left_out_is_named_with_its_reason():
    stream = io.StringIO()
    first = (("van/bad.csv", "no time column"), ("a\nb.bin", "not a format"))
    Screen(stream, Clock())(Found(2, 2, 0, 7, left_out_first=first))
    assert stream.getvalue().splitlines() == [
        "left out: 7 files",
        "van/bad.csv: no time column",
        "a b.bin: not a format",
        "and 5 more: --dry-run names them all",
        "2 drives, 2 to do, 0 kept",
    ]


def test_a_week_gives_no_flood_of_lines():
    clock, stream = Clock(), io.StringIO()
    screen = Screen(stream, clock)
    screen(Found(60_480, 60_480, 0, 0))
    for number in range(1, 60_481):
        clock.now = 10.0 * number
        if number % 50 == 0:
            screen(_ended(number))
    assert 50 < len(stream.getvalue().splitlines()) < 200


EVENTS: list[Event] = [
    FOUND,
    _started(1),
    _ended(1, "error", "why"),
    Joining(1),
    Finished(BatchSummary(12, 2, 9)),
]


def test_json_on_stdout_and_nothing_else(tmp_path, capsys):
    with watching(str(tmp_path), as_json=True) as watch:
        for event in EVENTS:
            watch(event)
    out, err = capsys.readouterr()
    read = [json.loads(line) for line in out.splitlines()]
    assert [line["event"] for line in read] == [event.kind for event in EVENTS]
    assert all(re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d[+-]\d\d:\d\d", line["time"]) for line in read)
    assert err == ""
    assert len((tmp_path / FILE_NAME).read_text("utf-8").splitlines()) == 3


def test_without_json_nothing_on_stdout(tmp_path, capsys):
    with watching(str(tmp_path)) as watch:
        for event in EVENTS:
            watch(event)
    out, err = capsys.readouterr()
    assert out == ""
    assert "error: van/drive1: why" in err


def test_a_log_that_cannot_be_written_is_said_and_costs_nothing(tmp_path, capsys):
    with watching(str(tmp_path / "gone")) as watch:
        for event in EVENTS:
            watch(event)
    assert FILE_NAME in capsys.readouterr().err


def test_a_script_that_stops_reading_is_told_like_any_pipe(tmp_path, monkeypatch):
    class Closed(io.StringIO):
        def write(self, text: str) -> int:
            raise BrokenPipeError

    monkeypatch.setattr(sys, "stdout", Closed())
    with pytest.raises(BrokenPipeError), watching(str(tmp_path), as_json=True) as watch:
        watch(FOUND)
    assert "stopped: BrokenPipeError" in (tmp_path / FILE_NAME).read_text("utf-8")


def test_events_from_several_threads_do_not_mix(tmp_path, capsys):
    with watching(str(tmp_path), as_json=True) as watch:
        threads = [threading.Thread(target=lambda: [watch(_ended(k)) for k in range(100)]) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert len([json.loads(line) for line in capsys.readouterr().out.splitlines()]) == 400


def test_wide_letters_take_two_columns():
    assert fitted("車両abc", 5) == "車両a"
    assert fitted("車両abc", 3) == "車"
    assert fitted("abc", 3) == "abc"


def test_a_bar_is_never_longer_than_it_is():
    line = LiveLine(lambda columns: "", io.StringIO())
    assert {len(line.bar(share)) for share in (-1.0, 0.0, 0.5, 1.0, 7.0)} == {progress.WIDTH + 2}
