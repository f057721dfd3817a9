"""A message type as a flat program of integers, which one compiled kernel runs over all messages.

Nested messages are written out in place; arrays of messages become LOOP … END. So there is nothing to compile for
a new type, and no recursion over untrusted data. Each number that can be asked for has a slot; the slots of one
operation follow each other: (index of the outermost loop, …, index of the innermost loop, element).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from parsers.channels import IntArray
from parsers.errors import LogError
from parsers.ros.contract import FieldInfo
from parsers.ros.fields import TIME_TYPES, Encoding, FieldSpec, Types, full_name, short_name
from parsers.ros.grammar import lookup

OP_PRIMITIVE, OP_SEQUENCE, OP_STRING, OP_WSTRING, OP_TIME, OP_LOOP, OP_END, OP_SKIP = range(8)
OP, CODE, SIZE, COUNT, LIMIT, SLOT, JUMP = range(7)
"""Columns of a program. LOOP: CODE is the body's exact size in bytes where it is fixed (else 0), SIZE its least
size, COUNT the elements of a fixed array (else -1), LIMIT how many elements have slots, JUMP the row of its END.
TIME: CODE 1 where seconds are signed, COUNT 1 where this is the message's stamp."""
WIDTH = 7

CODES: dict[str, tuple[int, int]] = {
    "bool": (0, 1),
    "uint8": (0, 1),
    "char": (0, 1),
    "octet": (0, 1),
    "int8": (1, 1),
    "uint16": (2, 2),
    "int16": (3, 2),
    "uint32": (4, 4),
    "int32": (5, 4),
    "uint64": (6, 8),
    "int64": (7, 8),
    "float32": (8, 4),
    "float64": (9, 8),
    "float128": (10, 16),
    "wchar": (10, 4),
}
"""Primitive -> (code, bytes). Code 10 cannot be asked for."""
NO_NUMBER = 10

LISTED_SEQUENCE = 64
LISTED_STRUCTS = 4
LISTED_ARRAY = 512
JOINTS, LETTERS = 16, 40
"""Of a joint state's names so many can be asked for, letter by letter, as numbers of bytes: what a place in the other lists means."""
LABEL_LETTERS = 64
"""Of the label of a MultiArray's dimension, which may list what stands at its places."""
MAX_FIELDS = 20_000
MAX_OPS = 20_000
MAX_DEPTH = 24
MAX_SIZE = 1 << 30

HEADER = "/Header"  # std_msgs; very old bags have it in roslib


@dataclass(frozen=True)
class Layout:
    """A compiled type. ops: shape (m, WIDTH). paths: slot -> field path. depth: how deep the loops nest."""

    ops: IntArray
    paths: tuple[str, ...]
    fields: tuple[FieldInfo, ...]
    has_header: bool
    has_wstring: bool
    depth: int


@dataclass
class _Builder:
    """State of one compilation. loops: how many slots each open loop multiplies."""

    types: Types
    encoding: Encoding
    ops: list[list[int]] = field(default_factory=list)
    paths: list[str] = field(default_factory=list)
    fields: list[FieldInfo] = field(default_factory=list)
    depth: int = 0
    has_header: bool = False
    has_wstring: bool = False

    def op(self, code: int, *rest: int) -> int:
        """Append an operation; its row."""
        if len(self.ops) >= MAX_OPS:
            raise LogError("the message type is too large (more than 20 000 parts)")
        row = [code, *rest]
        self.ops.append(row + [-1] * (WIDTH - len(row)))
        return len(self.ops) - 1

    def slots(self, paths: Sequence[str], unit: str | None = None) -> int:
        """Give `paths` their slots; the first, or -1 where there are none left to give."""
        if not paths or len(self.paths) + len(paths) > MAX_FIELDS:
            return -1
        first = len(self.paths)
        self.paths.extend(paths)
        self.fields.extend(FieldInfo(path, "number", unit) for path in paths)
        return first


def compile_layout(type_name: str, types: Types, encoding: Encoding) -> Layout:
    """Compile a type. Raises LogError for types that are unknown, contain themselves, or are absurdly large."""
    builder = _Builder(types, encoding)
    _message(builder, full_name(type_name), [""], (), 0)
    fields = tuple({info.path: info for info in builder.fields}.values())
    ops = np.array(builder.ops, dtype=np.int64).reshape(-1, WIDTH)
    return Layout(ops, tuple(builder.paths), fields, builder.has_header, builder.has_wstring, builder.depth)


