"""MF4 files built block by block: unsorted records, variable length, unfinished, cut, damaged and circular files."""

from __future__ import annotations

import contextlib
import struct
import zlib
from dataclasses import dataclass, field
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard

from parsers.can.frames import EXTENDED
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions, no_progress
from parsers.mf4.algebra import FormulaError, evaluate
from parsers.mf4.conversions import convert
from parsers.mf4.model import Conversion
from parsers.mf4.reader import Mf4Reader, open_mf4
from parsers.mf4_log import Mf4Importer

START = 1_700_000_000_000_000_000
Row = tuple[int, int, int, bytes]


@dataclass
class Builder:
    """Blocks by name, laid out one behind the other; links are names, resolved when the file is written."""

    blocks: dict[str, tuple[str, list[str], bytes]] = field(default_factory=dict)
    mark: bytes = b"MDF     "
    flags: int = 0
    version: int = 410

    def add(self, name: str, kind: str, links: list[str], data: bytes = b"") -> str:
        self.blocks[name] = (kind, links, data)
        return name

    def text(self, words: str) -> str:
        return self.add(f"text {words}", "TX", [], words.encode() + b"\0") if words else ""

    def header(self, first: str, start: int = START, time_flags: int = 2) -> None:
        data = struct.pack("<QhhBBBBdd", start, 0, 0, time_flags, 0, 0, 0, 0.0, 0.0)
        others = {name: block for name, block in self.blocks.items() if name != "HD"}
        self.blocks = {"HD": ("HD", [first, "", "", "", "", ""], data), **others}

    def data_group(self, name: str, group: str, data: str, *, id_size: int = 0, after: str = "") -> str:
        return self.add(name, "DG", [after, group, data, ""], bytes([id_size]) + b"\0" * 7)

    def group(self, name: str, channel: str, size: int, *, cycles: int = 0, ident: int = 0, flags: int = 0,
              invalid: int = 0, after: str = "") -> str:  # fmt: skip
        data = struct.pack("<QQHHIII", ident, cycles, flags, 0, 0, size, invalid)
        return self.add(name, "CG", [after, channel, "", "", "", ""], data)

    def channel(self, name: str, byte: int, bits: int, *, kind: int = 0, data_type: int = 0, bit: int = 0, rule: str = "",
                data: str = "", parts: str = "", after: str = "", flags: int = 0, invalid: int = 0, key: str = "") -> str:  # fmt: skip
        sync = 1 if kind in (2, 3) else 0
        body = struct.pack(
            "<BBBBIIIIBBH6d", kind, sync, data_type, bit, byte, bits, flags, invalid, 0, 0, 0, *[0.0] * 6
        )
        return self.add(key or name, "CN", [after, parts, self.text(name), "", rule, data, "", ""], body)

    def rule(self, name: str, kind: int, values: list[float], refs: list[str] | None = None) -> str:
        refs = refs or []
        data = struct.pack(f"<BBHHHdd{len(values)}d", kind, 0, 0, len(refs), len(values), 0.0, 0.0, *values)
        return self.add(name, "CC", ["", "", "", "", *refs], data)

    def packed(
        self, name: str, data: bytes, *, method: int = 0, columns: int = 0, kind: bytes = b"DT"
    ) -> str:
        raw = data
        if method % 2:
            lines = len(data) // columns
            body = np.frombuffer(data, np.uint8, lines * columns).reshape(lines, columns).T.tobytes()
            raw = body + data[lines * columns :]
        squeezed = {0: zlib.compress, 2: zstandard.compress, 4: lz4.frame.compress}[method // 2 * 2](raw)
        head = struct.pack("<2sBxIQQ", kind, method, columns, len(data), len(squeezed))
        return self.add(name, "DZ", [], head + squeezed)

    def data_list(self, name: str, links: list[str], after: str = "") -> str:
        return self.add(
            name, "DL", [after, *links], struct.pack("<B3xI", 0, len(links)) + b"\0" * 8 * len(links)
        )

    def build(self) -> bytes:
        places, at = {"": 0}, 64
        for name, (_, links, data) in self.blocks.items():
            places[name] = at
            at += (24 + 8 * len(links) + len(data) + 7) // 8 * 8
        out = bytearray(
            struct.pack("<8s8s8s4xH30xHH", self.mark, b"4.10    ", b"test    ", self.version, self.flags, 0)
        )
        for kind, links, data in self.blocks.values():
            length = 24 + 8 * len(links) + len(data)
            out += b"##" + kind.encode() + struct.pack("<IQQ", 0, length, len(links))
            out += b"".join(struct.pack("<Q", places[link]) for link in links) + data
            out += b"\0" * (-len(out) % 8)
        return bytes(out)


def opened(path: Path, content: bytes) -> tuple[Mf4Reader, ImportLog]:
    path.write_bytes(content)
    log = ImportLog()
    return open_mf4(path, ReadOptions(), log), log


def values_of(reader: Mf4Reader, *names: str) -> dict[str, tuple[list[int], list[float]]]:
    out: dict[str, tuple[list[int], list[float]]] = {}
    wanted = frozenset(names or [c.name for c in reader.channels])
    for chunk in reader.read(wanted):
        for name, column in chunk.columns.items():
            times, numbers = out.setdefault(name, ([], []))
            times += (chunk.time_ns - START).tolist()
            numbers += column.tolist()
    return out


def frames_of(reader: Mf4Reader) -> list[Row]:
    assert reader.frames is not None
    rows: list[Row] = []
    for batch in reader.frames.frames(counting=False):
        for i in range(batch.time_ns.size):
            at = int(batch.offset[i])
            data = batch.data[at : at + int(batch.length[i])].tobytes()
            rows.append((int(batch.time_ns[i]) - START, int(batch.can_id[i]), int(batch.bus[i]), data))
    return rows


def simple(data_link: str, *, cycles: int = 100) -> Builder:
    """Time u64 in ms and a u16 "v": records of 10 bytes."""
    b = Builder()
    b.header("dg")
    b.data_group("dg", "cg", data_link)
    b.group("cg", "t", 10, cycles=cycles)
    b.channel("t", 0, 64, kind=2, rule=b.rule("ms", 1, [0.0, 0.001]), after="v")
    b.channel("v", 8, 16)
    return b


RECORDS = b"".join(struct.pack("<QH", k * 10, k) for k in range(100))
TIMES = [k * 10_000_000 for k in range(100)]


@pytest.mark.parametrize(("method", "columns"), [(0, 0), (1, 10), (1, 7), (2, 0), (3, 10), (4, 0), (5, 10)])
def test_compressed_blocks(tmp_path: Path, method: int, columns: int) -> None:
    b = simple("hl")
    b.add("hl", "HL", ["dl"], b"\0" * 8)
    parts = [RECORDS[:333], RECORDS[333:805], RECORDS[805:]]
    b.data_list("dl", ["dz0", "dz1"], after="dl2")
    b.data_list("dl2", ["dz2"])
    for k, part in enumerate(parts):
        b.packed(f"dz{k}", part, method=method, columns=columns)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert values_of(reader)["v"] == (TIMES, list(range(100)))
    assert log.status == "complete"


def test_a_damaged_block_costs_its_records_only(tmp_path: Path) -> None:
    b = simple("dl")
    b.data_list("dl", ["dz0", "dz1", "dz2"])
    for k in range(3):
        b.packed(f"dz{k}", RECORDS[(0, 333, 666)[k] : (333, 666, 1000)[k]])
    whole = bytearray(b.build())
    second = whole.index(b"##DZ", whole.index(b"##DZ") + 4)
    whole[second + 60 : second + 90] = b"\xff" * 30
    reader, log = opened(tmp_path / "a.mf4", bytes(whole))
    assert values_of(reader)["v"][1] == [*range(33), *range(67, 100)]
    assert log.status == "malformed"
    assert log.rejected["damaged data block in the MF4 file"] == 1


def test_a_claimed_size_that_cannot_be_is_refused(tmp_path: Path) -> None:
    b = simple("dz")
    data = struct.pack("<2sBxIQQ", b"DT", 0, 0, 1 << 45, 40) + zlib.compress(RECORDS)[:40]
    b.add("dz", "DZ", [], data)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert values_of(reader) == {}
    assert log.status == "malformed"


def test_a_file_cut_in_its_data(tmp_path: Path) -> None:
    b = simple("dt")
    b.add("dt", "DT", [], RECORDS)
    whole = b.build()
    reader, log = opened(tmp_path / "a.mf4", whole[: len(whole) - 505])
    assert values_of(reader)["v"][1] == list(range(49))
    assert log.status == "truncated"
    assert any("49 of the 100" in note for note in log.notes)


@pytest.mark.parametrize("length", [0, 24, 24 + 1000])
def test_an_unfinished_file_is_read_to_its_end(tmp_path: Path, length: int) -> None:
    b = simple("dt", cycles=0)
    b.mark, b.flags = b"UnFinMF ", 0x05
    b.add("dt", "DT", [], RECORDS)
    whole = bytearray(b.build())
    at = whole.index(b"##DT")
    whole[at + 8 : at + 16] = struct.pack("<Q", length)
    reader, log = opened(tmp_path / "a.mf4", bytes(whole[: at + 24 + 955]))
    assert values_of(reader)["v"][1] == list(range(95))
    assert log.status == "complete"
    assert any("did not finish" in note for note in log.notes)


def test_an_unfinished_list_finds_the_blocks_behind_it(tmp_path: Path) -> None:
    b = simple("dl", cycles=0)
    b.mark, b.flags = b"UnFinMF ", 0x11
    b.data_list("dl", ["dt0", "", ""])
    b.add("dt0", "DT", [], RECORDS[:400])
    b.add("dt1", "DT", [], RECORDS[400:800])
    b.add("dt2", "DT", [], RECORDS[800:])
    reader, _ = opened(tmp_path / "a.mf4", b.build())
    assert values_of(reader)["v"][1] == list(range(100))


def unsorted(id_size: int) -> Builder:
    """Two groups in turn: "v" u16 every record, "w" f32 every third; ids of the size given."""
    first, second = 3, (1 << (8 * id_size)) - 2 if id_size < 8 else 1 << 40
    parts = []
    for k in range(100):
        parts.append(first.to_bytes(id_size, "little") + struct.pack("<QH", k * 10, k))
        if k % 3 == 0:
            parts.append(second.to_bytes(id_size, "little") + struct.pack("<Qf", k * 10 + 5, k / 2))
    b = Builder()
    b.header("dg")
    b.data_group("dg", "cg1", "dt", id_size=id_size)
    b.group("cg1", "t1", 10, cycles=100, ident=first, after="cg2")
    b.group("cg2", "t2", 12, cycles=34, ident=second)
    rule = b.rule("ms", 1, [0.0, 0.001])
    b.channel("t", 0, 64, kind=2, rule=rule, after="v", key="t1")
    b.channel("v", 8, 16)
    b.channel("t", 0, 64, kind=2, rule=rule, after="w", key="t2")
    b.channel("w", 8, 32, data_type=4)
    b.add("dt", "DT", [], b"".join(parts))
    return b


@pytest.mark.parametrize("id_size", [1, 2, 4, 8])
def test_unsorted_records(tmp_path: Path, id_size: int) -> None:
    reader, log = opened(tmp_path / "a.mf4", unsorted(id_size).build())
    got = values_of(reader)
    assert got["v"] == (TIMES, list(range(100)))
    assert got["w"] == ([t * 1_000_000 for t in range(5, 1000, 30)], [k / 2 for k in range(0, 100, 3)])
    assert log.status == "complete"
    only, _ = opened(tmp_path / "a.mf4", unsorted(id_size).build())
    assert list(values_of(only, "w")) == ["w"]


@pytest.mark.parametrize("id_size", [1, 2])
def test_damaged_records_cost_themselves_only(tmp_path: Path, id_size: int) -> None:
    b = unsorted(id_size)
    kind, links, data = b.blocks["dt"]
    # by threes "v" and one "w"; this is the id of "v" number 24, and then 100 bytes more
    at = 8 * (3 * (10 + id_size) + 12 + id_size)
    b.blocks["dt"] = (kind, links, data[:at] + b"\x77" * 100 + data[at + 100 :])
    reader, log = opened(tmp_path / "a.mf4", b.build())
    got = values_of(reader)["v"]
    lost = 100 - len(got[1])
    assert 6 <= lost <= 8
    assert got[1] == [k for k in range(100) if not 24 <= k < 24 + lost]
    assert got[0] == [int(k) * 10_000_000 for k in got[1]]
    assert log.status == "malformed"
    assert log.rejected == {"damaged place in the MF4 file's records": 1}
    # the record before is "v" number 23; behind it comes "v" or, between, "w"
    assert log.lost_spans_ns[0][0] == START + 230_000_000
    assert START + 290_000_000 < log.lost_spans_ns[0][1] <= START + 330_000_000


def test_a_pause_is_no_damage(tmp_path: Path) -> None:
    b = unsorted(1)
    parts = [bytes([3]) + struct.pack("<QH", k * 10 + (k >= 50) * 9_000_000, k) for k in range(100)]
    b.add("dt", "DT", [], b"".join(parts))
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert values_of(reader)["v"][1] == list(range(100))
    assert log.status == "complete"


def test_damage_ends_the_walk_where_no_stamps_can_tell(tmp_path: Path) -> None:
    b = unsorted(1)
    b.blocks["ms"] = ("CC", b.blocks["ms"][1], struct.pack("<BBHHHdddd", 1, 0, 0, 0, 2, 0.0, 0.0, 0.0, 1e-12))
    kind, links, data = b.blocks["dt"]
    b.blocks["dt"] = (kind, links, data[:368] + b"\x77" + data[369:])
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert values_of(reader)["v"][1] == list(range(24))
    assert log.status == "malformed"


def test_bits_and_byte_orders(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    raw = rng.integers(0, 256, (50, 24), dtype=np.uint8)
    raw[:, :8] = np.arange(50, dtype="<u8").view(np.uint8).reshape(50, 8)
    cases = [
        (8, 0, 12, 0),
        (9, 3, 10, 2),
        (10, 5, 64, 0),
        (8, 7, 58, 2),
        (12, 0, 24, 1),
        (12, 4, 20, 3),
        (20, 1, 1, 0),
    ]
    b = Builder()
    b.header("dg")
    b.data_group("dg", "cg", "dt")
    b.group("cg", "t", 24, cycles=50)
    b.channel("t", 0, 64, kind=2, rule=b.rule("s", 1, [0.0, 1.0]), after="c0")
    for k, (byte, bit, bits, data_type) in enumerate(cases):
        after = f"c{k + 1}" if k + 1 < len(cases) else ""
        b.channel(f"c{k}", byte, bits, bit=bit, data_type=data_type, after=after)
    b.add("dt", "DT", [], raw.tobytes())
    reader, _ = opened(tmp_path / "a.mf4", b.build())
    got = values_of(reader)
    for k, (byte, bit, bits, data_type) in enumerate(cases):
        size = (bit + bits + 7) // 8
        order = "big" if data_type in (1, 3) else "little"
        expected = []
        for row in raw:
            value = (int.from_bytes(row[byte : byte + size].tobytes(), order) >> bit) & ((1 << bits) - 1)
            if data_type in (2, 3) and value >> (bits - 1):
                value -= 1 << bits
            expected.append(float(value))
        assert got[f"c{k}"][1] == expected


def test_a_channel_outside_its_record_is_left_out(tmp_path: Path) -> None:
    b = simple("dt")
    b.channel("v", 8, 16, after="far")
    b.channel("far", 9, 16, after="odd")
    b.channel("odd", 0, 48, data_type=4)
    b.add("dt", "DT", [], RECORDS)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert [c.name for c in reader.channels] == ["v"]
    assert any("'far'" in note for note in log.notes)
    assert any("'odd'" in note for note in log.notes)


def test_an_array_is_left_out_and_said(tmp_path: Path) -> None:
    b = simple("dt")
    b.channel("v", 8, 16, parts="ca", after="w")
    b.channel("w", 8, 8)
    b.add("ca", "CA", [], struct.pack("<BBHIiIQ", 0, 0, 1, 0, 2, 0, 1))
    b.add("dt", "DT", [], RECORDS)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert [c.name for c in reader.channels] == ["w"]
    assert "channel 'v' was left out: an array or a structure" in log.notes


def test_a_database_inside_the_file_is_named(tmp_path: Path) -> None:
    b = simple("dt")
    b.add("dt", "DT", [], RECORDS)
    b.add("at", "AT", ["", b.text("net.dbc"), "", ""], b"\0" * 40)
    kind, links, data = b.blocks["HD"]
    b.blocks["HD"] = (kind, [*links[:3], "at", *links[4:]], data)
    _, log = opened(tmp_path / "a.mf4", b.build())
    assert any("net.dbc" in note and "--dbc" in note for note in log.notes)


def test_virtual_time_and_values(tmp_path: Path) -> None:
    b = Builder()
    b.header("dg")
    b.data_group("dg", "cg", "dt")
    b.group("cg", "t", 1, cycles=4)
    b.channel("t", 0, 0, kind=3, rule=b.rule("step", 1, [0.5, 0.02]), after="x")
    b.channel("x", 0, 8, after="n")
    b.channel("n", 0, 0, kind=6)
    b.add("dt", "DT", [], bytes([9, 8, 7, 6]))
    reader, _ = opened(tmp_path / "a.mf4", b.build())
    got = values_of(reader)
    assert got["x"] == ([500_000_000, 520_000_000, 540_000_000, 560_000_000], [9, 8, 7, 6])
    assert got["n"][1] == [0, 1, 2, 3]


def test_lists_that_run_in_a_circle_end(tmp_path: Path) -> None:
    b = simple("dl")
    b.channel("v", 8, 16, after="t")
    b.data_list("dl", ["dt"], after="dl")
    b.add("dt", "DT", [], RECORDS)
    b.blocks["dg"] = ("DG", ["dg", "cg", "dl", ""], b"\0" * 8)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert values_of(reader)["v"][1] == list(range(100))
    assert log.status == "malformed"
    assert any("circle" in note for note in log.notes)


def bus_builder(kind: str, *, flags: int = 0, wide: int = 8) -> Builder:
    """Ten CAN frames of growing length. kind: "fixed", "group" (VLSD group of an unsorted file) or "blocks" (SD).

    wide: bytes of a payload's place in its record.
    """
    payloads = [bytes(range(k, k + k)) for k in range(10)]
    stream, parts = b"", []
    for k, payload in enumerate(payloads):
        head = struct.pack("<QIBB", k * 10, (0x18FEF100 + k) | (0x80000000 if k % 2 else 0), len(payload), 2)
        if kind == "fixed":
            parts.append(head + payload.ljust(64, b"\xee"))
            continue
        place = 0xDEAD if flags & 0x40 else len(stream)
        record = head + place.to_bytes(wide, "little")
        stream += struct.pack("<I", len(payload)) + payload
        if kind == "group":
            variable = b"\2" + struct.pack("<I", len(payload)) + payload
            # some payloads come before their record, some behind it
            parts += [b"\1" + record, variable] if k % 2 else [variable, b"\1" + record]
            continue
        parts.append(record)
    b = Builder(mark=b"UnFinMF " if flags else b"MDF     ", flags=flags)
    b.header("dg")
    size = 14 + (64 if kind == "fixed" else wide)
    b.data_group("dg", "cg", "dt", id_size=1 if kind == "group" else 0)
    b.group("cg", "t", size, cycles=10, ident=1, flags=2, after="vlsd" if kind == "group" else "")
    if kind == "group":
        b.group("vlsd", "", len(stream), cycles=10, ident=2, flags=1)
    b.channel("t", 0, 64, kind=2, rule=b.rule("ms", 1, [0.0, 0.001]), after="frame")
    b.channel("CAN_DataFrame", 8, (size - 8) * 8, data_type=10, parts="id", key="frame", flags=0x400)
    b.channel("CAN_DataFrame.ID", 8, 29, key="id", after="ide")
    b.channel("CAN_DataFrame.IDE", 11, 1, bit=7, key="ide", after="len")
    b.channel("CAN_DataFrame.DataLength", 12, 8, key="len", after="bus")
    b.channel("CAN_DataFrame.BusChannel", 13, 8, key="bus", after="data")
    if kind == "fixed":
        b.channel("CAN_DataFrame.DataBytes", 14, 512, data_type=10, key="data")
    else:
        link = "vlsd" if kind == "group" else "sd"
        b.channel("CAN_DataFrame.DataBytes", 14, 8 * wide, kind=1, data_type=10, key="data", data=link)
    b.add("dt", "DT", [], b"".join(parts))
    if kind == "blocks":
        b.add("sd", "SD", [], stream)
    return b


FRAMES: list[Row] = [
    (k * 10_000_000, (0x18FEF100 + k) | EXTENDED, 2, bytes(range(k, k + k))) for k in range(10)
]  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "wide"), [("fixed", 8), ("group", 8), ("group", 4), ("blocks", 8), ("blocks", 4)]
)
def test_can_frames(tmp_path: Path, kind: str, wide: int) -> None:
    reader, log = opened(tmp_path / "a.mf4", bus_builder(kind, wide=wide).build())
    assert frames_of(reader) == FRAMES
    assert log.messages == 10
    assert log.status == "complete"
    assert not log.rejected
    assert all(channel.family == "can" for channel in reader.channels)


