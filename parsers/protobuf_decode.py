"""Protobuf messages of one type, decoded in bulk from the descriptor that a log carries."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.errors import LogError
from parsers.field_notes import join_stamp, stamp_fields
from parsers.protobuf_kernel import decode_payloads
from parsers.protobuf_tree import Entry, Range, Tree, build_tree
from parsers.ros.contract import Decoded, FieldInfo

_WIRE_FIXED64 = (1, 6, 16)
_WIRE_FIXED32 = (2, 7, 15)
_MESSAGE = 11


@dataclass(frozen=True)
class _Program:
    """The tables of `decode_payloads` for some wanted columns."""

    entries: IntArray
    nodes: IntArray
    oneofs: IntArray
    elements: IntArray
    defaults: FloatArray


def _wire(kind: int) -> int:
    if kind in _WIRE_FIXED64:
        return 1
    if kind in _WIRE_FIXED32:
        return 5
    return 2 if kind in (9, 11, 12) else 0


def _table(rows: Sequence[Sequence[int]], width: int) -> IntArray:
    return np.array(rows, dtype=np.int64).reshape(len(rows), width)


def _compile(
    tree: Tree, kept: IntArray, column_of: Mapping[int, int], stamp_of: Mapping[int, int]
) -> _Program:
    """Tables that look only at the kept columns (sorted). column_of: column -> row of the output; stamp_of: column
    -> 0 for the seconds and 1 for the nanoseconds of the stamp."""

    def squeezed(below: Range) -> list[int]:
        first, end = np.searchsorted(kept, below.columns).tolist()
        return [first, end, *below.nodes, *below.lists]

    entries: list[list[int]] = []
    nodes: list[list[int]] = []
    elements: list[list[int]] = []
    defaults: list[tuple[float, float]] = []

    def of_interest(entry: Entry) -> bool:
        first, end = squeezed(entry.below)[:2]
        return first < end or entry.oneof >= 0

    for node in tree.nodes:
        first_entry, first_default = len(entries), len(defaults)
        for entry in filter(of_interest, node.entries):
            idle = squeezed(entry.below)[0] == squeezed(entry.below)[1]
            first = len(elements)
            if entry.kind == _MESSAGE:
                elements += [[-1 if idle else element, -1] for element in entry.elements]
            else:
                elements += [
                    [column_of.get(element, -1), stamp_of.get(element, -1)] for element in entry.elements
                ]
            head = [entry.number, entry.kind, _wire(entry.kind), first, len(entry.elements)]
            entries.append([*head, entry.list_number, entry.oneof, *squeezed(entry.below)])
        defaults += [
            (float(column_of[column]), value)
            for column, value in node.defaults.items()
            if column in column_of and not math.isnan(value)
        ]
        nodes.append([first_entry, len(entries), first_default, len(defaults)])
    return _Program(
        _table(entries, 13),
        _table(nodes, 4),
        _table([squeezed(below) for below in tree.oneofs], 6),
        _table(elements, 2),
        np.array(defaults, dtype=np.float64).reshape(len(defaults), 2),
    )


@dataclass(frozen=True)
class ProtobufDecoder:
    """A `MessageDecoder` for one protobuf type. `notes`: what of the type cannot be given."""

    tree: Tree
    notes: tuple[str, ...] = ()
    _column: Mapping[str, int] = field(default_factory=dict)
    _stamp: tuple[str, str] | None = None

    @property
    def fields(self) -> Sequence[FieldInfo]:
        """All scalar fields, lists by element, and text fields."""
        return (*self.tree.fields, *self.tree.texts)

    @property
    def has_header(self) -> bool:
        """Whether messages carry their own stamp."""
        return self._stamp is not None

    def decode(self, data: ByteArray, offset: IntArray, length: IntArray, wanted: Sequence[str]) -> Decoded:
        """Decode payload i = data[offset[i] : offset[i] + length[i]] for all i; only the wanted field paths.

        Absent: 0.0 or the declared default where the type has no way to say "absent", else NaN.
        """
        known = [path for path in wanted if path in self._column]
        stamps = {self._column[path]: k for k, path in enumerate(self._stamp or ())}
        kept = np.array(sorted({self._column[path] for path in known} | set(stamps)), dtype=np.int64)
        column_of = {int(column): row for row, column in enumerate(kept.tolist())}
        program = _compile(self.tree, kept, column_of, stamps)
        out = np.empty((kept.size, offset.size), dtype=np.float64)
        stamp = np.zeros((offset.size, 2), dtype=np.int64)
        view = np.ascontiguousarray(data, dtype=np.uint8).view()
        view.flags.writeable = False
        bad = decode_payloads(
            view,
            np.ascontiguousarray(offset, dtype=np.int64),
            np.ascontiguousarray(length, dtype=np.int64),
            program.entries,
            program.nodes,
            program.oneofs,
            program.elements,
            program.defaults,
            self.tree.lists,
            out,
            stamp,
        )
        columns = {path: out[column_of[self._column[path]]] for path in known}
        missing = np.full(offset.size, np.nan)
        return Decoded(
            columns={path: columns.get(path, missing) for path in wanted},
            stamp_ns=join_stamp(stamp[:, 0], stamp[:, 1]) if self._stamp else None,
            bad=int(bad),
        )


def make_protobuf_decoder(type_name: str, definition: bytes) -> ProtobufDecoder:
    """A decoder for the type `type_name` ("foxglove.Imu") of a serialised FileDescriptorSet.

    Fields: nested messages as "a.b", the first 8 elements of lists as "[0]", enums and booleans as numbers. Maps, groups and types
    that contain themselves are left out. The stamp is a first-level google.protobuf.Timestamp (or seconds
    and nanoseconds) named header.stamp, timestamp or stamp. Raises LogError where the definition cannot be used.
    """
    tree = build_tree(type_name, definition)
    if not tree.fields and not tree.texts:
        raise LogError(f"the protobuf type {type_name!r} has no field that could be a channel")
    notes = (f"{type_name} has too many fields: only the first are listed",) if tree.full else ()
    column = {info.path: number for number, info in enumerate(tree.fields)}
    return ProtobufDecoder(tree, notes, column, stamp_fields(column))
