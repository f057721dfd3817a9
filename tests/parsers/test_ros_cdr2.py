"""Plain CDR of the second version (OMG DDS-XTYPES 1.3): 8-byte numbers at multiples of 4, and lists that say their size."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer
from ros_messages import run

from parsers.importer import ImportLog, ReadOptions
from parsers.mcap_log import McapImporter
from parsers.ros.decoder import make_decoder

TEXT = """std_msgs/Header header
uint8 a
float64 x
Inner[] list
float64[] numbers
string[] names
Inner[2] pair
builtin_interfaces/Time[] times
int64 last
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: pkg/Inner
uint8 k
float64 v
"""
WANTED = ["x", "list[1].k", "list[1].v", "numbers[1]", "pair[1].v", "times[0]", "last"]


class Cdr2:
    """Writes one message (to be read by a decoder of `TEXT`)."""

    def __init__(self, kind: int) -> None:
        self.order = "<" if kind & 1 else ">"
        self.head = bytes([0, kind, 0, 0])
        self.body = bytearray()

    def put(self, code: str, value: float) -> None:
        self.body += bytes(-len(self.body) % min(4, struct.calcsize(code)))
        self.body += struct.pack(self.order + code, value)

    def text(self, value: str) -> None:
        self.put("I", len(value) + 1)
        self.body += value.encode() + b"\0"

    def inner(self, k: int, v: float) -> None:
        self.put("B", k)
        self.put("d", v)

    def bytes(self) -> bytes:
        return self.head + bytes(self.body)


def message(kind: int, k: int) -> bytes:
    out = Cdr2(kind)
    out.put("i", 1_700_000_000 + k)
    out.put("I", 5)
    out.text("x" * (k % 5))
    out.put("B", 7)
    out.put("d", k / 8)
    for count in (2, -2):  # a list of messages, then one of fixed length: both behind their size
        if count < 0:
            out.put("I", 2)
            out.put("d", 1.0)
            out.put("d", k + 0.25)
            out.put("I", 99)
            out.put("I", 2)
            out.text("ab")
            out.text("c")
        out.put("I", 99)
        if count > 0:
            out.put("I", count)
        out.inner(1, 2.0)
        out.inner(k, k + 0.5)
    out.put("I", 99)
    out.put("I", 1)
    out.put("i", k)
    out.put("I", 500_000_000)
    out.put("q", -k)
    return out.bytes()


@pytest.mark.parametrize("kind", [6, 7])
def test_every_value_is_where_it_belongs(kind: int) -> None:
    decoder = make_decoder("pkg/T", TEXT, "cdr")
    decoded = run(decoder, [message(kind, k) for k in range(40)], WANTED)
    assert decoded.bad == 0
    k = np.arange(40)
    for path, expected in zip(WANTED, (k / 8, k, k + 0.5, k + 0.25, k + 0.5, k + 0.5, -k), strict=True):
        np.testing.assert_array_equal(decoded.columns[path], expected, err_msg=path)
    assert decoded.stamp_ns is not None
    np.testing.assert_array_equal(decoded.stamp_ns, (1_700_000_000 + k) * 10**9 + 5)


def test_both_versions_may_stand_beside_each_other() -> None:
    decoder = make_decoder("pkg/P", "uint8 a\nfloat64 x\nuint32 pad", "cdr")
    first = bytes([0, 1, 0, 0]) + struct.pack("<B7xdI", 1, 2.5, 3)
    second = bytes([0, 7, 0, 0]) + struct.pack("<B3x", 1) + struct.pack("<d", 3.5) + struct.pack("<II", 3, 0)
    decoded = run(decoder, [first, second, first, second[:-4], second[:-4]], ["x"])
    assert decoded.bad == 1
    np.testing.assert_array_equal(decoded.columns["x"], [2.5, np.nan, 2.5, 3.5, 3.5])


def test_what_is_cut_is_bad() -> None:
    decoder = make_decoder("pkg/T", TEXT, "cdr")
    whole = message(7, 3)
    cut = [whole[:n] for n in range(len(whole) - 3)]
    assert run(decoder, cut, WANTED).bad == len(cut)


@pytest.mark.parametrize(("kind", "name"), [(3, "PL_CDR"), (9, "DELIMITED_CDR2"), (11, "PL_CDR2")])
def test_an_encoding_that_is_not_read_is_named(kind: int, name: str, tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("pkg/msg/T", "ros2msg", TEXT.encode())
        channel = writer.register_channel("/t", "cdr", schema)
        for k in range(50):
            payload = bytes([0, kind]) + message(7, k)[2:]
            writer.add_message(channel, 1_700_000_000_000_000_000 + k, payload, k)
        writer.finish()  # type: ignore[no-untyped-call]
    log = ImportLog()
    reader = McapImporter().open(path, ReadOptions(), log)
    assert len(list(reader.read(frozenset(["/t.x"])))) == 1
    (reason,) = log.rejected
    assert name in reason
    assert "not read" in reason
    assert log.rejected[reason] == 50
    assert not any("header stamps" in note for note in log.notes)
