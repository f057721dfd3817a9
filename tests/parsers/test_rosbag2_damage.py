"""ROS 2 bags that are unfinished, damaged or no bags at all."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import zstandard
from rosbag2_files import COUNT, SPEED, YAW, collect, opened, write_database

from parsers.errors import LogError
from parsers.registry import read_head
from parsers.rosbag2_log import RosBag2Importer


def test_database_that_breaks_off(tmp_path: Path) -> None:
    path = write_database(tmp_path / "a.db3")
    raw = path.read_bytes()
    path.write_bytes(raw[: len(raw) * 6 // 10])
    reader, log = opened(path)
    values = collect(reader, YAW)[YAW][1]
    assert log.status == "truncated"
    assert any("breaks off" in note for note in log.notes)
    assert len(values) > COUNT * 0.3
    assert values.tolist() == [0.1 * i for i in range(len(values))]


def test_damaged_middle_of_a_database(tmp_path: Path) -> None:
    path = write_database(tmp_path / "a.db3")
    raw = bytearray(path.read_bytes())
    page = 4096
    for number in (len(raw) // page // 2, len(raw) // page // 2 + 3):
        raw[number * page : (number + 1) * page] = b"\xa5" * page
    path.write_bytes(raw)
    reader, log = opened(path)
    values = collect(reader, YAW)[YAW][1]
    assert log.status == "malformed"
    assert COUNT * 0.8 < len(values) < COUNT
    assert set(values) <= {0.1 * i for i in range(COUNT)}
    assert values[-1] == 0.1 * (COUNT - 1)


@pytest.mark.parametrize("size", [2000, 4096, 9000])
def test_messages_on_pages_of_zeros_are_counted_by_their_numbers(tmp_path: Path, size: int) -> None:
    path = write_database(tmp_path / "a.db3")
    raw = bytearray(path.read_bytes())
    begin = len(raw) // 4096 // 2 * 4096
    raw[begin : begin + size] = bytes(size)
    path.write_bytes(raw)
    reader, log = opened(path)
    read = [info.name for info in reader.channels if info.kind == "number" and "blob" not in info.name]
    collect(reader, *read)
    kept = 0
    with closing(sqlite3.connect(path)) as connection:
        lost = set(range(1, 4 * COUNT + 1))
        for number in tuple(lost):
            # the library finds what is whole, one by one
            try:
                query = "SELECT id, topic_id FROM messages WHERE id = ? AND typeof(data) = 'blob'"
                for found, topic in connection.execute(query, (number,)):
                    lost.discard(found)
                    kept += topic in (2, 5)
            except sqlite3.Error:
                pass
    assert 0 < len(lost) < 100
    assert log.messages == kept
    assert log.rejected == {"message of any topic on a damaged page of the bag": len(lost)}
    assert log.lost_spans_ns


def test_numbers_with_holes_tell_no_count_of_what_is_lost(tmp_path: Path) -> None:
    path = write_database(tmp_path / "a.db3")
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("DELETE FROM messages WHERE id = 7")
        connection.commit()
    raw = bytearray(path.read_bytes())
    begin = len(raw) // 4096 // 2 * 4096
    raw[begin : begin + 4096] = bytes(4096)
    path.write_bytes(raw)
    reader, log = opened(path)
    collect(reader, YAW)
    assert log.status == "malformed"
    assert not log.rejected
    assert any("how many messages were on its damaged pages cannot be told" in note for note in log.notes)


def test_messages_that_do_not_fit_are_counted(tmp_path: Path) -> None:
    path = write_database(tmp_path / "a.db3")
    with closing(sqlite3.connect(path)) as connection:
        connection.execute(
            "UPDATE messages SET data = substr(data, 1, 60) WHERE topic_id = 2 AND id % 40 = 1"
        )
        connection.execute("UPDATE messages SET data = 'text' WHERE topic_id = 2 AND id % 40 = 5")
        connection.commit()
    reader, log = opened(path)
    values = collect(reader, YAW)[YAW][1]
    assert np.isnan(values).sum() == COUNT // 10
    assert len(values) == COUNT - COUNT // 10
    assert log.rejected["message that does not fit its type's definition"] == COUNT // 10


def test_damaged_compressed_messages(tmp_path: Path) -> None:
    path = write_database(tmp_path / "a.db3")
    packer = zstandard.ZstdCompressor()
    with closing(sqlite3.connect(path)) as connection:
        rows = connection.execute("SELECT id, data FROM messages WHERE topic_id = 5").fetchall()
        packed = [(packer.compress(data), number) for number, data in rows]
        packed[3] = (packed[3][0][:-3], packed[3][1])
        packed[5] = (packed[5][0][:4] + b"\xe0" + b"\xff" * 8, packed[5][1])
        packed[7] = (rows[7][1], rows[7][0])
        connection.executemany("UPDATE messages SET data = ? WHERE id = ?", packed)
        connection.commit()
    reader, log = opened(path)
    values = collect(reader, SPEED)[SPEED][1]
    assert values.tolist() == [0.5 * i for i in range(COUNT) if i not in (3, 5, 7)]
    assert sum(log.rejected.values()) == 3


def test_compressed_file_that_breaks_off(tmp_path: Path) -> None:
    noise = np.random.default_rng(1).bytes(3000)
    whole = zstandard.ZstdCompressor().compress(write_database(tmp_path / "a.db3", extra=noise).read_bytes())
    packed = tmp_path / "b.db3.zstd"
    packed.write_bytes(whole[: len(whole) * 7 // 10])
    reader, log = opened(packed)
    assert log.status == "truncated"
    values = collect(reader, YAW)[YAW][1]
    assert values.tolist() == [0.1 * i for i in range(len(values))]
    assert COUNT > len(values) > COUNT * 0.4


def outcome(path: Path) -> str:
    """Read all of a bag: its status, or the error's line."""
    try:
        reader, log = opened(path)
        collect(reader, *[info.name for info in reader.channels if info.kind == "number"])
    except LogError as error:
        return str(error)
    return log.status