def _message(
    builder: _Builder, name: str, paths: list[str], above: tuple[str, ...], loops: int
) -> tuple[int, bool]:
    """Write a message's fields. Returns its least size in bytes (without alignment), and whether it is fixed."""
    if name in above:
        raise LogError(f"message type {short_name(name)} contains itself")
    if len(above) >= MAX_DEPTH:
        raise LogError(f"message types are nested more than {MAX_DEPTH} deep")
    specs = lookup(builder.types, name, builder.encoding)
    if not specs and builder.encoding == "cdr":
        # rosidl puts one byte into an empty structure, since C has no empty ones
        specs = (FieldSpec("", "uint8", "", "scalar", 0),)
    least, fixed = 0, True
    for spec in specs:
        size, same = _field(builder, spec, paths, (*above, name), loops)
        least += size
        fixed = fixed and same
    if least > MAX_SIZE:
        raise LogError(f"message type {short_name(name)} is absurdly large ({least} bytes)")
    return least, fixed


def _field(
    builder: _Builder, spec: FieldSpec, paths: list[str], above: tuple[str, ...], loops: int
) -> tuple[int, bool]:
    """Write one field: least size in bytes, and whether it is fixed."""
    below = [f"{path}.{spec.name}" if path else spec.name for path in paths] if spec.name else []
    if spec.shape == "scalar":
        return _single(builder, spec, below, above, loops)
    if spec.base and spec.base not in ("string", "wstring"):
        return _primitives(builder, spec, below)
    if spec.base == "string" and spec.shape == "sequence" and _names_joints(spec, above):
        return _letters(builder, spec, loops)
    if spec.base and below:
        builder.fields.extend(FieldInfo(path, "text", None, "list of texts") for path in below)
        below = []
    return _loop(builder, spec, below, above, loops)


def _single(
    builder: _Builder, spec: FieldSpec, paths: list[str], above: tuple[str, ...], loops: int
) -> tuple[int, bool]:
    top = len(above) == 1 and loops == 0
    if spec.ref in TIME_TYPES:
        inside = len(above) == 2 and loops == 0 and above[1].endswith(HEADER)
        stamp = (top or inside) and paths in (["stamp"], ["header.stamp"]) and not builder.has_header
        builder.has_header = builder.has_header or stamp
        # ROS 1 time counts in unsigned seconds, ROS 1 duration and both of ROS 2 in signed ones
        signed = builder.encoding == "cdr" or spec.ref.endswith("Duration")
        builder.op(OP_TIME, int(signed), 8, int(stamp), int(bool(paths)), builder.slots(paths, "s"))
        return 8, True
    if spec.ref:
        return _message(builder, full_name(spec.ref), paths, above, loops)
    if spec.base in ("string", "wstring"):
        builder.fields.extend(FieldInfo(path, "text") for path in paths)
        if _labels_places(spec, above, loops):
            return _label(builder, paths)
        builder.has_wstring = builder.has_wstring or spec.base == "wstring"
        builder.op(OP_STRING if spec.base == "string" else OP_WSTRING, 0, 1)
        return 4, False
    return _primitives(builder, spec, paths)


def _code(builder: _Builder, base: str) -> tuple[int, int]:
    if base == "byte":  # ROS 1: a signed byte; ROS 2: an octet
        base = "int8" if builder.encoding == "ros1" else "uint8"
    if base not in CODES:
        raise LogError(f"primitive type {base} is not supported")
    return CODES[base]


def _primitives(builder: _Builder, spec: FieldSpec, paths: list[str]) -> tuple[int, bool]:
    """A number, a fixed array or a sequence of numbers. Sequences of bytes are blobs: none of theirs is listed."""
    code, size = _code(builder, spec.base)
    if spec.shape == "scalar":
        count, listed = 1, paths
    elif spec.shape == "array":
        count = _checked(spec)
        listed = [f"{path}[{i}]" for path in paths for i in range(min(count, LISTED_ARRAY))]
    else:
        count = -1
        known = 0 if code == 0 and spec.base != "bool" else LISTED_SEQUENCE
        listed = [f"{path}[{i}]" for path in paths for i in range(known)]
    slot = builder.slots(listed) if code != NO_NUMBER else -1
    limit = len(listed) // len(paths) if slot >= 0 else 0
    builder.op(OP_SEQUENCE if count < 0 else OP_PRIMITIVE, code, size, count, limit, slot)
    return (4, False) if count < 0 else (size * count, True)


def _checked(spec: FieldSpec) -> int:
    if not 0 <= spec.size < 1 << 31:
        raise LogError(f"field {spec.name} is an array of {spec.size} elements")
    return spec.size


