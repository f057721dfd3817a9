"""batch.log: a line a drive, with when and how long; all that the tables of a store must not hold.

Columns are parted by tabs: time (ISO 8601 with its offset), run, status, seconds, drive, worker, reason. Lines that begin
with "#" begin and end a run. Control characters are written as escapes, so that a line is a line whatever a file's name.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import time
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import Protocol

from parsers.errors import StoreError
from pipelines.fleet.events import DriveEnded, Event, Finished, Found, Kept
from pipelines.fleet.storage import Storage
from pipelines.fleet.storage_at import storage_at

FILE_NAME = "batch.log"
FOLDER = "logs"
"""Below a store at a URL, where nothing can be appended to: a file a run."""

UPLOAD_S = 60.0
"""Between two writings of a run's log to a URL: a killed batch loses no more of it."""

LONGEST = 1000
"""Letters of one reason."""


class LogSink(Protocol):
    """Where lines go. Both raise OSError or StoreError where the place cannot be written."""

    def write(self, line: str) -> None:
        """Add one line, without its end."""
        ...

    def close(self) -> None:
        """Nothing follows."""
        ...


class FileSink:
    """Appends to a file. Each line is one write to a file opened for appending: those of two batches do not mix."""

    def __init__(self, path: Path) -> None:
        """Raises OSError."""
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0)
        self._file = os.open(path, flags, 0o666)

    def write(self, line: str) -> None:
        """Add one line."""
        os.write(self._file, (line + "\n").encode("utf-8"))

    def close(self) -> None:
        """Close the file."""
        os.close(self._file)


class UploadSink:
    """A run's own file in a store at a URL, written whole: every UPLOAD_S seconds, and at the end."""

    def __init__(self, storage: Storage, name: str, clock: Callable[[], float] = time.monotonic) -> None:
        """name: below the store."""
        self._storage, self._name, self._clock = storage, name, clock
        self._content = bytearray()
        self._next = clock() + UPLOAD_S
        self._new = False

    def write(self, line: str) -> None:
        """Add one line; upload if it is time to."""
        self._content += (line + "\n").encode("utf-8")
        self._new = True
        if self._clock() >= self._next:
            self._upload()

    def _upload(self) -> None:
        self._storage.write(self._name, bytes(self._content))
        self._new = False
        self._next = self._clock() + UPLOAD_S

    def close(self) -> None:
        """Upload what is new."""
        if self._new:
            self._upload()


def escaped(text: str) -> str:
    """A text without control characters, line ends or halves of letters, from which the text can be had again."""
    return "".join(c if c.isprintable() and c != "\\" else _escape(c) for c in text)


def _escape(letter: str) -> str:
    return "\\\\" if letter == "\\" else letter.encode("unicode_escape").decode("ascii")


def now_text() -> str:
    """This moment, ISO 8601 with the offset of the clock on the wall."""
    return datetime.now().astimezone().isoformat(timespec="seconds")


def sink_at(place: str, run: str) -> LogSink:
    """The log of a store at a path or a URL. run: names this run. Raises OSError, StoreError."""
    if "://" in place:
        return UploadSink(storage_at(place), f"{FOLDER}/{run}.log")
    return FileSink(Path(place) / FILE_NAME)


def run_name() -> str:
    """A name of its own for this run: when it began, and a few letters."""
    return f"{datetime.now().astimezone():%Y%m%dT%H%M%S}-{secrets.token_hex(2)}"


class BatchLog:
    """Watches a batch and writes its log; the file is opened when the batch begins, since the store is there then.

    A log that cannot be written does not end the batch: `trouble` is told once, and no more is written.
    """

    def __init__(
        self,
        place: str,
        trouble: Callable[[str], None],
        open_sink: Callable[[str, str], LogSink] = sink_at,
        now: Callable[[], str] = now_text,
    ) -> None:
        """place: the store's. now: the time as text."""
        self._place, self._trouble, self._open, self._now = place, trouble, open_sink, now
        self._run = run_name()
        self._sink: LogSink | None = None
        self._finished = False

    def __call__(self, event: Event) -> None:
        """Write what an event says, if it is one for the log. Drives that are kept are only counted."""
        with self._careful():
            if isinstance(event, Found):
                self._sink = self._open(self._place, self._run)
                self._say(_began(event))
            elif isinstance(event, DriveEnded):
                self._row(event.status, f"{event.seconds:.1f}", event.name, event.worker, event.reason)
            elif isinstance(event, Kept) and event.status != "done":
                self._row(event.status, "", event.name, "", f"as before: {event.reason}")
            elif isinstance(event, Finished):
                self._say(_finished(event))
                self._finished = True

    @contextlib.contextmanager
    def _careful(self) -> Iterator[None]:
        try:
            yield
        except (OSError, StoreError) as error:
            self._sink = None
            self._trouble(f"{FILE_NAME} cannot be written ({error}); the batch goes on without it")

    def _row(self, status: str, seconds: str, *texts: str) -> None:
        shown = [escaped(text if len(text) <= LONGEST else text[:LONGEST] + " …") for text in texts]
        self._write("\t".join([self._now(), self._run, status, seconds, *shown]))

    def _say(self, text: str) -> None:
        self._write(f"# {self._now()}\t{self._run}\t{escaped(text)}")

    def _write(self, line: str) -> None:
        if self._sink is not None:
            self._sink.write(line)

    def __enter__(self) -> BatchLog:
        """Nothing yet."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Say so where the batch did not come to its end, and close the file."""
        with self._careful():
            if not self._finished:
                why = kind.__name__ if kind else "no end"
                self._say(f"stopped: {why}" + (f": {error}" if error is not None and str(error) else ""))
            if self._sink is not None:
                self._sink.close()
        self._sink = None


def _began(found: Found) -> str:
    workers = f", {found.workers} workers" if found.workers else ""
    left_out = f", {found.left_out} left out" if found.left_out else ""
    return (
        f"batch of {found.folder}: {found.drives} drives, {found.to_do} to do ({found.bytes_to_do} bytes), "
        f"{found.kept} kept{left_out}; cogest {found.version}, engine {found.engine}{workers}, process {os.getpid()}"
    )


def _finished(event: Finished) -> str:
    s = event.summary
    gone = f", {s.gone} in the store without logs" if s.gone else ""
    gone += f", {s.moved} moved" if s.moved else ""
    return f"finished: {s.done} done, {len(s.failed)} failed, {s.kept} kept{gone}, in {s.seconds:.1f} s"
