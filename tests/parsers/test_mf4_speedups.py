"""The quick ways through an MF4 file give what the slow ones give: kernels, threads, transposed and cut blocks, gaps."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from mf4_files import START, Builder, bus_builder, frames_of, opened, values_of

import parsers.parallel
from parsers.can.frames import EXTENDED
from parsers.importer import ImportLog
from parsers.mf4 import pieces
from parsers.mf4.batch import Batch
from parsers.mf4.blocks import BlockFile
from parsers.mf4.bus_columns import columns_reader
from parsers.mf4.bus_layout import find_layout
from parsers.mf4.clock import NO_TIME, times_ns
from parsers.mf4.columns import column_reader
from parsers.mf4.model import Channel, Conversion, Group
from parsers.mf4.pieces import Fragment
from parsers.mf4.stamps import seconds_ns, stamp_reader
from parsers.mf4.streams import DataStream
from parsers.mf4.transpose import records_of

LINEAR = 1


def channel(name: str, byte: int, bits: int, data_type: int = 0, *, bit: int = 0, kind: int = 0,
            rule: Conversion | None = None, data: int = 0) -> Channel:  # fmt: skip
    return Channel(name, kind, int(kind == 2), data_type, bit, byte, bits, 0, 0, data, "", "", rule)


def line(offset: float, factor: float) -> Conversion:
    return Conversion(LINEAR, np.array([offset, factor]))


def group(size: int, *channels: Channel) -> Group:
    return Group(1, 64, 0, 0, 0, size, size, "", channels)


def records(of: Group, count: int, *, skip: int = 0, seed: int = 4) -> Batch:
    """Records of bytes at random, with `skip` bytes before each."""
    raw = np.random.default_rng(seed).integers(0, 256, count * (of.size + skip), dtype=np.uint8)
    return Batch(of, 7, raw, count, of.size + skip, skip)


@pytest.mark.parametrize("columns", [1, 2, 7, 8, 9, 13, 16, 24, 80])
@pytest.mark.parametrize("lines", [0, 1, 2, 7, 8, 9, 31, 1000])
def test_transposed_bytes(columns: int, lines: int) -> None:
    for rest in {0, columns // 2}:
        raw = np.random.default_rng(lines).integers(0, 256, columns * lines + rest, dtype=np.uint8)
        plain = [int(raw[c * lines + row]) for row in range(lines) for c in range(columns)]
        assert records_of(raw, columns).tolist() == plain + raw[columns * lines :].tolist()


def test_seconds_to_the_nearest_nanosecond() -> None:
    assert seconds_ns(0.1) == 100_000_000
    assert seconds_ns(1_700_000_000.25) == 1_700_000_000_250_000_000
    assert seconds_ns(-0.75) == -750_000_000
    assert seconds_ns(-2.0) == -2_000_000_000
    # halves of a nanosecond that a float holds exactly: to the even one
    assert [seconds_ns(k * 2.0**-10) for k in (1, 3)] == [976_562, 2_929_688]
    assert seconds_ns(3.0e-10) == 0
    for bad in (float("nan"), float("inf"), -float("inf"), 1e300, 2.4e9, -2.4e9):
        assert seconds_ns(bad) == NO_TIME


CLOCKS = [
    channel("t", 0, 64, 4, kind=2),
    channel("t", 5, 64, 4, kind=2, rule=line(3.0, 0.001)),
    channel("t", 2, 48, kind=2, rule=line(0.0, 1e-6)),
    channel("t", 0, 64, kind=2, rule=line(1.5, 1e-9)),
    channel("t", 11, 40, 2, kind=2, rule=line(-2.0, 1e-6)),
    channel("t", 4, 33, 0, bit=3, kind=2, rule=line(0.0, 1e-3 / 7)),
    channel("t", 12, 32, kind=2),
    channel("t", 3, 17, 2, bit=5, kind=2, rule=line(0.1, 0.01)),
    channel("t", 0, 32, 4, kind=2),
    channel("t", 0, 32, 1, kind=2, rule=line(0.0, 1e-3)),
    channel("t", 0, 0, kind=3, rule=line(0.5, 0.01)),
    channel("t", 0, 64, 4, kind=2, rule=line(float("nan"), 1.0)),
]


@pytest.mark.parametrize("clock", range(len(CLOCKS)))
@pytest.mark.parametrize("skip", [0, 1, 8])
def test_stamps_by_kernel_and_by_column(clock: int, skip: int) -> None:
    master = CLOCKS[clock]
    of = group(16, master)
    batch = records(of, 1500, skip=skip)
    if master.data_type == 4 and master.bit_count == 64:
        # bytes at random are rarely a time: put some in
        some = np.array([0.0, 1.25, -3.1, 1e9 / 3, np.nan, np.inf, 1e18, -0.0, 12345.678901234])
        batch.rows[: some.size, master.byte_offset : master.byte_offset + 8] = some.view(np.uint8).reshape(
            -1, 8
        )
    quick = stamp_reader(master, of, START)
    assert (quick.rules is not None) == (clock < 8 or clock == 11)
    slow = stamp_reader(master, of, START, compiled=False)
    got, bad = quick.read(batch)
    want, expected = slow.read(batch)
    np.testing.assert_array_equal(got, want)
    assert bad == expected == np.count_nonzero(times_ns(batch.rows, master, batch.first) == NO_TIME)
    assert (clock == 11) == (bad == 1500)


BITS = [
    (0, 8, 0, 0), (3, 12, 4, 0), (5, 64, 0, 0), (8, 1, 7, 0), (12, 57, 7, 0), (15, 40, 0, 2), (2, 11, 5, 2), (12, 64, 0, 2),
    (9, 32, 0, 4), (6, 64, 0, 4), (16, 32, 0, 4), (7, 58, 7, 2), (1, 16, 0, 1), (4, 24, 0, 3), (2, 16, 0, 4),
]  # fmt: skip
RULES = [
    None,
    line(0.0, 1.0),
    line(-40.0, 0.1),
    Conversion(2, np.array([0.0, 2.0, 1.0, 0.0, 0.5, 4.0])),
]


@pytest.mark.parametrize("skip", [0, 3])
def test_columns_by_kernel_and_by_column(skip: int) -> None:
    channels = {
        f"{number}/{which}": channel("x", byte, bits, data_type, bit=bit, rule=rule)
        for number, (byte, bits, bit, data_type) in enumerate(BITS)
        for which, rule in enumerate(RULES)
    }
    of = group(20, *channels.values())
    quick, slow = column_reader(channels, of), column_reader(channels, of, compiled=False)
    # the last fields lie across nine bytes, in another byte order, or are no whole float
    assert len(quick.plain) == 3 * 11
    assert slow.plain == ()
    batch = records(of, 1300, skip=skip)
    got, want = quick.read(batch).values, slow.read(batch).values
    assert list(got) == list(channels)
    for name in channels:
        np.testing.assert_array_equal(got[name], want[name], err_msg=name)


def can_group(size: int, *fields: Channel, master: Channel | None = None) -> Group:
    named = [replace(field, name=f"CAN_DataFrame.{field.name}") for field in fields]
    return group(size, master or channel("t", 0, 64, 4, kind=2), *named)


CODE_LENGTHS = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64]
ID, DATA = channel("ID", 8, 32), channel("DataBytes", 16, 64, 10)
LAYOUTS: list[tuple[bool, int, list[Channel]]] = [
    (True, 24, [ID, channel("IDE", 12, 8), channel("BusChannel", 13, 8), channel("DataLength", 14, 8), DATA]),
    (True, 24, [channel("ID", 8, 11), channel("IDE", 9, 1, bit=3), channel("DLC", 9, 4, bit=4), DATA]),
    (True, 96, [ID, channel("EDL", 13, 1, bit=6), channel("DLC", 12, 4), channel("DataBytes", 20, 512, 10)]),
    (True, 24, [channel("ID", 10, 29, bit=3), DATA]),
    # bus and length by rules of their own, as some recorders have them
    (True, 24, [ID, channel("BusChannel", 0, 0, kind=6, rule=line(9.0, 0.0)), DATA,
                channel("DataLength", 12, 4, rule=Conversion(5, np.array([v for k in range(16) for v in (k, CODE_LENGTHS[k])], float)))]),
    (True, 20, [ID, channel("IDE", 12, 8, rule=line(1.0, 0.0)), channel("DataLength", 13, 7), channel("DataBytes", 16, 32, 10)]),
    # not plain: the slow way
    (False, 24, [channel("ID", 8, 32, 1), DATA]),
    (False, 24, [ID, channel("BusChannel", 12, 16), DATA]),
    (False, 24, [ID, channel("DataLength", 12, 8, 1), DATA]),
    (False, 24, [ID, channel("BusChannel", 0, 0, kind=6), DATA]),
]  # fmt: skip


@pytest.mark.parametrize("case", range(len(LAYOUTS)))
@pytest.mark.parametrize("skip", [0, 2])
def test_frames_by_kernel_and_by_column(case: int, skip: int) -> None:
    plain, size, fields = LAYOUTS[case]
    of = can_group(size, *fields)
    layout = find_layout(of, ImportLog())
    assert layout is not None
    quick, slow = columns_reader(layout, START), columns_reader(layout, START, compiled=False)
    assert (quick.plan is not None) == plain
    assert slow.plan is None
    batch = records(of, 900, skip=skip)
    batch.rows[:, :8] = (np.arange(900) * 0.001).view(np.uint8).reshape(-1, 8)
    got, want = quick.read(batch), slow.read(batch)
    for name in ("time_ns", "can_id", "bus", "length", "offset", "timeless"):
        np.testing.assert_array_equal(getattr(got, name), getattr(want, name), err_msg=name)
    assert got.can_id.dtype == np.uint32
    assert got.length.max() <= 64
    np.testing.assert_array_equal(got.time_ns, START + np.arange(900) * 1_000_000)
    width = size - fields[-1].byte_offset if fields[-1].name == "DataBytes" else 8
    assert int((got.offset + got.length).max()) <= batch.data.size
    assert got.length.max() <= width


def test_lengths_of_classic_and_fd_frames_in_one_group() -> None:
    of = can_group(96, *LAYOUTS[2][2])
    layout = find_layout(of, ImportLog())
    assert layout is not None
    batch = records(of, 32)
    batch.rows[:, 8:16] = 0
    batch.rows[:, 12] = np.arange(32) % 16
    batch.rows[16:, 13] = 1 << 6
    got = columns_reader(layout, 0).read(batch)
    assert got.length.tolist() == [min(k, 8) for k in range(16)] + CODE_LENGTHS


RECORDS = b"".join(struct.pack("<QH", k * 10, k) for k in range(6000))


def many_blocks(method: int, cuts: list[int], *, kind: str = "DZ") -> Builder:
    """A group of 6000 records in blocks that end at the cuts."""
    b = Builder()
    b.header("dg")
    b.data_group("dg", "cg", "dl")
    b.group("cg", "t", 10, cycles=6000)
    b.channel("t", 0, 64, kind=2, rule=b.rule("ms", 1, [0.0, 0.001]), after="v")
    b.channel("v", 8, 16)
    names = [f"d{k}" for k in range(len(cuts) + 1)]
    b.data_list("dl", names)
    for k, (low, high) in enumerate(pairwise([0, *cuts, len(RECORDS)])):
        if kind == "DZ" or (kind == "mixed" and k % 2):
            b.packed(names[k], RECORDS[low:high], method=method, columns=10)
        else:
            b.add(names[k], "DT", [], RECORDS[low:high])
    return b


CUTS = [3, 10, 95, 4000, 4001, 17_777, 17_780, 33_330, 50_005]


@pytest.fixture(params=[1, 2])
def workers(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    monkeypatch.setattr(parsers.parallel, "cores", lambda: request.param)
    monkeypatch.setattr(pieces, "CHUNK", 9_999)
    return request.param


@pytest.mark.parametrize("kind", ["DZ", "DT", "mixed"])
@pytest.mark.parametrize("method", [0, 1])
def test_blocks_that_cut_records(tmp_path: Path, workers: int, kind: str, method: int) -> None:
    reader, log = opened(tmp_path / "a.mf4", many_blocks(method, CUTS, kind=kind).build())
    got = values_of(reader)["v"]
    assert got[1] == [float(k) for k in range(6000)]
    assert got[0] == [k * 10_000_000 for k in range(6000)]
    assert (log.status, log.messages) == ("complete", 6000)


@pytest.mark.parametrize("method", [0, 1])
def test_damage_costs_a_block_and_its_time_span_is_told(tmp_path: Path, workers: int, method: int) -> None:
    content = bytearray(many_blocks(method, CUTS).build())
    at = -1
    for _ in range(6):
        at = content.index(b"##DZ", at + 1)
    content[at + 100 : at + 400] = bytes(300)
    reader, log = opened(tmp_path / "a.mf4", bytes(content))
    # the sixth block: from byte 4001 to byte 17777 of the records
    got = values_of(reader)["v"]
    assert got[1] == [*range(400), *range(1778, 6000)]
    assert log.rejected == {"damaged data block in the MF4 file": 1}
    assert log.lost_spans_ns == [(START + 3990 * 1_000_000, START + 17_780 * 1_000_000)]
    assert log.status == "malformed"


@pytest.mark.parametrize("equal", [True, False])
def test_lists_with_equal_lengths_and_with_offsets(tmp_path: Path, equal: bool) -> None:
    b = many_blocks(1, [20_000, 40_000])
    _, links, _ = b.blocks["dl"]
    body = struct.pack("<Q", 20_000) if equal else struct.pack("<3Q", 0, 20_000, 40_000)
    b.add("dl", "DL", links, struct.pack("<B3xI", int(equal), 3) + body)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert values_of(reader)["v"][1] == list(range(6000))
    assert log.status == "complete"


def test_damage_in_the_frames_is_told_once(tmp_path: Path, workers: int) -> None:
    b = bus_builder("fixed")
    _, _, data = b.blocks["dt"]
    size = len(data) // 10
    b.data_list("dt", ["d0", "d1", "d2"])
    for k, part in enumerate((data[: 4 * size + 5], data[4 * size + 5 : 6 * size + 1], data[6 * size + 1 :])):
        b.packed(f"d{k}", part)
    content = bytearray(b.build())
    at = content.index(b"##DZ", content.index(b"##DZ") + 1)
    content[at + 60 : at + 80] = b"\xff" * 20
    reader, log = opened(tmp_path / "a.mf4", bytes(content))
    assert [row[0] // 10_000_000 for row in frames_of(reader)] == [0, 1, 2, 3, 7, 8, 9]
    list(reader.read(frozenset(info.name for info in reader.channels)))
    assert log.rejected["damaged data block in the MF4 file"] == 1
    assert log.lost_spans_ns == [(START + 30_000_000, START + 70_000_000)]


@pytest.mark.parametrize(("method", "least"), [(0, 4900), (1, 3333)])
def test_a_file_cut_in_a_compressed_block(tmp_path: Path, method: int, least: int) -> None:
    content = many_blocks(method, [33_330]).build()
    second = content.index(b"##DZ", content.index(b"##DZ") + 4)
    cut = second + (len(content) - second) * 2 // 3
    reader, log = opened(tmp_path / "a.mf4", content[:cut])
    got = values_of(reader)["v"][1]
    # of a transposed block nothing is whole; of another the first two thirds are
    assert got == list(range(len(got)))
    assert least <= len(got) < 6000
    assert (len(got) == 3333) == (method == 1)
    assert log.status == "truncated"


def test_big_blocks_are_inflated_one_at_a_time(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked: list[int | None] = []

    def listen(function: object, items: object, *, workers: int | None = None) -> Iterator[object]:
        asked.append(workers)
        return map(function, items)  # type: ignore[arg-type, call-overload, no-any-return]

    monkeypatch.setattr(pieces, "in_order", listen)
    for limit in (1 << 20, 1000):
        monkeypatch.setattr(pieces, "BIG", limit)
        reader, _ = opened(tmp_path / "a.mf4", many_blocks(0, CUTS).build())
        assert len(values_of(reader)["v"][1]) == 6000
    assert asked == [None, 1]


def test_any_place_of_a_stream(tmp_path: Path) -> None:
    path = tmp_path / "a.mf4"
    path.write_bytes(many_blocks(1, CUTS, kind="mixed").build())
    from parsers.mf4.streams import open_stream
    from parsers.mf4.tree import read_measurement

    rng = np.random.default_rng(9)
    with BlockFile(path) as file:
        stream = open_stream(
            file, read_measurement(file, ImportLog()).data_groups[0].data_link, 0, ImportLog()
        )
        assert stream.size == len(RECORDS)
        for _ in range(100):
            low, high = sorted(rng.integers(0, len(RECORDS) + 1, 2).tolist())
            assert stream.read(low, high).tobytes() == RECORDS[low:high]


def test_a_file_that_shrinks_while_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.mf4"
    path.write_bytes(bytes(5000))
    log = ImportLog()
    with BlockFile(path) as file:
        stream = DataStream(file, log)
        stream.add(Fragment(100, 4000, 4000))
        path.write_bytes(bytes(300))
        assert list(stream.chunks(10)) == []
    assert log.status == "malformed"
    assert "became shorter" in log.notes[0]


def test_unsorted_frames_of_many_kinds(tmp_path: Path) -> None:
    """Classic and FD frames with the same id, two buses, remote and error frames: groups of one stream."""
    b = Builder()
    b.header("dg")
    b.data_group("dg", "g1", "dt", id_size=1)
    rule = b.rule("us", 1, [0.0, 1e-6])
    names = {
        1: ("CAN_DataFrame", 8),
        2: ("CAN_DataFrame", 64),
        3: ("CAN_RemoteFrame", 0),
        4: ("CAN_ErrorFrame", 0),
    }
    for number, (name, width) in names.items():
        after = f"g{number + 1}" if number < 4 else ""
        b.group(f"g{number}", f"t{number}", 12 + width, ident=number, flags=2, after=after)
        b.channel("t", 0, 48, kind=2, rule=rule, key=f"t{number}", after=f"f{number}")
        b.channel(name, 6, 8 * (6 + width), data_type=10, key=f"f{number}", parts=f"i{number}", flags=0x400)
        b.channel(f"{name}.ID", 6, 29, key=f"i{number}", after=f"e{number}")
        b.channel(f"{name}.IDE", 9, 1, bit=7, key=f"e{number}", after=f"b{number}")
        b.channel(f"{name}.BusChannel", 10, 4, key=f"b{number}", after=f"l{number}")
        b.channel(f"{name}.DataLength", 11, 7, key=f"l{number}", after=f"d{number}" if width else "")
        if width:
            b.channel(f"{name}.DataBytes", 12, 8 * width, data_type=10, key=f"d{number}")
    rng = np.random.default_rng(6)
    parts, sent = [], []
    for k in range(3000):
        number = int(rng.integers(1, 5))
        width, bus, far = names[number][1], int(rng.integers(1, 4)), bool(rng.integers(2))
        data = rng.bytes(int(rng.choice([v for v in CODE_LENGTHS if v <= width])))
        ident = 0x123 | (EXTENDED if far else 0)
        head = struct.pack("<Q", k * 1000)[:6] + struct.pack("<IBB", ident, bus, len(data))
        parts.append(bytes([number]) + head + data.ljust(width, b"\x5a"))
        if number < 3:
            sent.append((k * 1_000_000, ident, bus, data))
    b.add("dt", "DT", [], b"".join(parts))
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert sorted(frames_of(reader)) == sent
    kinds = [part[0] for part in parts]
    assert log.rejected == {"CAN remote frame": kinds.count(3), "CAN error frame": kinds.count(4)}
    assert log.messages == len(sent)
