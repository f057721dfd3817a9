"""Protobuf definitions and payloads for the tests, read by cogest and by the protobuf library."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet
from google.protobuf.timestamp_pb2 import DESCRIPTOR as TIMESTAMP_FILE

from parsers.protobuf_decode import ProtobufDecoder, make_protobuf_decoder
from parsers.ros.contract import Decoded
from tests.parsers.payload_bytes import laid_out

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


def decode(
    decoder: ProtobufDecoder, payloads: Sequence[bytes], wanted: Sequence[str] | None = None
) -> Decoded:
    if wanted is None:
        wanted = [info.path for info in decoder.fields if info.kind == "number"]
    return decoder.decode(*laid_out(payloads), wanted)


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
