"""A folder as a store's place: files whole or not at all, folders exchanged, leftovers swept; also where a process is killed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from parsers.errors import StoreError
from pipelines.fleet import storage_local
from pipelines.fleet.owner import Owner, alive, owner_from, this_process
from pipelines.fleet.storage import MARK, checked
from pipelines.fleet.storage_at import storage_at
from pipelines.fleet.storage_local import LocalStorage

ROOT = Path(__file__).resolve().parents[3]
FOLDER = "drives/ab/one"

WRITER = """
import json, sys
from pipelines.fleet.storage_local import LocalStorage
storage, number = LocalStorage(sys.argv[1]), 0
while True:
    number += 1
    files = {f"file{k}": str(number).encode() * 2000 for k in range(4)}
    storage.publish("drives/ab/one", {**files, "drive.json": json.dumps({"number": number}).encode()})
    print(number, flush=True)
"""


def whole(storage: LocalStorage) -> int:
    """The number of the folder, after checking that all its files are of one writing; 0 = no folder."""
    files = storage.tree(FOLDER)
    if not files:
        return 0
    number = json.loads(storage.read(f"{FOLDER}/{MARK}") or b"")["number"]
    assert sorted(files) == [f"{FOLDER}/{name}" for name in (MARK, "file0", "file1", "file2", "file3")]
    for k in range(4):
        assert storage.read(f"{FOLDER}/file{k}") == str(number).encode() * 2000
    return int(number)


def files(number: int) -> dict[str, bytes]:
    """A folder's files of one writing."""
    content = str(number).encode() * 2000
    return {**{f"file{k}": content for k in range(4)}, MARK: json.dumps({"number": number}).encode()}


def partial(root: Path) -> list[str]:
    return sorted(os.listdir(root / ".partial")) if (root / ".partial").is_dir() else []


@pytest.fixture
def no_exchange(monkeypatch: pytest.MonkeyPatch) -> None:
    """A system that cannot exchange two folders in one step."""
    monkeypatch.setattr(storage_local, "_exchange", lambda one, other: False)


def test_reads_what_was_written(tmp_path: Path) -> None:
    storage = LocalStorage(tmp_path / "store")
    assert storage.read("a/b.txt") is None
    assert storage.names("") == ()
    assert storage.tree("") == {}
    storage.write("a/b.txt", b"one")
    storage.write("a/b.txt", b"two")
    assert storage.read("a/b.txt") == b"two"
    assert storage.read("a/b.txt/c") is None
    assert storage.names("") == ["a"]
    assert storage.tree("") == {"a/b.txt": 3}
    storage.remove("a")
    storage.remove("a")
    assert storage.read("a/b.txt") is None
    assert partial(tmp_path / "store") == []


