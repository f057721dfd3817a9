"""BLF objects that are walked in groups: every mix of sorts and sizes, wherever containers cut them, damage among them."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from blf_files import (
    NUMBERED,
    START,
    classic,
    container,
    fd,
    frames_of,
    header_bytes,
    obj,
    write_containers,
)
from frame_rows import Frame

from parsers.allocator import Slab
from parsers.blf_walk import Columns, block_of
from parsers.blf_walker import ObjectWalker, guess


def mixed_objects(count: int) -> tuple[list[bytes], list[Frame]]:
    """Objects of all sorts in no regular order, and the frames that they are."""
    rng = np.random.default_rng(8)
    objects, rows = [], []
    for k in range(count):
        sort, data = int(rng.integers(5)), rng.bytes(int(rng.integers(0, 9)))
        ident, ticks = int(rng.integers(0x700)), k * 1000
        if sort == 0:
            objects.append(obj(1, classic(2, ident, data), ticks))
        elif sort == 1:
            objects.append(obj(86, classic(2, ident, data) + bytes(8), k, flags=1))
            ticks = k * 10_000
        elif sort == 2:
            data = rng.bytes(int(rng.integers(0, 65)))
            objects.append(obj(100, fd(2, ident, data), ticks))
        elif sort == 3:
            # the writer left out what is zero at the end
            objects.append(obj(100, fd(2, ident, data, valid=48), ticks))
            data = data.ljust(48, b"\0")
        else:
            objects.append(obj(65, b"LOBJ" * int(rng.integers(9)), ticks))
            continue
        rows.append((ticks, ident, 2, data))
    return objects, rows


@pytest.mark.parametrize("workers", [1, 2, 3])
@pytest.mark.parametrize(("group", "read"), [(1, 128), (700, 1000), (1 << 20, 1 << 20)])
def test_every_sort_of_object_whatever_is_read_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, workers: int, group: int, read: int
) -> None:
    monkeypatch.setattr("parsers.parallel.cores", lambda: workers)
    monkeypatch.setattr("parsers.blf_groups.GROUP_BYTES", group)
    monkeypatch.setattr("parsers.blf_groups.READ_BYTES", read)
    objects, expected = mixed_objects(3000)
    path = write_containers(tmp_path / "a.blf", b"".join(objects), 333)
    rows, log = frames_of(path)
    assert rows == expected
    assert (log.status, log.messages, dict(log.rejected)) == ("complete", len(expected), {})


def test_containers_are_inflated_one_by_one_where_it_cannot_be_done_with_one_call(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    objects, expected = mixed_objects(500)
    path = write_containers(tmp_path / "a.blf", b"".join(objects), 333)
    calls = []
    monkeypatch.setattr("parsers.blf_groups.inflate_all", lambda *given: calls.append(given))
    assert frames_of(path)[0] == expected
    assert calls


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("cut", range(3, 230, 7))
def test_payloads_that_look_like_objects_where_a_group_begins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, workers: int, cut: int
) -> None:
    monkeypatch.setattr("parsers.parallel.cores", lambda: workers)
    monkeypatch.setattr("parsers.blf_groups.GROUP_BYTES", 1)
    # whole frames of its own within a payload, at the end of it and in its middle
    fake = obj(1, classic(1, 0x666, b"fakefake"), 5)
    payloads = [fake.ljust(64, b"\0"), fake.rjust(64, b"\0"), b"LOBJ" * 16, b"\0" * 7 + fake + b"LOBJ"]
    content = b"".join(
        NUMBERED[k] + obj(100, fd(1, 100 + k, payloads[k % 4]), k * 1000 + 500) for k in range(40)
    )
    rows, log = frames_of(write_containers(tmp_path / "a.blf", content, cut))
    assert [row[1] for row in rows] == [number for k in range(40) for number in (k, 100 + k)]
    assert [row[3] for row in rows[1::2]] == [payloads[k % 4] for k in range(40)]
    assert (log.status, dict(log.rejected), log.lost_spans_ns) == ("complete", {}, [])


@pytest.mark.parametrize("cut", [0, 1, 20, 47, 48, 100])
def test_what_was_walked_ahead_is_taken(cut: int) -> None:
    content = b"".join(NUMBERED)
    walker = ObjectWalker(0)
    first, second = block_of("container", 0, cut, content[:cut]), block_of("container", cut, 0, content[cut:])
    ahead = guess(second, 0, Columns.of(Slab(0)))
    assert ahead is not None
    ids = [int(can_id) for batch in walker.walk(first) for can_id in batch.can_id]
    batches = list(walker.walk(second, ahead))
    assert batches[-1].time_ns.base is ahead.columns.time_ns
    assert ids + [int(can_id) for batch in batches for can_id in batch.can_id] == list(range(40))
    assert walker.tail == b""


def test_more_frames_in_a_container_than_in_a_batch(tmp_path: Path) -> None:
    count = 150_000
    content = b"".join(obj(1, classic(1, k & 0x7FF, bytes([k & 255])), k) for k in range(count))
    rows, log = frames_of(write_containers(tmp_path / "a.blf", content, len(content)))
    assert [(row[0], row[1]) for row in rows] == [(k, k & 0x7FF) for k in range(count)]
    assert log.status == "complete"


def test_more_payloads_with_zeros_left_out_than_there_is_room_for(tmp_path: Path) -> None:
    content = b"".join(obj(100, fd(1, 5, bytes([k & 255]), valid=64), k) for k in range(5000))
    rows, _ = frames_of(write_containers(tmp_path / "a.blf", content, 1 << 20))
    assert [row[3] for row in rows] == [bytes([k & 255]).ljust(64, b"\0") for k in range(5000)]


@pytest.mark.parametrize("claimed", [0, 1, 1919, 1921, 1 << 20, 0xFFFFFFFF])
def test_a_container_whose_stated_size_is_not_true_is_read_all_the_same(tmp_path: Path, claimed: int) -> None:
    whole = container(b"".join(NUMBERED))
    path = tmp_path / "a.blf"
    wrong = whole[:24] + struct.pack("<L", claimed) + whole[28:]
    path.write_bytes(header_bytes() + whole + wrong + whole)
    rows, log = frames_of(path)
    assert [row[1] for row in rows] == list(range(40)) * 3
    assert log.status == "complete"


@pytest.mark.parametrize("method", [0, 2], ids=["stored", "zlib"])
def test_an_object_larger_than_containers(tmp_path: Path, method: int) -> None:
    content = NUMBERED[0] + obj(65, b"LOBJ" * 5000, 0) + NUMBERED[1]
    path = tmp_path / "a.blf"
    parts = [content[at : at + 3000] for at in range(0, len(content), 3000)]
    path.write_bytes(header_bytes() + b"".join(container(part, method) for part in parts))
    rows, log = frames_of(path)
    assert [row[1] for row in rows] == [0, 1]
    assert log.status == "complete"


@pytest.mark.parametrize("workers", [1, 2])
def test_damage_within_a_group_costs_what_is_in_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, workers: int
) -> None:
    monkeypatch.setattr("parsers.parallel.cores", lambda: workers)
    # cut within an object: what straddles the damage is lost as well
    content = b"".join(NUMBERED)
    parts = [bytearray(container(content[at : at + 200])) for at in range(0, len(content), 200)]
    for number in (2, 6):
        parts[number][35:50] = b"\xff" * 15
    path = tmp_path / "a.blf"
    path.write_bytes(header_bytes() + b"".join(parts))
    rows, log = frames_of(path)
    assert [row[1] for row in rows] == [*range(8), *range(13, 25), *range(30, 40)]
    start = START * 1_000_000_000 + 250_000_000
    assert log.lost_spans_ns == [(start + 7000, start + 13_000), (start + 24_000, start + 30_000)]
    assert log.rejected["damaged container in the BLF file"] == 2