@pytest.mark.parametrize("size", [16, 100, 4000, 5000, 20_000])
def test_stumps_end_with_one_line_or_say_that_they_break_off(tmp_path: Path, size: int) -> None:
    path = write_database(tmp_path / "a.db3")
    path.write_bytes(path.read_bytes()[:size])
    line = outcome(path)
    assert line == "truncated" or line.startswith(f"{path}: ")
    assert "\n" not in line


def test_what_is_no_bag(tmp_path: Path) -> None:
    importer = RosBag2Importer()
    path = tmp_path / "x.sqlite"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("CREATE TABLE other (a)")
        connection.commit()
    assert not importer.claims(path, read_head(path))
    (tmp_path / "metadata.yaml").write_text("something: else\n")
    assert not importer.claims(tmp_path, b"")
    wrong = tmp_path / "y.db3"
    wrong.write_bytes(b"time,speed\n1,2\n")
    assert not importer.claims(wrong, read_head(wrong))


def test_folders_that_cannot_be_used(tmp_path: Path) -> None:
    (tmp_path / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  relative_file_paths:\n    - ../../etc/bag_0.db3\n"
    )
    with pytest.raises(LogError, match=r"names bag_0.db3, which is not there"):
        opened(tmp_path)
    (tmp_path / "metadata.yaml").unlink()
    write_database(tmp_path / "one_0.db3", 0, 5)
    write_database(tmp_path / "two_0.db3", 0, 5)
    with pytest.raises(LogError, match="2 different recordings"):
        opened(tmp_path)
    (tmp_path / "two_0.db3").unlink()
    (tmp_path / "one_1.db3").write_bytes(b"not a database at all")
    reader, log = opened(tmp_path)
    assert len(collect(reader, SPEED)[SPEED][1]) == 5
    assert log.status == "malformed"


def test_no_random_damage_crashes(tmp_path: Path) -> None:
    raw = write_database(tmp_path / "a.db3", count=60).read_bytes()
    rng = np.random.default_rng(7)
    for trial in range(40):
        bad = bytearray(raw)
        for _ in range(40):
            at = int(rng.integers(16, len(bad)))
            bad[at : at + 4] = rng.integers(0, 256, 4, dtype=np.uint8).tobytes()
        path = tmp_path / f"b{trial}.db3"
        path.write_bytes(bad)
        line = outcome(path)
        assert line in ("complete", "truncated", "malformed") or line.startswith(f"{path}: ")
        assert "\n" not in line
