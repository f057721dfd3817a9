"""A store in an object store: the operations of `Storage`, on a real S3 server and on fsspec's memory."""

from __future__ import annotations

import contextlib
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from parsers import places_fs
from parsers.errors import StoreError
from pipelines.fleet import storage_url
from pipelines.fleet.keys import facts_of
from pipelines.fleet.storage import MARK, Storage
from pipelines.fleet.storage_at import storage_at
from pipelines.fleet.storage_local import LocalStorage
from pipelines.fleet.storage_url import UrlStorage
from pipelines.fleet.store import open_store
from tests.pipelines.fleet.stored_drives import facts_of_drive, found_drive, kept_of_drive, results_of_drive

pytest.importorskip("fsspec", reason="fsspec (cogest[remote]) is not installed")

DRIVE = "drives/ab/one"


@pytest.fixture(params=["local", "memory", "s3"])
def storage(request: pytest.FixtureRequest, tmp_path: Path) -> Storage:
    """An empty store of each kind."""
    if request.param == "local":
        return LocalStorage(tmp_path / "store")
    if request.param == "memory":
        return UrlStorage(f"memory://{tmp_path.name}/store")
    return UrlStorage(request.getfixturevalue("s3_store").url + "/a/store")


def test_files_are_written_replaced_listed_and_removed(storage: Storage) -> None:
    assert storage.read("store.json") is None
    assert list(storage.names("")) == []
    assert dict(storage.tree("")) == {}
    storage.write("store.json", b"1")
    storage.write("store.json", b"22")
    storage.write("drives/ab/one/x.json", b"x")
    storage.write("drives/abc/two/x.json", b"x")
    assert storage.read("store.json") == b"22"
    assert list(storage.names("")) == ["drives", "store.json"]
    assert list(storage.names("drives")) == ["ab", "abc"]
    assert list(storage.names("drives/a")) == []
    tree = storage.tree("drives/ab")
    assert list(tree) == ["drives/ab/one/x.json"]
    assert dict(tree) == {"drives/ab/one/x.json": 1}
    assert storage.tree("")["store.json"] == 2
    storage.remove("store.json")
    storage.remove("drives/ab")
    storage.remove("nothing/here")
    assert list(storage.tree("")) == ["drives/abc/two/x.json"]


def test_of_many_that_create_a_file_one_succeeds(storage: Storage) -> None:
    with ThreadPoolExecutor(8) as pool:
        made = list(pool.map(lambda k: storage.create("claims/one.json", b"%d" % k), range(8)))
    assert made.count(True) == 1
    assert storage.read("claims/one.json") == b"%d" % made.index(True)


def test_a_published_folder_replaces_the_one_before(storage: Storage) -> None:
    storage.publish(DRIVE, {MARK: b"1", "results.json": b"old", "report.pdf": b"old"})
    storage.publish(DRIVE, {MARK: b"2", "results.json": b"new"})
    assert {name: storage.read(name) for name in storage.tree("drives")} == {
        f"{DRIVE}/{MARK}": b"2",
        f"{DRIVE}/results.json": b"new",
    }


def test_a_reader_never_sees_files_of_two_under_one_mark(storage: Storage) -> None:
    stop, looked, mixed = threading.Event(), [], []

    def watch() -> None:
        while not stop.is_set():
            mark = storage.read(f"{DRIVE}/{MARK}")
            files = {storage.read(f"{DRIVE}/{name}") for name in ("a.json", "b.json")}
            # every mark is written once: where it is still there, what was read in between lay under it
            if mark is not None and mark == storage.read(f"{DRIVE}/{MARK}"):
                looked.append(mark)
                mixed.extend(files - {mark})

    watcher = threading.Thread(target=watch)
    watcher.start()
    for number in range(16):
        content = b"%d" % number
        storage.publish(DRIVE, {MARK: content, "a.json": content, "b.json": content})
        # every second version is replaced at once, in the midst of a look; the others stay until they were seen,
        # however seldom a loaded machine lets the reader in
        end = time.monotonic() + 60
        while number % 2 and content not in looked and time.monotonic() < end:
            time.sleep(0.001)
    stop.set()
    watcher.join()
    assert set(looked) >= {b"%d" % number for number in range(1, 16, 2)}
    assert mixed == []


def test_a_writer_killed_at_any_request_leaves_no_mixture(s3_store, monkeypatch: pytest.MonkeyPatch) -> None:
    """The old folder, the new one, or none: whatever request is the last one that the store gets."""
    old = {MARK: b"old", "a.json": b"old", "gone.json": b"old"}
    new = {MARK: b"new", "a.json": b"new", "b.json": b"new"}
    outcomes = set()
    for last in range(12):
        storage = UrlStorage(f"{s3_store.url}/kill{last}")
        storage.publish(DRIVE, old)
        asked = 0
        plain = UrlStorage._ask

        def ask(self, what, plain=plain, last=last):
            nonlocal asked
            asked += 1
            if asked > last:
                raise KeyboardInterrupt
            return plain(self, what)

        with monkeypatch.context() as patch:
            patch.setattr(UrlStorage, "_ask", ask)
            with contextlib.suppress(KeyboardInterrupt):
                storage.publish(DRIVE, new)
        found = {name.rpartition("/")[2]: storage.read(name) for name in storage.tree(DRIVE)}
        mark = found.get(MARK)
        outcomes.add(mark)
        if mark is not None:
            assert found == (old if mark == b"old" else new), last
    assert outcomes == {b"old", None, b"new"}


