"""What is fetched of a remote file: parts, each once, in few requests; and what happens when that fails."""

from __future__ import annotations

import contextlib
import http.server
import io
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from mcap.writer import CompressionType
from remote_files import with_camera
from test_importer_contract import options_for
from test_remote_logs import same

from parsers import places_fs, places_ranges
from parsers.errors import LogError
from parsers.load import load_drive
from parsers.places import as_path, remote
from parsers.places_ranges import RangeFile, Ranges

CONTENT = np.random.default_rng(5).integers(0, 256, 3_000_001, dtype=np.uint8).tobytes()


class Source:
    """Bytes, and the ranges that were asked for."""

    def __init__(self, content: bytes = CONTENT) -> None:
        self.content = content
        self.asked: list[tuple[int, int]] = []

    def fetch(self, start: int, stop: int) -> bytes:
        self.asked.append((start, stop))
        return self.content[start:stop]

    def ranges(self) -> Ranges:
        return Ranges(len(self.content), self.fetch)


def test_a_stream_reads_and_seeks_as_a_file_does(tmp_path: Path) -> None:
    path = tmp_path / "x"
    path.write_bytes(CONTENT)
    rng = np.random.default_rng(2)
    source = Source()
    with path.open("rb", buffering=0) as expected, RangeFile(source.ranges()) as found:
        for _ in range(300):
            whence = int(rng.integers(0, 3))
            offset = (
                int(rng.integers(0, len(CONTENT) + 100)) if whence == 0 else int(rng.integers(-5000, 200))
            )
            try:
                place = expected.seek(offset, whence)
            except (OSError, ValueError):
                with pytest.raises(ValueError, match="negative"):
                    found.seek(offset, whence)
                continue
            assert found.seek(offset, whence) == place == found.tell()
            size = int(rng.integers(0, 1 << int(rng.integers(1, 20))))
            assert found.read(size) == expected.read(size)
        found.seek(-7, io.SEEK_END)
        assert found.read() == CONTENT[-7:]
        found.seek(0)
        assert found.readall() == CONTENT
    with pytest.raises(ValueError, match="closed"):
        found.read(1)


def test_reading_on_and_on_asks_ever_more_at_a_time_and_nothing_twice() -> None:
    source = Source()
    with RangeFile(source.ranges()) as file:
        while file.read(4096):
            pass
    sizes = [stop - start for start, stop in source.asked]
    assert sum(sizes) == len(CONTENT)
    assert len(sizes) <= 7
    assert sizes[:5] == [1 << 15, 1 << 16, 1 << 17, 1 << 19, 1 << 21]


def test_jumps_fetch_little() -> None:
    source = Source()
    with RangeFile(source.ranges()) as file:
        for place in (2_999_990, 1_000_000, 2_000_000, 1_000_100):
            file.seek(place)
            file.read(11)
    assert len(source.asked) == 3
    assert (
        sum(stop - start for start, stop in source.asked)
        <= 3 * places_ranges.JUMP_BLOCKS * places_ranges.BLOCK_BYTES
    )


def test_memory_is_bounded_and_many_threads_share_what_comes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(places_ranges, "KEPT_BYTES", 1 << 18)
    source = Source()
    ranges = source.ranges()

    def read(start: int) -> bytes:
        with RangeFile(ranges) as file:
            file.seek(start)
            return file.read(100_000)

    starts = list(range(0, 3_000_000, 100_000))
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(read, starts))
    assert found == [CONTENT[a : a + 100_000] for a in starts]
    assert sum(len(block) for block in ranges._kept.values()) <= 1 << 18


def test_a_small_file_is_fetched_once_however_many_read_it() -> None:
    small = Source(CONTENT[:300_000])
    shared = small.ranges()
    with ThreadPoolExecutor(8) as pool:
        assert set(pool.map(lambda _: RangeFile(shared).read(300_000), range(16))) == {small.content}
    assert small.asked == [(0, 300_000)]


def test_a_failed_fetch_fails_its_reader_and_the_next_one_tries_again() -> None:
    source, broken = Source(), [True]

    def fetch(start: int, stop: int) -> bytes:
        if broken.pop() if broken else False:
            raise OSError(5, "gone")
        return source.fetch(start, stop)

    file = RangeFile(Ranges(len(CONTENT), fetch))
    with pytest.raises(OSError, match="gone"):
        file.read(10)
    assert file.read(10) == CONTENT[:10]


def test_a_camera_50_times_as_large_is_hardly_fetched(
    s3_store, counted, samples: Path, tmp_path: Path
) -> None:
    log = tmp_path / "camera.mcap"
    with_camera(samples / "mcap" / "drive_json.mcap", log, 0.3, 50, CompressionType.NONE)
    url = s3_store.put(log, "camera.mcap")
    options = options_for(samples / "mcap" / "drive_json.mcap")
    counted.bytes = 0
    there = load_drive([as_path(url)], options)
    same(load_drive([log], options), there)
    assert log.stat().st_size > 10_000_000
    assert counted.bytes < 0.1 * log.stat().st_size


