"""Protobuf definitions: defaults, presence, units from comments, and what cannot be used."""

from __future__ import annotations

import math
import struct

import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet
from protobuf_files import F, build, decode, scalars_file

from parsers.errors import LogError
from parsers.protobuf_decode import make_protobuf_decoder


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


def test_fields_without_columns_are_named() -> None:
    file = FileDescriptorProto(name="odd.proto", package="t", syntax="proto2")
    inner = file.message_type.add(name="Inner")
    inner.field.add(name="x", number=1, type=F.TYPE_DOUBLE, label=1)
    inner.field.add(name="more", number=2, type=F.TYPE_MESSAGE, type_name=".t.Inner2", label=3)
    file.message_type.add(name="Inner2").field.add(name="y", number=1, type=F.TYPE_DOUBLE, label=1)
    root = file.message_type.add(name="Root")
    root.field.add(name="speed", number=1, type=F.TYPE_DOUBLE, label=1)
    entry = root.nested_type.add(name="ValuesEntry")
    entry.options.map_entry = True
    entry.field.add(name="key", number=1, type=F.TYPE_STRING, label=1)
    entry.field.add(name="value", number=2, type=F.TYPE_DOUBLE, label=1)
    root.field.add(name="values", number=2, type=F.TYPE_MESSAGE, type_name=".t.Root.ValuesEntry", label=3)
    root.nested_type.add(name="Part").field.add(name="z", number=1, type=F.TYPE_DOUBLE, label=1)
    root.field.add(name="part", number=3, type=F.TYPE_GROUP, type_name=".t.Root.Part", label=1)
    root.field.add(name="items", number=4, type=F.TYPE_MESSAGE, type_name=".t.Inner", label=3)
    decoder = make_protobuf_decoder("t.Root", FileDescriptorSet(file=[file]).SerializeToString())
    assert [f.path for f in decoder.fields][:2] == ["speed", "items[0].x"]
    assert decoder.notes == (
        "fields of t.Root that are not read: values (a map), part (a group), items[].more (a list within a list)",
    )
