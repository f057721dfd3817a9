"""Runs of protobuf messages of the same layout equal the library, damage among them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorProto
from protobuf_files import F, build, check_same, decode


def flat_file() -> FileDescriptorProto:
    """Numbers of a fixed size only, with a field number that needs two bytes, and a text and a map behind them."""
    file = FileDescriptorProto(name="flat.proto", package="t", syntax="proto3")
    m = file.message_type.add(name="Flat")
    for number in range(1, 6):
        m.field.add(name=f"d{number}", number=number, type=F.TYPE_DOUBLE, label=1)
    m.field.add(name="f", number=6, type=F.TYPE_FLOAT, label=1)
    m.field.add(name="far", number=200, type=F.TYPE_DOUBLE, label=1)
    m.field.add(name="n", number=201, type=F.TYPE_INT32, label=1)
    m.field.add(name="text", number=300, type=F.TYPE_STRING, label=1)
    entry = m.nested_type.add(name="TableEntry")
    entry.options.map_entry = True
    entry.field.add(name="key", number=1, type=F.TYPE_STRING, label=1)
    entry.field.add(name="value", number=2, type=F.TYPE_DOUBLE, label=1)
    m.field.add(name="table", number=301, type=F.TYPE_MESSAGE, type_name=".t.Flat.TableEntry", label=3)
    return file


@pytest.mark.parametrize("zeros", [0.0, 0.02, 0.4])
@pytest.mark.parametrize("rest", [False, True])
def test_runs_of_the_same_layout_equal_the_library(zeros: float, rest: bool) -> None:
    """Fields that are zero are not in the message: its layout changes now and then, or all the time."""
    decoder, peer = build(flat_file(), "t.Flat")
    rng = np.random.default_rng(4)
    messages = []
    for i in range(600):
        values = np.where(rng.random(7) < zeros, 0.0, rng.normal(size=7)).tolist()
        m = peer(
            d1=values[0], d2=values[1], d3=values[2], d4=values[3], d5=values[4], f=values[5], far=values[6]
        )
        if rest and i % 7 == 0:
            m.n, m.text, m.table["a"] = -i, "x" * (i % 40), 1.0
        messages.append(m)
    payloads = [m.SerializeToString() for m in messages]
    for wanted in (None, ["far", "d2"], ["n"]):
        decoded = decode(decoder, payloads, wanted)
        assert decoded.bad == 0
        check_same(decoded, messages)
    assert not any(info.path.startswith("table") for info in decoder.fields)


def test_damage_inside_a_run_of_the_same_layout() -> None:
    """Same size, but a tag that is not there; a message that is cut; one that lies outside of the data."""
    decoder, peer = build(flat_file(), "t.Flat")
    good = peer(d1=1.0, d2=2.0, d5=3.0).SerializeToString()
    other = bytearray(good)
    other[9] = 0x1C  # the end of a group that never began
    swapped = good[9:18] + good[:9] + good[18:]
    payloads = [good, good, bytes(other), good, good[:-1], good, swapped, good + good, good]
    decoded = decode(decoder, payloads)
    assert decoded.bad == 2
    expected = [1.0, 1.0, math.nan, 1.0, math.nan, 1.0, 1.0, 1.0, 1.0]
    np.testing.assert_array_equal(decoded.columns["d1"], expected)
    np.testing.assert_array_equal(decoded.columns["d3"], [0.0 * x for x in expected])
    offset, length = np.array([0, 0, len(good), -5, 0]), np.array([len(good)] * 5)
    data = np.frombuffer(good, dtype=np.uint8)
    np.testing.assert_array_equal(
        decoder.decode(data, offset, length, ["d2"]).columns["d2"], [2.0, 2.0, math.nan, math.nan, 2.0]
    )
