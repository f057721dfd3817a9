"""What a user sees of a batch while it runs: a live line on a terminal, a few plain lines elsewhere, JSON for scripts."""

from __future__ import annotations

import contextlib
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import TextIO

from cogest_cli.output import complain, one_line
from cogest_cli.progress import WIDTH, LiveLine
from pipelines.fleet.batch_log import BatchLog, now_text
from pipelines.fleet.events import (
    DriveEnded,
    Event,
    Found,
    Joining,
    Kept,
    Reported,
    Started,
    Watcher,
    event_json,
    to_all,
)
from pipelines.fleet.time_left import TimeLeft, told

QUIET_S, QUIET_SHARE = 30.0, 0.05
"""Where nobody watches, a line comes after so many seconds, or so much of the time gone by if that is more."""

NARROWEST_NAMES = 20
"""Columns that must be left for the names of the drives under work, or they are not shown."""


class BatchState:
    """What is known of a batch while it runs."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """clock: seconds that only go on."""
        self.clock = clock
        self.phase = "finding drives"
        self.total = self.ended = self.failed = 0
        self.left: TimeLeft | None = None
        self.under_work: dict[str, str] = {}
        self.changed: set[str] = set()
        """Vehicles of which a drive was done anew: the others are not joined again."""

    def __call__(self, event: Event) -> None:
        """Take an event into account."""
        if isinstance(event, Found):
            self.phase, self.total = "", event.to_do
            self.left = TimeLeft(event.to_do, event.bytes_to_do, self.clock())
        elif isinstance(event, Kept):
            self.failed += event.status != "done"
        elif isinstance(event, Started):
            self.under_work[event.drive_id] = event.name
        elif isinstance(event, DriveEnded):
            self.under_work.pop(event.drive_id, None)
            self.ended = event.number
            if event.status == "done":
                self.changed.add(event.vehicle_id)
            self.failed += event.status not in ("done", "kept")
            if self.left is not None:
                self.left.ended(event.bytes, event.seconds, self.clock(), work=event.status != "kept")
        elif isinstance(event, Joining):
            self.phase = (
                f"joining the drives of {counted(len(self.changed), 'vehicle')}"
                if self.changed
                else "no vehicle to join again"
            )
        elif isinstance(event, Reported):
            self.phase = "writing the report"

    def parts(self) -> list[str]:
        """The state in words, the most needed first."""
        if self.left is None:
            return [self.phase]
        said = [f"{self.ended}/{self.total}", f"{self.failed} failed" if self.failed else ""]
        if self.phase:
            return [*filter(None, said if self.total else said[1:]), self.phase]
        if 0 < self.ended < self.total:
            now = self.clock()
            seconds = self.left.seconds(now)
            said += [
                f"{told(seconds)} left" if seconds is not None else "",
                f"{self.left.a_minute(now):.3g} a minute",
            ]
        return [part for part in said if part]

    def share(self) -> float:
        """How many of the drives ended, 0-1."""
        return self.ended / self.total if self.total else float(self.left is not None)


def counted(number: int, noun: str) -> str:
    """A number with its noun: "1 drive", "2 drives"."""
    return f"{number} {noun}" + ("" if number == 1 else "s")


def _failure(event: DriveEnded) -> str:
    return f"{event.status}: {event.name}: {event.reason}"


def _left_out(event: Found) -> list[str]:
    """How many files are no part of the batch, and the first ones with their reasons: a log among them is hardly missed otherwise."""
    named = [f"  {name}: {why}" for name, why in event.left_out_first]
    more = event.left_out - len(named)
    rest = [f"  and {more} more: --dry-run names them all"] if named and more > 0 else []
    return [f"left out: {counted(event.left_out, 'file')}", *named, *rest]


class Screen:
    """The progress of a batch on stderr."""

    def __init__(self, stream: TextIO | None = None, clock: Callable[[], float] = time.monotonic) -> None:
        """stream: where, stderr unless given."""
        self._state = BatchState(clock)
        self._live = LiveLine(self._text, stream)
        self._clock = clock
        self._started = self._last = clock()

    def __call__(self, event: Event) -> None:
        """Show an event: a failure at once and for good, the rest in the live line or, without one, now and then."""
        self._state(event)
        if isinstance(event, DriveEnded) and event.status not in ("done", "kept"):
            self._live.above(_failure(event))
        if isinstance(event, Found) and event.left_out:
            for line in _left_out(event):
                self._live.above(line)
        if self._live.live:
            return
        if isinstance(event, Found):
            self._live.above(f"{counted(event.drives, 'drive')}, {event.to_do} to do, {event.kept} kept")
        elif isinstance(event, Joining) or (isinstance(event, DriveEnded) and self._due()):
            self._live.above(", ".join(self._state.parts()))

    def say(self, text: str) -> None:
        """Print one line that stays."""
        self._live.above(text)

    def _due(self) -> bool:
        now = self._clock()
        if now - self._last < max(QUIET_S, QUIET_SHARE * (now - self._started)):
            return False
        self._last = now
        return True

    def _text(self, columns: int) -> str:
        bar = self._live.bar(self._state.share(), min(WIDTH, columns // 4))
        line = f"{bar} {', '.join(self._state.parts())}"
        names = ", ".join(one_line(name) for name in tuple(self._state.under_work.values()))
        room = columns - len(line) - 3
        if names and not self._state.phase and room >= NARROWEST_NAMES:
            line += " · " + (names if len(names) <= room else names[: room - 1] + "…")
        return line

    def __enter__(self) -> Screen:
        """Start."""
        self._live.__enter__()
        return self

    def __exit__(self, *ending: object) -> None:
        """Wipe the live line."""
        self._live.__exit__(None, None, None)


def print_json(event: Event) -> None:
    """An event as a line of JSON on stdout, at once. Raises BrokenPipeError where the reader is gone."""
    # in one piece, its end too: two batches may append to one file
    sys.stdout.write(event_json(event, now_text()) + "\n")
    sys.stdout.flush()


@contextlib.contextmanager
def watching(store: str, *, as_json: bool = False) -> Iterator[Watcher]:
    """Show, log and print what happens in a batch, as long as the context is open.

    store: its place, where batch.log goes. as_json: events on stdout and nothing else there; progress goes on on stderr where
    that is a terminal of its own, and is silent where it is none, since the events say the same.
    """
    lock = threading.Lock()
    with contextlib.ExitStack() as open_things:
        watchers: list[Watcher] = []
        trouble: Callable[[str], None] = complain
        if not as_json or (sys.stderr.isatty() and not sys.stdout.isatty()):
            screen = open_things.enter_context(Screen())
            watchers.append(screen)
            trouble = screen.say
        watchers.append(open_things.enter_context(BatchLog(store, trouble)))
        if as_json:
            watchers.append(print_json)
        tell = to_all(*watchers)

        def watch(event: Event) -> None:
            with lock:
                tell(event)

        yield watch