def test_payloads_by_order_where_the_recorder_wrote_no_places(tmp_path: Path) -> None:
    reader, log = opened(tmp_path / "a.mf4", bus_builder("group", flags=0x41).build())
    assert frames_of(reader) == FRAMES
    assert not log.rejected


@pytest.mark.parametrize("kind", ["group", "blocks"])
def test_a_payload_that_is_not_there_rejects_its_frame(tmp_path: Path, kind: str) -> None:
    b = bus_builder(kind)
    block, links, data = b.blocks["dt"]
    # the place of the fifth frame's payload
    at = data.index(struct.pack("<QI", 50, 0x98FEF105)) + 14
    b.blocks["dt"] = (block, links, data[:at] + struct.pack("<Q", 1 << 63) + data[at + 8 :])
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert frames_of(reader) == FRAMES[:5] + FRAMES[6:]
    assert log.rejected == {"CAN frame without its payload": 1}


def test_remote_and_error_frames_are_counted(tmp_path: Path) -> None:
    b = unsorted(1)
    b.channel("v", 8, 16, after="err")
    b.channel("CAN_ErrorFrame", 8, 16, data_type=10, key="err", parts="code")
    b.channel("CAN_ErrorFrame.ErrorType", 8, 8, key="code")
    b.channel("w", 8, 32, data_type=4, after="frame")
    b.channel("CAN_DataFrame", 8, 32, data_type=10, key="frame", parts="id")
    b.channel("CAN_DataFrame.ID", 8, 11, key="id", after="data")
    b.channel("CAN_DataFrame.DataBytes", 10, 16, data_type=10, key="data")
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert len(frames_of(reader)) == 34
    assert log.rejected == {"CAN error frame": 100}
    # a file may hold both: measured channels stay
    assert [c.name for c in reader.channels] == ["v", "w"]


