"""Protobuf messages of one type, decoded in bulk from the descriptor that a log carries."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.errors import LogError
from parsers.field_notes import join_stamp, stamp_fields
from parsers.protobuf_kernel import decode_payloads
from parsers.protobuf_tables import LOOK_UP, STEP_OVER, TAKE, TAKE_DOUBLE, Output, Tables
from parsers.protobuf_tree import Entry, Range, Tree, build_tree
from parsers.ros.contract import Cells, Decoded, FieldInfo

_WIRE_FIXED64 = (1, 6, 16)
_WIRE_FIXED32 = (2, 7, 15)
_DOUBLE, _MESSAGE = 1, 11
_MOST_NAMED = 6


def _wire(kind: int) -> int:
    if kind in _WIRE_FIXED64:
        return 1
    if kind in _WIRE_FIXED32:
        return 5
    return 2 if kind in (9, 11, 12) else 0


def _table(rows: Sequence[Sequence[int]], width: int) -> IntArray:
    return np.array(rows, dtype=np.int64).reshape(len(rows), width)


def _tag(field: int, wire: int) -> tuple[int, int]:
    """A field's tag as it stands in a message, as a number of 8 bytes; and how many of them it has."""
    value, tag, size = field << 3 | wire, 0, 0
    while True:
        more = value > 0x7F
        tag |= (value & 0x7F | (0x80 if more else 0)) << (8 * size)
        size += 1
        value >>= 7
        if not more:
            return tag, size


class _Compiler:
    """Makes tables that look only at the kept columns (sorted).

    column_of: column -> row of the output. stamp_of: column -> 0 for the seconds and 1 for the nanoseconds of the stamp.
    """

    def __init__(
        self, tree: Tree, kept: IntArray, column_of: Mapping[int, int], stamp_of: Mapping[int, int]
    ) -> None:
        self.tree, self.kept, self.column_of, self.stamp_of = tree, kept, column_of, stamp_of
        self.entries: list[list[int]] = []
        self.tags: list[tuple[int, int]] = []
        self.elements: list[list[int]] = []

    def tables(self) -> Tables:
        """All tables of the kernel."""
        nodes: list[list[int]] = []
        defaults: list[tuple[float, float]] = []
        for node in self.tree.nodes:
            first_entry, first_default = len(self.entries), len(defaults)
            for entry in node.entries:
                self._add(entry)
            defaults += [
                (float(self.column_of[column]), value)
                for column, value in node.defaults.items()
                if column in self.column_of and not math.isnan(value)
            ]
            nodes.append([first_entry, len(self.entries), first_default, len(defaults)])
        template = np.full(self.kept.size, np.nan)
        for row, value in defaults[: nodes[0][3]]:
            template[int(row)] = value
        return Tables(
            _table(self.entries, 16),
            np.array([tag for tag, _ in self.tags], dtype=np.uint64),
            np.array([(1 << 8 * size) - 1 for _, size in self.tags], dtype=np.uint64),
            _table(nodes, 4),
            _table([self._squeezed(below) for below in self.tree.oneofs], 6),
            _table(self.elements, 2),
            np.array(defaults, dtype=np.float64).reshape(len(defaults), 2),
            template,
            self.tree.lists,
        )

    def _squeezed(self, below: Range) -> list[int]:
        first, end = np.searchsorted(self.kept, below.columns).tolist()
        return [first, end, *below.nodes, *below.lists]

    def _add(self, entry: Entry) -> None:
        squeezed = self._squeezed(entry.below)
        idle = squeezed[0] == squeezed[1]
        first = len(self.elements)
        if entry.kind == _MESSAGE:
            self.elements += [[-1 if idle else element, -1] for element in entry.elements]
        else:
            self.elements += [
                [self.column_of.get(element, -1), self.stamp_of.get(element, -1)]
                for element in entry.elements
            ]
        wire, listed = _wire(entry.kind), entry.list_number >= 0
        action, cell = LOOK_UP, -1
        if entry.oneof < 0 and idle:
            action = STEP_OVER
        elif entry.oneof < 0 and not listed and wire != 2 and self.elements[first][1] < 0:
            action = TAKE_DOUBLE if entry.kind == _DOUBLE else TAKE
            cell = self.elements[first][0]
        # numbers of a list are usually packed
        tag, size = _tag(entry.number, 2 if listed else wire)
        self.tags.append((tag, size))
        head = [entry.number, entry.kind, wire, first, len(entry.elements), entry.list_number, entry.oneof]
        self.entries.append([*head, *squeezed, action, cell, size])


