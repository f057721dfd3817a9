"""JSON messages of one topic, decoded in bulk."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import polars as pl

from parsers.channels import ByteArray, FloatArray, IntArray
from parsers.errors import LogError
from parsers.field_notes import MAX_FIELDS, join_stamp, stamp_fields
from parsers.json_kernel import read_documents
from parsers.json_tree import (
    FlatTree,
    JsonNode,
    add_sample,
    add_schema,
    flatten,
    has_open_places,
    read_sample,
)
from parsers.mcap_records import gather
from parsers.ros.contract import Decoded, FieldInfo

SAMPLES = 64
"""So many messages are looked at for the fields that a schema does not name."""

_SLOW_BYTES = 4
"""The shortest number whose value only its text tells is "1e23"."""


@dataclass(frozen=True)
class _Tables:
    """The tables of `read_documents`."""

    nodes: IntArray
    items: IntArray
    keys: IntArray
    names: ByteArray


def _spellings(key: str) -> list[bytes]:
    """How a key may stand in a message: as it is, and with everything beyond ASCII escaped."""
    plain = json.dumps(key, ensure_ascii=False)[1:-1].encode("utf-8", "surrogatepass")
    escaped = json.dumps(key)[1:-1].encode()
    return [plain] if plain == escaped else [plain, escaped]


def _known(node: JsonNode) -> bool:
    """Whether anything but null is known of a place; else what comes there later counts as new."""
    return bool(node.number or node.text or node.keys or node.items)


def _compile(tree: FlatTree, column_of: Mapping[str, int], stamp: tuple[str, str] | None) -> _Tables:
    number_of = {id(node): number for number, (_, node) in enumerate(tree.nodes)}
    stamp_of = {path: k for k, path in enumerate(stamp or ())}
    nodes: list[list[int]] = []
    items: list[int] = []
    keys: list[list[int]] = []
    names = bytearray()
    for path, node in tree.nodes:
        first_key, first_item = len(keys), len(items)
        for key, inner in node.keys.items():
            if not _known(inner):
                continue
            for spelling in _spellings(key):
                keys.append([len(names), len(spelling), number_of[id(inner)]])
                names += spelling
        items += [number_of[id(inner)] for inner in node.items]
        column = column_of.get(path, -1) if node.number else -1
        stamp_at = stamp_of.get(path, -1) if node.number else -1
        nodes.append([first_key, len(keys), first_item, len(node.items), column, stamp_at, bool(node.keys)])
    return _Tables(
        np.array(nodes, dtype=np.int64).reshape(len(nodes), 7),
        np.array(items, dtype=np.int64),
        np.array(keys, dtype=np.int64).reshape(len(keys), 3),
        np.frombuffer(bytes(names), dtype=np.uint8),
    )


def _read_texts(data: ByteArray, slow: IntArray) -> FloatArray:
    """The values of number texts: rows (place, length, …) of `slow`; shape (n,)."""
    # one text a line; the byte behind a number is no part of it and becomes the line's end
    lengths = slow[:, 1] + 1
    text = np.full(int(lengths.sum()), 10, dtype=np.uint8)
    starts = np.cumsum(lengths) - lengths
    gather(data, slow[:, 0].copy(), slow[:, 1].copy(), starts, text)
    frame = pl.read_csv(text.tobytes(), has_header=False, schema={"value": pl.Float64})
    return frame["value"].to_numpy().astype(np.float64)


@dataclass
class JsonDecoder:
    """A `MessageDecoder` for JSON messages. `notes` grows while messages with keys that are not known go by."""

    tree: FlatTree
    notes: list[str] = field(default_factory=list)
    _new_keys: int = 0
    _first_new_key: str = ""

    def __post_init__(self) -> None:
        paths = {info.path for info in self.tree.fields if info.kind == "number"}
        self._stamp = stamp_fields(paths)
        self._paths = paths

    @property
    def fields(self) -> Sequence[FieldInfo]:
        """All places with numbers or text, lists by element."""
        return self.tree.fields

    @property
    def has_header(self) -> bool:
        """Whether messages carry their own stamp."""
        return self._stamp is not None

    def decode(self, data: ByteArray, offset: IntArray, length: IntArray, wanted: Sequence[str]) -> Decoded:
        """Decode payload i = data[offset[i] : offset[i] + length[i]] for all i; only the wanted field paths.

        true is 1.0, false 0.0; null, text and absent are NaN.
        """
        known = [path for path in wanted if path in self._paths]
        column_of = {path: column for column, path in enumerate(dict.fromkeys(known))}
        tables = _compile(self.tree, column_of, self._stamp)
        view = np.ascontiguousarray(data, dtype=np.uint8).view()
        view.flags.writeable = False
        out = np.empty((offset.size, len(column_of)), dtype=np.float64)
        stamps = np.empty((offset.size, 2), dtype=np.int64)
        room = min(int(np.maximum(length, 0).sum()), view.size) // _SLOW_BYTES + 1
        slow = np.empty((min(room, 2 * out.size + 16), 3), dtype=np.int64)
        unknown = np.zeros(3, dtype=np.int64)
        bad, used = read_documents(
            view,
            np.ascontiguousarray(offset, dtype=np.int64),
            np.ascontiguousarray(length, dtype=np.int64),
            tables.nodes,
            tables.items,
            tables.keys,
            tables.names,
            out,
            stamps,
            slow,
            unknown,
        )
        if used:
            slow = slow[:used]
            cells = out.reshape(-1)
            # a later value of the same key, read at once, holds
            open_cells = np.isnan(cells[slow[:, 2]])
            cells[slow[open_cells, 2]] = _read_texts(view, slow)[open_cells]
        if unknown[0]:
            self._count_new(int(unknown[0]), view[unknown[1] : unknown[1] + unknown[2]].tobytes())
        columns = {path: np.ascontiguousarray(out[:, column]) for path, column in column_of.items()}
        missing = np.full(offset.size, np.nan)
        return Decoded(
            columns={path: columns.get(path, missing) for path in wanted},
            stamp_ns=self._stamp_ns(stamps),
            bad=int(bad),
        )

    def _stamp_ns(self, stamps: IntArray) -> IntArray | None:
        if self._stamp is None:
            return None
        return np.where(stamps[:, 1] < 0, 0, join_stamp(stamps[:, 0], stamps[:, 1]))

    def _count_new(self, count: int, key: bytes) -> None:
        """Keep one note of all keys that came up only after the fields were listed."""
        self._first_new_key = self._first_new_key or key.decode("utf-8", "replace")[:60]
        self._new_keys += count
        self.notes[:] = [
            *(note for note in self.notes if not note.startswith("a key")),
            f"a key that neither the schema nor the first messages have came up later and was not read "
            f"({self._new_keys} times, the first is {self._first_new_key!r})",
        ]


def needs_samples(definition: bytes) -> bool:
    """Whether messages must be looked at to know the fields: no JSON schema, or one that leaves places open."""
    root = JsonNode()
    return not add_schema(root, definition) or has_open_places(root)


def make_json_decoder(definition: bytes, samples: Sequence[bytes] = ()) -> JsonDecoder:
    """A decoder for the messages of one topic.

    definition: the JSON schema, or b"". samples: some messages, for the fields that the schema does not name.
    Fields: nested objects as "a.b", the first 8 elements of lists as "[0]". The stamp is a first-level header.stamp,
    timestamp or stamp with sec and nanosec (nsec). Raises LogError where there is no field.
    """
    root = JsonNode()
    add_schema(root, definition)
    for payload in samples[:SAMPLES]:
        add_sample(root, read_sample(payload))
    tree = flatten(root)
    if not tree.fields:
        raise LogError("neither the JSON schema nor the first messages have a field that could be a channel")
    notes = [f"two places share the name {path!r}; only the first is read" for path in tree.clashes[:3]]
    if tree.full:
        notes.append(f"the messages have more than {MAX_FIELDS} fields; only the first are listed")
    return JsonDecoder(tree, notes)