def test_of_a_wide_table_only_the_columns_that_are_read_are_fetched(
    s3_store, counted, tmp_path: Path
) -> None:
    rng, n = np.random.default_rng(3), 40_000
    names = ["time_ns", "accel_y_mps2", "speed_mps", *(f"other_{k}" for k in range(60))]
    columns = {name: rng.normal(size=n) for name in names}
    columns["time_ns"] = 1_700_000_000_000_000_000 + 10_000_000 * np.arange(n)
    columns["speed_mps"] = 20 + columns["speed_mps"] / 10
    log = tmp_path / "wide.parquet"
    pl.DataFrame(columns).write_parquet(log, row_group_size=7000)
    url = s3_store.put(log, "wide.parquet")
    counted.bytes = 0
    there = load_drive([as_path(url)])
    same(load_drive([log]), there)
    assert {"accel_y", "speed"} <= set(there.signals)
    assert counted.bytes < 0.1 * log.stat().st_size


def test_a_damaged_table_of_contents_is_said(s3_store, samples: Path) -> None:
    content = (samples / "parquet" / "drive.parquet").read_bytes()
    cut = s3_store.write("cut.parquet", content[: len(content) // 2])
    with pytest.raises(LogError, match="truncated"):
        load_drive([as_path(cut)])
    rng = np.random.default_rng(7)
    length = int.from_bytes(content[-8:-4], "little")
    told = []
    for k in range(12):
        bad = bytearray(content)
        for place in len(content) - 8 - length + rng.integers(0, length, 3):
            bad[place] = int(rng.integers(0, 256))
        url = s3_store.write(f"bad{k}.parquet", bytes(bad))
        # bytes that say nothing may be hit; nothing but LogError is ever raised
        with contextlib.suppress(LogError):
            load_drive([as_path(url)])
            continue
        told.append(url)
    assert len(told) > 3


def test_a_connection_that_breaks_in_the_middle_is_tried_again(
    s3_store, samples: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(places_fs, "WAITS_S", (0.0, 0.0))
    log = samples / "vbo" / "drive.vbo"
    url = s3_store.put(log, "drive.vbo")
    import s3fs

    plain, left = s3fs.S3FileSystem._call_s3, [2]

    async def call(self, method, *args, **kwargs):
        if method == "get_object" and left[0] and "bytes=32768" in kwargs["Range"]:
            left[0] -= 1
            raise ConnectionResetError("reset by peer")
        return await plain(self, method, *args, **kwargs)

    monkeypatch.setattr(s3fs.S3FileSystem, "_call_s3", call)
    monkeypatch.setattr(places_ranges, "SMALL_BYTES", 0)
    same(load_drive([log], options_for(log)), load_drive([as_path(url)], options_for(log)))
    assert left == [0]
    left[0] = 1000
    with pytest.raises(
        LogError, match=r"^s3://drives/drive.vbo: cannot be read \(the connection failed 3 times"
    ):
        load_drive([as_path(url)], options_for(log))


def test_a_log_that_changes_while_it_is_read_is_no_log(s3_store, samples: Path) -> None:
    log = samples / "csv" / "drive.csv"
    url = s3_store.put(log, "drive.csv")
    path = as_path(url)
    assert path.stat().st_size == log.stat().st_size
    s3_store.write("drive.csv", log.read_bytes()[:-1] + b"x")
    with pytest.raises(LogError, match="changed in its store"):
        load_drive([path], options_for(log))


def test_no_permission_and_no_network_are_said(s3_store, monkeypatch: pytest.MonkeyPatch) -> None:
    import s3fs

    for code, said in (("AccessDenied", "no permission"), ("InvalidAccessKeyId", "no permission")):
        from botocore.exceptions import ClientError

        async def refuse(self, method, *args, code=code, **kwargs):
            from s3fs.errors import translate_boto_error

            raise translate_boto_error(ClientError({"Error": {"Code": code, "Message": code}}, method))

        with monkeypatch.context() as patch:
            patch.setattr(s3fs.S3FileSystem, "_call_s3", refuse)
            with pytest.raises(LogError, match=said):
                load_drive([as_path("s3://drives/x.csv")])
    monkeypatch.setattr(places_fs, "WAITS_S", (0.0,))
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:9")
    s3fs.S3FileSystem.clear_instance_cache()
    with pytest.raises(LogError, match="connection failed 2 times"):
        load_drive([as_path("s3://drives/x.csv")])


@pytest.fixture
def plain_server(samples: Path) -> Iterator[str]:
    """A web server over the sample logs that knows no ranges."""

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_: object) -> None:
            return

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(samples)))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_address[1]}"
    server.shutdown()
    server.server_close()
    thread.join()


def test_a_server_without_ranges_costs_one_download_and_is_named(
    plain_server: str, samples: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("aiohttp")
    log = samples / "can" / "drive.trc"
    path = as_path(f"{plain_server}/can/drive.trc?token=hunter2")
    drive = load_drive([path], options_for(log))
    same(load_drive([log], options_for(log)), drive)
    notes = " ".join(drive.record.notes)
    assert "downloaded whole" in notes
    assert "hunter2" not in notes + str(drive.record.paths)
    far = remote(path)
    assert far is not None
    assert not far.was_downloaded  # the temporary file is gone


def test_a_signed_address_is_read_in_ranges(s3_store, samples: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = samples / "vbo" / "drive.vbo"
    s3_store.put(log, "drive.vbo")
    path = as_path(f"{s3_store.endpoint}/drives/drive.vbo?X-Amz-Signature=hunter2")
    drive = load_drive([path], options_for(log))
    same(load_drive([log], options_for(log)), drive)
    assert "hunter2" not in str(drive.record)
    assert any("http etag" in note for note in drive.record.notes)
    assert not any("downloaded" in note for note in drive.record.notes)