@dataclass(frozen=True)
class ProtobufDecoder:
    """A `MessageDecoder` for one protobuf type. `notes`: what of the type cannot be given."""

    tree: Tree
    notes: tuple[str, ...] = ()
    _column: Mapping[str, int] = field(default_factory=dict)
    _stamp: tuple[str, str] | None = None
    _programs: dict[tuple[str, ...], tuple[Tables, dict[str, int]]] = field(
        default_factory=dict, compare=False, repr=False
    )

    @property
    def fields(self) -> Sequence[FieldInfo]:
        """All scalar fields, lists by element, and text fields."""
        return (*self.tree.fields, *self.tree.texts)

    @property
    def has_header(self) -> bool:
        """Whether messages carry their own stamp."""
        return self._stamp is not None

    def decode(
        self,
        data: ByteArray,
        offset: IntArray,
        length: IntArray,
        wanted: Sequence[str],
        cells: Cells = np.empty,
    ) -> Decoded:
        """Decode payload i = data[offset[i] : offset[i] + length[i]] for all i; only the wanted field paths.

        Absent: 0.0 or the declared default where the type has no way to say "absent", else NaN.
        """
        tables, rows = self._program(tuple(wanted))
        out = cells(tables.template.size * offset.size).reshape(tables.template.size, offset.size)
        stamp = np.empty((offset.size, 2), dtype=np.int64)
        view = np.ascontiguousarray(data, dtype=np.uint8).view()
        view.flags.writeable = False
        bad = decode_payloads(
            view,
            np.ascontiguousarray(offset, dtype=np.int64),
            np.ascontiguousarray(length, dtype=np.int64),
            tables,
            Output(out, out.view(np.uint64), stamp),
        )
        return Decoded(
            columns={
                path: out[row] if row >= 0 else np.full(offset.size, np.nan) for path, row in rows.items()
            },
            stamp_ns=join_stamp(stamp[:, 0], stamp[:, 1]) if self._stamp else None,
            bad=int(bad),
        )

    def _program(self, wanted: tuple[str, ...]) -> tuple[Tables, dict[str, int]]:
        """The tables for these paths, and the row of the output of each (-1: none); kept for the next batch."""
        found = self._programs.get(wanted)
        if found is None:
            stamps = {self._column[path]: k for k, path in enumerate(self._stamp or ())}
            columns = {self._column[path] for path in wanted if path in self._column}
            kept = np.array(sorted(columns | set(stamps)), dtype=np.int64)
            row_of = {int(column): row for row, column in enumerate(kept.tolist())}
            rows = {path: row_of[self._column[path]] if path in self._column else -1 for path in wanted}
            found = self._programs[wanted] = _Compiler(self.tree, kept, row_of, stamps).tables(), rows
        return found


def _left_out(type_name: str, tree: Tree) -> Iterator[str]:
    """A sentence on the fields that have no columns."""
    if not tree.left_out:
        return
    named = [f"{name} (a {what})" for name, what in tree.left_out.items()]
    more = f" and {len(named) - _MOST_NAMED} more" if len(named) > _MOST_NAMED else ""
    yield f"fields of {type_name} that are not read: {', '.join(named[:_MOST_NAMED])}{more}"


def make_protobuf_decoder(type_name: str, definition: bytes) -> ProtobufDecoder:
    """A decoder for the type `type_name` ("foxglove.Imu") of a serialised FileDescriptorSet.

    Fields: nested messages as "a.b", the first 8 elements of lists as "[0]", enums and booleans as numbers. Maps, groups and types
    that contain themselves are left out and named in the notes. The stamp is a first-level google.protobuf.Timestamp (or seconds
    and nanoseconds) named header.stamp, timestamp or stamp. Raises LogError where the definition cannot be used.
    """
    tree = build_tree(type_name, definition)
    if not tree.fields and not tree.texts:
        raise LogError(f"the protobuf type {type_name!r} has no field that could be a channel")
    notes: tuple[str, ...] = ()
    if tree.full:
        notes = (f"{type_name} has too many fields: only the first are listed",)
    notes += tuple(_left_out(type_name, tree))
    column = {info.path: number for number, info in enumerate(tree.fields)}
    return ProtobufDecoder(tree, notes, column, stamp_fields(column))