def test_two_writers_of_one_drive_leave_one_of_the_two(s3_store) -> None:
    storage = UrlStorage(f"{s3_store.url}/store")
    versions = [{MARK: b"%d" % k, **{f"{n}.json": b"%d" % k for n in "abc"}} for k in range(3)]
    with ThreadPoolExecutor(3) as pool:
        list(pool.map(lambda version: storage.publish(DRIVE, version), versions))
    found = {name.rpartition("/")[2]: storage.read(name) for name in storage.tree(DRIVE)}
    assert found in versions


def test_many_drives_are_listed_with_one_request(s3_store, counted) -> None:
    storage = UrlStorage(f"{s3_store.url}/store")
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda k: storage.write(f"drives/{k % 7:02x}/d{k}/{MARK}", b"{}"), range(200)))
    counted.calls.clear()
    assert len(storage.tree("drives")) == 200
    assert counted.calls == {"list_objects_v2": 1}


def test_what_was_left_half_written_is_swept_when_it_is_old(
    s3_store, monkeypatch: pytest.MonkeyPatch
) -> None:
    storage = UrlStorage(f"{s3_store.url}/store")
    storage.write("drives/ab/half/results.json", b"x")
    storage.publish(DRIVE, {MARK: b"1", "results.json": b"x"})
    storage.sweep()
    assert "drives/ab/half/results.json" in storage.tree("drives")
    monkeypatch.setattr(storage_url, "LEFT_BEHIND_S", -60.0)
    storage.sweep()
    assert list(storage.tree("drives")) == [f"{DRIVE}/{MARK}", f"{DRIVE}/results.json"]


def test_a_store_that_cannot_be_reached_is_one_line(s3_store, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(StoreError, match=r"^s3://not-there/store/drives/ab/one: .*no such bucket"):
        UrlStorage("s3://not-there/store").publish(DRIVE, {MARK: b""})
    assert isinstance(storage_at("s3://drives/store"), UrlStorage)
    with pytest.raises(StoreError, match="no library knows"):
        UrlStorage("nosuch://a/b")
    with pytest.raises(StoreError, match="no name of a file"):
        storage_at("s3://drives/store").write("../x", b"")


def test_a_connection_that_breaks_is_tried_again(s3_store, monkeypatch: pytest.MonkeyPatch) -> None:
    storage = UrlStorage(f"{s3_store.url}/store")
    monkeypatch.setattr(places_fs, "WAITS_S", (0.0, 0.0))
    broken = {"left": 2}
    plain = storage._fs.pipe_file

    def pipe_file(path, value, **kwargs):
        plain(path, value, **kwargs)
        if broken["left"]:
            broken["left"] -= 1
            raise ConnectionResetError("the answer was lost")

    monkeypatch.setattr(storage._fs, "pipe_file", pipe_file)
    assert storage.create("claims/one.json", b"me")
    broken["left"] = 3
    with pytest.raises(StoreError, match=r"failed 3 times .*the answer was lost"):
        storage.write("x.json", b"")


def test_a_results_store_in_s3_is_the_same_as_on_disk(s3_store, tmp_path: Path) -> None:
    there, here = (
        open_store(place, create=True) for place in (f"{s3_store.url}/store", str(tmp_path / "store"))
    )
    for store in (there, here):
        for number in (1, 2):
            files = {"results.json": b"{}", "report.html": b"<p>report</p>"}
            told = results_of_drive(number), kept_of_drive(number)
            store.put(found_drive(number), "key", facts_of_drive(number), *told, files)
        store.put_failure(found_drive(3), "key", facts_of_drive(3), "error", "no such file")
    assert there.all() == here.all()
    assert len(there.all().drives) == 3
    inside = UrlStorage(f"{s3_store.url}/store"), LocalStorage(tmp_path / "store")
    assert inside[0].tree("") == inside[1].tree("")
    assert all(inside[0].read(name) == inside[1].read(name) for name in inside[0].tree(""))
    stored = there.stored(found_drive(1).drive_id)
    assert stored is not None
    np.testing.assert_array_equal(there.kept(stored).rows, kept_of_drive(1).rows)
    assert there.report(stored) == here.report(stored)


def test_keys_of_large_logs_in_a_store_read_none_of_their_bytes(s3_store, counted) -> None:
    url = s3_store.write("fleet/drive.csv", b"1" * 3_000_000)
    counted.bytes = 0
    first = facts_of(url)
    assert counted.bytes == 0
    assert facts_of(url, first) == first
    assert facts_of(s3_store.write("fleet/drive.csv", b"2" * 3_000_000)).sha256 != first.sha256
