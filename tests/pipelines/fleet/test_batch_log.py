"""batch.log: a line a drive whatever its name, appended by several runs at once, and no reason to end a batch."""

from __future__ import annotations

import multiprocessing
from datetime import datetime

import pytest

from parsers.errors import StoreError
from pipelines.fleet import batch_log
from pipelines.fleet.batch_log import FILE_NAME, BatchLog, FileSink, UploadSink, escaped, now_text, run_name
from pipelines.fleet.events import DriveEnded, Finished, Found, Kept, Started
from pipelines.fleet.records import BatchSummary

FOUND = Found(3, 2, 1, 0, 700, "/fleet", "/store", "local", 2, "0.7")


def _ended(name: str, status: str = "done", reason: str = "") -> DriveEnded:
    return DriveEnded("id", name, "van", status, reason, 12.345, "worker 1", 1, 2, 7)


def _no_trouble(text: str) -> None:
    raise AssertionError(text)


def test_a_line_a_drive_between_a_first_and_a_last(tmp_path):
    with BatchLog(str(tmp_path), _no_trouble) as log:
        for event in (
            FOUND, Kept("k", "kept.csv", "van"), Kept("b", "bad.csv", "van", "error", "no time"), Started("id", "a"),
            _ended("a.csv"), _ended("b.csv", "timeout", "over 60 s"), Finished(BatchSummary(3, 1, 1, seconds=9.0)),
        ):  # fmt: skip
            log(event)
    lines = (tmp_path / FILE_NAME).read_text("utf-8").splitlines()
    assert len(lines) == 5
    assert (
        "batch of /fleet: 3 drives, 2 to do (700 bytes), 1 kept; cogest 0.7, engine local, 2 workers"
        in lines[0]
    )
    assert lines[0].startswith("# ")
    assert lines[-1].startswith("# ")
    assert "finished: 1 done, 0 failed, 1 kept, in 9.0 s" in lines[-1]
    before, one, two = (line.split("\t") for line in lines[1:4])
    assert before[2:] == ["error", "", "bad.csv", "", "as before: no time"]
    assert one[2:] == ["done", "12.3", "a.csv", "worker 1", ""]
    assert two[2:] == ["timeout", "12.3", "b.csv", "worker 1", "over 60 s"]
    assert datetime.fromisoformat(one[0]).utcoffset() is not None


@pytest.mark.parametrize(
    "name", ["a\nb\tc", "\x1b[2J", "half \udc80", "\u2028", "back\\slash", "größe 車.csv"]
)
def test_names_cannot_break_a_line_and_come_back(tmp_path, name):
    with BatchLog(str(tmp_path), _no_trouble) as log:
        log(FOUND)
        log(_ended(name))
    line = (tmp_path / FILE_NAME).read_text("utf-8").splitlines()[1]
    shown = line.split("\t")[4]
    assert shown.isprintable()
    assert shown == escaped(name)
    plain = shown.encode("latin-1", "backslashreplace").decode("unicode_escape")
    assert plain == name


def test_a_second_run_goes_on_in_the_same_file_and_says_that_it_was_stopped(tmp_path):
    def interrupted() -> None:
        with BatchLog(str(tmp_path), _no_trouble) as log:
            log(FOUND)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    with BatchLog(str(tmp_path), _no_trouble) as log:
        log(FOUND)
        log(Finished(BatchSummary(0, 0, 0)))
    lines = (tmp_path / FILE_NAME).read_text("utf-8").splitlines()
    assert [line.split("\t")[2].split(":")[0] for line in lines] == [
        "batch of /fleet", "stopped", "batch of /fleet", "finished"
    ]  # fmt: skip
    assert len({line.split("\t")[1] for line in lines}) == 2


def _write_many(folder: str, name: str) -> None:
    with BatchLog(folder, _no_trouble) as log:
        log(FOUND)
        for _ in range(400):
            log(_ended(name * 200))


def test_two_batches_at_once_do_not_mix_their_lines(tmp_path):
    context = multiprocessing.get_context("spawn")
    both = [context.Process(target=_write_many, args=(str(tmp_path), name)) for name in "xy"]
    for one in both:
        one.start()
    for one in both:
        one.join(60)
    assert [one.exitcode for one in both] == [0, 0]
    lines = (tmp_path / FILE_NAME).read_text("utf-8").splitlines()
    assert len(lines) == 2 * 402
    names = [line.split("\t")[4] for line in lines if not line.startswith("#")]
    assert sorted(names) == ["x" * 200] * 400 + ["y" * 200] * 400


def test_a_log_that_cannot_be_written_is_told_once(tmp_path):
    told: list[str] = []
    with BatchLog(str(tmp_path / "nowhere"), told.append) as log:
        log(FOUND)
        log(_ended("a"))
        log(_ended("b"))
    assert len(told) == 1
    assert FILE_NAME in told[0]


def test_a_disk_that_fills_up_is_told_once(tmp_path):
    class Full(FileSink):
        def write(self, line: str) -> None:
            raise OSError(28, "no space left")

    told: list[str] = []
    with BatchLog(str(tmp_path), told.append, lambda place, run: Full(tmp_path / "x")) as log:
        log(FOUND)
        log(_ended("a"))
    assert len(told) == 1


class _Remote:
    """Holds what is written; refuses where told to."""

    def __init__(self) -> None:
        self.files: dict[str, bytes] = {}
        self.writes = 0
        self.down = False

    def write(self, name: str, content: bytes) -> None:
        if self.down:
            raise StoreError("the server does not answer")
        self.files[name] = content
        self.writes += 1


def test_at_a_url_a_run_has_its_own_file_written_now_and_then():
    remote, clock = _Remote(), [0.0]
    sink = UploadSink(remote, "logs/run.log", lambda: clock[0])  # type: ignore[arg-type]
    for second in range(150):
        clock[0] = float(second)
        sink.write(f"line {second}")
    assert remote.writes == 2
    sink.close()
    sink.close()
    assert remote.writes == 3
    assert remote.files["logs/run.log"].decode().splitlines() == [f"line {k}" for k in range(150)]


def test_a_url_that_is_down_ends_no_batch(monkeypatch):
    remote, told = _Remote(), []
    remote.down = True
    monkeypatch.setattr(batch_log, "storage_at", lambda place: remote)
    with BatchLog("s3://bucket/store", told.append) as log:
        log(FOUND)
        log(Finished(BatchSummary(0, 0, 0)))
    assert len(told) == 1
    assert "does not answer" in told[0]


def test_runs_have_names_of_their_own_that_sort_by_time():
    names = [run_name() for _ in range(5)]
    assert len(set(names)) == 5
    assert sorted(n[:15] for n in names) == [n[:15] for n in names]
    assert datetime.fromisoformat(now_text()).tzinfo is not None