def test_of_many_who_create_one_succeeds(tmp_path: Path) -> None:
    storage = LocalStorage(tmp_path)
    won: list[int] = []
    start = threading.Barrier(8)

    def create(number: int) -> None:
        start.wait()
        if storage.create("claims/x", str(number).encode()):
            won.append(number)

    threads = [threading.Thread(target=create, args=(n,)) for n in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(won) == 1
    assert storage.read("claims/x") == str(won[0]).encode()


def test_creates_without_hard_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> None:
        raise PermissionError(1, "no hard links here")

    monkeypatch.setattr(os, "link", none)
    storage = LocalStorage(tmp_path)
    assert storage.create("x", b"1")
    assert not storage.create("x", b"2")
    assert storage.read("x") == b"1"


def test_publishes_a_folder_in_place_of_another(tmp_path: Path) -> None:
    storage = LocalStorage(tmp_path)
    storage.publish(FOLDER, {"old": b"", MARK: b"{}"})
    storage.publish(FOLDER, files(7))
    assert whole(storage) == 7
    assert partial(tmp_path) == []


@pytest.mark.usefixtures("no_exchange")
def test_publishes_where_folders_cannot_be_exchanged(tmp_path: Path) -> None:
    storage = LocalStorage(tmp_path)
    for number in (1, 2, 3):
        storage.publish(FOLDER, files(number))
    assert whole(storage) == 3
    assert os.listdir(tmp_path / "drives/ab") == ["one"]


def test_publishes_over_a_file_that_lies_there(tmp_path: Path) -> None:
    storage = LocalStorage(tmp_path)
    storage.write(FOLDER, b"someone put a file here")
    storage.publish(FOLDER, files(2))
    assert whole(storage) == 2


@pytest.mark.parametrize("successor", [True, False])
def test_a_folder_that_stood_aside_comes_back(tmp_path: Path, successor: bool) -> None:
    storage = LocalStorage(tmp_path)
    storage.publish("drives/ab/.one.0123456789ab.old", files(1))
    if successor:
        storage.publish(FOLDER, files(2))
    storage.sweep()
    assert whole(storage) == (2 if successor else 1)
    assert os.listdir(tmp_path / "drives/ab") == ["one"]


@pytest.mark.parametrize("exchange", [True, False])
def test_many_publish_at_once(tmp_path: Path, exchange: bool, request: pytest.FixtureRequest) -> None:
    if not exchange:
        request.getfixturevalue("no_exchange")
    storage = LocalStorage(tmp_path)
    threads = [
        threading.Thread(target=lambda n=n: [storage.publish(FOLDER, files(10 * n + k)) for k in range(5)])
        for n in range(1, 5)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    storage.sweep()
    assert whole(storage) in {10 * n + 4 for n in range(1, 5)}
    assert partial(tmp_path) == []


def test_a_killed_writer_leaves_a_whole_folder(tmp_path: Path) -> None:
    storage, last = LocalStorage(tmp_path), 0
    for attempt in range(12):
        writer = subprocess.Popen(
            [sys.executable, "-c", WRITER, str(tmp_path)], stdout=subprocess.PIPE, text=True, cwd=ROOT
        )
        assert writer.stdout is not None
        said = int(writer.stdout.readline())
        time.sleep(0.003 * attempt)
        writer.send_signal(signal.SIGKILL)
        rest = writer.stdout.read().split()
        writer.wait()
        writer.stdout.close()
        storage.sweep()
        last = whole(storage)
        assert last >= int(rest[-1] if rest else said)
        assert partial(tmp_path) == []
    assert last > 0


def test_sweep_leaves_what_the_living_write(tmp_path: Path) -> None:
    storage = LocalStorage(tmp_path)
    mine = this_process()
    names = {
        f"{mine.text}~aaaa": True,
        f"{Owner(mine.host, mine.pid, mine.started - 60_000).text}~bbbb": False,
        f"{Owner(mine.host, 2**22 + 7, 1000).text}~cccc": False,
        f"{Owner('elsewhere', 1, 1000).text}~dddd": True,
        f"{Owner('elsewhere', 1, 1000).text}~eeee": False,
        "what is this": True,
    }
    for name in names:
        (tmp_path / ".partial" / name).mkdir(parents=True)
    long_ago = time.time() - 3 * 24 * 3600
    os.utime(tmp_path / ".partial" / f"{Owner('elsewhere', 1, 1000).text}~eeee", (long_ago, long_ago))
    storage.sweep()
    assert partial(tmp_path) == sorted(name for name, stays in names.items() if stays)


def test_owner() -> None:
    mine = this_process()
    assert owner_from(mine.text) == mine
    assert alive(mine) is True
    assert alive(Owner("elsewhere", mine.pid, mine.started)) is None
    assert alive(Owner(mine.host, -1, 0)) is False
    assert owner_from("../../x") is None


@pytest.mark.parametrize("name", ["", "/etc/passwd", "a/../b", "a//b", ".", "a\\b", "a\0b", "c:/x", "a*"])
def test_refuses_names_that_leave_the_store(name: str, tmp_path: Path) -> None:
    with pytest.raises(StoreError, match="no name of a file"):
        checked(name)
    with pytest.raises(StoreError):
        LocalStorage(tmp_path).write(name, b"")


def test_errors_are_told_in_words(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    storage = storage_at(str(tmp_path / "file"))
    with pytest.raises(StoreError, match="cannot be written"):
        storage.write("a", b"")
    with pytest.raises(StoreError, match="cannot be listed"):
        storage.names("")