def _loop(
    builder: _Builder, spec: FieldSpec, paths: list[str], above: tuple[str, ...], loops: int
) -> tuple[int, bool]:
    """An array or a sequence of messages, times or texts."""
    count = _checked(spec) if spec.shape == "array" else -1
    limit = LISTED_STRUCTS if count < 0 else min(count, LISTED_STRUCTS)
    below = [f"{path}[{i}]" for path in paths for i in range(limit)]
    if len(below) > MAX_FIELDS:
        below = []
    start = builder.op(OP_LOOP, 0, 0, count, limit if below else 0)
    builder.depth = max(builder.depth, loops + 1)
    element = FieldSpec("", spec.base, spec.ref, "scalar", 0)
    least, fixed = _single(builder, element, below, above, loops + 1)
    if least == 0:
        # elements without any content: only their number is in the message, if that
        del builder.ops[start:]
        if count < 0:
            builder.op(OP_SEQUENCE, NO_NUMBER, 0, -1, 0)
        return (0, True) if count >= 0 else (4, False)
    end = builder.op(OP_END, 0, 0, 0, 0, -1, start)
    exact = least if fixed and builder.encoding == "ros1" else 0
    builder.ops[start][CODE], builder.ops[start][SIZE], builder.ops[start][JUMP] = exact, least, end
    return (4, False) if count < 0 else (least * count, fixed)


def _names_joints(spec: FieldSpec, above: tuple[str, ...]) -> bool:
    return len(above) == 1 and spec.name == "name" and short_name(above[0]) == "sensor_msgs/JointState"


def _letters(builder: _Builder, spec: FieldSpec, loops: int) -> tuple[int, bool]:
    """The names of a joint state: texts whose letters have slots. They are fields of no kind that is listed."""
    paths = [letter_path(k, j) for k in range(JOINTS) for j in range(LETTERS)]
    builder.fields.append(FieldInfo(spec.name, "text", None, "list of texts"))
    start = builder.op(OP_LOOP, 0, 4, -1, JOINTS)
    builder.depth = max(builder.depth, loops + 1)
    slot = len(builder.paths)
    builder.paths.extend(paths)
    builder.fields.extend(FieldInfo(path, "letter") for path in paths)
    builder.op(OP_STRING, 0, 1, -1, LETTERS, slot)
    builder.ops[start][JUMP] = builder.op(OP_END, 0, 0, 0, 0, -1, start)
    return 4, False


def _labels_places(spec: FieldSpec, above: tuple[str, ...], loops: int) -> bool:
    of_dimension = short_name(above[-1]) == "std_msgs/MultiArrayDimension" and spec.base == "string"
    return of_dimension and spec.name == "label" and loops == 1


def _label(builder: _Builder, paths: list[str]) -> tuple[int, bool]:
    """The label of each dimension, whose letters have slots."""
    letters = [label_path(path, j) for path in paths for j in range(LABEL_LETTERS)]
    slot = len(builder.paths) if letters and len(builder.paths) + len(letters) <= MAX_FIELDS else -1
    if slot >= 0:
        builder.paths.extend(letters)
        builder.fields.extend(FieldInfo(path, "letter") for path in letters)
    builder.op(OP_STRING, 0, 1, -1, LABEL_LETTERS, slot)
    return 4, False


def label_path(field: str, letter: int) -> str:
    """The path of a letter of a dimension's label. field: the label's."""
    return f"{field}[{letter}]"


def letter_path(joint: int, letter: int) -> str:
    """The path of a letter of a joint's name."""
    return f"name[{joint}][{letter}]"


def specialise(layout: Layout, wanted: Sequence[str], encoding: Encoding) -> tuple[IntArray, IntArray]:
    """The program for these fields alone: (ops, slot -> column or -1). What nobody wants is stepped over.

    Without alignment (ROS 1), neighbours of fixed size that nobody wants become one step.
    """
    column = {path: i for i, path in enumerate(wanted)}
    table = np.array([column.get(path, -1) for path in layout.paths] + [-1], dtype=np.int64)
    starts = sorted({int(slot) for slot in layout.ops[:, SLOT] if slot >= 0})
    ends = dict(zip(starts, [*starts[1:], len(layout.paths)], strict=False))
    rows: list[list[int]] = []
    open_loops: list[int] = []
    for source in layout.ops.tolist():
        row = list(source)
        if row[SLOT] >= 0 and row[OP] != OP_END and not (table[row[SLOT] : ends[row[SLOT]]] >= 0).any():
            row[LIMIT], row[SLOT] = 0, -1
        idle = row[OP] == OP_PRIMITIVE or (row[OP] == OP_TIME and row[COUNT] != 1)
        if encoding == "ros1" and idle and row[SLOT] < 0:
            size = row[SIZE] * (row[COUNT] if row[OP] == OP_PRIMITIVE else 1)
            if rows and rows[-1][OP] == OP_SKIP:
                rows[-1][SIZE] += size
                continue
            row = [OP_SKIP, 0, size, 1, 0, -1, -1]
        elif row[OP] == OP_LOOP:
            open_loops.append(len(rows))
        elif row[OP] == OP_END:
            row[JUMP] = open_loops.pop()
            rows[row[JUMP]][JUMP] = len(rows)
        rows.append(row)
    return np.array(rows, dtype=np.int64).reshape(-1, WIDTH), table