def test_local_start_time_is_said(tmp_path: Path) -> None:
    b = simple("dt")
    b.add("dt", "DT", [], RECORDS)
    b.header("dg", time_flags=1)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert reader.absolute
    assert any("local time" in note for note in log.notes)
    b.header("dg", start=0)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert not reader.absolute


def test_conversions_by_hand() -> None:
    x = np.array([-1.0, 0.0, 99.0, 99.5, 100.0, 250.0, 251.0])
    ranges = Conversion(6, np.array([0.0, 99.0, 1.0, 100.0, 250.0, 2.0, 3.0]))
    assert convert(ranges, x, whole_numbers=True).tolist() == [3, 1, 1, 3, 2, 2, 3]
    assert convert(ranges, x).tolist() == [3, 1, 3, 3, 2, 3, 3]
    table = Conversion(5, np.array([10.0, 1.0, 20.0, 2.0]))
    assert convert(table, np.array([0.0, 14.0, 15.0, 16.0, 99.0, np.nan]))[:5].tolist() == [1, 1, 1, 2, 2]
    linear = Conversion(1, np.array([-5.0, 0.5]))
    named = Conversion(7, np.array([255.0, 254.0]), ("not available", None, linear))
    got = convert(named, np.array([10.0, 254.0, 255.0]))
    assert got[:2].tolist() == [0.0, 122.0]
    assert np.isnan(got[2])


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2*X+1", 7.0),
        ("-X^2", -9.0),
        ("2^X^0.5*0+X**2", 9.0),
        ("(X1-1)/4", 0.5),
        ("sqrt(X+6)*pi", 3 * np.pi),
        ("1e-3*X", 0.003),
    ],
)
def test_formulas(text: str, value: float) -> None:
    assert evaluate(text, np.array([3.0]))[0] == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    "text", ["", "X+", "__import__('os')", "X.real", "(X", "X)", "f(X)", "(" * 500 + "X", "X" * 3000]
)
def test_formulas_that_are_no_formulas(text: str) -> None:
    with pytest.raises(FormulaError):
        evaluate(text, np.array([3.0]))


