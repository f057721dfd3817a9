"""Protobuf payloads: every value equals what the protobuf library reads, and damaged ones never crash."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet
from google.protobuf.message import DecodeError
from google.protobuf.timestamp_pb2 import DESCRIPTOR as TIMESTAMP_FILE
from hypothesis import given, settings
from hypothesis import strategies as st

from parsers.errors import LogError
from parsers.protobuf_decode import ProtobufDecoder, make_protobuf_decoder
from parsers.ros.contract import Decoded

F = FieldDescriptorProto
SCALARS = {
    "double": F.TYPE_DOUBLE,
    "float": F.TYPE_FLOAT,
    "int64": F.TYPE_INT64,
    "uint64": F.TYPE_UINT64,
    "int32": F.TYPE_INT32,
    "fixed64": F.TYPE_FIXED64,
    "fixed32": F.TYPE_FIXED32,
    "bool": F.TYPE_BOOL,
    "uint32": F.TYPE_UINT32,
    "sfixed32": F.TYPE_SFIXED32,
    "sfixed64": F.TYPE_SFIXED64,
    "sint32": F.TYPE_SINT32,
    "sint64": F.TYPE_SINT64,
}


def scalars_file() -> FileDescriptorProto:
    """A message with every scalar, packed and unpacked lists, nesting, an enum, a oneof and a text."""
    file = FileDescriptorProto(name="scalars.proto", package="t", syntax="proto3")
    file.dependency.append("google/protobuf/timestamp.proto")
    inner = file.message_type.add(name="Inner")
    inner.field.add(name="x", number=1, type=F.TYPE_DOUBLE, label=1)
    inner.field.add(name="y", number=2, type=F.TYPE_SINT32, label=1)
    inner.field.add(name="many", number=3, type=F.TYPE_FLOAT, label=3)
    kind = file.enum_type.add(name="Kind")
    for name, number in (("ZERO", 0), ("BELOW", -3), ("ABOVE", 70000)):
        kind.value.add(name=name, number=number)
    root = file.message_type.add(name="Root")
    for number, (name, code) in enumerate(SCALARS.items(), start=1):
        root.field.add(name=f"f_{name}", number=number, type=code, label=1)
    for number, (name, code) in enumerate(SCALARS.items(), start=101):
        packed = root.field.add(name=f"p_{name}", number=number, type=code, label=3)
        unpacked = root.field.add(name=f"u_{name}", number=number + 100, type=code, label=3)
        packed.options.packed, unpacked.options.packed = True, False
    root.field.add(
        name="timestamp", number=20, type=F.TYPE_MESSAGE, type_name=".google.protobuf.Timestamp", label=1
    )
    root.field.add(name="kind", number=21, type=F.TYPE_ENUM, type_name=".t.Kind", label=1)
    root.field.add(name="inner", number=22, type=F.TYPE_MESSAGE, type_name=".t.Inner", label=1)
    root.field.add(name="items", number=23, type=F.TYPE_MESSAGE, type_name=".t.Inner", label=3)
    root.field.add(name="note", number=24, type=F.TYPE_STRING, label=1)
    root.oneof_decl.add(name="choice")
    root.field.add(name="one_a", number=30, type=F.TYPE_DOUBLE, label=1, oneof_index=0)
    root.field.add(name="one_b", number=31, type=F.TYPE_MESSAGE, type_name=".t.Inner", label=1, oneof_index=0)
    root.field.add(name="one_text", number=32, type=F.TYPE_STRING, label=1, oneof_index=0)
    root.oneof_decl.add(name="_maybe")
    root.field.add(name="maybe", number=33, type=F.TYPE_INT32, label=1, oneof_index=1, proto3_optional=True)
    root.field.add(name="again", number=34, type=F.TYPE_MESSAGE, type_name=".t.Root", label=1)
    return file


def timestamp_file() -> FileDescriptorProto:
    file = FileDescriptorProto()
    TIMESTAMP_FILE.CopyToProto(file)
    return file


def build(file: FileDescriptorProto, type_name: str) -> tuple[ProtobufDecoder, Any]:
    """Our decoder, and the class that the protobuf library makes."""
    files = FileDescriptorSet(file=[timestamp_file(), file])
    pool = descriptor_pool.DescriptorPool()
    for each in files.file:
        pool.Add(each)
    peer = message_factory.GetMessageClass(pool.FindMessageTypeByName(type_name))
    return make_protobuf_decoder(type_name, files.SerializeToString()), peer


@pytest.fixture(scope="module")
def root() -> tuple[ProtobufDecoder, Any]:
    return build(scalars_file(), "t.Root")


def decode(
    decoder: ProtobufDecoder, payloads: Sequence[bytes], wanted: Sequence[str] | None = None
) -> Decoded:
    if wanted is None:
        wanted = [info.path for info in decoder.fields if info.kind == "number"]
    length = np.array([len(p) for p in payloads], dtype=np.int64)
    offset = np.cumsum(length) - length
    return decoder.decode(np.frombuffer(b"".join(payloads), dtype=np.uint8), offset, length, wanted)


def peer_value(message: Any, path: str) -> float:
    """What the protobuf library says for a path of ours."""
    value = message
    for part in path.split("."):
        name, _, index = part.partition("[")
        field = value.DESCRIPTOR.fields_by_name[name]
        if index:
            items = getattr(value, name)
            k = int(index.rstrip("]"))
            if k >= len(items):
                return math.nan
            value = items[k]
        else:
            if field.has_presence and not value.HasField(name):
                return math.nan
            value = getattr(value, name)
    return float(value)


def check_same(decoded: Decoded, messages: Sequence[Any]) -> None:
    for path, column in decoded.columns.items():
        expected = np.array([peer_value(m, path) for m in messages])
        np.testing.assert_array_equal(column, expected, err_msg=path)


EXTREMES = {
    "double": [0.1, -1e300, math.inf],
    "float": [0.5, -3.25, 1e30],
    "int64": [-(2**63), 2**53 - 1, -1],
    "uint64": [2**63, 1, 2**53 - 1],
    "int32": [-(2**31), 2**31 - 1, -1],
    "fixed64": [2**63, 5, 0],
    "fixed32": [2**32 - 1, 7, 0],
    "bool": [True, False, True],
    "uint32": [2**32 - 1, 127, 128],
    "sfixed32": [-(2**31), 2**31 - 1, -1],
    "sfixed64": [-(2**53), 2**53 - 1, -1],
    "sint32": [-(2**31), 2**31 - 1, -1],
    "sint64": [-(2**53), 2**53 - 1, -1],
}


def full_messages(peer: Any) -> list[Any]:
    messages = []
    for i in range(40):
        m = peer()
        for name, values in EXTREMES.items():
            setattr(m, f"f_{name}", values[i % 3])
            getattr(m, f"p_{name}").extend((values * 4)[: i % 12])
            getattr(m, f"u_{name}").extend((values * 4)[: (i + 5) % 12])
        m.timestamp.seconds, m.timestamp.nanos = 1_700_000_000 + i, 123_456_789
        m.kind = (0, -3, 70000)[i % 3]
        if i % 2:
            m.inner.x = i / 7
        if i % 3:
            m.inner.many.extend([1.5, -2.5])
        for k in range(i % 10):
            item = m.items.add(x=k + 0.25, y=-k)
            item.many.extend([k] * k)
        m.note = "text" * i
        if i % 4 == 1:
            m.one_a = i
        elif i % 4 == 2:
            m.one_b.y = i
        elif i % 4 == 3:
            m.one_text = "t"
        if i % 5:
            m.maybe = i % 3
        m.again.f_double = 5.0
        messages.append(m)
    return [*messages, peer()]


def test_every_value_equals_the_library(root: tuple[ProtobufDecoder, Any]) -> None:
    decoder, peer = root
    messages = full_messages(peer)
    decoded = decode(decoder, [m.SerializeToString() for m in messages])
    assert decoded.bad == 0
    assert len(decoded.columns) > 250
    check_same(decoded, messages)
    assert decoded.stamp_ns is not None
    assert decoded.stamp_ns.tolist() == [(1_700_000_000 + i) * 10**9 + 123_456_789 for i in range(40)] + [0]


def test_only_wanted_columns_with_same_values(root: tuple[ProtobufDecoder, Any]) -> None:
    decoder, peer = root
    messages = full_messages(peer)
    wanted = ["items[2].many[1]", "one_a", "p_double[3]", "no.such", "inner.x", "items[0].y"]
    decoded = decode(decoder, [m.SerializeToString() for m in messages], wanted)
    assert list(decoded.columns) == wanted
    assert np.isnan(decoded.columns["no.such"]).all()
    check_same(Decoded({k: v for k, v in decoded.columns.items() if k != "no.such"}, None, 0), messages)


def test_repeated_occurrences_merge_and_the_last_wins(root: tuple[ProtobufDecoder, Any]) -> None:
    decoder, peer = root
    first = peer(
        f_double=1.0, inner={"x": 1.0, "many": [1, 2]}, one_b={"x": 3.0, "many": [9]}, items=[{"x": 1}]
    )
    second = peer(f_double=2.0, inner={"y": 5, "many": [3]}, one_a=4.0, items=[{"y": 2}])
    third = peer(one_b={"y": 6, "many": [8]}, p_int32=[1], u_int32=[2])
    fourth = peer(one_text="x")
    parts = [m.SerializeToString() for m in (first, second, third, fourth)]
    payloads = [b"".join(parts[:k]) for k in range(1, 5)] + [parts[0] + parts[2], parts[2] + parts[2]]
    messages = [peer.FromString(p) for p in payloads]
    check_same(decode(decoder, payloads), messages)


def test_unknown_fields_groups_and_wrong_wire_types_are_skipped(root: tuple[ProtobufDecoder, Any]) -> None:
    decoder, peer = root
    value = peer(f_double=2.5).SerializeToString()
    group = b"\xfb\x3e" + b"\x08\x01" + b"\x13\x14" + b"\xfc\x3e"
    unknown = b"\xf8\x3e\x05" + b"\xf9\x3e" + bytes(8) + b"\xfd\x3e" + bytes(4) + b"\xfa\x3e\x02ab" + group
    wrong = b"\x08\x05"  # field 1 is a double, here a varint
    payloads = [unknown + value, value + unknown, value + wrong]
    decoded = decode(decoder, payloads, ["f_double"])
    assert decoded.bad == 0
    assert decoded.columns["f_double"].tolist() == [2.5] * 3


@pytest.mark.parametrize(
    "damaged",
    [
        b"\x08",
        b"\x09\x00",
        b"\x00\x01",
        b"\x0c",
        b"\xb2\x01\xff\xff\xff\xff\x0f",
        b"\xb2\x01\x05\x09",
        b"\xff" * 12,
        b"\xfb\x3e\x08\x01",
        b"\x0f\x00",
    ],
)
def test_damaged_payloads_are_counted_and_leave_the_others(
    root: tuple[ProtobufDecoder, Any], damaged: bytes
) -> None:
    decoder, peer = root
    with pytest.raises(DecodeError):
        peer.FromString(damaged)
    good = peer(f_double=1.0, timestamp={"seconds": 5}).SerializeToString()
    decoded = decode(decoder, [good, good + damaged, good])
    assert decoded.bad == 1
    np.testing.assert_array_equal(decoded.columns["f_double"], [1.0, math.nan, 1.0])
    assert decoded.stamp_ns is not None
    assert decoded.stamp_ns.tolist() == [5 * 10**9, 0, 5 * 10**9]


def test_proto2_defaults_and_presence() -> None:
    file = FileDescriptorProto(name="two.proto", package="t", syntax="proto2")
    kind = file.enum_type.add(name="Gear")
    kind.value.add(name="PARK", number=4)
    kind.value.add(name="DRIVE", number=9)
    m = file.message_type.add(name="Two")
    m.field.add(name="gain", number=1, type=F.TYPE_FLOAT, label=1, default_value="2.5")
    m.field.add(name="on", number=2, type=F.TYPE_BOOL, label=1, default_value="true")
    m.field.add(name="gear", number=3, type=F.TYPE_ENUM, type_name=".t.Gear", label=1, default_value="DRIVE")
    m.field.add(name="plain", number=4, type=F.TYPE_INT32, label=1)
    decoder, peer = build(file, "t.Two")
    decoded = decode(decoder, [b"", peer(gain=1.0, on=False, gear=4, plain=0).SerializeToString()])
    columns = {path: column.tolist() for path, column in decoded.columns.items()}
    assert columns["gain"] == [2.5, 1.0]
    assert columns["on"] == [1.0, 0.0]
    assert columns["gear"] == [9.0, 4.0]
    assert math.isnan(columns["plain"][0])
    assert columns["plain"][1] == 0.0
    assert decoded.stamp_ns is None
    assert not decoder.has_header


def test_units_from_comments() -> None:
    file = FileDescriptorProto(name="c.proto", package="t", syntax="proto3")
    m = file.message_type.add(name="C")
    m.field.add(name="ay", number=1, type=F.TYPE_FLOAT, label=1)
    m.field.add(name="n", number=2, type=F.TYPE_FLOAT, label=1)
    file.source_code_info.location.add(path=[4, 0, 2, 0], leading_comments=" lateral acceleration [m/s^2]\n")
    file.source_code_info.location.add(path=[4, 0, 2, 1], trailing_comments=" between [0, 1] [no unit]\n")
    decoder, _ = build(file, "t.C")
    assert [(info.path, info.unit) for info in decoder.fields] == [("ay", "m/s^2"), ("n", None)]
    assert decoder.fields[0].comment == "lateral acceleration [m/s^2]"


def test_fields_of_a_type_that_holds_itself(root: tuple[ProtobufDecoder, Any]) -> None:
    paths = [info.path for info in root[0].fields]
    assert "again.f_double" not in paths
    assert ("note", "text") in [(info.path, info.kind) for info in root[0].fields]
    assert len(paths) == len(set(paths))


def test_definitions_that_cannot_be_used() -> None:
    good = FileDescriptorSet(file=[scalars_file()]).SerializeToString()
    with pytest.raises(LogError, match=r"does not have the type 't\.Nobody'"):
        make_protobuf_decoder("t.Nobody", good)
    with pytest.raises(LogError, match="damaged"):
        make_protobuf_decoder("t.Root", b"\xff\xff\xff")
    with pytest.raises(LogError, match="no field"):
        make_protobuf_decoder("t.E", FileDescriptorSet(file=[_empty()]).SerializeToString())


def _empty() -> FileDescriptorProto:
    file = FileDescriptorProto(name="e.proto", package="t")
    file.message_type.add(name="E")
    return file


@settings(max_examples=150, deadline=None)
@given(st.lists(st.binary(max_size=80), min_size=1, max_size=4))
def test_random_bytes_never_crash_and_agree_with_the_library(payloads: list[bytes]) -> None:
    decoder, peer = _CACHED
    decoded = decode(decoder, payloads)
    messages = []
    for payload in payloads:
        try:
            messages.append(peer.FromString(payload))
        except DecodeError:
            messages.append(None)
    # inner texts and unknown messages are not looked into here, so that the library may refuse more
    assert decoded.bad <= sum(m is None for m in messages)
    for i, m in enumerate(messages):
        if m is not None:
            for path, column in decoded.columns.items():
                np.testing.assert_equal(column[i], peer_value(m, path), err_msg=path)


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 40), st.integers(0, 4000), st.binary(min_size=1, max_size=6))
def test_overwritten_bytes_never_crash(which: int, at: int, new: bytes) -> None:
    decoder, peer = _CACHED
    payload = bytearray(full_messages(peer)[which].SerializeToString())
    at = at % (len(payload) + 1)
    payload[at : at + len(new)] = new
    decoded = decode(decoder, [bytes(payload)])
    assert all(column.shape == (1,) for column in decoded.columns.values())


def test_offsets_outside_of_the_data_are_bad_not_read(root: tuple[ProtobufDecoder, Any]) -> None:
    data = np.zeros(4, dtype=np.uint8)
    offset, length = np.array([-1, 0, 2, 5]), np.array([2, 2**62, 3, 0])
    assert root[0].decode(data, offset, length, ["f_double"]).bad == 4


def test_deep_nesting_is_bounded() -> None:
    file = FileDescriptorProto(name="deep.proto", package="t", syntax="proto3")
    for k in range(40):
        m = file.message_type.add(name=f"L{k}")
        m.field.add(name="v", number=1, type=F.TYPE_FLOAT, label=1)
        if k < 39:
            m.field.add(name="n", number=2, type=F.TYPE_MESSAGE, type_name=f".t.L{k + 1}", label=1)
    decoder, _ = build(file, "t.L0")
    payload = b"\x0d" + struct.pack("<f", 7.0)
    for _ in range(39):
        body = payload
        payload = b"\x0d" + struct.pack("<f", 7.0) + b"\x12" + _varint(len(body)) + body
    decoded = decode(decoder, [payload])
    assert decoded.bad == 0
    assert all(column.tolist() == [7.0] for column in decoded.columns.values())


def _varint(value: int) -> bytes:
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes([*out, value])


_CACHED = build(scalars_file(), "t.Root")


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


def test_any_mix_of_messages_equals_each_alone(root: tuple[ProtobufDecoder, Any]) -> None:
    """What was learnt from one message must not show in the next one."""
    decoder, peer = root
    messages = full_messages(peer)
    order = np.random.default_rng(8).integers(0, len(messages), 300)
    payloads = [m.SerializeToString() for m in messages]
    alone = [decode(decoder, [payload]) for payload in payloads]
    mixed = decode(decoder, [payloads[k] for k in order])
    for path, column in mixed.columns.items():
        np.testing.assert_array_equal(column, [alone[k].columns[path][0] for k in order], err_msg=path)
    assert mixed.stamp_ns is not None
    stamps = [each.stamp_ns for each in alone]
    assert mixed.stamp_ns.tolist() == [int(stamps[k][0]) for k in order if stamps[k] is not None]
