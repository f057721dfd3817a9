"""MF4 files for the tests: built block by block, then read and compared."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field
from pathlib import Path

import lz4.frame
import numpy as np
import zstandard
from frame_rows import Frame, rows_of

from parsers.importer import ImportLog, ReadOptions
from parsers.mf4.reader import Mf4Reader, open_mf4

START = 1_700_000_000_000_000_000


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


def frames_of(reader: Mf4Reader) -> list[Frame]:
    assert reader.frames is not None
    rows = rows_of(reader.frames.frames(counting=False))
    return [(t - START, ident, bus, payload) for t, ident, bus, payload in rows]


TIMES = [k * 10_000_000 for k in range(100)]


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


def long_bus(
    count: int, *, double: bool = False, order: str = "before", flags: int = 0x05, first_id: int = 1
) -> tuple[Builder, list[Frame], list[int]]:
    """CAN frames a millisecond apart in an unfinished, unsorted file as recorders leave it: file, frames, and where each ends.

    double: stamps are floats of seconds. order: the payload stands "before" its record, "behind" it, or now here now there
    ("mixed"). first_id: the record id of the frames; the next one is that of the payloads. A frame's first bytes are its
    number, so that a wrong payload shows.
    """
    parts, frames, ends, stream, size = [], [], [], 0, 0
    for k in range(count):
        payload = struct.pack("<I", k + 1) + bytes([7]) * (k % 5)
        stamp = struct.pack("<d", k / 1000) if double else struct.pack("<Q", k * 1000)
        place = 0xDEAD if flags & 0x40 else stream
        record = bytes([first_id]) + stamp + struct.pack("<IBBQ", 0x100 + k % 3, len(payload), 2, place)
        variable = bytes([first_id + 1]) + struct.pack("<I", len(payload)) + payload
        before = order == "before" or (order == "mixed" and k % 2)
        parts.append(variable + record if before else record + variable)
        stream += 4 + len(payload)
        size += len(parts[-1])
        ends.append(size)
        frames.append((k * 1_000_000, 0x100 + k % 3, 2, payload))
    b = Builder(mark=b"UnFinMF ", flags=flags)
    b.header("dg")
    b.data_group("dg", "cg", "dt", id_size=1)
    b.group("cg", "t", 22, ident=first_id, flags=2, after="vlsd")
    b.group("vlsd", "", 0, ident=first_id + 1, flags=1)
    rule = "" if double else b.rule("us", 1, [0.0, 1e-6])
    b.channel("t", 0, 64, kind=2, data_type=4 if double else 0, rule=rule, after="frame")
    b.channel("CAN_DataFrame", 8, 112, data_type=10, parts="id", key="frame", flags=0x400)
    b.channel("CAN_DataFrame.ID", 8, 29, key="id", after="len")
    b.channel("CAN_DataFrame.DataLength", 12, 8, key="len", after="bus")
    b.channel("CAN_DataFrame.BusChannel", 13, 8, key="bus", after="data")
    b.channel("CAN_DataFrame.DataBytes", 14, 64, kind=1, data_type=10, key="data", data="vlsd")
    b.add("dt", "DT", [], b"".join(parts))
    return b, frames, ends
