"""The field tree of a protobuf message type, from the FileDescriptorSet that a log carries. Nothing is executed.

Every scalar gets one column; a repeated field gets one for each of its first elements. The columns, nodes and lists
of a field stand behind one another, so that "everything below this field" is a range of numbers.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from google.protobuf.descriptor_pb2 import (
    DescriptorProto,
    EnumDescriptorProto,
    FeatureSet,
    FieldDescriptorProto,
    FileDescriptorProto,
    FileDescriptorSet,
)
from google.protobuf.message import DecodeError

from parsers.errors import LogError
from parsers.field_notes import MAX_FIELDS, MAX_LIST, unit_in
from parsers.ros.contract import FieldInfo

MAX_DEPTH = 16
_ELEMENT = re.compile(r"\[\d+\]")
_TEXT = (FieldDescriptorProto.TYPE_STRING, FieldDescriptorProto.TYPE_BYTES)
_MESSAGE, _GROUP = FieldDescriptorProto.TYPE_MESSAGE, FieldDescriptorProto.TYPE_GROUP
_REPEATED = FieldDescriptorProto.LABEL_REPEATED


@dataclass
class Range:
    """Numbers first <= i < end of columns, nodes and lists below a field."""

    columns: tuple[int, int] = (0, 0)
    nodes: tuple[int, int] = (0, 0)
    lists: tuple[int, int] = (0, 0)


@dataclass
class Entry:
    """One field of a node. kind: the type number of protobuf. elements: column numbers of a scalar field or node
    numbers of a message field, one for each element. list_number: which element counter, -1 where not repeated."""

    number: int
    kind: int
    elements: list[int]
    list_number: int
    oneof: int
    below: Range


@dataclass
class Node:
    """One message at one place. defaults: column -> value where the message is there and the field is not."""

    entries: list[Entry] = field(default_factory=list)
    defaults: dict[int, float] = field(default_factory=dict)


@dataclass
class Tree:
    """All nodes (0 is the message itself), the fields by column, text fields, and the ranges of the oneofs.

    full: whether fields were left out because there are too many. left_out: field -> what it is that has no columns.
    """

    nodes: list[Node] = field(default_factory=list)
    fields: list[FieldInfo] = field(default_factory=list)
    texts: list[FieldInfo] = field(default_factory=list)
    oneofs: list[Range] = field(default_factory=list)
    lists: int = 0
    full: bool = False
    left_out: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class _Type:
    name: str
    message: DescriptorProto
    file: FileDescriptorProto
    comments: dict[int, str]


def _comments(file: FileDescriptorProto) -> dict[tuple[int, ...], str]:
    found: dict[tuple[int, ...], str] = {}
    for place in file.source_code_info.location:
        text = " ".join((place.leading_comments + " " + place.trailing_comments).split())
        if text:
            found[tuple(place.path)] = text
    return found


def _types(files: FileDescriptorSet) -> Iterator[_Type]:
    """All message types with their full names, nested ones too."""
    for file in files.file:
        comments = _comments(file)
        prefix = f"{file.package}." if file.package else ""
        waiting: list[tuple[str, DescriptorProto, tuple[int, ...]]] = [
            (prefix + m.name, m, (4, i)) for i, m in enumerate(file.message_type)
        ]
        while waiting:
            name, message, path = waiting.pop()
            own = {
                f.number: comments[(*path, 2, i)]
                for i, f in enumerate(message.field)
                if (*path, 2, i) in comments
            }
            yield _Type(name, message, file, own)
            waiting += [(f"{name}.{m.name}", m, (*path, 3, i)) for i, m in enumerate(message.nested_type)]


def _has_presence(item: FieldDescriptorProto, file: FileDescriptorProto) -> bool:
    """Whether a message says of this field that it is absent, rather than giving zero."""
    if item.HasField("oneof_index") or item.proto3_optional:
        return True
    if file.syntax == "proto3":
        return False
    if file.syntax != "editions":
        return True
    chosen = item.options.features.field_presence or file.options.features.field_presence
    return chosen != FeatureSet.IMPLICIT


def _enums(files: FileDescriptorSet) -> dict[str, int]:
    """The values of all enums: "package.Enum.NAME" -> number."""
    found: dict[str, int] = {}
    for file in files.file:
        top = f"{file.package}." if file.package else ""
        found.update(_values(top, file.enum_type))
    for kind in _types(files):
        found.update(_values(f"{kind.name}.", kind.message.enum_type))
    return found


def _values(prefix: str, enums: Iterable[EnumDescriptorProto]) -> dict[str, int]:
    return {f"{prefix}{enum.name}.{value.name}": value.number for enum in enums for value in enum.value}


def _default(item: FieldDescriptorProto, file: FileDescriptorProto, enums: dict[str, int]) -> float:
    """The value of a field that is not in a message that is there; NaN where absent means unknown."""
    if item.label == _REPEATED:
        return math.nan
    text = item.default_value
    if text and not item.HasField("oneof_index"):
        if text in ("true", "false"):
            return float(text == "true")
        if item.type == FieldDescriptorProto.TYPE_ENUM:
            return float(enums.get(f"{item.type_name.lstrip('.')}.{text}", math.nan))
        try:
            return float(text)
        except ValueError:
            return math.nan
    return math.nan if _has_presence(item, file) else 0.0


class _Builder:
    def __init__(self, types: dict[str, _Type], enums: dict[str, int]) -> None:
        self.types, self.enums = types, enums
        self.tree = Tree()

    def node(self, kind: _Type, path: str, above: tuple[str, ...], in_list: bool) -> int:
        """Add a node for a message at a path, with all that is below it."""
        tree = self.tree
        node = Node()
        tree.nodes.append(node)
        number = len(tree.nodes) - 1
        oneofs: dict[int, int] = {}
        for item in self._ordered(kind.message):
            start = self._here()
            oneof = -1
            if item.HasField("oneof_index") and not item.proto3_optional:
                if item.oneof_index not in oneofs:
                    oneofs[item.oneof_index] = len(tree.oneofs)
                    tree.oneofs.append(self._below(start))
                oneof = oneofs[item.oneof_index]
            entry = self._entry(item, kind, path, (*above, kind.name), in_list)
            if entry is None and oneof >= 0:
                entry = Entry(item.number, item.type, [], -1, -1, Range())
            if entry is None:
                continue
            entry.oneof, entry.below = oneof, self._below(start)
            node.entries.append(entry)
            if oneof >= 0:
                first = tree.oneofs[oneof]
                tree.oneofs[oneof] = self._below((first.columns[0], first.nodes[0], first.lists[0]))
            if item.type not in (_MESSAGE, _GROUP):
                node.defaults.update(dict.fromkeys(entry.elements, _default(item, kind.file, self.enums)))
        node.entries.sort(key=lambda entry: entry.number)
        return number

    def _ordered(self, message: DescriptorProto) -> list[FieldDescriptorProto]:
        """The fields in their order, but those of one oneof together."""
        first: dict[int, int] = {}
        for i, item in enumerate(message.field):
            if item.HasField("oneof_index"):
                first.setdefault(item.oneof_index, i)

        def place(pair: tuple[int, FieldDescriptorProto]) -> tuple[int, int]:
            i, item = pair
            return (first[item.oneof_index] if item.HasField("oneof_index") else i, i)

        return [item for _, item in sorted(enumerate(message.field), key=place)]

    def _here(self) -> tuple[int, int, int]:
        return len(self.tree.fields), len(self.tree.nodes), self.tree.lists

    def _below(self, start: tuple[int, int, int]) -> Range:
        end = self._here()
        return Range((start[0], end[0]), (start[1], end[1]), (start[2], end[2]))

    def _entry(
        self, item: FieldDescriptorProto, kind: _Type, path: str, above: tuple[str, ...], in_list: bool
    ) -> Entry | None:
        tree = self.tree
        name = f"{path}.{item.name}" if path else item.name
        comment = kind.comments.get(item.number, "")
        repeated = item.label == _REPEATED
        if item.type in _TEXT:
            tree.texts.append(FieldInfo(name, "text", None, comment))
            return None
        if item.type == _GROUP:
            self._leave_out(name, "group")
            return None
        names = [f"{name}[{k}]" for k in range(MAX_LIST)] if repeated else [name]
        if len(tree.fields) + len(names) > MAX_FIELDS:
            tree.full = True
            return None
        list_number = -1
        inner = self.types.get(item.type_name.lstrip(".")) if item.type == _MESSAGE else None
        if item.type == _MESSAGE:
            why = self._unusable(inner, above, repeated and in_list)
            if inner is None or why:
                self._leave_out(name, why)
                return None
        if repeated:
            list_number, tree.lists = tree.lists, tree.lists + 1
        if inner is not None:
            elements = [self.node(inner, each, above, in_list or repeated) for each in names]
        else:
            elements = list(range(len(tree.fields), len(tree.fields) + len(names)))
            tree.fields += [FieldInfo(each, "number", unit_in(comment), comment) for each in names]
        return Entry(item.number, item.type, elements, list_number, -1, Range())

    def _unusable(self, inner: _Type | None, above: tuple[str, ...], list_in_list: bool) -> str:
        """Why a field's message has no columns; "" where it has."""
        if inner is None:
            return "message without a definition"
        if inner.message.options.map_entry:
            return "map"
        if inner.name in above or len(above) >= MAX_DEPTH:
            return "message within itself"
        return "list within a list" if list_in_list else ""

    def _leave_out(self, name: str, why: str) -> None:
        """Write down a field without columns; once for all elements of a list."""
        self.tree.left_out.setdefault(_ELEMENT.sub("[]", name), why)


def build_tree(type_name: str, definition: bytes) -> Tree:
    """The tree of a type. Raises LogError where the definition is damaged or does not have the type."""
    try:
        files = FileDescriptorSet.FromString(definition)
    except DecodeError as error:
        raise LogError(f"the protobuf definition of {type_name!r} is damaged ({error})") from error
    types = {kind.name: kind for kind in _types(files)}
    root = types.get(type_name.lstrip("."))
    if root is None:
        raise LogError(f"the protobuf definition does not have the type {type_name!r}")
    builder = _Builder(types, _enums(files))
    builder.node(root, "", (), False)
    return builder.tree