def test_other_versions_and_stumps(tmp_path: Path) -> None:
    b = simple("")
    b.version = 330
    path = tmp_path / "a.mdf"
    with pytest.raises(LogError, match="convert the file to MDF 4"):
        opened(path, b.build())
    for size in (8, 63, 64, 80, 130):
        with pytest.raises(LogError) as error:
            opened(path, simple("").build()[:size])
        assert "\n" not in str(error.value)
    # the descriptions of the data stand behind the cut
    far = simple("")
    with pytest.raises(LogError, match="breaks off at byte 200, before the end of a data group at byte 192"):
        opened(path, far.build()[:200])
    empty = Builder()
    empty.header("")
    with pytest.raises(LogError, match="no data groups"):
        opened(path, empty.build())


@pytest.mark.parametrize("kind", ["plain", "unsorted", "group", "blocks"])
def test_random_damage_never_hangs_or_crashes(tmp_path: Path, kind: str) -> None:
    if kind == "plain":
        b = simple("dl")
        b.data_list("dl", ["dz0", "dz1"])
        b.packed("dz0", RECORDS[:500], method=1, columns=10)
        b.packed("dz1", RECORDS[500:])
    else:
        b = unsorted(1) if kind == "unsorted" else bus_builder(kind)
    whole = b.build()
    rng = np.random.default_rng(7)
    path = tmp_path / "a.mf4"
    for _ in range(150):
        broken = bytearray(whole)
        for at in rng.integers(64, len(whole), 6):
            broken[at] = rng.integers(256)
        path.write_bytes(bytes(broken[: rng.integers(64, len(whole) + 1)]))
        log = ImportLog()
        # a LogError or what is whole; anything else fails the test
        with contextlib.suppress(LogError):
            reader = Mf4Importer().open(path, ReadOptions(), log)
            rows = sum(
                chunk.time_ns.size for chunk in reader.read(frozenset(c.name for c in reader.channels))
            )
            assert rows < 1_000_000


def test_progress_is_told(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    b = simple("dt")
    b.add("dt", "DT", [], RECORDS)
    path = tmp_path / "a.mf4"
    path.write_bytes(b.build())
    reader = open_mf4(path, ReadOptions(progress=lambda done, total: told.append((done, total))), ImportLog())
    list(reader.read(frozenset({"v"})))
    assert told[-1] == (path.stat().st_size, path.stat().st_size)
    assert no_progress(*told[0]) is None
